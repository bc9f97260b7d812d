//! Flat round discs without thickness: signs, leaves, lids.

use super::{Bounds, Meeting, Ray, Shape, Surface};
use crate::number::greatest;
use crate::vector::{Frame, Vector};

/// A disc across the z axis of its frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Disc {
    centre: Vector,
    frame: Frame,
    radius: f64,
}

impl Disc {
    pub fn new(centre: Vector, frame: Frame, radius: f64) -> Self {
        Self { centre, frame, radius }
    }

    #[inline]
    pub fn meets(&self, ray: &Ray, after: f64, before: f64) -> Option<Meeting> {
        let normal = self.frame.z;
        let t = (self.centre - ray.origin).dot(normal) / ray.direction.dot(normal);
        // Written so that a NaN (a ray inside the disc's plane) is refused.
        if !(t > after && t < before) {
            return None;
        }
        let off = ray.at(t) - self.centre;
        (off.dot(off) <= self.radius * self.radius).then_some(Meeting { t, part: 0 })
    }

    pub fn surface(&self, point: Vector, _part: u8) -> Surface {
        Surface { normal: self.frame.z, local: self.frame.to_local(point - self.centre) }
    }

    pub fn bounds(&self) -> Bounds {
        let rim = self.frame.z.map(|n| greatest(1.0 - n * n, 0.0).sqrt());
        Bounds::around(self.centre, rim * self.radius)
    }
}

impl From<Disc> for Shape {
    fn from(shape: Disc) -> Self {
        Self::Disc(shape)
    }
}
