//! `hazcam bench --speed`: what is kept and shown, never how long anything took.

use std::fs;

use crate::{hazcam, run};

/// The smallest pair, on which only `fast` runs.
const SMALL: &str = "bench --speed --scenes cones-sized --matcher fast --repeat 2";

fn words(command: &str) -> Vec<&str> {
    command.split(' ').collect()
}

#[test]
fn without_data_rendered_pairs_of_the_same_sizes_stand_in() {
    let folder = tempfile::tempdir().unwrap();
    let (csv, stderr) = run(folder.path(), &words(&format!("{SMALL} --format csv")), 0);
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][..6], ["scene", "size", "threads", "matcher", "runs", "min ms"]);
    assert_eq!(rows[1][..5], ["cones-sized", "450 x 375 x 64", "1", "fast", "2"]);
    assert_eq!(rows.len(), 2, "{csv}");
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
    assert!(stderr.contains("stand in for course/cones and course/kitti"), "{stderr}");
}

#[test]
fn without_python_one_line_says_who_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = format!("{SMALL} --engine opencv-bm-9x9,opencv-hh");
    let mut command = hazcam(folder.path(), &words(&arguments));
    let output = command.env("PATH", "nowhere").env_remove("HAZCAM_PYTHON").output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    // Whoever is called by name and has nothing to say is no success.
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.contains("opencv-hh was asked for and has given no answer"), "{stderr}");
    let left_out: Vec<&str> = stderr.lines().filter(|line| line.contains("left out")).collect();
    assert_eq!(left_out.len(), 1, "{stderr}");
    assert!(left_out[0].contains("opencv-bm-9x9, opencv-hh left out: "), "{stderr}");
    let stdout = String::from_utf8(output.stdout).unwrap();
    assert!(stdout.starts_with("scene") && !stdout.contains("peer ms"), "{stdout}");
}

#[test]
fn a_record_grows_and_a_page_is_made_from_all_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    fs::write(&page, "<!-- speed -->\nold\n<!-- /speed -->\nend\n").unwrap();
    let record = "--record speed.json --into page.md";
    run(folder.path(), &words(&format!("{SMALL} {record}")), 0);
    let sweep = "bench --speed --sweep --scenes sweep/390x260x64 -m fast --repeat 1 --threads 2";
    let (stdout, _) = run(folder.path(), &words(&format!("{sweep} {record}")), 0);
    assert!(stdout.starts_with("size            Mpixel  threads  fast ns\n"), "{stdout}");
    assert!(!stdout.contains("cones-sized"), "{stdout}");
    let both = fs::read_to_string(&page).unwrap();
    assert!(both.starts_with("<!-- speed -->\n| size | Mpixel | threads | fast ns |"), "{both}");
    assert!(both.contains("made by `hazcam bench --speed --scenes cones-sized"), "{both}");
    assert!(both.contains("--into page.md`, `hazcam bench --speed --sweep"), "{both}");
    assert!(both.ends_with("\n<!-- /speed -->\nend\n") && !both.contains("old"), "{both}");
    fs::write(&page, "<!-- speed -->\n<!-- /speed -->\nend\n").unwrap();
    let (stdout, _) = run(folder.path(), &words(&format!("bench --speed --recorded {record}")), 0);
    assert!(stdout.contains("cones-sized") && stdout.contains("390 x 260 x 64"), "{stdout}");
    assert_eq!(fs::read_to_string(&page).unwrap(), both);
    let json = fs::read_to_string(folder.path().join("speed.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["runs"][0]["measurements"][0]["seconds"].as_array().unwrap().len(), 2);
    assert_eq!(json["runs"][1]["threads"], 2);
}

#[cfg(unix)]
#[test]
fn an_engine_that_does_not_tell_its_time_is_told_how() {
    let folder = tempfile::tempdir().unwrap();
    let script = r#"echo '{"hazcam":"ready","protocol":1}'; read line
        cp ../answer.npy disparity.npy; echo '{"hazcam":"done","job":1}'; read line"#;
    let script = script.replace("..", &folder.path().display().to_string());
    let answer = raster::Plane::filled(450, 375, 1f32);
    formats::write_disparity(folder.path().join("answer.npy"), &answer).unwrap();
    let engine = format!("name = 'mute'\ncommand = ['/bin/sh', '-c', '''{script}''']");
    fs::write(folder.path().join("mute.toml"), engine).unwrap();
    let arguments = format!("{SMALL} --engines . --engine mute");
    let (stdout, stderr) = run(folder.path(), &words(&arguments), 2);
    assert!(stderr.contains("mute was asked for and has given no answer that counts"), "{stderr}");
    let told = "cones-sized, mute: bad-result: its answer does not say how long matching took";
    assert!(stdout.contains(told), "{stdout}");
}

#[test]
fn what_cannot_be_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("other.json"), "[1]").unwrap();
    fs::write(folder.path().join("page.md"), "# no place\n").unwrap();
    for (arguments, words_of_error) in [
        ("bench --sweep", "--speed"),
        ("bench --record speed.json", "--speed"),
        ("bench --record speed.json --use tuning", "cannot be used with"),
        ("bench --record speed.json --obstacles", "cannot be used with"),
        ("bench --sweep --jobs 2", "cannot be used with"),
        ("bench --recorded --obstacles", "cannot be used with"),
        ("bench --recorded --use tuning", "cannot be used with"),
        ("bench --recorded --out results", "cannot be used with"),
        ("bench --speed --ablation", "cannot be used with"),
        ("bench --speed --jobs 2", "cannot be used with"),
        ("bench --speed --recorded", "--record"),
        ("bench --speed --stress", "cannot be used with"),
        ("bench --speed --sweep --data .", "cannot be used with"),
        ("bench --speed --limits x.toml", "cannot be used with"),
        ("bench --speed --out results", "cannot be used with"),
        ("bench --speed --record speed.json --recorded", "cannot read speed.json"),
        ("bench --speed --record other.json", "other.json holds no record of"),
        // Before anything is chosen or measured.
        ("bench --speed --scenes none --record no/speed.json", "the folder no does not exist"),
        ("bench --speed --into page.md", "put the lines <!-- speed --> and <!-- /speed -->"),
        ("bench --speed --scenes x", "no scene matches `x`; there are cones-sized, kitti-sized"),
    ] {
        let (_, stderr) = run(folder.path(), &words(arguments), 2);
        assert!(stderr.contains(words_of_error), "{arguments}: {stderr}");
    }
}
