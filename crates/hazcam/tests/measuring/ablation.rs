//! `hazcam bench --ablation`: every ingredient does something, and leaving it out is a row.

use std::fs;
use std::path::Path;

use matching::{Ingredient, Matcher, Options, Preset};

use crate::run;

/// A cluttered room, rendered small, rectified badly and noisy.
fn room() -> scenes::Scene {
    let mut settings = scenes::Settings::new(scenes::Kind::Clutter, 3);
    (settings.columns, settings.rows, settings.max_disparity) = (240, 180, 36);
    (settings.vertical_offset, settings.noise) = (1.5, 6.0);
    scenes::render(&settings).unwrap()
}

#[test]
fn every_ingredient_changes_what_its_preset_says() {
    let scene = room();
    for preset in [Preset::Balanced, Preset::Best] {
        let found = |without: &[Ingredient]| {
            let mut options = Options::new(preset, scene.range);
            options.without = without.to_vec();
            let mut matcher = Matcher::new(options).unwrap();
            let map = matcher.compute(&scene.left, &scene.right, None).unwrap();
            // Bits, so that holes are equal to holes.
            map.values.samples().iter().map(|value| value.to_bits()).collect::<Vec<_>>()
        };
        let whole = found(&[]);
        for ingredient in Ingredient::of(preset) {
            // Even where only confidence is left out: judges are told how confident pixels are.
            assert!(found(&[*ingredient]) != whole, "{preset} is the same without {ingredient}");
        }
    }
}

/// A data set for tuning with one scene: the room.
fn data(folder: &Path) {
    let (scene, room) = (folder.join("data/rooms/one"), room());
    fs::create_dir_all(&scene).unwrap();
    formats::write_image(scene.join("left.png"), &room.left).unwrap();
    formats::write_image(scene.join("right.png"), &room.right).unwrap();
    formats::write_disparity(scene.join("truth.pfm"), &room.truth_left).unwrap();
    let seen = room.occluded.map(|&hidden| if hidden { 0 } else { 255 });
    formats::write_image(scene.join("noc.png"), &raster::Image::Grey8(seen)).unwrap();
    let catalogue = r#"[{"id": "rooms/one", "use": "tuning", "left": "rooms/one/left.png",
        "right": "rooms/one/right.png", "truth": "rooms/one/truth.pfm",
        "mask_nocc": "rooms/one/noc.png", "max_disparity": 24}]"#;
    fs::write(folder.join("data/scenes.json"), catalogue).unwrap();
}

#[test]
fn each_ingredient_left_out_is_a_row_of_the_page() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    let page = folder.path().join("page.md");
    fs::write(&page, "# Ablation\n<!-- ablation -->\nold\n<!-- /ablation -->\nend\n").unwrap();
    let command = "bench --data data --ablation --matcher balanced --format csv --into page.md";
    let (csv, _) = run(folder.path(), &command.split(' ').collect::<Vec<_>>(), 0);
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][..5], ["matcher", "without", "E_RMS", "E_RMS noc", "E_RMS occ"]);
    let left_out: Vec<&str> = rows[1..].iter().map(|row| row[1]).collect();
    let names = Ingredient::of(Preset::Balanced).iter().map(|ingredient| ingredient.name());
    assert_eq!(left_out, ["nothing"].into_iter().chain(names).collect::<Vec<_>>());
    assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{csv}");
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.contains("| balanced | nothing |") && text.contains("* median: "), "{text}");
    assert!(text.ends_with("page.md`\n<!-- /ablation -->\nend\n") && !text.contains("old"));
}

#[test]
fn what_cannot_be_left_out_is_told_with_what_can() {
    let folder = tempfile::tempdir().unwrap();
    data(folder.path());
    for (arguments, words) in [
        (
            "engine --matcher best --without salt",
            "it must be one of vertical-alignment, noise-smoothing,",
        ),
        ("engine --matcher balanced --without surface-prior", "`balanced` is made without it"),
        ("engine --matcher fast --without median", "nothing can be left out of `fast`"),
        ("bench --data data --ablation --matcher fast", "nothing can be left out of `fast`"),
        ("bench --data data --ablation --matcher none", "must be one of fast, balanced, best"),
        ("bench --ablation --stress", "cannot be used with"),
        ("bench --data data --ablation --use test", "no scene of the use"),
    ] {
        let (_, stderr) = run(folder.path(), &arguments.split(' ').collect::<Vec<_>>(), 2);
        assert!(stderr.contains(words), "{arguments}: {stderr}");
    }
}
