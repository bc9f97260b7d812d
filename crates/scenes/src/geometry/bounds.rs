//! Boxes along the world's axes that hold a shape.

use super::Ray;
use crate::number::{greatest, least};
use crate::vector::{Vector, vector};

/// Everything between two corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub low: Vector,
    pub high: Vector,
}

/// A ray with the reciprocals of its direction, which boxes are tested with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PreparedRay {
    origin: Vector,
    reciprocal: Vector,
}

impl Ray {
    /// The ray made ready for many box tests.
    #[inline]
    pub fn prepared(&self) -> PreparedRay {
        // A huge number instead of infinity, so that no product is 0 times infinity.
        let reciprocal = |v: f64| if v.abs() < 1e-150 { 1e150 } else { 1.0 / v };
        PreparedRay { origin: self.origin, reciprocal: self.direction.map(reciprocal) }
    }
}

impl Bounds {
    /// Holds nothing: where unions start. No ray may be asked of it.
    pub const NOTHING: Self = Self {
        low: vector(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: vector(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// The box around a point, `reach` to both sides along each axis.
    pub fn around(centre: Vector, reach: Vector) -> Self {
        Self { low: centre - reach, high: centre + reach }
    }

    /// Holds both boxes.
    pub fn with(self, other: Self) -> Self {
        let (a, b) = (self, other);
        Self {
            low: vector(least(a.low.x, b.low.x), least(a.low.y, b.low.y), least(a.low.z, b.low.z)),
            high: vector(
                greatest(a.high.x, b.high.x),
                greatest(a.high.y, b.high.y),
                greatest(a.high.z, b.high.z),
            ),
        }
    }

    /// Twice the middle, for sorting.
    pub fn doubled_centre(&self) -> Vector {
        self.low + self.high
    }

    /// Where the ray is inside, cut to `after..before`.
    #[inline]
    pub fn span(&self, ray: &PreparedRay, after: f64, before: f64) -> Option<(f64, f64)> {
        let a = (self.low - ray.origin).scaled(ray.reciprocal);
        let b = (self.high - ray.origin).scaled(ray.reciprocal);
        let enter =
            greatest(greatest(least(a.x, b.x), least(a.y, b.y)), greatest(least(a.z, b.z), after));
        let leave =
            least(least(greatest(a.x, b.x), greatest(a.y, b.y)), least(greatest(a.z, b.z), before));
        (enter <= leave).then_some((enter, leave))
    }

    /// Whether the ray passes through between `after` and `before`.
    #[inline]
    pub fn meets(&self, ray: &PreparedRay, after: f64, before: f64) -> bool {
        self.span(ray, after, before).is_some()
    }

    /// Whether the point lies inside, or outside by at most `slack`.
    #[cfg(test)]
    pub fn holds(&self, p: Vector, slack: f64) -> bool {
        let (a, b) = (p - self.low, self.high - p);
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
