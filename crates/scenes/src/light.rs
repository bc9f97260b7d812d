//! How bright a surface looks: sun, sky, shadows, highlights, haze.
//!
//! Lambert's law for the sun and for a sky that is one colour above and another below, a hard
//! shadow where something stands between the point and the sun, Blinn's highlight (1977), which
//! moves with the viewer and so breaks the brightness constancy that matchers rely on, one mirrored
//! ray for glass and lacquer, and haze that grows with distance. All in linear light.

use crate::geometry::Ray;
use crate::noise::fractal;
use crate::number::{exp2, greatest, smoothstep};
use crate::random::{hash, salt};
use crate::vector::{Vector, vector};
use crate::world::{Hit, World};

const CLOUDS: u64 = salt("clouds");

/// Light and sky. Colours are linear red, green, blue; 1 is the brightest that the sensor holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Light {
    /// Towards the sun, length 1.
    pub sun: Vector,
    /// Light of the sun on a surface that faces it.
    pub sunlight: Vector,
    /// Light of the sky on a surface that faces up.
    pub above: Vector,
    /// Light of the surroundings on a surface that faces down.
    pub below: Vector,
    /// The sky itself.
    pub sky: Sky,
    /// Metres after which half of what is seen is haze; infinity for clear air.
    pub haze: f64,
}

/// What is seen where nothing is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sky {
    pub horizon: Vector,
    pub zenith: Vector,
    /// Added towards the sun.
    pub glow: Vector,
    /// Share of white clouds, 0 to 1.
    pub clouds: f64,
}

impl Sky {
    /// One colour everywhere.
    pub fn plain(colour: Vector) -> Self {
        Self { horizon: colour, zenith: colour, glow: vector(0.0, 0.0, 0.0), clouds: 0.0 }
    }

    fn colour(&self, direction: Vector, sun: Vector, footprint: f64, seed: u64) -> Vector {
        let d = direction.normalized();
        let up = greatest(d.z, 0.0);
        let mut colour = self.horizon.mix(self.zenith, up.sqrt());
        let towards = greatest(d.dot(sun), 0.0);
        let squared = towards * towards;
        colour = colour + self.glow * (squared * squared * squared);
        if self.clouds > 0.0 && d.z > 0.0 {
            // Where the ray passes a layer one unit up; far clouds are seen flat.
            let p = vector(d.x / (d.z + 0.1), d.y / (d.z + 0.1), 0.0);
            let thick = fractal(p, 1.4, 5, 0.55, footprint / (d.z + 0.1), seed ^ CLOUDS);
            let cover = smoothstep(0.3 - self.clouds, 0.9 - self.clouds, thick);
            colour = colour.mix(vector(0.9, 0.9, 0.92), cover * smoothstep(0.0, 0.15, d.z));
        }
        colour
    }
}

/// How much brighter a highlight of this exponent (2 to the power `gloss`) is than its base.
fn lobe(cosine: f64, gloss: u32) -> f64 {
    let mut value = greatest(cosine, 0.0);
    for _ in 0..gloss {
        value *= value;
    }
    value
}

impl World {
    /// The light that comes back along a ray from beyond `after`, and what sends it. `spread` is
    /// the width of the ray per metre of depth. `contrast` as in [`crate::Settings::contrast`].
    pub fn radiance(&self, ray: &Ray, after: f64, spread: f64, contrast: f64) -> (Vector, Seen) {
        let Some(hit) = self.hit(ray, after) else {
            return (
                self.light.sky.colour(ray.direction, self.light.sun, spread, self.seed),
                Seen::SKY,
            );
        };
        let view = ray.direction.normalized();
        let (mut colour, lit) = self.reflected(&hit, view, spread * hit.t, contrast);
        if hit.material.mirror > 0.0 {
            let direction = view - hit.normal * (2.0 * view.dot(hit.normal));
            let mirrored = Ray { origin: hit.point + hit.normal * clearance(&hit), direction };
            let facing = 1.0 + view.dot(hit.normal);
            // Glancing rays are mirrored most, after Schlick (1994), with a third power instead of his fifth.
            let share = hit.material.mirror * (0.15 + 0.85 * facing * facing * facing);
            let seen = match self.hit(&mirrored, 0.0) {
                Some(other) => {
                    self.reflected(&other, direction, spread * (hit.t + other.t), contrast).0
                }
                None => self.light.sky.colour(direction, self.light.sun, spread, self.seed),
            };
            colour = colour.mix(seen, share);
        }
        if self.light.haze < f64::INFINITY {
            let distance = hit.t * ray.direction.length();
            let clear = exp2(-distance / self.light.haze);
            let level = vector(ray.direction.x, ray.direction.y, 0.0);
            let haze = self.light.sky.colour(level, self.light.sun, spread, self.seed);
            colour = haze.mix(colour, clear);
        }
        (colour, Seen { number: hit.number, part: hit.part, lit })
    }

    /// The light that a surface sends towards the viewer; `view` points at the surface.
    fn reflected(
        &self,
        hit: &Hit<'_>,
        view: Vector,
        footprint: f64,
        contrast: f64,
    ) -> (Vector, bool) {
        let light = &self.light;
        let material = hit.material;
        // Each object has a texture of its own.
        let seed = hash(self.seed, hit.number.into(), 0, 0);
        let mut albedo = material.colour(hit.local, footprint, contrast, seed);
        let mut normal = hit.normal;
        if material.relief > 0.0 {
            let bump = material.bump(hit.local, footprint, seed);
            normal = (normal + bump * contrast).normalized();
        }
        let (dust, cover) = material.dust;
        if cover > 0.0 {
            albedo = albedo.mix(dust, cover * smoothstep(0.2, 0.9, normal.z));
        }
        let up = 0.5 + 0.5 * normal.z;
        let mut colour = albedo.scaled(light.below.mix(light.above, up));
        let cosine = normal.dot(light.sun);
        let origin = hit.point + hit.normal * clearance(hit);
        let lit = hit.normal.dot(light.sun) > 0.0
            && !self.is_blocked(&Ray { origin, direction: light.sun }, 0.0);
        if lit && cosine > 0.0 {
            colour = colour + albedo.scaled(light.sunlight) * cosine;
            if material.specular > 0.0 {
                let half = (light.sun - view).normalized();
                let shine = material.specular * lobe(half.dot(normal), material.gloss);
                colour = colour + light.sunlight * shine;
            }
        }
        (colour, lit)
    }
}

/// What sends light along a ray: rays of one pixel that see the same need no company.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Seen {
    number: u32,
    part: u8,
    lit: bool,
}

impl Seen {
    const SKY: Self = Self { number: u32::MAX - 1, part: 0, lit: true };
}

/// How far from a surface a new ray begins, so that rounding does not put it inside.
fn clearance(hit: &Hit<'_>) -> f64 {
    1e-6 * greatest(hit.t, 1.0)
}
