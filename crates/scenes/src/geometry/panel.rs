//! Flat rectangles without thickness, whole or with holes: walls, cards, fences, nets.

use super::{Bounds, Meeting, Ray, Shape, Surface};
use crate::vector::{Frame, Vector, vector};

/// What is cut out of a panel, in its own x and y from its middle, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Holes {
    /// Nothing.
    None,
    /// Crossed bars `bar` wide, `pitch` from one to the next.
    Lattice { pitch: f64, bar: f64 },
    /// Upright bars `bar` wide, `pitch` from one to the next.
    Slats { pitch: f64, bar: f64 },
}

/// A rectangle in the x and y axes of its frame; z is its normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Panel {
    centre: Vector,
    frame: Frame,
    half_width: f64,
    half_height: f64,
    holes: Holes,
}

impl Holes {
    #[inline]
    fn is_open(self, x: f64, y: f64) -> bool {
        let between = |v: f64, pitch: f64, bar: f64| {
            let phase = v / pitch - (v / pitch).floor();
            phase * pitch > bar
        };
        match self {
            Self::None => false,
            Self::Lattice { pitch, bar } => between(x, pitch, bar) && between(y, pitch, bar),
            Self::Slats { pitch, bar } => between(x, pitch, bar),
        }
    }
}

impl Panel {
    pub fn new(centre: Vector, frame: Frame, half_width: f64, half_height: f64) -> Self {
        Self { centre, frame, half_width, half_height, holes: Holes::None }
    }

    pub fn with_holes(self, holes: Holes) -> Self {
        Self { holes, ..self }
    }

    #[inline]
    pub fn meets(&self, ray: &Ray, after: f64, before: f64) -> Option<Meeting> {
        let normal = self.frame.z;
        let t = (self.centre - ray.origin).dot(normal) / ray.direction.dot(normal);
        // Written so that a NaN (a ray inside the panel's plane) is refused.
        if !(t > after && t < before) {
            return None;
        }
        let off = ray.at(t) - self.centre;
        let (x, y) = (off.dot(self.frame.x), off.dot(self.frame.y));
        let inside = x.abs() <= self.half_width && y.abs() <= self.half_height;
        (inside && !self.holes.is_open(x, y)).then_some(Meeting { t, part: 0 })
    }

    pub fn surface(&self, point: Vector, _part: u8) -> Surface {
        Surface { normal: self.frame.z, local: self.frame.to_local(point - self.centre) }
    }

    pub fn bounds(&self) -> Bounds {
        let along = |axis: Vector, h: f64| vector(axis.x.abs(), axis.y.abs(), axis.z.abs()) * h;
        let reach = along(self.frame.x, self.half_width) + along(self.frame.y, self.half_height);
        Bounds::around(self.centre, reach)
    }
}

impl From<Panel> for Shape {
    fn from(shape: Panel) -> Self {
        Self::Panel(shape)
    }
}
