//! Sets of scenes that measurements share.

use crate::kinds::Kind;
use crate::number::least;
use crate::settings::{Depth, Settings};

/// The scenes that `hazcam demo` renders and matches: small, and each hard in its own way. One for
/// every kind, from cards, where only occlusion is hard, to a room in which everything is.
pub fn demo_scenes() -> Vec<Settings> {
    Kind::NAMED.map(|kind| Settings::new(kind, 1)).to_vec()
}

/// Scenes that each strain one assumption of a matcher, with a label that says which and how
/// much. All are the same cards with fine texture, 450 x 375 pixels, 0 to 64 disparities and noise
/// 1, and differ in nothing else, so that what grows is due to it; but for those that lean, each of
/// which is one plane with the same texture.
pub fn stress_scenes() -> Vec<(String, Settings)> {
    let mut scenes = Vec::new();
    let base = Settings::new(Kind::Cards, 1);
    let mut add = |label: String, change: &dyn Fn(&mut Settings)| {
        let mut settings = base.clone();
        change(&mut settings);
        scenes.push((label, settings));
    };
    add("plain".into(), &|_| {});
    for factor in [0.25, 0.5, 2.0] {
        add(format!("right exposure {factor}"), &|s| s.right_exposure = factor);
    }
    for gain in [0.7, 1.3] {
        add(format!("right gain {gain}"), &|s| s.right_gain = gain);
    }
    for gamma in [0.6, 1.6] {
        add(format!("right gamma {gamma}"), &|s| s.right_gamma = gamma);
    }
    for offset in [0.5, 1.0, 1.5, 2.0] {
        add(format!("vertical offset {offset} px"), &|s| s.vertical_offset = offset);
    }
    for noise in [0.0, 2.0, 5.0, 10.0, 20.0] {
        add(format!("noise {noise}"), &|s| s.noise = noise);
    }
    add("16 bit".into(), &|s| s.depth = Depth::Sixteen);
    for contrast in [0.5, 0.2, 0.0] {
        add(format!("texture contrast {contrast}"), &|s| s.contrast = contrast);
    }
    for exposure in [0.1, 4.0, 16.0] {
        add(format!("exposure {exposure}"), &|s| s.exposure = exposure);
    }
    for count in [1, 2, 16, 128, 256, 512] {
        add(format!("{count} disparities"), &|s| s.max_disparity = count - 1);
    }
    add("negative disparities".into(), &|s| (s.min_disparity, s.max_disparity) = (-16, 47));
    for columns in [32, 8, 1] {
        add(format!("{columns} columns"), &|s| s.columns = columns);
    }
    // The farthest point of each has disparity 2, and its range ends where it does.
    let mut lean = |label: String, per_column: f64, per_row: f64| {
        add(label, &|s| {
            let nearer = (per_column * (s.columns - 1) as f64, per_row * (s.rows - 1) as f64);
            let offset = 2.0 - least(nearer.0, 0.0) - least(nearer.1, 0.0);
            s.kind = Kind::Plane { offset, per_column, per_row };
            s.max_disparity = (2.0 + nearer.0.abs() + nearer.1.abs()).ceil() as i32;
        });
    };
    for slope in [0.1, 0.2, 0.4] {
        lean(format!("floor {slope} px a row"), 0.0, slope);
    }
    for slope in [0.1, 0.2, 0.4, -0.1, -0.2, -0.4] {
        lean(format!("wall {slope} px a column"), slope, 0.0);
    }
    scenes
}
