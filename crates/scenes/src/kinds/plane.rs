//! One textured plane with a disparity known in closed form, lit from all sides.
//!
//! With `d + doffs = f B / Z`, `x = f X / Z + cx` and `y = f Y / Z + cy`, a disparity
//! `d = offset + a x + b y` is the plane `f B = a f X + b f Y + (offset + a cx + b cy + doffs) Z`.

use super::Stage;
use crate::geometry::Panel;
use crate::light::{Light, Sky};
use crate::number::{greatest, least};
use crate::rig::{Pose, Rig};
use crate::settings::{Settings, SettingsError};
use crate::texture::{Material, Pattern};
use crate::vector::{Frame, vector};
use crate::world::{Object, World};

/// Largest slope in pixels of disparity per pixel; at 1 the right camera would see the plane on
/// edge.
const STEEPEST: f64 = 0.9;
/// Large enough to fill every view.
const REACH: f64 = 1e9;

/// The light of a scene without any: every surface shows its own colour.
pub(super) fn even_light() -> Light {
    let white = vector(1.0, 1.0, 1.0);
    Light {
        sun: vector(0.0, 0.0, 1.0),
        sunlight: vector(0.0, 0.0, 0.0),
        above: white,
        below: white,
        sky: Sky::plain(vector(0.2, 0.2, 0.2)),
        haze: f64::INFINITY,
    }
}

/// Rich texture: the widest feature is 12 pixels wide at a depth of 1 m.
pub(super) fn easy_texture(focal: f64) -> Material {
    let speckle = Pattern::Speckle { size: 12.0 / focal };
    Material::patterned(speckle, vector(0.02, 0.02, 0.03), vector(0.8, 0.75, 0.65))
}

/// Smallest and largest value of `offset + per_column * x + per_row * y` up to these last pixels.
fn extremes(offset: f64, per_column: f64, per_row: f64, last: (f64, f64)) -> (f64, f64) {
    let growth = [last.0 * per_column, last.1 * per_row];
    let low = offset + growth.iter().filter(|v| **v < 0.0).sum::<f64>();
    let high = offset + growth.iter().filter(|v| **v > 0.0).sum::<f64>();
    (low, high)
}

fn last_pixel(settings: &Settings) -> (f64, f64) {
    ((settings.columns - 1) as f64, (settings.rows - 1) as f64)
}

pub(super) fn check(
    settings: &Settings,
    offset: f64,
    per_column: f64,
    per_row: f64,
) -> Result<(), SettingsError> {
    for (field, slope) in [("per_column", per_column), ("per_row", per_row)] {
        // A NaN is in no range.
        if !(-STEEPEST..=STEEPEST).contains(&slope) {
            let allowed = format!("it must be from -{STEEPEST} to {STEEPEST} pixels per pixel");
            return Err(SettingsError::new(field, slope, allowed));
        }
    }
    let (low, high) = extremes(offset, per_column, per_row, last_pixel(settings));
    let (min, max) = (f64::from(settings.min_disparity), f64::from(settings.max_disparity));
    if low >= min && high <= max {
        return Ok(());
    }
    Err(SettingsError::new(
        "offset",
        offset,
        format!(
            "the plane's disparities {low} to {high} must lie within min_disparity to \
             max_disparity, {min} to {max}"
        ),
    ))
}

pub(super) fn build(settings: &Settings, offset: f64, per_column: f64, per_row: f64) -> Stage {
    let focal = settings.columns.max(settings.rows) as f64;
    let pose = Pose::looking_ahead(vector(0.0, 0.0, 0.0), 0.0);
    let mut rig = Rig::new(settings, pose, focal, 1.0);

    // Both views, and what lies around their edges, must be in front of the cameras. The right
    // view's disparity at its own (x, y) is (offset + a x + b y) / (1 - a).
    let left = extremes(offset, per_column, per_row, last_pixel(settings));
    let shrink = 1.0 - per_column;
    let right =
        extremes(offset / shrink, per_column / shrink, per_row / shrink, last_pixel(settings));
    let margin = (1.0 + settings.vertical_offset.abs()) / shrink;
    let (low, high) = (least(left.0, right.0) - margin, greatest(left.1, right.1) + margin);
    // The plane's depths run from 1 m to 2 m, whatever its disparities are.
    let span = high - low;
    rig.doffs = span - low;
    rig.baseline = (high + rig.doffs) / focal;
    rig.near = 0.25;

    let ahead = offset + per_column * rig.cx + per_row * rig.cy + rig.doffs;
    let normal =
        pose.right * (per_column * focal) + pose.down * (per_row * focal) + pose.forward * ahead;
    let middle = pose.point(0.0, 0.0, focal * rig.baseline / ahead);
    let panel = Panel::new(middle, Frame::along(normal), REACH, REACH);
    let objects = vec![Object { shape: panel.into(), material: easy_texture(focal) }];
    Stage { world: World::new(objects, None, even_light(), settings.seed), rig }
}
