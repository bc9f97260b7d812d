//! Scenes on disk and other people's engines.

use std::fs;
use std::path::Path;

use raster::{Image, Plane};

use crate::{hazcam, run};

/// A data set of one scene: a wall at 6 pixels of disparity.
fn data(folder: &Path) {
    let scene = folder.join("data/walls/near");
    fs::create_dir_all(&scene).unwrap();
    let value = |x: usize, y: usize| ((x * x * 7 + x * 13 + y * 29 + x * y * 3) % 251) as u8;
    for (name, shift) in [("im0.png", 0), ("im1.png", 6)] {
        let image = Image::Grey8(Plane::from_fn(80, 40, |x, y| value(x + shift, y)));
        formats::write_image(scene.join(name), &image).unwrap();
    }
    let truth = Plane::filled(80, 40, 6f32);
    formats::write_disparity(scene.join("disp0GT.pfm"), &truth).unwrap();
}

#[test]
fn without_data_one_line_says_where_it_looked_and_how_to_get_some() {
    let folder = tempfile::tempdir().unwrap();
    let (stdout, stderr) = run(folder.path(), &["bench"], 2);
    assert_eq!((stdout.as_str(), stderr.lines().count()), ("", 1), "{stderr}");
    for word in ["HAZCAM_DATA", "middlebury.edu", "cvlibs.net", "hazcam demo"] {
        assert!(stderr.contains(word), "{stderr}");
    }
    let (_, stderr) = run(folder.path(), &["bench", "--data", "nowhere"], 2);
    assert!(stderr.contains("nowhere is not a folder"), "{stderr}");
    let (_, stderr) = run(folder.path(), &["bench", "--data", "."], 2);
    assert!(stderr.contains("no scene was found"), "{stderr}");
}

#[test]
fn scenes_whose_truth_has_no_scale_are_said_to_be_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let grey = Image::Grey8(Plane::filled(20, 20, 9));
    let scene = folder.path().join("data/Art");
    fs::create_dir_all(&scene).unwrap();
    for name in ["view1.png", "view5.png", "disp1.png"] {
        formats::write_image(scene.join(name), &grey).unwrap();
    }
    let arguments = ["bench", "-m", "fast", "--data", "data"];
    let (_, stderr) = run(folder.path(), &arguments, 2);
    for words in ["Art without truth", "Art/disp1.png is truth times a number", "ThirdSize"] {
        assert!(stderr.contains(words), "{stderr}");
    }
    data(folder.path());
    let (stdout, stderr) = run(folder.path(), &arguments, 0);
    assert!(stdout.contains("walls/near") && !stdout.contains("Art"), "{stdout}");
    assert!(stderr.contains("left out of data: Art without truth"), "{stderr}");
}

#[test]
fn scenes_on_disk_are_found_matched_and_scored() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let mut command = hazcam(folder.path(), &["bench", "--format", "csv", "--matcher", "fast"]);
    let output = command.env("HAZCAM_DATA", "data").output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let csv = String::from_utf8(output.stdout).unwrap();
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][..5], ["scene", "matcher", "pixels", "E_RMS", "p_bad"]);
    assert_eq!(rows[1][..3], ["walls/near", "fast", "all"]);
    assert!(rows[1][4].parse::<f64>().unwrap() < 0.2, "{csv}");
}

#[test]
fn of_pairs_without_truth_it_is_told_how_much_matchers_speak_of() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let scene = folder.path().join("data/rover");
    fs::create_dir(&scene).unwrap();
    for (from, to) in [("im0.png", "left.png"), ("im1.png", "right.png")] {
        fs::copy(folder.path().join("data/walls/near").join(from), scene.join(to)).unwrap();
    }
    let arguments = ["bench", "--data", "data", "-m", "fast", "--scenes", "*"];
    let (stdout, _) = run(folder.path(), &[&arguments[..], &["--use", "rover"]].concat(), 0);
    assert!(stdout.starts_with("scene  matcher  density %  matched %  sure %"), "{stdout}");
    assert!(stdout.contains("nobody knows the truth") && !stdout.contains("E_RMS"), "{stdout}");
    let (_, stderr) = run(folder.path(), &["bench", "--data", "data", "--scenes", "*over*"], 2);
    assert!(stderr.contains("which is of the use rover: give --use rover too"), "{stderr}");
    // A scene with truth beside it takes no row from the others.
    let catalogue = r#"[{"id": "x/far", "use": "test", "left": "walls/near/im0.png", "right": "walls/near/im1.png"},
        {"id": "x/near", "use": "test", "left": "walls/near/im0.png", "right": "walls/near/im1.png",
         "truth": "walls/near/disp0GT.pfm"}]"#;
    fs::create_dir(folder.path().join("mixed")).unwrap();
    fs::rename(folder.path().join("data/walls"), folder.path().join("mixed/walls")).unwrap();
    fs::write(folder.path().join("mixed/scenes.json"), catalogue).unwrap();
    let mixed = ["bench", "--data", "mixed", "-m", "fast", "--use", "test", "--format", "csv"];
    let (stdout, _) = run(folder.path(), &mixed, 0);
    for scene in ["x/far,fast", "x/near,fast"] {
        assert!(stdout.contains(scene), "{stdout}");
    }
    let only = ["--use", "rover", "--format", "csv"];
    let (stdout, _) = run(folder.path(), &[&arguments[..], &only].concat(), 0);
    let numbers: Vec<f64> =
        stdout.lines().nth(1).unwrap().split(',').skip(2).map(|n| n.parse().unwrap()).collect();
    assert_eq!(numbers[0], 100.0, "{stdout}");
    assert!((50.0..100.0).contains(&numbers[1]) && numbers[2] <= numbers[1], "{stdout}");
}

#[cfg(unix)]
#[test]
fn anybodys_engine_takes_part_and_its_crash_is_a_row() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let engines = folder.path().join("engines");
    fs::create_dir(&engines).unwrap();
    let crash = r#"echo '{"hazcam":"ready","protocol":1}'; read line; echo 'no luck' >&2; exit 3"#;
    let crash = format!("name = 'crash'\ncommand = ['/bin/sh', '-c', '''{crash}''']");
    fs::write(engines.join("crash.toml"), crash).unwrap();
    let absent = r#"echo '{"hazcam":"absent","message":"no licence"}'"#;
    let absent = format!("name = 'shy'\ncommand = ['/bin/sh', '-c', '''{absent}''']");
    fs::write(engines.join("shy.toml"), absent).unwrap();
    let arguments = ["bench", "--data", "data", "--engines", "engines", "-m", "fast", "--engine"];
    let (stdout, stderr) = run(folder.path(), &[&arguments[..], &["cras?,sh*"]].concat(), 0);
    assert!(stdout.contains("crashed"), "{stdout}");
    assert!(
        stdout.contains("walls/near, crash: crashed: it exited with status 3 without an answer")
    );
    assert!(stdout.contains("fast     all"), "{stdout}");
    assert!(stderr.contains("shy left out: no licence"), "{stderr}");
    // Who calls for one by its name wants its answers.
    let (_, stderr) = run(folder.path(), &[&arguments[..], &["crash,shy"]].concat(), 2);
    for name in ["crash", "shy"] {
        let words = format!("{name} was asked for and has given no answer that counts");
        assert!(stderr.contains(&words), "{stderr}");
    }
}

#[test]
fn a_reference_is_compared_with_and_kept_in_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let arguments = "bench --data data -m none -e fast --reference fast --format markdown -o out";
    let arguments: Vec<&str> = arguments.split(' ').collect();
    let (stdout, stderr) = run(folder.path(), &arguments, 0);
    assert!(stdout.contains("| ratio | worst ratio |"), "{stdout}");
    assert!(stderr.contains("records are in out"), "{stderr}");
    assert!(folder.path().join("out/walls/near/fast.json").exists());
    assert!(!folder.path().join("out/walls/near/left.png").exists());
}

#[test]
fn results_do_not_come_among_a_scenes_own_files() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let files = |at: &str| {
        let names =
            fs::read_dir(folder.path().join(at)).unwrap().map(|entry| entry.unwrap().file_name());
        let mut names: Vec<_> = names.collect();
        names.sort();
        names
    };
    let before = files("data/walls/near");
    let arguments = "bench --data data -m fast --out data --pictures";
    let (_, stderr) = run(folder.path(), &arguments.split(' ').collect::<Vec<_>>(), 2);
    assert!(stderr.contains("results of walls/near would lie among its own files"), "{stderr}");
    assert_eq!(files("data/walls/near"), before);
}

#[test]
fn engines_at_once_are_told_and_recorded() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let words = ", 2 engines at once: times are longer than alone; ";
    for (jobs, told) in [("1", false), ("2", true)] {
        let arguments = format!("bench --data data -m fast -m balanced --jobs {jobs} -o out");
        let (stdout, _) = run(folder.path(), &arguments.split(' ').collect::<Vec<_>>(), 0);
        assert_eq!(stdout.contains(words), told, "{stdout}");
        let record = fs::read(folder.path().join("out/walls/near/fast.json")).unwrap();
        let record: serde_json::Value = serde_json::from_slice(&record).unwrap();
        assert_eq!(record["jobs"].to_string(), jobs);
    }
}

#[test]
fn without_a_choice_opencv_runs_beside_or_is_said_to_be_absent() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let arguments = ["bench", "--data", "data", "--format", "csv"];
    let mut command = hazcam(folder.path(), &arguments);
    // No Python, no OpenCV.
    let output = command.env("PATH", "nowhere").env_remove("HAZCAM_PYTHON").output().unwrap();
    assert!(output.status.success());
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.contains("opencv-bm, opencv-sgbm, opencv-wls left out: "), "{stderr}");
    let csv = String::from_utf8(output.stdout).unwrap();
    for matcher in ["fast", "balanced", "best"] {
        assert!(csv.contains(&format!("walls/near,{matcher},all")), "{csv}");
    }
}

#[test]
fn figures_are_held_to_a_file_of_limits() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let run_with = |limits: &str, status| {
        fs::write(folder.path().join("limits.toml"), limits).unwrap();
        let arguments = "bench --data data -m fast --limits limits.toml";
        run(folder.path(), &arguments.split(' ').collect::<Vec<_>>(), status)
    };
    run_with("[fast.'walls/near']\np_bad = 0.2\nD1 = '20%'", 0);
    // Everything is estimated a pixel too far: a bias counts by its size.
    let truth = Plane::filled(80, 40, 7f32);
    formats::write_disparity(folder.path().join("data/walls/near/disp0GT.pfm"), &truth).unwrap();
    let (stdout, stderr) = run_with("[fast.'walls/near']\nbias = 0.5\np_bad = 0.2", 1);
    assert!(stderr.contains("failed: fast on walls/near: bias is -"), "{stderr}");
    assert!(stderr.contains(", over 0.5\n") && !stderr.contains("p_bad"), "{stderr}");
    assert!(stdout.contains("walls/near"), "the scores are printed all the same");
    for (limits, words) in [
        ("[best.'walls/near']\np_bad = 0.2", "holds best to figures on walls/near, but that was"),
        ("[fast.'walls/far']\np_bad = 0.2", "holds fast to figures on walls/far"),
        ("[fast.'walls/near']\npsnr = 3", "`psnr` is no measure; the measures are E_RMS"),
        ("[fast.'walls/near']\ndensity = 0.5", "`density` is no measure"),
        ("[fast.'walls/near']\navgerr = -1", "`-1` is no threshold: give a number, 0 or more"),
        ("p_bad = 0.2", "limits.toml holds no limits: they look like"),
        ("", "limits.toml holds no limits: with none, every run would pass"),
        ("[fast.\"walls/near\"]", "with none, every run would pass"),
        ("[fast.\"walls/near\"]\np_bad = 5", "in a file \"5%\""),
        ("[fast.'plain/wall']\nbad2 = 5", "bad2 is a share, and `5` is more than all"),
    ] {
        let (_, stderr) = run_with(limits, 2);
        assert!(stderr.contains(words), "{limits}: {stderr}");
    }
}

#[test]
fn an_overview_goes_between_the_markers_of_a_page() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let page = folder.path().join("page.md");
    let arguments: Vec<&str> = "bench --data data -m fast --into page.md".split(' ').collect();
    fs::write(&page, "# Results\n").unwrap();
    let (stdout, stderr) = run(folder.path(), &arguments, 2);
    assert!(stderr.contains("page.md has no place for results") && stdout.is_empty(), "{stderr}");
    fs::write(&page, "# Results\n<!-- results -->\nold\n<!-- /results -->\nend\n").unwrap();
    run(folder.path(), &arguments, 0);
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.starts_with("# Results\n<!-- results -->\n| matcher | walls/near |"), "{text}");
    assert!(text.contains("made by `hazcam bench --data data -m fast --into page.md`"), "{text}");
    assert!(text.ends_with("\n<!-- /results -->\nend\n") && !text.contains("old"), "{text}");
}

#[test]
fn wrong_names_are_answered_with_the_right_ones() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    for (arguments, words) in [
        ("bench --data data --engine opencv-magic", "there is no engine `opencv-magic`; there are"),
        ("bench --data data --reference nobody", "there is no engine `nobody`"),
        ("bench --data data --scenes nothing", "no scene matches `nothing`; there are walls/near"),
        ("bench --data data --use rover", "no scene of the use"),
        ("bench --data data --matcher none", "no matcher is left to run"),
        ("bench --data data --engines nowhere", "cannot read nowhere"),
        ("bench --data data --pictures", "--out"),
        ("bench --stress --data data", "cannot be used with"),
    ] {
        let (_, stderr) = run(folder.path(), &arguments.split(' ').collect::<Vec<_>>(), 2);
        assert!(stderr.contains(words), "{arguments}: {stderr}");
    }
}

#[test]
fn a_scene_that_cannot_be_read_is_left_out_and_told() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let broken = folder.path().join("data/walls/broken");
    fs::create_dir(&broken).unwrap();
    for name in ["im0.png", "im1.png"] {
        fs::write(broken.join(name), "no picture").unwrap();
    }
    fs::copy(folder.path().join("data/walls/near/disp0GT.pfm"), broken.join("disp0GT.pfm"))
        .unwrap();
    let (stdout, stderr) = run(folder.path(), &["bench", "--data", "data", "-m", "fast"], 2);
    assert!(stderr.contains("walls/broken is left out: ") && stderr.contains("im0.png"));
    assert!(stdout.contains("walls/near"), "{stdout}");
}

#[test]
fn half_a_pair_is_left_out_and_told() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let half = folder.path().join("data/walls/half");
    fs::create_dir(&half).unwrap();
    for file in ["im0.png", "disp0GT.pfm"] {
        fs::copy(folder.path().join("data/walls/near").join(file), half.join(file)).unwrap();
    }
    fs::write(half.join("calib.txt"), "").unwrap();
    let (stdout, stderr) = run(folder.path(), &["bench", "--data", "data", "-m", "fast"], 2);
    assert!(stderr.contains("walls/half is left out: ") && stderr.contains("im1.png"), "{stderr}");
    assert!(stdout.contains("walls/near"), "{stdout}");
}

#[test]
fn truth_at_a_wrong_scale_is_told() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let truth = folder.path().join("data/walls/near/disp0GT.pfm");
    let bench = ["bench", "--data", "data", "-m", "fast"];
    assert!(!run(folder.path(), &bench, 0).1.contains("scale"));
    formats::write_disparity(&truth, &Plane::filled(80, 40, 24f32)).unwrap();
    let (_, stderr) = run(folder.path(), &bench, 0);
    let told = "walls/near: most disparities of fast are bad, but would not be if they were multiplied by 4";
    assert!(stderr.contains(told), "{stderr}");
    formats::write_disparity(&truth, &Plane::filled(80, 40, 6f32 / 256.0)).unwrap();
    let (_, stderr) = run(folder.path(), &bench, 0);
    assert!(stderr.contains("walls/near: no true disparity is larger than 1"), "{stderr}");
}

#[test]
fn stress_scenes_need_no_data() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["bench", "--stress", "--scenes", "stress/1-columns", "--matcher", "fast"];
    let (stdout, _) = run(folder.path(), &arguments, 0);
    let lines: Vec<Vec<&str>> = stdout.lines().map(|l| l.split_whitespace().collect()).collect();
    assert_eq!(lines[0], ["scene", "fast", "noc"]);
    // Of a single column the right camera sees nothing that the left one does.
    assert_eq!(lines[1], ["stress/1-columns", "100.00", "-"]);
    // Data that happens to be there changes nothing.
    let mut command = hazcam(folder.path(), &arguments);
    let output = command.env("HAZCAM_DATA", "nowhere").output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
