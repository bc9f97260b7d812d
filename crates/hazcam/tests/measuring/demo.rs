//! The whole path without any data: rendered, matched in processes, scored, shown.

use crate::run;

#[test]
fn a_demo_leaves_pictures_records_and_tables() {
    let folder = tempfile::tempdir().unwrap();
    let (stdout, stderr) =
        run(folder.path(), &["demo", "--matcher", "fast", "--scenes", "*cards*", "-o", "out"], 0);
    assert!(stdout.starts_with("scene "), "{stdout}");
    assert!(stderr.contains("pictures, pages of points and records are in out"), "{stderr}");
    let out = folder.path().join("out");
    let scene = std::fs::read_dir(out.join("demo")).unwrap().next().unwrap().unwrap().path();
    let id = format!("demo/{}", scene.file_name().unwrap().to_str().unwrap());
    assert!(stdout.contains(&id), "{stdout}");

    let left = formats::read_image(scene.join("im0.png")).unwrap();
    for picture in ["truth.png", "fast.png", "fast-error.png"] {
        let picture = formats::read_image(scene.join(picture)).unwrap();
        assert_eq!(picture.size(), left.size());
    }
    let page = std::fs::read_to_string(scene.join("fast.html")).unwrap();
    let title = format!("<title>{id}: fast</title>");
    for shown in [&title, "Points are in metres: focal length", "id=\"image\"", "id=\"truth\""] {
        assert!(page.contains(shown), "{shown}");
    }
    let record = std::fs::read(scene.join("fast.json")).unwrap();
    let record: serde_json::Value = serde_json::from_slice(&record).unwrap();
    assert_eq!((&record["status"], &record["case"]), (&"done".into(), &id.into()));
    let p_bad = record["scores"][0]["course"]["p_bad"].as_f64().unwrap();
    assert!(stdout.contains(&format!("{p_bad:.4}")), "{stdout}");
    // Occluded pixels are the hard ones: a scene that does not show it is too easy.
    assert!(record["scores"][2]["course"]["p_bad"].as_f64().unwrap() > p_bad);
    for table in ["scores.md", "scores.csv", "scores.json"] {
        assert!(std::fs::metadata(out.join(table)).unwrap().len() > 100);
    }
    // What it leaves is a data set, of which all can be measured again.
    let (again, _) = run(folder.path(), &["bench", "--data", "out", "--matcher", "fast"], 0);
    assert!(again.contains(&format!("{p_bad:.4}")), "{again}");
    let depth = ["depth", "d.pfm", "--calibration", "calib.txt", "-o", "depth.pfm"];
    let found = ["match", "im0.png", "im1.png", "-o", "d.pfm", "--max-disparity", "63"];
    run(&scene, &found, 0);
    run(&scene, &depth, 0);
}

/// The scenes tell good matchers from bad ones: a fixed window fails at thin things, where there is
/// no texture, where it repeats, and where only one camera sees.
#[test]
fn fast_fails_where_it_should() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = "demo --matcher fast --scenes *clutter* -o out";
    let (stdout, _) = run(folder.path(), &arguments.split(' ').collect::<Vec<_>>(), 0);
    for region in ["occluded", "discontinuity", "textureless", "thin", "repeated"] {
        assert!(stdout.contains(&format!("  {region}")), "{stdout}");
    }
    let json = std::fs::read(folder.path().join("out/scores.json")).unwrap();
    let report: serde_json::Value = serde_json::from_slice(&json).unwrap();
    let scores = report["records"][0]["scores"].as_array().unwrap();
    let bad2 = |region: &str| {
        let of_region = scores.iter().find(|scores| scores["region"] == region).unwrap();
        of_region["middlebury"]["bad"][2]["totbad"].as_f64().unwrap()
    };
    for hard in ["occluded", "discontinuity", "textureless", "thin", "repeated"] {
        let (there, elsewhere) = (bad2(hard), bad2("non-occluded"));
        assert!(there > 1.3 * elsewhere, "{hard}: {there}, non-occluded {elsewhere}");
    }
}

#[test]
fn a_scene_that_is_not_there_is_answered_with_those_that_are() {
    let folder = tempfile::tempdir().unwrap();
    let (_, stderr) = run(folder.path(), &["demo", "--scenes", "venus"], 2);
    assert!(stderr.contains("no scene matches `venus`; there are demo/"), "{stderr}");
    assert!(!folder.path().join("hazcam-demo").exists());
}
