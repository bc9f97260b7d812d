//! Course submissions of very different quality, kept as fixtures beside the grader.

use std::path::PathBuf;

use crate::classroom::{Classroom, Report};

fn fixture(name: &str) -> PathBuf {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../arena/tests/submissions");
    PathBuf::from(folder).join(name)
}

fn graded(classroom: Option<Classroom>, name: &str, arguments: &[&str]) -> Option<Report> {
    Some(classroom?.grade(&fixture(name), arguments))
}

#[test]
fn honest_ones_get_their_points() {
    for name in ["vectorised", "prints", "mutates_inputs", "triple_loop"] {
        let arguments = ["--cpu-limit", "60"];
        let Some(report) = graded(Classroom::with_python(), name, &arguments) else { return };
        assert_eq!(report.0["points"], 5.0, "{name}: {}{}", report.message(0), report.message(1));
        assert!(report.0["secret_id"].as_str().unwrap().len() >= 4, "{name}");
        let usage = &report.0["tests"][0]["usage"];
        assert!(usage["cpu_seconds"].as_f64().unwrap() > 0.0, "{name}: {usage}");
        assert!(usage["peak_memory_bytes"].as_u64().unwrap() > 1 << 20, "{name}: {usage}");
    }
}

#[test]
fn what_is_printed_does_not_disturb_messages() {
    let Some(report) = graded(Classroom::with_python(), "prints", &[]) else { return };
    let printed = report.0["tests"][0]["output"].as_str().unwrap();
    assert!(printed.contains("imported\n") && printed.contains("disparity 12\n"), "{printed}");
    // A message of the protocol that is only printed is chatter, too.
    assert!(printed.contains("{\"hazcam\":\"done\",\"job\":1}"), "{printed}");
}

#[test]
fn filters_of_scipy_work_under_their_old_names() {
    let Some(report) = graded(Classroom::with_scipy(), "scipy_filters", &[]) else { return };
    assert_eq!(report.0["points"], 5.0, "{}{}", report.message(0), report.message(1));
}

#[test]
fn code_of_2016_runs_and_is_told_what_is_gone() {
    let Some(report) = graded(Classroom::with_scipy(), "from_2016", &[]) else { return };
    assert_eq!(report.0["points"], 5.0, "{}{}", report.message(0), report.message(1));
    let findings = report.findings();
    assert!(findings.contains("time.clock is gone; it is run as time.process_time"), "{findings}");
}

#[test]
fn a_bad_matcher_gets_no_points_and_the_reason() {
    for name in ["gives_up", "uint8_overflow"] {
        let Some(report) = graded(Classroom::with_python(), name, &[]) else { return };
        assert_eq!((report.outcome(0), report.points(0)), ("OK", 0.0), "{name}");
        assert!(report.0["tests"][0]["scores"]["p_bad"].as_f64().unwrap() > 0.3, "{name}");
        if name == "uint8_overflow" {
            let findings = report.findings();
            assert!(findings.contains("if sums or differences are taken in uint8"), "{findings}");
        }
    }
}

#[test]
fn one_scene_that_crashes_leaves_the_others_their_points() {
    let Some(classroom) = Classroom::with_python() else { return };
    let wide = std::fs::read_to_string(classroom.path("small.toml")).unwrap();
    let wide = wide.replacen("max_disparity = 12", "max_disparity = 60", 1);
    std::fs::write(classroom.path("small.toml"), wide).unwrap();
    let report = classroom.grade(&fixture("crashes_on_kitti"), &[]);
    report.expect("RE", &["stereo_disparity_fast.py, line 15", "IndexError", "index 56", "hint"]);
    report.expect_part_2_to_pass();
}

#[test]
fn what_never_ends_is_stopped_by_either_clock() {
    let Some(report) = graded(Classroom::with_python(), "times_out", &["--cpu-limit", "0.2"])
    else {
        return;
    };
    report.expect("TO", &["of CPU time", "the limit is 0.2 s", "hint"]);
    assert_eq!(report.outcome(1), "TO");
    assert!(report.message(1).contains("of wall time"), "{}", report.message(1));
}
