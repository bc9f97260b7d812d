//! What is there to be seen: objects, ground, sky and light.

use crate::geometry::{Ray, Shape, Tree};
use crate::light::Light;
use crate::texture::Material;
use crate::vector::Vector;

/// A shape and what it is made of.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Object {
    pub shape: Shape,
    pub material: Material,
}

/// Everything, ready for rays.
#[derive(Debug, Clone)]
pub(crate) struct World {
    objects: Vec<Object>,
    tree: Tree,
    pub light: Light,
    /// Seed of all textures.
    pub seed: u64,
}

/// What a ray meets first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hit<'a> {
    pub t: f64,
    pub point: Vector,
    /// Length 1, towards the viewer.
    pub normal: Vector,
    /// The point in the object's own axes.
    pub local: Vector,
    pub material: &'a Material,
    /// The object's number.
    pub number: u32,
    /// The part of the object, as in [`crate::geometry::Meeting`].
    pub part: u8,
}

impl World {
    pub fn new(objects: Vec<Object>, light: Light, seed: u64) -> Self {
        let boxes = objects.iter().zip(0..).flat_map(|(object, number)| {
            object.shape.boxes().into_iter().map(move |bounds| (bounds, number))
        });
        Self { tree: Tree::over(boxes.collect()), objects, light, seed }
    }

    /// How far along the ray the first thing is, beyond `after`; infinity for the sky.
    pub fn distance(&self, ray: &Ray, after: f64) -> f64 {
        self.first(ray, after, f64::INFINITY).map_or(f64::INFINITY, |(t, _, _)| t)
    }

    /// Distance, number and part of the first thing between `after` and `before`.
    #[inline]
    fn first(&self, ray: &Ray, after: f64, before: f64) -> Option<(f64, u32, u8)> {
        let mut found = None;
        self.tree.walk(ray, after, before, |i, before| {
            match self.objects[i].shape.meets(ray, after, before) {
                Some(meeting) => {
                    found = Some((meeting.t, i as u32, meeting.part));
                    meeting.t
                }
                None => before,
            }
        });
        found
    }

    /// The first thing beyond `after`, with its surface.
    pub fn hit(&self, ray: &Ray, after: f64) -> Option<Hit<'_>> {
        let (t, number, part) = self.first(ray, after, f64::INFINITY)?;
        let point = ray.at(t);
        let Object { shape, material } = &self.objects[number as usize];
        let surface = shape.surface(point, part);
        let facing = surface.normal.dot(ray.direction) <= 0.0;
        let normal = if facing { surface.normal } else { -surface.normal };
        Some(Hit { t, point, normal, local: surface.local, material, number, part })
    }

    /// Whether anything stands between the ray's origin and infinity.
    pub fn is_blocked(&self, ray: &Ray, after: f64) -> bool {
        let mut blocked = false;
        self.tree.walk(ray, after, f64::INFINITY, |i, before| {
            if self.objects[i].shape.meets(ray, after, before).is_some() {
                blocked = true;
                // Nothing is nearer than this, so the walk ends.
                return f64::NEG_INFINITY;
            }
            before
        });
        blocked
    }
}
