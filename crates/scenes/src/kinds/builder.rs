//! What the builders of scenes share: a stream of numbers, sizes in pixels, and a list of objects
//! that keeps its distance from the cameras.

use crate::geometry::Shape;
use crate::light::Light;
use crate::number::{greatest, least};
use crate::random::Random;
use crate::rig::{Pose, Rig};
use crate::settings::Settings;
use crate::terrain::Terrain;
use crate::texture::Material;
use crate::vector::{Vector, vector};
use crate::world::{Object, World};

/// A scene being built.
pub(super) struct Builder {
    pub random: Random,
    pub rig: Rig,
    objects: Vec<Object>,
}

impl Builder {
    /// An empty scene whose largest disparity is at depth `near`.
    pub fn new(settings: &Settings, purpose: &str, pose: Pose, focal: f64, near: f64) -> Self {
        Self {
            random: Random::new(settings.seed, purpose),
            rig: Rig::new(settings, pose, focal, near),
            objects: Vec::new(),
        }
    }

    /// The longer side of the images, in pixels: what focal lengths and sizes grow with.
    pub fn side(settings: &Settings) -> f64 {
        settings.columns.max(settings.rows) as f64
    }

    /// Metres per pixel at this depth.
    pub fn pixel(&self, depth: f64) -> f64 {
        depth / self.rig.focal
    }

    /// Half of what is seen at this depth: to the right, and downwards, in metres.
    pub fn half_view(&self, depth: f64) -> (f64, f64) {
        let half = 0.5 * self.pixel(depth);
        (half * self.rig.columns as f64, half * self.rig.rows as f64)
    }

    /// Adds an object, wherever it is.
    pub fn add(&mut self, shape: impl Into<Shape>, material: Material) {
        self.objects.push(Object { shape: shape.into(), material });
    }

    /// Adds objects that belong together, unless some part of one may be nearer than the largest
    /// disparity allows. Answers whether it did.
    pub fn add_beyond_near(&mut self, group: Vec<(Shape, Material)>) -> bool {
        let is_far = group.iter().all(|(shape, _)| self.nearest_depth(shape) > self.rig.near);
        if is_far {
            self.objects
                .extend(group.into_iter().map(|(shape, material)| Object { shape, material }));
        }
        is_far
    }

    /// A lower bound of the shape's depth before the left camera (and so before the right one).
    fn nearest_depth(&self, shape: &Shape) -> f64 {
        let bounds = shape.bounds();
        let ahead = self.rig.pose.forward;
        let along = |axis: f64, low: f64, high: f64| least(axis * low, axis * high);
        along(ahead.x, bounds.low().x, bounds.high().x)
            + along(ahead.y, bounds.low().y, bounds.high().y)
            + along(ahead.z, bounds.low().z, bounds.high().z)
            - ahead.dot(self.rig.pose.place)
    }

    /// The scene, with ground or without.
    pub fn finish(self, ground: Option<Terrain>, light: Light, seed: u64) -> super::Stage {
        super::Stage { world: World::new(self.objects, ground, light, seed), rig: self.rig }
    }

    /// A colour of any hue, from pale to strong, dark to bright.
    pub fn paint(&mut self) -> Vector {
        let bright = self.random.between(0.12, 0.85);
        let strength = self.random.between(0.0, 0.8);
        let hue = vector(self.random.unit(), self.random.unit(), self.random.unit());
        let low = least(hue.x, least(hue.y, hue.z));
        let high = greatest(hue.x, greatest(hue.y, hue.z));
        // Stretched so that the strongest channel is 1 and the weakest 0.
        let pure = hue.map(|v| (v - low) / greatest(high - low, 1e-3));
        pure.map(|v| bright * (1.0 - strength + strength * v))
    }
}
