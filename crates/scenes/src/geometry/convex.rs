//! Convex solids cut out by planes: angular rocks, cars.

use super::{Bounds, Meeting, Ray, Shape, Surface};
use crate::number::least;
use crate::random::Random;
use crate::vector::{Frame, Vector, vector};

/// The points that lie below every plane: `normal . (p - centre) <= distance`, all in the axes of
/// its frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Convex {
    centre: Vector,
    frame: Frame,
    planes: Vec<(Vector, f64)>,
    /// Half of a box in the frame's axes that holds the solid.
    half: Vector,
}

impl Convex {
    /// The box `half` cut by more planes, each a direction (of any length) and its distance from
    /// the middle. At most 250 of them.
    pub fn cut_box(centre: Vector, frame: Frame, half: Vector, cuts: &[(Vector, f64)]) -> Self {
        let mut planes = vec![
            (vector(-1.0, 0.0, 0.0), half.x),
            (vector(1.0, 0.0, 0.0), half.x),
            (vector(0.0, -1.0, 0.0), half.y),
            (vector(0.0, 1.0, 0.0), half.y),
            (vector(0.0, 0.0, -1.0), half.z),
            (vector(0.0, 0.0, 1.0), half.z),
        ];
        planes.extend(cuts.iter().map(|&(n, distance)| (n.normalized(), distance)));
        assert!(planes.len() < 256, "a convex solid has at most 255 faces");
        Self { centre, frame, planes, half }
    }

    /// An angular stone about as large as an ellipsoid with these radii: the ellipsoid's tangent
    /// planes in `faces` random directions, each pushed in by up to a fifth.
    pub fn rock(
        centre: Vector,
        radii: Vector,
        frame: Frame,
        faces: usize,
        random: &mut Random,
    ) -> Self {
        let cuts: Vec<_> = (0..faces)
            .map(|_| {
                let n = random.direction();
                let n = vector(n.x / radii.x, n.y / radii.y, n.z / radii.z).normalized();
                // The ellipsoid's tangent plane with this normal is this far from its middle.
                let distance = n.scaled(radii).length();
                (n, distance * random.between(0.72, 0.95))
            })
            .collect();
        Self::cut_box(centre, frame, radii, &cuts)
    }

    #[inline]
    pub fn meets(&self, ray: &Ray, after: f64, before: f64) -> Option<Meeting> {
        let o = self.frame.to_local(ray.origin - self.centre);
        let d = self.frame.to_local(ray.direction);
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        let (mut front, mut back) = (0, 0);
        for (part, &(normal, distance)) in self.planes.iter().enumerate() {
            let (above, speed) = (o.dot(normal) - distance, d.dot(normal));
            if speed.abs() < 1e-150 {
                if above > 0.0 {
                    return None;
                }
                continue;
            }
            let t = -above / speed;
            if speed < 0.0 {
                if t > enter {
                    (enter, front) = (t, part as u8);
                }
            } else if t < leave {
                (leave, back) = (t, part as u8);
            }
            if enter > least(leave, before) {
                return None;
            }
        }
        let (t, part) = if enter > after { (enter, front) } else { (leave, back) };
        (t > after && t < before).then_some(Meeting { t, part })
    }

    pub fn surface(&self, point: Vector, part: u8) -> Surface {
        Surface {
            normal: self.frame.to_world(self.planes[usize::from(part)].0),
            local: self.frame.to_local(point - self.centre),
        }
    }

    pub fn bounds(&self) -> Bounds {
        Bounds::around_turned(self.centre, self.frame, self.half)
    }
}

impl From<Convex> for Shape {
    fn from(shape: Convex) -> Self {
        Self::Convex(shape)
    }
}
