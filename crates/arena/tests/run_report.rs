//! Engines on scenes end as records, tables and summaries, whatever becomes of one of them.
#![cfg(unix)]

use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::path::Path;

use arena::dataset::{Case, CaseData, Obstacles};
use arena::engine::{Definition, Limits, Programs, Status};
use arena::record::{Machine, Record};
use arena::report;
use arena::run::{Event, Outcome, Plan, run};
use formats::npy;
use raster::{DisparityRange, Image, Plane};

/// Four pixels whose truth is 10; the last one is occluded.
fn case(id: &str, grey: u8) -> Case {
    Case::rendered(id, move || {
        let image = Image::Grey8(Plane::filled(4, 1, grey));
        let range = DisparityRange::new(0, 20).unwrap();
        let mut data = CaseData::new(image.clone(), image, range);
        data.truth = Some(Plane::filled(4, 1, 10.0));
        data.add_occlusions(&Plane::new(4, 1, vec![false, false, false, true]).unwrap());
        Ok(data)
    })
}

/// An engine that runs this shell script for each job, `$i` being its number.
fn engine(folder: &Path, name: &str, script: &str) -> Definition {
    let own = folder.join(name);
    std::fs::create_dir_all(&own).unwrap();
    let text = format!(
        "echo '{{\"hazcam\":\"ready\",\"protocol\":1,\"version\":\"3\"}}'; i=0
         while read line; do i=$((i+1)); {script}
         echo \"{{\\\"hazcam\\\":\\\"done\\\",\\\"job\\\":$i}}\"; done"
    );
    std::fs::write(own.join("engine.sh"), text).unwrap();
    let toml = format!("name = '{name}'\ncommand = ['/bin/sh', '{{folder}}/engine.sh']");
    std::fs::write(own.join("engine.toml"), toml).unwrap();
    Definition::read(&own.join("engine.toml")).unwrap()
}

/// An engine that is wrong by 5 pixels at so many pixels of the first and of the second scene.
fn wrong_at(folder: &Path, name: &str, counts: [usize; 2]) -> Definition {
    let definition =
        engine(folder, name, &format!("cp {}/{name}/$i.npy disparity.npy", folder.display()));
    for (job, count) in counts.into_iter().enumerate() {
        let answer = Plane::from_fn(4, 1, |x, _| if x < count { 15f32 } else { 10.0 });
        npy::write(folder.join(name).join(format!("{}.npy", job + 1)), &answer).unwrap();
    }
    definition
}

fn plan(engines: Vec<Definition>, repeats: usize) -> Plan {
    Plan {
        cases: vec![case("a/one", 1), case("b/two", 2)],
        engines,
        programs: Programs::find("hazcam".into()),
        limits: Limits::default(),
        threads: 1,
        repeats,
        jobs: NonZeroUsize::MIN,
        machine: Machine::this(None),
    }
}

fn outcome(plan: &Plan) -> Outcome {
    run(plan, |_| ControlFlow::Continue(())).unwrap()
}

fn p_bads(records: &[Record]) -> Vec<Option<f64>> {
    records.iter().map(|record| record.value("all", "p_bad")).collect()
}

#[test]
fn two_engines_are_scored_and_compared() {
    let folder = tempfile::tempdir().unwrap();
    let engines =
        vec![wrong_at(folder.path(), "mine", [1, 2]), wrong_at(folder.path(), "other", [2, 1])];
    let records = outcome(&plan(engines, 1)).records;
    assert_eq!(p_bads(&records), [Some(0.25), Some(0.5), Some(0.5), Some(0.25)]);
    assert_eq!(records[0].value("non-occluded", "p_bad"), Some(1.0 / 3.0));
    assert_eq!(records[0].value("occluded", "p_bad"), Some(0.0));
    assert_eq!(records[0].engine_version.as_deref(), Some("3"));

    let text = report::scores_table(&records).to_text();
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with("scene  matcher  pixels  E_RMS   p_bad  bad0.5 %"), "{text}");
    assert!(!lines[0].contains("status"));
    assert!(lines[1].starts_with("a/one  mine     all      2.50  0.2500     25.00"), "{text}");
    assert!(lines[2].starts_with("                noc      2.89  0.3333     33.33"), "{text}");
    assert_eq!(lines.len(), 1 + 8);

    let bad2 = report::bad2_table(&records).to_markdown();
    assert!(bad2.contains("| a/one | 25.00 | 33.33 | 50.00 | 66.67 |"), "{bad2}");
    let regions = report::regions_table(&records).to_markdown();
    assert!(regions.contains("| a/one | mine | 25.00 | 33.33 | 0.00 |"), "{regions}");
    let csv = report::scores_table(&records).to_csv();
    let column = csv.lines().next().unwrap().split(',').position(|name| name == "avgerr").unwrap();
    // One pixel of four is off by 5: by 1.25 in the mean, 2.5 in the rms.
    assert_eq!(csv.lines().nth(1).unwrap().split(',').nth(column), Some("1.25"), "{csv}");

    let summaries = report::summaries(&records, Some("other"));
    let families: Vec<_> = summaries.iter().map(|s| (&s.family[..], &s.engine[..])).collect();
    let expected = ["a", "b", "overall"].map(|family| [(family, "mine"), (family, "other")]);
    assert_eq!(families, expected.concat());
    let overall = &summaries[4];
    assert_eq!((overall.scenes, overall.mean_p_bad), (2, Some(0.375)));
    // Half as bad on one scene and twice as bad on the other cancel; the worst is shown.
    assert!((overall.ratio.unwrap() - 1.0).abs() < 1e-12);
    assert_eq!(overall.worst_ratio, Some((2.0, "b/two".into())));
    let table = report::summary_table(&summaries, Some("other"));
    assert!(table.to_markdown().contains("| overall | mine | 2 | 3.02 | 0.3750 | 0.5000 |"));

    let json: serde_json::Value =
        serde_json::from_str(&report::to_json(&records, &summaries)).unwrap();
    assert_eq!(json["records"][0]["status"], "done");
    assert_eq!(json["records"][0]["scores"][0]["course"]["p_bad"], 0.25);
    assert_eq!(json["summaries"][4]["ratio_scenes"], 2);
    let path = folder.path().join("record.json");
    records[0].write(&path).unwrap();
    let kept: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    assert_eq!(kept, json["records"][0]);
}

#[test]
fn errors_by_reason_are_shares_of_all_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("tells");
    let copy = format!("cp {0}/d$i.npy disparity.npy; cp {0}/r$i.npy reasons.npy", own.display());
    let tells = engine(folder.path(), "tells", &copy);
    // One pixel of four is off by 3 px. Reasons: 1 is matched, 2 occluded and filled.
    for (job, reasons) in [[1u8, 1, 1, 1], [2, 1, 1, 1]].into_iter().enumerate() {
        let off = Plane::from_fn(4, 1, |x, _| if x == 0 { 13f32 } else { 10.0 });
        npy::write(own.join(format!("d{}.npy", job + 1)), &off).unwrap();
        let reasons = Plane::new(4, 1, reasons.to_vec()).unwrap();
        npy::write(own.join(format!("r{}.npy", job + 1)), &reasons).unwrap();
    }
    let silent = wrong_at(folder.path(), "silent", [1, 1]);
    let records = outcome(&plan(vec![silent, tells], 1)).records;
    let text = report::reasons_table(&records).to_csv();
    let lines: Vec<&str> = text.lines().skip(1).collect();
    let expected = ["tells,matched,87.5,12.5,0", "tells,occluded-filled,12.5,12.5,0"];
    assert_eq!(lines, expected);
}

#[test]
fn errors_by_confidence_are_shares_of_the_sure_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("sure");
    let copy = format!("cp {0}/d.npy disparity.npy; cp {0}/c$i.npy confidence.npy", own.display());
    let sure = engine(folder.path(), "sure", &copy);
    // One pixel of four is off by 3 px: the least sure one of the first scene, the surest of the other.
    let off = Plane::from_fn(4, 1, |x, _| if x == 0 { 13f32 } else { 10.0 });
    npy::write(own.join("d.npy"), &off).unwrap();
    for (job, sure) in [[0.1f32, 0.6, 0.95, 0.95], [0.8, 0.1, 0.1, 0.1]].into_iter().enumerate() {
        let sure = Plane::new(4, 1, sure.to_vec()).unwrap();
        npy::write(own.join(format!("c{}.npy", job + 1)), &sure).unwrap();
    }
    let silent = wrong_at(folder.path(), "silent", [1, 1]);
    let records = outcome(&plan(vec![silent, sure], 1)).records;
    let text = report::reliability_table(&records).to_csv();
    let lines: Vec<&str> = text.lines().skip(1).collect();
    let expected = [
        "sure,0,100,25,0,0,3,3,3,25,b/two",
        "sure,0.25,50,50,0,1.5,1.5,1.5,1.5,100,b/two",
        "sure,0.5,50,50,0,1.5,1.5,1.5,1.5,100,b/two",
        "sure,0.75,37.5,50,0,1.5,1.5,1.5,1.5,100,b/two",
        // Nobody is as sure in the second scene, which counts with none of its pixels.
        "sure,0.9,25,0,0,0,0,0,0,0,a/one",
    ];
    assert_eq!(lines, expected);
}

#[test]
fn obstacles_are_missed_over_all_scenes() {
    let folder = tempfile::tempdir().unwrap();
    let copy = format!("cp {}/ground/$i.npy disparity.npy", folder.path().display());
    let ground = engine(folder.path(), "ground", &copy);
    // A stone 12 px wide stands 2 px before the ground at 8; of the first scene half is missed, of the other one all.
    for (job, missed) in [2, 4].into_iter().enumerate() {
        let answer = Plane::from_fn(4, 1, |x, _| if x < missed { 8.5f32 } else { 9.5 });
        npy::write(folder.path().join(format!("ground/{}.npy", job + 1)), &answer).unwrap();
    }
    let mut plan = plan(vec![ground], 1);
    for case in &mut plan.cases {
        let before = case.clone();
        *case = Case::rendered(case.id.clone(), move || {
            let mut data = before.load().unwrap();
            let (behind, things) = (Plane::filled(4, 1, 8.0), Plane::filled(4, 1, 1));
            data.obstacles = Some(Obstacles { behind, things, widths: vec![12] });
            Ok(data)
        });
    }
    let text = report::obstacles_table(&outcome(&plan).records).to_csv();
    let lines: Vec<&str> = text.lines().skip(1).collect();
    // It does not say how sure it is, and of four pixels nobody says whether a stone is seen.
    let expected = ["up to 9", "10 to 16", "17 and more"].into_iter().flat_map(|side| {
        ["0.7 to 1.5", "1.5 to 3", "3 and more"].map(|step| {
            let missed = if (side, step) == ("10 to 16", "1.5 to 3") { "75" } else { "" };
            format!("{side},{step},ground,{missed},,")
        })
    });
    assert_eq!(lines, expected.collect::<Vec<_>>());
}

#[test]
fn a_crash_is_a_row_and_the_rest_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let crashing = engine(folder.path(), "crashing", "echo 'oh no' >&2; exit 7;");
    let engines = vec![crashing, wrong_at(folder.path(), "mine", [1, 2])];
    let records = outcome(&plan(engines, 1)).records;
    assert_eq!(p_bads(&records), [None, Some(0.25), None, Some(0.5)]);
    let text = report::scores_table(&records).to_text();
    assert!(text.lines().next().unwrap().ends_with("status"), "{text}");
    assert!(text.lines().nth(1).unwrap().ends_with("crashed"), "{text}");
    let failures = report::failures(&records);
    assert_eq!(failures.len(), 2);
    assert!(failures[0].status.contains("status 7") && failures[0].status.contains("oh no"));
    let summaries = report::summaries(&records, Some("crashing"));
    assert_eq!((summaries[0].scenes, summaries[0].failed), (0, 1));
    assert_eq!(summaries[1].ratio, None, "there is nothing to compare with");
}

#[test]
fn a_scene_without_an_answer_is_in_no_mean() {
    let folder = tempfile::tempdir().unwrap();
    let answer = folder.path().join("answer.npy");
    npy::write(&answer, &Plane::filled(4, 1, 10f32)).unwrap();
    let script = format!("[ $i = 1 ] || exit 7; cp {} disparity.npy;", answer.display());
    let records = outcome(&plan(vec![engine(folder.path(), "once", &script)], 1)).records;
    assert_eq!(p_bads(&records), [Some(0.0), None]);
    let answered = records[0].usage.cpu_seconds;
    let summaries = report::summaries(&records, None);
    let overall = summaries.last().unwrap();
    assert_eq!((overall.scenes, overall.failed), (1, 1));
    assert_eq!(overall.mean_cpu_seconds, answered);
    let csv = report::overview_table(&records).to_csv();
    let expected = answered.map_or(String::new(), |seconds| (seconds * 1e3).to_string());
    assert_eq!(csv.trim_end().rsplit(',').next(), Some(&expected[..]), "{csv}");
}

#[test]
fn two_jobs_work_at_once_and_their_records_keep_the_order() {
    let folder = tempfile::tempdir().unwrap();
    let told = folder.path().display();
    // Each waits until the other has begun with the same scene, the first one until it has ended.
    let wait_for = |name: &str| {
        format!(
            "until [ -e {told}/{name}.$i ]; do sleep 0.01; done; cp {told}/answer.npy disparity.npy;"
        )
    };
    npy::write(folder.path().join("answer.npy"), &Plane::filled(4, 1, 10f32)).unwrap();
    let engines = vec![
        engine(
            folder.path(),
            "first",
            &format!("touch {told}/first.$i; {}", wait_for("second-done")),
        ),
        engine(
            folder.path(),
            "second",
            &format!("{} touch {told}/second-done.$i;", wait_for("first")),
        ),
    ];
    let mut plan = plan(engines, 1);
    plan.jobs = NonZeroUsize::new(2).unwrap();
    let records = outcome(&plan).records;
    let order: Vec<_> = records.iter().map(|r| (&r.case[..], &r.engine[..])).collect();
    let cases = ["a/one", "b/two"];
    assert_eq!(order, cases.map(|case| [(case, "first"), (case, "second")]).concat());
    assert_eq!(p_bads(&records), [Some(0.0); 4]);
    assert!(records.iter().all(|record| record.jobs == 2), "who reads the times must know");
    // One engine alone is not disturbed, whatever is allowed.
    plan.engines = vec![wrong_at(folder.path(), "alone", [0, 0])];
    assert!(outcome(&plan).records.iter().all(|record| record.jobs == 1));
}

#[test]
fn absent_engines_and_unreadable_scenes_are_left_out_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let mut absent = engine(folder.path(), "absent", ":");
    let say = r#"echo '{"hazcam":"absent","message":"no tables"}'"#;
    absent.command = vec!["/bin/sh".into(), "-c".into(), say.into()];
    let mut plan = plan(vec![absent, wrong_at(folder.path(), "mine", [1, 2])], 1);
    plan.cases.insert(0, Case::rendered("a/broken", || Err("no lens".into())));
    let mut told = Vec::new();
    let outcome = run(&plan, |event| {
        match event {
            Event::EngineAbsent { engine, message } => {
                told.push(format!("{} {message}", engine.name))
            }
            Event::CaseUnreadable { case, error } => told.push(format!("{} {error}", case.id)),
            Event::Begins { .. } => {}
            Event::Finished { record, answer, .. } => {
                assert_eq!((&record.status, answer.is_some()), (&Status::Done, true));
                told.push(record.case.clone());
            }
        }
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(told, ["absent no tables", "a/broken no lens", "a/one", "b/two"]);
    assert_eq!((outcome.records.len(), outcome.absent, outcome.unreadable), (2, 1, 1));
}

#[test]
fn repetitions_show_whether_answers_repeat() {
    let folder = tempfile::tempdir().unwrap();
    let steady = wrong_at(folder.path(), "steady", [1, 1]);
    let at = folder.path().join("steady");
    std::fs::copy(at.join("1.npy"), at.join("3.npy")).unwrap();
    let fickle = wrong_at(folder.path(), "fickle", [1, 2]);
    let mut plan = plan(vec![steady, fickle], 2);
    plan.cases.truncate(1);
    let records = outcome(&plan).records;
    assert_eq!((records[0].repeatable, records[1].repeatable), (Some(true), Some(false)));
    assert_eq!(records[0].runs.len(), 2);
    assert_eq!(records[1].value("all", "p_bad"), Some(0.5), "the last answer is scored");
}

#[test]
fn a_run_that_fails_after_others_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let plan = Plan {
        cases: vec![case("a/one", 1)],
        ..plan(vec![engine(folder.path(), "once", "exit 0")], 3)
    };
    let message = |records: &[Record]| records[0].status.message().unwrap().to_owned();
    assert!(message(&outcome(&plan).records).starts_with("it exited with status 0"));
    let script =
        format!("[ $i = 1 ] || exit 0; cp {}/answer.npy disparity.npy", folder.path().display());
    npy::write(folder.path().join("answer.npy"), &Plane::filled(4, 1, 10f32)).unwrap();
    let plan = Plan { engines: vec![engine(folder.path(), "later", &script)], ..plan };
    let records = outcome(&plan).records;
    assert_eq!(records[0].runs.len(), 2);
    let expected = "after 1 run with an answer, it exited with status 0 without an answer";
    assert_eq!(message(&records), expected);
}

#[test]
fn an_observer_can_end_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let plan = plan(vec![wrong_at(folder.path(), "mine", [1, 2])], 1);
    let outcome = run(&plan, |event| match event {
        Event::Finished { .. } => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    })
    .unwrap();
    assert_eq!(outcome.records.len(), 1);
}
