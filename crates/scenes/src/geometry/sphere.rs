//! Spheres and ellipsoids.

use super::{Bounds, Meeting, Ray, Shape, Surface, roots};
use crate::vector::{Frame, Vector, vector};

/// A ball, stretched along the axes of its frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sphere {
    centre: Vector,
    frame: Frame,
    radii: Vector,
    /// 1 / radii.
    shrink: Vector,
}

impl Sphere {
    pub fn new(centre: Vector, radius: f64) -> Self {
        Self::ellipsoid(centre, Frame::WORLD, vector(radius, radius, radius))
    }

    /// Half as long along each axis of the frame as `radii` says; all must be positive.
    pub fn ellipsoid(centre: Vector, frame: Frame, radii: Vector) -> Self {
        Self { centre, frame, radii, shrink: radii.map(|r| 1.0 / r) }
    }

    #[inline]
    pub fn meets(&self, ray: &Ray, after: f64, before: f64) -> Option<Meeting> {
        // In the axes of the frame, shrunk to a unit sphere.
        let o = self.frame.to_local(ray.origin - self.centre).scaled(self.shrink);
        let d = self.frame.to_local(ray.direction).scaled(self.shrink);
        let (first, second) = roots(d.dot(d), o.dot(d), o.dot(o) - 1.0)?;
        let t = if first > after { first } else { second };
        (t > after && t < before).then_some(Meeting { t, part: 0 })
    }

    pub fn surface(&self, point: Vector, _part: u8) -> Surface {
        let local = self.frame.to_local(point - self.centre);
        let gradient = local.scaled(self.shrink).scaled(self.shrink);
        Surface { normal: self.frame.to_world(gradient).normalized(), local }
    }

    pub fn bounds(&self) -> Bounds {
        let f = self.frame;
        let (a, b, c) = (f.x * self.radii.x, f.y * self.radii.y, f.z * self.radii.z);
        let reach = a.scaled(a) + b.scaled(b) + c.scaled(c);
        Bounds::around(self.centre, reach.map(f64::sqrt))
    }
}

impl From<Sphere> for Shape {
    fn from(shape: Sphere) -> Self {
        Self::Sphere(shape)
    }
}
