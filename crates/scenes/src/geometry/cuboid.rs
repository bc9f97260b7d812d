//! Boxes, turned any way.

use super::{Bounds, Meeting, Ray, Shape, Surface};
use crate::vector::{Frame, Vector};

/// A box with six right-angled faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cuboid {
    centre: Vector,
    frame: Frame,
    half: Vector,
}

impl Cuboid {
    /// `half` is half the edge length along each axis of the frame.
    pub fn new(centre: Vector, frame: Frame, half: Vector) -> Self {
        Self { centre, frame, half }
    }

    #[inline]
    pub fn meets(&self, ray: &Ray, after: f64, before: f64) -> Option<Meeting> {
        let o = self.frame.to_local(ray.origin - self.centre);
        let d = self.frame.to_local(ray.direction);
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        let (mut front, mut back) = (0, 0);
        for (axis, (o, d, h)) in
            [(o.x, d.x, self.half.x), (o.y, d.y, self.half.y), (o.z, d.z, self.half.z)]
                .into_iter()
                .enumerate()
        {
            if d.abs() < 1e-150 {
                if o.abs() > h {
                    return None;
                }
                continue;
            }
            // Going up, the low face comes first.
            let (first, second) = if d > 0.0 { (-h, h) } else { (h, -h) };
            let (a, b) = ((first - o) / d, (second - o) / d);
            let part = 2 * axis as u8;
            if a > enter {
                enter = a;
                front = part + u8::from(d < 0.0);
            }
            if b < leave {
                leave = b;
                back = part + u8::from(d > 0.0);
            }
        }
        if enter > leave {
            return None;
        }
        let (t, part) = if enter > after { (enter, front) } else { (leave, back) };
        (t > after && t < before).then_some(Meeting { t, part })
    }

    /// Parts: 0 and 1 are the low and the high face along x, 2 and 3 along y, 4 and 5 along z.
    pub fn surface(&self, point: Vector, part: u8) -> Surface {
        let axis = [self.frame.x, self.frame.y, self.frame.z][usize::from(part / 2)];
        let normal = if part % 2 == 1 { axis } else { -axis };
        Surface { normal, local: self.frame.to_local(point - self.centre) }
    }

    pub fn bounds(&self) -> Bounds {
        Bounds::around_turned(self.centre, self.frame, self.half)
    }
}

impl From<Cuboid> for Shape {
    fn from(shape: Cuboid) -> Self {
        Self::Cuboid(shape)
    }
}
