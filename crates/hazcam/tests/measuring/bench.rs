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
    let arguments = ["bench", "--data", "data", "--engines", "engines", "--engine", "crash,shy"];
    let (stdout, stderr) = run(folder.path(), &[&arguments[..], &["-m", "fast"]].concat(), 0);
    assert!(stdout.contains("crashed"), "{stdout}");
    assert!(
        stdout.contains("walls/near, crash: crashed: it exited with status 3 without an answer")
    );
    assert!(stdout.contains("fast     all"), "{stdout}");
    assert!(stderr.contains("left out: shy: no licence"), "{stderr}");
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
fn stress_scenes_need_no_data() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["bench", "--stress", "--scenes", "stress/1-columns", "--matcher", "fast"];
    let (stdout, _) = run(folder.path(), &arguments, 0);
    assert!(stdout.contains("stress/1-columns  fast"), "{stdout}");
}
