//! Engines in the place of a submission: hazcam's own, and programs of other people in the sandbox.

use std::fs;

use crate::classroom::{Classroom, Report};

fn graded(classroom: &Classroom, arguments: &[&str]) -> Report {
    let mut all = vec!["--scheme", "small.toml", "--format", "json"];
    all.extend(arguments);
    let (status, stdout, stderr) = classroom.run(&all);
    assert_eq!(status, 0, "{stdout}{stderr}");
    Report(serde_json::from_str(&stdout).unwrap())
}

#[test]
fn our_own_presets_get_all_points() {
    let Some(classroom) = Classroom::without_python() else { return };
    let report = graded(&classroom, &["--matcher", "fast:best"]);
    assert_eq!(report.0["points"], 5.0, "{}{}", report.message(0), report.message(1));
    assert_eq!(report.0["entrant"], "fast:best");
    assert_eq!(report.0["confinement"], "sandbox");
}

#[test]
fn the_course_gives_its_fifty_points() {
    let Some(data) = std::env::var_os("HAZCAM_DATA").filter(|folder| !folder.is_empty()) else {
        return crate::skip::skip("HAZCAM_DATA is not set");
    };
    let Some(classroom) = Classroom::without_python() else { return };
    let mut command = classroom.command("grade", &["--matcher", "fast:best", "--format", "json"]);
    let output = command.env("HAZCAM_DATA", data).output().unwrap();
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["points"], &report["max_points"]), (&50.0.into(), &50.0.into()));
}

/// A shell script as an engine, in the Robust Vision form.
fn with_script(script: &str) -> Option<(Classroom, Report)> {
    if !std::path::Path::new("/bin/sh").exists() {
        crate::skip::skip("there is no /bin/sh");
        return None;
    }
    let classroom = Classroom::without_python()?;
    let folder = classroom.path("engines");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("script.sh"), script).unwrap();
    let definition = "name = 'mine'\nkind = 'robust-vision'\n\
                      command = ['/bin/sh', '{folder}/script.sh']\n";
    fs::write(folder.join("mine.toml"), definition).unwrap();
    let report = graded(&classroom, &["--matcher", "mine:fast", "--engines", "engines"]);
    report.expect_part_2_to_pass();
    Some((classroom, report))
}

#[test]
fn a_program_is_confined_without_any_python() {
    let outside = tempfile::tempdir().unwrap();
    let target = outside.path().join("written");
    let Some((_classroom, report)) = with_script(&format!(
        "echo mischief > {}\nread line < /etc/passwd && echo \"got $line\"\n\
         (echo child) && echo forked\necho four: $4\n",
        target.display()
    )) else {
        return;
    };
    assert!(!target.exists());
    let output = report.0["tests"][0]["output"].as_str().unwrap();
    assert!(!output.contains("got") && !output.contains("forked"), "{output}");
    assert_ne!(report.outcome(0), "OK");
}

#[test]
fn a_program_without_an_answer_is_told_so() {
    let Some((_classroom, report)) = with_script("exit 0\n") else { return };
    report.expect("BAD", &["disp0"]);
    let Some((_classroom, report)) = with_script("while :; do :; done\n") else { return };
    report.expect("TO", &["of CPU time"]);
}
