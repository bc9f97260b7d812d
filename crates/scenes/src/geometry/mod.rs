//! Solid things that a ray can meet, one file each.
//!
//! A ray is `origin + t * direction`; the direction's length is the caller's affair, and `t` is in
//! its units (camera rays have forward part 1, so there `t` is the depth `Z` itself). Every shape
//! answers three questions: where a ray meets it first ([`Shape::meets`]), what the surface is like
//! there ([`Shape::surface`]), and which box holds it ([`Shape::bounds`]).

mod bounds;
mod convex;
mod cuboid;
mod disc;
mod frustum;
mod panel;
mod sphere;
mod tree;

pub(crate) use bounds::Bounds;
pub(crate) use convex::Convex;
pub(crate) use cuboid::Cuboid;
pub(crate) use disc::Disc;
pub(crate) use frustum::Frustum;
pub(crate) use panel::{Holes, Panel};
pub(crate) use sphere::Sphere;
pub(crate) use tree::Tree;

use crate::vector::Vector;

/// A half line. Points on it are `origin + t * direction`, t > 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ray {
    pub origin: Vector,
    pub direction: Vector,
}

impl Ray {
    #[inline]
    pub fn at(&self, t: f64) -> Vector {
        self.origin + self.direction * t
    }
}

/// Where a ray meets a shape first, and on which of its parts (a face, the mantle, an end).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Meeting {
    pub t: f64,
    pub part: u8,
}

/// What a surface is like at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Surface {
    /// Length 1, outward where the shape has an inside.
    pub normal: Vector,
    /// The point in the shape's own axes, which textures are defined in.
    pub local: Vector,
}

/// Any shape.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Shape {
    Sphere(Sphere),
    Cuboid(Cuboid),
    Frustum(Frustum),
    Disc(Disc),
    Panel(Panel),
    Convex(Convex),
}

macro_rules! each {
    ($self:ident, $shape:ident => $answer:expr) => {
        match $self {
            Self::Sphere($shape) => $answer,
            Self::Cuboid($shape) => $answer,
            Self::Frustum($shape) => $answer,
            Self::Disc($shape) => $answer,
            Self::Panel($shape) => $answer,
            Self::Convex($shape) => $answer,
        }
    };
}

impl Shape {
    /// The first meeting with `after < t < before`.
    #[inline]
    pub fn meets(&self, ray: &Ray, after: f64, before: f64) -> Option<Meeting> {
        each!(self, shape => shape.meets(ray, after, before))
    }

    /// The surface at a point that [`Shape::meets`] found on this part.
    pub fn surface(&self, point: Vector, part: u8) -> Surface {
        each!(self, shape => shape.surface(point, part))
    }

    /// A box that holds all of the shape.
    pub fn bounds(&self) -> Bounds {
        each!(self, shape => shape.bounds())
    }

    /// Boxes that together hold all of the shape, for the tree.
    pub fn boxes(&self) -> Vec<Bounds> {
        match self {
            Self::Frustum(frustum) => frustum.boxes(),
            _ => vec![self.bounds()],
        }
    }
}

/// The smaller, then the larger root of `a t^2 + 2 b t + c = 0`, if there are any. Written so that
/// neither root loses digits to cancellation.
#[inline]
pub(crate) fn roots(a: f64, b: f64, c: f64) -> Option<(f64, f64)> {
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let q = if b > 0.0 { -b - root } else { root - b };
    if q == 0.0 {
        return if a == 0.0 { None } else { Some((0.0, 0.0)) };
    }
    let (first, second) = (c / q, q / a);
    Some(if first < second { (first, second) } else { (second, first) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::vector::{Frame, vector};

    fn shapes(random: &mut Random) -> Vec<Shape> {
        let at = vector(0.3, 6.0, -0.2);
        let frame = random.frame();
        vec![
            Sphere::new(at, 1.0).into(),
            Sphere::ellipsoid(at, frame, vector(1.0, 0.4, 0.7)).into(),
            Cuboid::new(at, frame, vector(0.5, 1.0, 0.7)).into(),
            Frustum::between(at, at + vector(0.4, 0.3, 1.5), 0.6, 0.6).into(),
            Frustum::between(at, at + vector(0.4, 0.3, 1.5), 0.6, 0.0).into(),
            Frustum::between(at, at + vector(-0.4, 0.3, 1.0), 0.2, 0.7).into(),
            Frustum::between(at - frame.x, at + frame.x, 0.04, 0.05).into(),
            Disc::new(at, frame, 1.0).into(),
            Panel::new(at, frame, 1.0, 0.6).into(),
            Panel::new(at, frame, 1.0, 0.6)
                .with_holes(Holes::Lattice { pitch: 0.3, bar: 0.1 })
                .into(),
            Convex::rock(at, vector(1.0, 0.8, 0.6), frame, 14, random).into(),
        ]
    }

    /// For rays from everywhere: the meeting lies in the bounds, the normal has length 1, stepping
    /// back along the ray meets the same point, and closed shapes are left where they were entered.
    #[test]
    fn meetings_lie_on_the_surface_and_in_the_bounds() {
        let mut random = Random::new(11, "test");
        for round in 0..5 {
            for shape in shapes(&mut random) {
                let bounds = shape.bounds();
                let mut met = 0;
                for _ in 0..400 {
                    let from = vector(0.3, 6.0, 0.3) + random.direction() * 5.0;
                    let aim = vector(0.3, 6.0, 0.1) + random.direction() * 0.7;
                    let ray = Ray { origin: from, direction: aim - from };
                    let Some(meeting) = shape.meets(&ray, 0.0, f64::INFINITY) else { continue };
                    met += 1;
                    let point = ray.at(meeting.t);
                    let span = bounds.span(&ray.prepared(), 0.0, f64::INFINITY);
                    assert!(span.is_some(), "{round} {shape:?}");
                    assert!(bounds.holds(point, 1e-9), "{round} {shape:?} {point:?}");
                    assert!(shape.boxes().iter().any(|b| b.holds(point, 1e-9)), "{shape:?}");
                    let surface = shape.surface(point, meeting.part);
                    assert!((surface.normal.length() - 1.0).abs() < 1e-9);
                    let later = Ray { origin: ray.at(0.5 * meeting.t), ..ray };
                    let again = shape.meets(&later, 0.0, f64::INFINITY).expect("still met");
                    assert!((again.t - 0.5 * meeting.t).abs() < 1e-9, "{shape:?}");
                    assert!(shape.meets(&ray, 0.0, meeting.t).is_none());
                    if !matches!(shape, Shape::Disc(_) | Shape::Panel(_)) {
                        assert!(surface.normal.dot(ray.direction) <= 1e-9, "outward {shape:?}");
                        assert!(shape.meets(&ray, meeting.t + 1e-9, f64::INFINITY).is_some());
                    }
                }
                assert!(met > 10, "{shape:?} met {met} times");
            }
        }
    }

    #[test]
    fn known_distances() {
        let ray = Ray { origin: vector(0.0, 0.0, 0.0), direction: vector(0.0, 1.0, 0.0) };
        let t = |shape: Shape| shape.meets(&ray, 0.0, f64::INFINITY).map(|m| m.t);
        let at = vector(0.0, 4.0, 0.0);
        assert_eq!(t(Sphere::new(at, 1.0).into()), Some(3.0));
        assert_eq!(t(Cuboid::new(at, Frame::WORLD, vector(1.0, 0.5, 1.0)).into()), Some(3.5));
        let upright = Frustum::between(vector(0.0, 4.0, -1.0), vector(0.0, 4.0, 1.0), 0.5, 0.5);
        assert_eq!(t(upright.into()), Some(3.5));
        assert_eq!(t(Disc::new(at, Frame::along(vector(0.0, 1.0, 0.0)), 1.0).into()), Some(4.0));
        assert_eq!(t(Sphere::new(vector(2.0, 4.0, 0.0), 1.0).into()), None);
    }

    #[test]
    fn roots_keep_their_digits() {
        // t^2 - 2e8 t + 1 = 0: the small root is 5e-9.
        let (small, large) = roots(1.0, -1e8, 1.0).unwrap();
        assert!((small / 5e-9 - 1.0).abs() < 1e-12);
        assert!((large / 2e8 - 1.0).abs() < 1e-12);
        assert_eq!(roots(1.0, 0.0, 1.0), None);
    }
}
