//! The two cameras: ideal pinholes, rectified, side by side.
//!
//! Pixel centres have whole coordinates. The left camera's pixel `(x, y)` looks along
//! `right * (x - cx) / f + down * (y - cy) / f + forward`, so a ray's `t` is the depth `Z` along the
//! optical axis, and with the right camera `baseline` to the right and its principal point shifted
//! by `doffs` (Middlebury's term)
//!
//! `d = x_left - x_right = f * baseline / Z - doffs`.

use crate::geometry::Ray;
use crate::settings::Settings;
use crate::vector::{Vector, vector};

/// Which camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Left,
    Right,
}

/// Where the left camera stands and looks. The world's z points up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pose {
    pub place: Vector,
    pub right: Vector,
    pub down: Vector,
    pub forward: Vector,
}

impl Pose {
    /// Standing at `place`, looking along +y and down by the angle whose half has this tangent.
    pub fn looking_ahead(place: Vector, half_tangent: f64) -> Self {
        let square = half_tangent * half_tangent;
        let cosine = (1.0 - square) / (1.0 + square);
        let sine = 2.0 * half_tangent / (1.0 + square);
        Self {
            place,
            right: vector(1.0, 0.0, 0.0),
            down: vector(0.0, -sine, -cosine),
            forward: vector(0.0, cosine, -sine),
        }
    }

    /// The world's point with these coordinates to the right, downwards and ahead.
    pub fn point(&self, right: f64, down: f64, depth: f64) -> Vector {
        self.place + self.right * right + self.down * down + self.forward * depth
    }
}

/// A stereo pair of cameras.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rig {
    pub pose: Pose,
    /// Focal length in pixels.
    pub focal: f64,
    /// Metres from the left to the right camera.
    pub baseline: f64,
    /// Depth in metres before which nothing is seen.
    pub near: f64,
    /// The left camera's principal point.
    pub cx: f64,
    pub cy: f64,
    /// The right camera's cx less the left one's.
    pub doffs: f64,
    /// The right camera's cy less the left one's.
    pub vertical: f64,
    pub columns: usize,
    pub rows: usize,
}

impl Rig {
    /// Cameras that give depth `near` the largest disparity of the settings and infinity the
    /// smallest. Nothing nearer is seen, so no disparity leaves that range.
    pub fn new(settings: &Settings, pose: Pose, focal: f64, near: f64) -> Self {
        let span = f64::from(settings.max_disparity) - f64::from(settings.min_disparity);
        Self {
            pose,
            focal,
            baseline: span * near / focal,
            near,
            cx: 0.5 * (settings.columns - 1) as f64,
            cy: 0.5 * (settings.rows - 1) as f64,
            doffs: f64::from(-settings.min_disparity),
            vertical: settings.vertical_offset,
            columns: settings.columns,
            rows: settings.rows,
        }
    }

    /// Where the camera's pinhole is.
    pub fn pinhole(&self, side: Side) -> Vector {
        match side {
            Side::Left => self.pose.place,
            Side::Right => self.pose.place + self.pose.right * self.baseline,
        }
    }

    /// The ray through `(x, y)` of that camera's image; its `t` is the depth.
    #[inline]
    pub fn ray(&self, side: Side, x: f64, y: f64) -> Ray {
        let (cx, cy) = match side {
            Side::Left => (self.cx, self.cy),
            Side::Right => (self.cx + self.doffs, self.cy + self.vertical),
        };
        let (u, v) = ((x - cx) / self.focal, (y - cy) / self.focal);
        Ray {
            origin: self.pinhole(side),
            direction: self.pose.right * u + self.pose.down * v + self.pose.forward,
        }
    }

    /// The disparity of points at this depth; of infinity too.
    #[inline]
    pub fn disparity(&self, depth: f64) -> f64 {
        self.focal * self.baseline / depth - self.doffs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::Kind;

    #[test]
    fn a_point_is_seen_where_its_disparity_says() {
        let mut settings = Settings::new(Kind::Cards, 0);
        settings.min_disparity = -7;
        settings.vertical_offset = 1.5;
        let pose = Pose::looking_ahead(vector(1.0, 2.0, 3.0), 0.2);
        let rig = Rig::new(&settings, pose, 400.0, 1.5);
        assert!((rig.disparity(1.5) - 64.0).abs() < 1e-12);
        assert_eq!(rig.disparity(f64::INFINITY), -7.0);
        let depth = 3.3;
        let point = rig.ray(Side::Left, 101.25, 37.5).at(depth);
        let d = rig.disparity(depth);
        let other = rig.ray(Side::Right, 101.25 - d, 37.5 + 1.5).at(depth);
        assert!((point - other).length() < 1e-12);
    }
}
