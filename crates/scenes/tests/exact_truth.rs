//! The truth of a rendered scene is exact: planes have the disparities of their formula, both views
//! tell the same story, and the pictures agree where the truth says that they show the same thing.

// The functions that rendering must not use are fine for looking at what came out.
#![allow(clippy::disallowed_methods)]

use raster::{Image, Plane};
use scenes::{Channels, Kind, Scene, Settings, render};

fn small(kind: Kind, seed: u64) -> Settings {
    let mut settings = Settings::new(kind, seed);
    (settings.columns, settings.rows, settings.max_disparity) = (160, 120, 24);
    (settings.channels, settings.noise) = (Channels::Grey, 0.0);
    settings
}

fn rendered(settings: &Settings) -> Scene {
    render(settings).unwrap_or_else(|error| panic!("{}: {error}", settings.name()))
}

fn grey(image: &Image) -> &Plane<u8> {
    match image {
        Image::Grey8(plane) => plane,
        other => panic!("8-bit grey was asked for, not {:?}", other.size()),
    }
}

#[test]
fn a_plane_has_the_disparities_of_its_formula() {
    for (offset, per_column, per_row) in [(7.0, 0.0, 0.0), (4.25, 0.08, 0.0), (20.0, -0.05, -0.07)]
    {
        let kind = Kind::Plane { offset, per_column, per_row };
        let scene = rendered(&small(kind, 3));
        for y in 0..120 {
            for x in 0..160 {
                let expected = offset + per_column * x as f64 + per_row * y as f64;
                let found = f64::from(scene.truth_left.row(y)[x]);
                assert!((found - expected).abs() < 1e-4, "{kind} at {x}, {y}: {found}");
                // Occluded is what lies outside the right image, whose pixels reach half a pixel
                // beyond their centres.
                let outside = !(-0.5..159.5).contains(&(x as f64 - expected));
                let at_the_edge = (x as f64 - expected + 0.5).abs() < 1e-3;
                assert!(scene.occluded.row(y)[x] == outside || at_the_edge, "{kind} at {x}, {y}");
            }
        }
    }
}

#[test]
fn a_whole_disparity_moves_the_picture_by_whole_pixels() {
    let kind = Kind::Plane { offset: 9.0, per_column: 0.0, per_row: 0.0 };
    let scene = rendered(&small(kind, 5));
    let (left, right) = (grey(&scene.left), grey(&scene.right));
    let mut varied = 0;
    for y in 0..120 {
        for x in 9..160 {
            let (a, b) = (left.row(y)[x], right.row(y)[x - 9]);
            assert!(a.abs_diff(b) <= 1, "{x}, {y}: {a} and {b}");
            varied += usize::from(a.abs_diff(left.row(y)[x - 1]) > 2);
        }
    }
    assert!(varied > 5000, "a blank picture would prove nothing: {varied}");
}

#[test]
fn with_a_vertical_offset_the_right_picture_stands_lower() {
    let kind = Kind::Plane { offset: 6.0, per_column: 0.0, per_row: 0.0 };
    let level = rendered(&small(kind, 5));
    let mut settings = small(kind, 5);
    settings.vertical_offset = 2.0;
    let lower = rendered(&settings);
    assert_eq!(lower.left, level.left);
    assert_eq!(lower.truth_left, level.truth_left);
    for y in 2..120 {
        for x in 0..160 {
            let (a, b) = (grey(&lower.right).row(y)[x], grey(&level.right).row(y - 2)[x]);
            assert!(a.abs_diff(b) <= 1, "{x}, {y}: {a} and {b}");
        }
    }
}

/// For every kind: a left pixel that the right camera sees has its disparity in the right truth
/// too, and one that something hides has a larger one before it.
#[test]
fn both_views_tell_the_same_story() {
    for kind in Kind::NAMED {
        let scene = rendered(&small(kind, 2));
        let (mut seen, mut agreeing, mut hidden, mut covered) = (0, 0, 0, 0);
        for y in 0..120 {
            for x in 0..160 {
                let d = scene.truth_left.row(y)[x];
                let at = x as f32 - d;
                if !(0.0..159.0).contains(&at) {
                    continue;
                }
                let right = scene.truth_right.row(y);
                let (low, high) = (right[at as usize], right[at as usize + 1]);
                if scene.occluded.row(y)[x] {
                    hidden += 1;
                    covered += usize::from(low.max(high) > d + 0.04);
                } else {
                    seen += 1;
                    agreeing += usize::from((low - d).abs().min((high - d).abs()) < 0.75);
                }
            }
        }
        assert!(seen > 9000 && hidden > 100, "{kind}: {seen} seen, {hidden} hidden");
        // Between the two right pixels that are asked, a thing thinner than a pixel can stand.
        assert!(agreeing as f64 > 0.985 * seen as f64, "{kind}: {agreeing} of {seen}");
        assert!(covered as f64 > 0.95 * hidden as f64, "{kind}: {covered} of {hidden}");
    }
}

/// Mean squared difference between the left picture and the right one fetched through the truth
/// moved by `shift`, over pixels that both cameras see and that are far from any edge.
fn mismatch(scene: &Scene, shift: f32) -> f64 {
    let (left, right) = (grey(&scene.left), grey(&scene.right));
    let (mut sum, mut count) = (0.0, 0);
    for y in 0..left.rows() {
        for x in 0..left.columns() {
            let at = x as f32 - scene.truth_left.row(y)[x] - shift;
            let inside = at >= 0.0 && at < (left.columns() - 1) as f32;
            if scene.occluded.row(y)[x] || scene.discontinuity.row(y)[x] || !inside {
                continue;
            }
            let row = right.row(y);
            let (i, part) = (at as usize, at.fract());
            let value = f32::from(row[i]) * (1.0 - part) + f32::from(row[i + 1]) * part;
            sum += f64::from((value - f32::from(left.row(y)[x])).powi(2));
            count += 1;
        }
    }
    sum / f64::from(count)
}

#[test]
fn the_pictures_agree_best_through_the_truth_itself() {
    for kind in Kind::NAMED {
        for seed in [1, 2] {
            let scene = rendered(&small(kind, seed));
            let exact = mismatch(&scene, 0.0);
            for shift in [-1.0, -0.5, 0.5, 1.0] {
                let moved = mismatch(&scene, shift);
                assert!(exact < moved, "{kind} {seed}: {exact} at 0, {moved} at {shift}");
            }
        }
    }
}

#[test]
fn no_truth_leaves_the_range() {
    for kind in Kind::NAMED {
        let mut settings = small(kind, 7);
        (settings.min_disparity, settings.max_disparity) = (-9, 12);
        let scene = rendered(&settings);
        for truth in [&scene.truth_left, &scene.truth_right] {
            let inside = |&d: &f32| (-9.0..=12.0).contains(&d);
            assert!(truth.samples().iter().all(inside), "{kind}");
        }
        let nearest = scene.truth_left.samples().iter().copied().fold(f32::MIN, f32::max);
        assert!(nearest > 6.0, "{kind}: the range must be used, not only kept ({nearest})");
    }
}
