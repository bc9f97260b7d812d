//! Boxes along the world's axes that hold a shape.

use super::Ray;
use crate::number::{greatest, least};
use crate::vector::{Frame, Vector, vector};

/// Everything between two corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    /// The low corner, then the high one.
    corners: [Vector; 2],
}

/// A ray made ready for many boxes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PreparedRay {
    origin: Vector,
    reciprocal: Vector,
    /// Per axis, which corner's face the ray comes to first.
    first: [usize; 3],
}

impl Ray {
    /// The ray made ready for many boxes.
    #[inline]
    pub fn prepared(&self) -> PreparedRay {
        // A huge number instead of infinity, so that no product is 0 times infinity.
        let reciprocal = |v: f64| if v.abs() < 1e-150 { 1e150 } else { 1.0 / v };
        let reciprocal = self.direction.map(reciprocal);
        let first = [reciprocal.x, reciprocal.y, reciprocal.z].map(|r| usize::from(r < 0.0));
        PreparedRay { origin: self.origin, reciprocal, first }
    }
}

impl Bounds {
    /// Holds nothing: where unions start. No ray may be asked of it.
    pub const NOTHING: Self = Self {
        corners: [
            vector(f64::INFINITY, f64::INFINITY, f64::INFINITY),
            vector(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
        ],
    };

    /// The box around a point, `reach` to both sides along each axis.
    pub fn around(centre: Vector, reach: Vector) -> Self {
        Self { corners: [centre - reach, centre + reach] }
    }

    /// The box around one that is turned, `half` to both sides along each axis of its own.
    pub fn around_turned(centre: Vector, own: Frame, half: Vector) -> Self {
        let along = |axis: Vector, h: f64| vector(axis.x.abs(), axis.y.abs(), axis.z.abs()) * h;
        Self::around(centre, along(own.x, half.x) + along(own.y, half.y) + along(own.z, half.z))
    }

    /// The corner with the smallest coordinates.
    pub fn low(&self) -> Vector {
        self.corners[0]
    }

    /// The corner with the largest coordinates.
    pub fn high(&self) -> Vector {
        self.corners[1]
    }

    /// Holds both boxes.
    pub fn with(self, other: Self) -> Self {
        let join = |a: Vector, b: Vector, choose: fn(f64, f64) -> f64| {
            vector(choose(a.x, b.x), choose(a.y, b.y), choose(a.z, b.z))
        };
        Self {
            corners: [
                join(self.low(), other.low(), least),
                join(self.high(), other.high(), greatest),
            ],
        }
    }

    /// Twice the middle along one axis (0, 1 or 2), for sorting.
    pub fn doubled_centre(&self, axis: usize) -> f64 {
        let sum = self.low() + self.high();
        [sum.x, sum.y, sum.z][axis]
    }

    /// Half of the surface; 0 for [`Bounds::NOTHING`].
    pub fn area(&self) -> f64 {
        let size = self.high() - self.low();
        if size.x < 0.0 { 0.0 } else { size.x * size.y + size.y * size.z + size.z * size.x }
    }

    /// Where the ray enters and leaves the box, cut to `after..before`; `None` if it misses.
    #[inline]
    pub fn span(&self, ray: &PreparedRay, after: f64, before: f64) -> Option<(f64, f64)> {
        let [x, y, z] = ray.first;
        let (o, r) = (ray.origin, ray.reciprocal);
        let enter = greatest(
            greatest((self.corners[x].x - o.x) * r.x, (self.corners[y].y - o.y) * r.y),
            greatest((self.corners[z].z - o.z) * r.z, after),
        );
        let leave = least(
            least((self.corners[1 - x].x - o.x) * r.x, (self.corners[1 - y].y - o.y) * r.y),
            least((self.corners[1 - z].z - o.z) * r.z, before),
        );
        (enter <= leave).then_some((enter, leave))
    }

    /// Whether the point lies inside, or outside by at most `slack`.
    #[cfg(test)]
    pub fn holds(&self, p: Vector, slack: f64) -> bool {
        let (a, b) = (p - self.low(), self.high() - p);
        [a.x, a.y, a.z, b.x, b.y, b.z].into_iter().all(|v| v >= -slack)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_along_the_axes_are_handled() {
        let bounds = Bounds::around(vector(0.0, 4.0, 0.0), vector(1.0, 1.0, 1.0));
        let hit = |x: f64| {
            let ray = Ray { origin: vector(x, 0.0, 0.0), direction: vector(0.0, 1.0, 0.0) };
            bounds.span(&ray.prepared(), 0.0, f64::INFINITY)
        };
        assert_eq!(hit(0.0), Some((3.0, 5.0)));
        assert_eq!(hit(1.5), None);
        // On the boundary itself the answer may be either, but never a NaN or a panic.
        let _ = hit(1.0);
    }

    #[test]
    fn unions_start_from_nothing() {
        let b = Bounds::around(vector(1.0, 2.0, 3.0), vector(1.0, 1.0, 1.0));
        assert_eq!(Bounds::NOTHING.with(b), b);
    }
}
