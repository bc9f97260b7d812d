//! `hazcam bench --obstacles`: how much of small things matchers miss.

use std::fs;
use std::path::Path;

use crate::run;

/// A data set with two scenes: rendered cards, and the same pair without its truth.
fn data(folder: &Path) {
    let mut settings = scenes::Settings::new(scenes::Kind::Cards, 3);
    (settings.columns, settings.rows, settings.max_disparity) = (300, 220, 40);
    let scene = scenes::render(&settings).unwrap();
    fs::create_dir_all(folder.join("data")).unwrap();
    formats::write_image(folder.join("data/left.png"), &scene.left).unwrap();
    formats::write_image(folder.join("data/right.png"), &scene.right).unwrap();
    formats::write_disparity(folder.join("data/truth.pfm"), &scene.truth_left).unwrap();
    let one = |name: &str, purpose: &str, truth: &str| {
        format!(
            r#"{{"id": "cards/{name}", "use": "{purpose}", "left": "left.png", "right": "right.png"{truth},
            "max_disparity": 48}}"#
        )
    };
    let known = one("known", "tuning", r#", "truth": "truth.pfm""#);
    let all = [known, one("unknown", "rover", "")].join(",");
    fs::write(folder.join("data/scenes.json"), format!("[{all}]")).unwrap();
}

#[test]
fn narrow_things_are_missed_more_often_than_wide_ones() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let page = folder.path().join("page.md");
    fs::write(&page, "<!-- obstacles -->\n<!-- /obstacles -->\n").unwrap();
    let command = "bench --data data --obstacles -m fast -m balanced --format csv --into page.md -o out --pictures";
    let (csv, _) = run(folder.path(), &command.split(' ').collect::<Vec<_>>(), 0);
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    let names = ["smaller side px", "step px", "matcher", "missed %", "surely %", "overlooked %"];
    assert_eq!(rows[0], names, "{csv}");
    // Of both matchers for each step of each width.
    let kinds = ["up to 9", "10 to 16", "17 and more"]
        .into_iter()
        .flat_map(|side| ["0.7 to 1.5", "1.5 to 3", "3 and more"].map(|step| (side, step)));
    let expected = kinds.flat_map(|(side, step)| ["fast", "balanced"].map(|of| [side, step, of]));
    let found: Vec<_> = rows[1..].iter().map(|row| [row[0], row[1], row[2]]).collect();
    assert_eq!(found, expected.collect::<Vec<_>>());
    let share = |cell: &str| cell.parse::<f64>().ok();
    for row in &rows[1..] {
        // What is missed surely is missed; of some kind there may be none.
        let [missed, surely, overlooked] = [3, 4, 5].map(|i| share(row[i]));
        assert!(missed >= surely && missed <= Some(100.0), "{csv}");
        assert!(overlooked <= Some(100.0), "{csv}");
    }
    let missed = |matcher: &str, side: &str| {
        let row = rows.iter().find(|row| row[..3] == [side, "3 and more", matcher]).unwrap();
        share(row[3]).unwrap()
    };
    for matcher in ["fast", "balanced"] {
        assert!(missed(matcher, "up to 9") > missed(matcher, "17 and more"), "{csv}");
    }
    let page = fs::read_to_string(&page).unwrap();
    assert!(
        page.contains("| up to 9 | 0.7 to 1.5 | fast |") && page.contains("* overlooked: "),
        "{page}"
    );
    assert!(page.contains("| nearer by px | matcher | false alarms % | surely % |"), "{page}");
    let record = folder.path().join("out/obstacles/cards/known/fast.json");
    let record = fs::read_to_string(record).unwrap();
    assert!(record.contains(r#""from_width": 10"#) && record.contains("lie before it"), "{record}");
    let picture = folder.path().join("out/obstacles/cards/known/balanced-obstacles.png");
    let raster::Image::Rgb8(picture) = formats::read_image(picture).unwrap() else {
        panic!("grey")
    };
    let of = |is_so: fn(&[u8; 3]) -> bool| picture.samples().iter().filter(|p| is_so(p)).count();
    let green = of(|[r, g, b]| *g > r.saturating_add(60) && *g > b.saturating_add(60));
    let red = of(|[r, g, b]| *r > g.saturating_add(100) && *r > b.saturating_add(100));
    assert!(green > red && red > 0, "{green} pixels are green, {red} red");
    // Tables of another kind take their place in no folder.
    let others = "bench --data data --use tuning -m fast -o out";
    run(folder.path(), &others.split(' ').collect::<Vec<_>>(), 0);
    let kept = fs::read_to_string(folder.path().join("out/obstacles.csv")).unwrap();
    assert_eq!(kept.replace("\r\n", "\n"), csv.replace("\r\n", "\n"));
    assert!(folder.path().join("out/scores.csv").exists());
    // Where there is no truth nobody is asked.
    assert!(!folder.path().join("out/obstacles/cards/unknown").exists());
}

#[test]
fn where_nothing_was_measured_what_was_there_stays() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    // Nothing can be nearer than the scene itself.
    let catalogue = folder.path().join("data/scenes.json");
    let narrow = fs::read_to_string(&catalogue).unwrap().replace(": 48", ": 1");
    fs::write(&catalogue, narrow).unwrap();
    let text = "<!-- obstacles -->\nold\n<!-- /obstacles -->\n";
    fs::write(folder.path().join("page.md"), text).unwrap();
    let command = "bench --data data --obstacles -m fast --into page.md -o out";
    let (_, stderr) = run(folder.path(), &command.split(' ').collect::<Vec<_>>(), 2);
    assert!(
        stderr.contains("no obstacle fits in: ") && !stderr.contains("records are in"),
        "{stderr}"
    );
    assert_eq!(fs::read_to_string(folder.path().join("page.md")).unwrap(), text);
    assert!(!folder.path().join("out/obstacles.csv").exists());
}

#[test]
fn without_truth_nothing_can_be_laid() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let command = "bench --data data --obstacles -m fast --use rover";
    let (_, stderr) = run(folder.path(), &command.split(' ').collect::<Vec<_>>(), 2);
    assert!(stderr.contains("truth, by which --obstacles tells what is wrong"), "{stderr}");
}
