//! `hazcam score` on maps whose scores are known.

use raster::{Image, Plane};
use serde_json::Value;

use crate::folder::Folder;

/// Errors 0, 1, 3 and a hole, and one pixel without truth.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.disparities("d.pfm", &[10.0, 11.0, 13.0, f32::NAN, 5.0]);
    folder.disparities("truth.pfm", &[10.0, 10.0, 10.0, 10.0, f32::NAN]);
    folder
}

#[test]
fn the_courses_numbers_come_first_and_holes_are_shown() {
    let outcome = folder().run("score d.pfm truth.pfm").done();
    insta::assert_snapshot!(outcome.stdout);
    assert_eq!(outcome.stderr, "");
}

#[test]
fn json_holds_numbers_and_protocols() {
    let outcome = folder().run("score d.pfm truth.pfm --format json").done();
    let report: Value = serde_json::from_str(&outcome.stdout).unwrap();
    let scores = &report["scores"];
    assert_eq!(scores["course"]["p_bad"], 0.5);
    // Squares 0, 1, 9, and 100 for the hole, which counts as disparity 0.
    assert_eq!(scores["course"]["e_rms"], f64::sqrt(110.0 / 4.0));
    assert_eq!(scores["middlebury"]["bad"][2]["totbad"], 0.5);
    assert_eq!(scores["middlebury"]["bad"][2]["bad"], 0.25);
    assert_eq!((&scores["pixels"], &scores["holes"]), (&Value::from(4), &Value::from(1)));
    assert_eq!(report["truth"]["encoding"], "pfm");
    assert!(scores["kitti"]["protocol"].as_str().unwrap().contains("filled"));
}

#[test]
fn csv_and_markdown_hold_the_same_numbers() {
    let folder = folder();
    let csv = folder.run("score d.pfm truth.pfm --format csv").done().stdout;
    assert!(csv.starts_with("estimate,truth,measure,value,unit,protocol\r\n"));
    assert!(csv.contains("\nd.pfm,truth.pfm,p_bad,0.5,share,\"course: 4 pixels"), "{csv}");
    let markdown = folder.run("score d.pfm truth.pfm --format markdown").done().stdout;
    assert!(markdown.contains("| p_bad (1) | 0.5000 |"), "{markdown}");
    assert!(markdown.contains("\n1. course: 4 pixels"), "{markdown}");
}

#[test]
fn zeros_in_a_truth_of_floats_are_told() {
    let folder = folder();
    folder.disparities("zeros.pfm", &[10.0, 0.0, 10.0, -0.0, 5.0]);
    let told = folder.run("score d.pfm zeros.pfm").done().stderr;
    assert!(told.contains("zeros.pfm: 40.0 % of the truth is exactly 0"), "{told}");
}

#[test]
fn a_reader_that_goes_away_changes_no_status() {
    let folder = folder();
    for (threshold, status) in [("p_bad=0.4", 1), ("p_bad=0.6", 0)] {
        let arguments = ["score", "d.pfm", "truth.pfm", "--fail-over", threshold];
        let mut command = folder.command();
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let ended = command.args(arguments).stdout(writer).status().unwrap();
        assert_eq!(ended.code(), Some(status), "{threshold}");
    }
}

#[test]
fn a_score_over_its_threshold_ends_with_status_one() {
    let folder = folder();
    let run = |options: &str| folder.run(&format!("score d.pfm truth.pfm {options}"));
    let outcome = run("--fail-over p_bad=0.5 --fail-over e_rms=5.5");
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""));
    let outcome = run("--fail-over p_bad=49% --fail-over E_RMS=5 --fail-over A50=9");
    assert_eq!(outcome.status, 1);
    assert!(outcome.stdout.contains("E_RMS"), "the scores are printed all the same");
    let expected = "failed: p_bad is 0.5000, over 0.49\nfailed: E_RMS is 5.2440, over 5\n";
    assert_eq!(outcome.stderr, expected);
}

#[test]
fn box_and_mask_choose_the_pixels() {
    let folder = folder();
    let mask = Plane::new(5, 1, vec![255, 255, 128, 255, 0]).unwrap();
    formats::write_image(folder.path("mask.png"), &Image::Grey8(mask)).unwrap();
    let json = |options: &str| -> Value {
        let arguments = format!("score d.pfm truth.pfm --format json {options}");
        serde_json::from_str(&folder.run(&arguments).done().stdout).unwrap()
    };
    let report = json("--mask mask.png --box 1,0,4,0");
    assert_eq!(report["scores"]["pixels"], 2);
    assert_eq!(report["scores"]["course"]["p_bad"], 0.5);
    let protocol = report["scores"]["course"]["protocol"].as_str().unwrap();
    assert!(protocol.contains("the box 1,0,4,0 (inclusive) under the mask `mask.png`"));
    assert_eq!(json("--max-disparity 12")["scores"]["middlebury"]["clipped"], 1);
    let told = |most: u32| {
        let arguments = format!("score d.pfm truth.pfm --max-disparity {most}");
        folder.run(&arguments).done().stderr
    };
    assert_eq!(told(100), "");
    assert!(
        told(1).contains("% of the truth lies beyond --max-disparity 1, to which"),
        "{}",
        told(1)
    );
}

#[test]
fn a_truth_read_at_the_wrong_scale_is_told() {
    let folder = Folder::new();
    let samples: Vec<u8> = (0..60).map(|x| 40 + 2 * x).collect();
    let values: Vec<f32> = samples.iter().map(|&s| f32::from(s) / 4.0).collect();
    folder.disparities("d.pfm", &values);
    let truth = Image::Grey8(Plane::new(60, 1, samples).unwrap());
    formats::write_image(folder.path("truth.png"), &truth).unwrap();
    let outcome = folder.run("score d.pfm truth.png").done();
    assert!(outcome.stderr.contains("truth.png: 8-bit grey does not say its scale"));
    assert!(
        outcome.stderr.contains("divided by 4: read it with --truth-encoding png8/4"),
        "{}",
        outcome.stderr
    );
    let outcome = folder.run("score d.pfm truth.png --truth-encoding png8/4").done();
    assert_eq!(outcome.stderr, "");
    assert!(outcome.stdout.contains("E_RMS              0.000 px"), "{}", outcome.stdout);
}

#[test]
fn an_estimate_in_other_units_or_of_the_other_sign_is_told() {
    let folder = Folder::new();
    let truth: Vec<f32> = (0..60).map(|x| 10.0 + x as f32 / 2.0).collect();
    folder.disparities("truth.pfm", &truth);
    // Sixteenths of a pixel, as OpenCV has them.
    let samples = truth.iter().map(|&d| (16.0 * d) as u16).collect();
    let image = Image::Grey16(Plane::new(60, 1, samples).unwrap());
    formats::write_image(folder.path("d.png"), &image).unwrap();
    folder.disparities("d.pfm", &truth.iter().map(|d| -d).collect::<Vec<_>>());
    for (estimate, told) in [
        ("d.png", "d.png were multiplied by 16: read it with --estimate-encoding png16/16"),
        ("d.pfm", "with the other sign: d.pfm"),
    ] {
        let outcome = folder.run(&format!("score {estimate} truth.pfm")).done();
        assert!(outcome.stderr.contains(told), "{}", outcome.stderr);
    }
    let again = folder.run("score d.png truth.pfm --estimate-encoding png16/16").done();
    assert_eq!(again.stderr, "");
}

#[test]
fn an_estimate_without_a_value_is_all_bad() {
    let folder = Folder::new();
    folder.disparities("d.pfm", &[f32::NAN]);
    folder.disparities("truth.pfm", &[8.0]);
    let outcome = folder.run("score d.pfm truth.pfm --fail-over avgerr=100");
    assert_eq!(outcome.status, 1);
    assert!(outcome.stdout.contains("1 of them holes (100.00 %)"), "{}", outcome.stdout);
    assert!(outcome.stderr.contains("avgerr has no value"), "{}", outcome.stderr);
}

#[test]
fn what_match_writes_score_reads() {
    let folder = Folder::with_pair(64, 40);
    let truth = Plane::filled(64, 40, 3.0);
    formats::write_disparity(folder.path("truth.png"), &truth).unwrap();
    folder.run("match left.png right.png -o d.png -d 12 --matcher fast").done();
    let outcome = folder.run("score d.png truth.png --box 3,0,63,39 --fail-over p_bad=5%");
    assert_eq!(outcome.status, 0, "{}{}", outcome.stdout, outcome.stderr);
}

#[test]
fn a_confidence_is_told_how_well_it_ranks_errors() {
    let folder = folder();
    // Errors 0, 1 and 3: the worst is the surest. The hole and what has no truth are not ranked.
    folder.disparities("sure.pfm", &[20.0, 10.0, 30.0, f32::NAN, f32::NAN]);
    let json = folder.run("score d.pfm truth.pfm --confidence sure.pfm --format json").done();
    let report: Value = serde_json::from_str(&json.stdout).unwrap();
    let confidence = &report["confidence"];
    assert_eq!(confidence["path"], "sure.pfm");
    // By confidence 3, 3/2, 4/3, at best 0, 1/2, 4/3; of bad pixels 1, 1/2, 1/3 and 0, 0, 1/3.
    let is = |value: &Value, expected: f64| (value.as_f64().unwrap() - expected).abs() < 1e-12;
    assert!(is(&confidence["error"]["auc"], (3.0 + 1.5 + 4.0 / 3.0) / 3.0), "{confidence}");
    assert!(is(&confidence["bad"]["ause"], (1.0 + 0.5) / 3.0), "{confidence}");
    assert_eq!(confidence["bad"]["curve"].as_array().unwrap().len(), 3);
    let text = folder.run("score d.pfm truth.pfm --confidence sure.pfm").done().stdout;
    let line = |name: &str| text.lines().find(|line| line.trim().starts_with(name)).unwrap();
    assert!(
        line("AUSE-bad2").ends_with(" 50.00 %") && line("AUC-EPE").ends_with(" 1.944 px"),
        "{text}"
    );

    folder.disparities("unknown.pfm", &[20.0, 10.0, f32::NAN, 1.0, 1.0]);
    folder.disparities("short.pfm", &[20.0, 10.0]);
    let picture = Image::Grey8(Plane::filled(5, 1, 9));
    formats::write_image(folder.path("sure.png"), &picture).unwrap();
    for (file, said) in [
        ("unknown.pfm", "column 2, row 0"),
        ("short.pfm", "2 x 1"),
        ("sure.png", "give a .pfm, .npy or .tiff"),
        ("missing.pfm", "missing.pfm"),
    ] {
        folder.refuses(&format!("score d.pfm truth.pfm --confidence {file}"), &[said, file]);
    }
}
