//! The ground: fractal relief, ripples of sand, hills at the horizon; and the rocks on it.

use super::super::builder::Builder;
use super::DUST;
use crate::geometry::{Convex, Shape, Sphere};
use crate::noise::{fractal, gradient};
use crate::number::{greatest, power, smoothstep};
use crate::random::salt;
use crate::terrain::Terrain;
use crate::texture::{Material, Pattern};
use crate::vector::{Frame, Vector, vector};

/// Levels of the ground: 12.5 mm cells near the rover, 3.2 m cells at the horizon.
const LEVELS: usize = 5;
const FINEST: f64 = 0.0125;
const ROCKS: usize = 1100;

/// Height of a wave at this phase: 0 to 1, a steep side and a flat one, its crest rounded.
fn ripple(phase: f64) -> f64 {
    let t = phase - phase.floor();
    let rise = smoothstep(0.0, 0.62, t);
    let fall = smoothstep(0.58, 1.0, t);
    rise - fall
}

pub(super) fn terrain(builder: &mut Builder) -> Terrain {
    let seed = builder.random.bits();
    let rough = builder.random.between(0.6, 1.2);
    let hills = builder.random.between(25.0, 70.0);
    let sand = builder.random.between(-0.1, 0.25);
    let wind = builder.random.direction() + vector(1e-3, 0.0, 0.0);
    let wind = vector(wind.x, wind.y, 0.0).normalized();
    let soil = Material::patterned(
        Pattern::Regolith { size: 3.0 },
        vector(0.12, 0.055, 0.028),
        vector(0.5, 0.27, 0.14),
    )
    .with_grain(0.0, 0.03)
    .with_relief(0.16);
    Terrain::new(LEVELS, FINEST, soil, move |level, cell, x, y| {
        let p = vector(x, y, 0.0);
        let distance = (x * x + y * y).sqrt();
        if level + 1 == LEVELS {
            // Hills far away, in terraces; level ground around the rover.
            let wide = fractal(p, 420.0, 6, 0.5, 1e-9, seed);
            let far = smoothstep(160.0, 900.0, distance + 300.0 * wide);
            let stepped = wide + 0.12 * smoothstep(0.1, 0.2, wide);
            let around = smoothstep(8.0, 120.0, distance);
            return hills * far * (0.45 + stepped) + 3.0 * rough * around * wide;
        }
        // Two octaves per level, a twentieth as high as they are wide.
        let size = 8.0 * cell;
        let level_out = smoothstep(0.0, 30.0 * size, distance + 6.0 * size);
        let mut height = 0.15 * rough * size * level_out * fractal(p, size, 2, 0.5, 1e-9, seed);
        // Sand lies in some places, in ripples of two sizes, one on each of the finest levels.
        let here = gradient(p * (1.0 / 7.0), seed ^ salt("sand"));
        let sandy = smoothstep(-0.05, 0.2, here + sand);
        let wave = match level {
            0 => Some((0.2, 0.022)),
            1 => Some((1.3, 0.12)),
            _ => None,
        };
        if let (Some((length, high)), true) = (wave, sandy > 0.0) {
            let bend = gradient(p * (0.35 / length), seed ^ salt("bend"));
            height += sandy * high * ripple(p.dot(wind) / length + 1.2 * bend);
        }
        height
    })
}

/// Rocks of many sizes: as many in each octave of distance, since that is how they fill an image;
/// their sizes follow a power law, as counted on Mars. Some are angular, some rounded, most partly
/// buried, and dust lies on top of them.
pub(super) fn rocks(builder: &mut Builder, ground: &Terrain) {
    for _ in 0..ROCKS {
        let random = &mut builder.random;
        // From 2.4 m to 70 m.
        let ahead = 2.4 * power(29.0, random.unit());
        let across = random.between(-1.0, 1.0) * (0.75 * ahead + 0.5);
        // Three pixels of a 450-pixel image, and up to ninety times as much, but hardly more than a metre.
        let smallest = 3.0 / 382.0 * ahead;
        let size = smallest * power(greatest(random.unit(), 1e-3), -0.65);
        let size = if size > 1.1 { 1.1 * random.between(0.5, 1.0) } else { size };
        let half = 0.5 * size;
        let radii = vector(half, half * random.between(0.6, 1.0), half * random.between(0.4, 0.85));
        let turn = Frame::about(vector(0.0, 0.0, 1.0), random.between(-1.0, 1.0));
        let tilt = Frame::about(random.direction(), random.between(-0.15, 0.15));
        let frame =
            Frame { x: tilt.to_world(turn.x), y: tilt.to_world(turn.y), z: tilt.to_world(turn.z) };
        let buried = random.between(-0.35, 0.6) * radii.z;
        let at = vector(across, ahead, ground.height(across, ahead) + buried);
        let shape: Shape = if random.chance(0.75) {
            let faces = 9 + random.below(8);
            Convex::rock(at, radii, frame, faces, random).into()
        } else {
            Sphere::ellipsoid(at, frame, radii).into()
        };
        let material = rock(builder, size);
        builder.add_beyond_near(vec![(shape, material)]);
    }
}

fn rock(builder: &mut Builder, size: f64) -> Material {
    let random = &mut builder.random;
    let base = vector(0.2, 0.135, 0.1).mix(vector(0.34, 0.2, 0.12), random.unit());
    let base: Vector = base * random.between(0.6, 1.25);
    Material::patterned(Pattern::Cloudy { size: 0.6 * size }, base * 0.65, base * 1.2)
        .with_grain(random.between(0.1, 0.3), 0.12 * size)
        .with_relief(random.between(0.05, 0.16))
        .with_dust(DUST, random.between(0.2, 0.95))
}
