//! `hazcam info` and `hazcam explain`.

use crate::folder::Folder;

#[test]
fn every_kind_of_file_is_described() {
    let folder = Folder::with_pair(24, 16);
    folder.disparities("d.pfm", &[1.0, 2.5, f32::NAN]);
    let outcome = folder.run("info left.png d.pfm").done();
    assert!(outcome.stdout.contains("left.png: PNG picture"), "{}", outcome.stdout);
    assert!(outcome.stdout.contains("24 x 16"));
    assert!(outcome.stdout.contains("1 to 2.5000, mean 1.75, no value at 33.3 %"));
    let outcome = folder.run("info --json d.pfm").done();
    let found: serde_json::Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(found[0]["content"]["columns"], 3);
}

#[test]
fn a_file_that_is_not_understood_does_not_hide_the_others() {
    let folder = Folder::with_pair(24, 16);
    std::fs::write(folder.path("story.txt"), "once upon a time").unwrap();
    let outcome = folder.run("info story.txt left.png");
    assert_eq!(outcome.status, 2);
    assert!(outcome.stdout.contains("left.png: PNG picture"));
    assert!(outcome.stderr.contains("story.txt is text"), "{}", outcome.stderr);
}

#[test]
fn every_matcher_can_be_explained() {
    let folder = Folder::new();
    for matcher in ["fast", "balanced", "best"] {
        let outcome = folder.run(&format!("explain {matcher}")).done();
        assert!(outcome.stdout.lines().count() >= 5, "{matcher}: {}", outcome.stdout);
    }
    let all = folder.run("explain").done().stdout;
    insta::assert_snapshot!(all);
    folder.refuses("explain slow", &["slow", "fast, balanced, best"]);
}
