//! A street as a car sees it: road, facades, cars, poles, trees, people, and the sky.
//!
//! The cameras stand 1.65 m above the road and look ahead. The road and the facades are strongly
//! slanted; windows, bollards, railings and lane marks repeat; lamp posts, signs and wires are
//! thin; windscreens and shop windows mirror what is around them; and the sky is at infinity, where
//! the disparity is the smallest of the range. The largest disparity is just before the place where
//! the road enters the image: about 3 m at 450 x 375, where the baseline is 0.52 m. Axes: x to the
//! right, y ahead, z up, the origin on the road below the left camera.

mod buildings;
mod furniture;
mod traffic;

use super::Stage;
use super::builder::Builder;
use crate::light::{Light, Sky};
use crate::number::least;
use crate::rig::Pose;
use crate::settings::Settings;
use crate::vector::{Vector, vector};

/// Height of the cameras above the road in metres.
const HEIGHT: f64 = 1.65;
/// Focal length as a multiple of the longer side.
const FOCAL: f64 = 0.8;
/// Half the width of the road in metres.
const ROAD: f64 = 4.6;
/// Height of the pavements in metres.
const KERB: f64 = 0.13;
const UP: Vector = vector(0.0, 0.0, 1.0);

pub(super) fn build(settings: &Settings) -> Stage {
    let pose = Pose::looking_ahead(vector(0.0, 0.0, HEIGHT), 0.006);
    let focal = FOCAL * Builder::side(settings);
    let road_begins = 2.0 * focal * HEIGHT / settings.rows as f64;
    let near = least(0.93 * road_begins, 10.0);
    let mut builder = Builder::new(settings, "street", pose, focal, near);
    buildings::ground(&mut builder);
    buildings::facades(&mut builder);
    traffic::cars(&mut builder);
    traffic::people(&mut builder);
    furniture::along_the_kerbs(&mut builder);
    furniture::trees(&mut builder);
    furniture::wires(&mut builder);

    let side = if builder.random.chance(0.5) { 1.0 } else { -1.0 };
    let sun =
        vector(side * builder.random.between(0.1, 0.4), builder.random.between(-0.9, 0.4), 1.0);
    let light = Light {
        sun: sun.normalized(),
        sunlight: vector(1.15, 1.08, 0.97),
        above: vector(0.34, 0.38, 0.46),
        below: vector(0.15, 0.14, 0.13),
        sky: Sky {
            horizon: vector(0.66, 0.74, 0.84),
            zenith: vector(0.2, 0.36, 0.66),
            glow: vector(0.2, 0.2, 0.18),
            clouds: builder.random.between(0.1, 0.6),
        },
        haze: 900.0,
    };
    builder.finish(None, light, settings.seed)
}
