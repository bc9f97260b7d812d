//! What is there to be seen: objects, ground, sky and light.

use crate::geometry::{Ray, Shape, Tree};
use crate::light::Light;
use crate::terrain::Terrain;
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
    terrain: Option<Terrain>,
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
    /// The object's number; the ground's is [`GROUND`].
    pub number: u32,
    /// The part of the object, as in [`crate::geometry::Meeting`].
    pub part: u8,
}

/// The number of the ground in [`Hit`].
pub(crate) const GROUND: u32 = u32::MAX;

impl World {
    pub fn new(objects: Vec<Object>, terrain: Option<Terrain>, light: Light, seed: u64) -> Self {
        let boxes = objects.iter().zip(0..).flat_map(|(object, number)| {
            object.shape.boxes().into_iter().map(move |bounds| (bounds, number))
        });
        Self { tree: Tree::over(boxes.collect()), objects, terrain, light, seed }
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
        if let Some(terrain) = &self.terrain {
            let limit = found.map_or(before, |(t, _, _)| t);
            if let Some(t) = terrain.meets(ray, after, limit) {
                found = Some((t, GROUND, 0));
            }
        }
        found
    }

    /// The first thing beyond `after`, with its surface.
    pub fn hit(&self, ray: &Ray, after: f64) -> Option<Hit<'_>> {
        let (t, number, part) = self.first(ray, after, f64::INFINITY)?;
        let point = ray.at(t);
        let (surface, material) = match (self.objects.get(number as usize), &self.terrain) {
            (Some(object), _) => (object.shape.surface(point, part), &object.material),
            (None, Some(terrain)) => (terrain.surface(point), terrain.material()),
            (None, None) => return None,
        };
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
            || self.terrain.as_ref().is_some_and(|t| t.meets(ray, after, f64::INFINITY).is_some())
    }
}
