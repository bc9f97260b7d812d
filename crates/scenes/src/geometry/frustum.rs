//! Cylinders, rods and cones: round things between two ends.

use super::{Bounds, Meeting, Ray, Shape, Surface, roots};
use crate::number::greatest;
use crate::vector::{Frame, Vector, vector};

/// A solid between two discs: a cylinder when they are equal, a cone when one has radius 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frustum {
    base: Vector,
    /// z points from the base to the top.
    frame: Frame,
    height: f64,
    base_radius: f64,
    /// Change of the radius per metre of height.
    slope: f64,
}

const MANTLE: u8 = 0;
const BASE: u8 = 1;
const TOP: u8 = 2;

impl Frustum {
    /// From the middle of the base to the middle of the top, which must differ.
    pub fn between(base: Vector, top: Vector, base_radius: f64, top_radius: f64) -> Self {
        let height = (top - base).length();
        let slope = (top_radius - base_radius) / height;
        Self { base, frame: Frame::along(top - base), height, base_radius, slope }
    }

    #[inline]
    pub fn meets(&self, ray: &Ray, after: f64, before: f64) -> Option<Meeting> {
        let o = self.frame.to_local(ray.origin - self.base);
        let d = self.frame.to_local(ray.direction);
        let mut nearest: Option<Meeting> = None;
        let mut limit = before;
        let mut offer = |t: f64, part: u8, limit: &mut f64| {
            if t > after && t < *limit {
                *limit = t;
                nearest = Some(Meeting { t, part });
            }
        };
        // The mantle: x^2 + y^2 = r(z)^2 with r(z) = base + slope z.
        let (r, dr) = (self.base_radius + self.slope * o.z, self.slope * d.z);
        let a = d.x * d.x + d.y * d.y - dr * dr;
        let b = o.x * d.x + o.y * d.y - r * dr;
        let c = o.x * o.x + o.y * o.y - r * r;
        if let Some((first, second)) = roots(a, b, c) {
            for t in [first, second] {
                let z = o.z + t * d.z;
                // The mirrored cone beyond its tip has a negative radius and is no part of it.
                if z >= 0.0 && z <= self.height && self.base_radius + self.slope * z >= 0.0 {
                    offer(t, MANTLE, &mut limit);
                }
            }
        }
        if d.z.abs() > 1e-150 {
            for (z, part) in [(0.0, BASE), (self.height, TOP)] {
                let t = (z - o.z) / d.z;
                let (x, y, r) = (o.x + t * d.x, o.y + t * d.y, self.base_radius + self.slope * z);
                if x * x + y * y <= r * r {
                    offer(t, part, &mut limit);
                }
            }
        }
        nearest
    }

    pub fn surface(&self, point: Vector, part: u8) -> Surface {
        let local = self.frame.to_local(point - self.base);
        let normal = match part {
            BASE => -self.frame.z,
            TOP => self.frame.z,
            _ => {
                let around = greatest((local.x * local.x + local.y * local.y).sqrt(), 1e-12);
                let out = vector(local.x / around, local.y / around, -self.slope);
                self.frame.to_world(out).normalized()
            }
        };
        Surface { normal, local }
    }

    pub fn bounds(&self) -> Bounds {
        self.between_heights(0.0, self.height)
    }

    /// Boxes that together hold all of it: several for a long slanted rod, whose one box would be
    /// mostly empty.
    pub fn boxes(&self) -> Vec<Bounds> {
        let axis = self.frame.z * self.height;
        let mut sides = [axis.x.abs(), axis.y.abs(), axis.z.abs()];
        sides.sort_by(f64::total_cmp);
        let thick = greatest(self.base_radius, self.base_radius + self.slope * self.height);
        let count = (sides[1] / (8.0 * thick)).ceil().clamp(1.0, 24.0);
        let part = self.height / count;
        (0..count as u32)
            .map(|i| self.between_heights(f64::from(i) * part, f64::from(i + 1) * part))
            .collect()
    }

    fn between_heights(&self, low: f64, high: f64) -> Bounds {
        let axis = self.frame.z;
        // A disc reaches sqrt(1 - n^2) radii along each axis of the world.
        let rim = axis.map(|n| greatest(1.0 - n * n, 0.0).sqrt());
        let disc = |height: f64| {
            let radius = greatest(self.base_radius + self.slope * height, 0.0);
            Bounds::around(self.base + axis * height, rim * radius)
        };
        disc(low).with(disc(high))
    }
}

impl From<Frustum> for Shape {
    fn from(shape: Frustum) -> Self {
        Self::Frustum(shape)
    }
}
