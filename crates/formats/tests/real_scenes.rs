//! Every file of the scenes under `HAZCAM_DATA` is read, and its parts agree with each other.

use std::env;
use std::fs;
use std::path::Path;

use formats::{
    Encoding, inspect, read_bounding_box, read_calibration, read_disparity, read_image, read_mask,
};
use serde_json::Value;

#[test]
fn every_scene_reads_and_its_parts_agree() {
    let Some(data) = env::var_os("HAZCAM_DATA") else {
        eprintln!("skipped: HAZCAM_DATA names no folder with scenes.json");
        return;
    };
    let data = Path::new(&data);
    let Ok(list) = fs::read_to_string(data.join("scenes.json")) else {
        eprintln!("skipped: HAZCAM_DATA names no folder with scenes.json");
        return;
    };
    let list: Value = serde_json::from_str(&list).expect("scenes.json is JSON");
    let scenes = list.as_array().expect("scenes.json is a list");
    assert!(!scenes.is_empty());
    let mut with_truth = 0;
    for scene in scenes {
        with_truth += usize::from(check(data, scene));
    }
    eprintln!("read {} scenes, {with_truth} of them with truth", scenes.len());
}

/// Reads all that a scene names; whether it has truth.
fn check(data: &Path, scene: &Value) -> bool {
    let id = scene["id"].as_str().expect("a scene has an id");
    let file = |key: &str| scene[key].as_str().map(|name| data.join(name));
    let left = read_image(file("left").expect("a scene has a left image")).unwrap();
    let right = read_image(file("right").expect("a scene has a right image")).unwrap();
    assert_eq!(left.size(), right.size(), "{id}");
    let (columns, rows) = left.size();

    if let Some(path) = file("mask_nocc") {
        let mask = read_mask(&path).unwrap();
        assert_eq!(mask.size(), left.size(), "{id}");
        assert!(mask.samples().contains(&true), "{id}");
    }
    if let Some(path) = file("box") {
        read_bounding_box(&path).unwrap().check_within(columns, rows).unwrap();
        inspect(&path).unwrap();
    }
    if let Some(path) = file("calib") {
        let calibration = read_calibration(&path).unwrap();
        if let (Some(width), Some(height)) = (calibration.width, calibration.height) {
            assert_eq!((width, height), (columns, rows), "{id}");
        }
        inspect(&path).unwrap();
    }
    let Some(path) = file("truth") else { return false };
    let encoding: Encoding = scene["truth_encoding"].as_str().unwrap().parse().unwrap();
    let max_disparity = scene["max_disparity"].as_f64().unwrap() as f32;
    for path in [Some(path), file("truth_noc")].into_iter().flatten() {
        let truth = read_disparity(&path, encoding).unwrap();
        assert_eq!((truth.values.size(), truth.note), (left.size(), None), "{id}");
        let valid: Vec<f32> =
            truth.values.samples().iter().copied().filter(|v| !v.is_nan()).collect();
        assert!(!valid.is_empty(), "{id}");
        for value in valid {
            assert!((0.0..=max_disparity + 2.0).contains(&value), "{id}: {value}");
        }
        // The trap: read without its scale, an 8-bit map is 4 times as large.
        if encoding == (Encoding::Png8 { divisor: 4.0 }) {
            let trapped = read_disparity(&path, Encoding::Auto).unwrap();
            assert!(trapped.note.is_some(), "{id}");
        }
        inspect(&path).unwrap();
    }
    true
}
