//! What a rover sees: Martian ground to the horizon, rocks, and the rover's own front.
//!
//! The cameras stand 1.9 m above the ground and look ahead and 17 degrees down, with a field of
//! view of 61 degrees on the longer side. The largest disparity is at a depth of 1 m, so at
//! 450 columns and 64 disparities the baseline is 0.17 m, as wide as on real hazard cameras. Axes:
//! x to the right, y ahead, z up, the origin on the ground below the left camera.

mod ground;
mod rover;

use super::Stage;
use super::builder::Builder;
use crate::light::{Light, Sky};
use crate::rig::Pose;
use crate::settings::Settings;
use crate::vector::{Vector, vector};

/// Height of the cameras above the ground in metres.
const HEIGHT: f64 = 1.9;
/// Tangent of half the angle by which the cameras look down.
const LOOK_DOWN: f64 = 0.15;
/// Focal length as a multiple of the longer side.
const FOCAL: f64 = 0.85;
/// Depth of the largest disparity in metres.
const NEAR: f64 = 1.0;
/// Bright dust, as it lies on everything.
const DUST: Vector = vector(0.5, 0.27, 0.13);

pub(super) fn build(settings: &Settings) -> Stage {
    let pose = Pose::looking_ahead(vector(0.0, 0.0, HEIGHT), LOOK_DOWN);
    let focal = FOCAL * Builder::side(settings);
    let mut builder = Builder::new(settings, "mars", pose, focal, NEAR);
    let terrain = ground::terrain(&mut builder);
    ground::rocks(&mut builder, &terrain);
    rover::front(&mut builder, &terrain);

    // A sun 25 to 50 degrees high, never straight ahead or behind, so that shadows show.
    let side = if builder.random.chance(0.5) { 1.0 } else { -1.0 };
    let sun = vector(
        side * builder.random.between(0.5, 1.0),
        builder.random.between(-0.7, 0.6),
        builder.random.between(0.45, 0.95),
    );
    let light = Light {
        sun: sun.normalized(),
        sunlight: vector(1.15, 1.02, 0.86),
        above: vector(0.26, 0.2, 0.15),
        below: vector(0.14, 0.085, 0.05),
        sky: Sky {
            horizon: vector(0.72, 0.55, 0.38),
            zenith: vector(0.42, 0.3, 0.21),
            glow: vector(0.18, 0.18, 0.18),
            clouds: 0.0,
        },
        haze: 1500.0,
    };
    builder.finish(Some(terrain), light, settings.seed)
}
