//! What surfaces look like: patterns in each object's own coordinates, in metres.
//!
//! A pattern is a number in [0, 1] per point, which mixes a dark and a light colour. It is solid
//! (defined in space, not on a map), so both cameras see one and the same surface. Edges are
//! filtered over the `footprint` of a pixel: stripes and checks by the exact integral of a square
//! wave, noise by dropping octaves.

use crate::noise::{fractal, gradient, resolved};
use crate::number::{greatest, least, mix, smoothstep};
use crate::random::{hash, salt, unit};
use crate::vector::{Vector, vector};

const GRAIN: u64 = salt("grain");
const TILTS: [u64; 3] = [salt("tilt x"), salt("tilt y"), salt("tilt z")];

/// How dark and light alternate. Lengths are in metres in the object's own axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Pattern {
    /// One colour: nothing to match but shading.
    Blank,
    /// Rich fine texture without repetition: the easy case. `size` is the widest feature.
    Speckle { size: f64 },
    /// Clouds with soft edges; `size` is the widest feature.
    Cloudy { size: f64 },
    /// Stripes across the object's x axis: every `period` looks alike.
    Stripes { period: f64 },
    /// A chequerboard in space.
    Checks { period: f64 },
    /// Round dots on a square grid in x and y.
    Dots { period: f64 },
    /// Rows of bricks in x and y with light mortar, each brick of its own shade.
    Bricks { length: f64, height: f64 },
    /// Lines of dark words on light paper, in x and y.
    Print { line: f64 },
    /// Growth rings around the object's z axis.
    Wood { ring: f64 },
    /// Soil: clouds from `size` down to the finest grain that a pixel shows, and dark pebbles of
    /// every size in x and y.
    Regolith { size: f64 },
    /// Dark window panes with light frames in x and y, every `width` by `height`.
    Windows { width: f64, height: f64 },
}

/// How a surface reflects light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Material {
    pub pattern: Pattern,
    /// Colour where the pattern is 0; linear red, green, blue reflectance.
    pub dark: Vector,
    /// Colour where the pattern is 1.
    pub light: Vector,
    /// Strength of an irregular fine grain on top, 0 for none. Its size is `grain_size`.
    pub grain: f64,
    /// Widest feature of the grain.
    pub grain_size: f64,
    /// Strength of the highlight, which moves with the viewer; 0 for none.
    pub specular: f64,
    /// The highlight's exponent is 2 to this power.
    pub gloss: u32,
    /// Share of the surroundings that a glancing ray sees mirrored, 0 to 1.
    pub mirror: f64,
    /// How much the grain also tilts the surface for the light; 0 for smooth.
    pub relief: f64,
    /// Dust that has settled on what faces up: its colour, and 0 (none) to 1 (all covered).
    pub dust: (Vector, f64),
}

impl Material {
    /// A matt surface of one colour.
    pub fn matt(colour: Vector) -> Self {
        Self {
            pattern: Pattern::Blank,
            dark: colour,
            light: colour,
            grain: 0.0,
            grain_size: 1.0,
            specular: 0.0,
            gloss: 5,
            mirror: 0.0,
            relief: 0.0,
            dust: (colour, 0.0),
        }
    }

    /// A matt surface with a pattern between two colours.
    pub fn patterned(pattern: Pattern, dark: Vector, light: Vector) -> Self {
        Self { pattern, dark, light, ..Self::matt(light) }
    }

    pub fn with_grain(self, strength: f64, size: f64) -> Self {
        Self { grain: strength, grain_size: size, ..self }
    }

    pub fn with_highlight(self, specular: f64, gloss: u32) -> Self {
        Self { specular, gloss, ..self }
    }

    pub fn with_mirror(self, mirror: f64) -> Self {
        Self { mirror, ..self }
    }

    pub fn with_relief(self, relief: f64) -> Self {
        Self { relief, ..self }
    }

    pub fn with_dust(self, colour: Vector, cover: f64) -> Self {
        Self { dust: (colour, cover), ..self }
    }

    /// How the grain tilts the surface: added to a normal of length 1.
    pub fn bump(&self, p: Vector, footprint: f64, seed: u64) -> Vector {
        let along = |salt: u64| fractal(p, self.grain_size, 1, 1.0, footprint, seed ^ salt);
        vector(along(TILTS[0]), along(TILTS[1]), along(TILTS[2])) * (3.0 * self.relief)
    }

    /// The colour at a point in the object's own axes. `contrast` 0 leaves the mean colour.
    pub fn colour(&self, p: Vector, footprint: f64, contrast: f64, seed: u64) -> Vector {
        let mean = 0.5;
        let at = mean + (self.pattern.value(p, footprint, seed) - mean) * contrast;
        let colour = self.dark.mix(self.light, at);
        if self.grain == 0.0 {
            return colour;
        }
        let grain = fractal(p, self.grain_size, 3, 0.8, footprint, seed ^ GRAIN);
        colour * greatest(1.0 + contrast * self.grain * 2.0 * grain, 0.0)
    }
}

/// The mean over a window `width` wide of the square wave that is 1 on the first `duty` of each
/// unit and 0 on the rest.
#[inline]
fn pulse(x: f64, duty: f64, width: f64) -> f64 {
    let integral = |x: f64| x.floor() * duty + least(x - x.floor(), duty);
    let width = greatest(width, 1e-9);
    (integral(x + 0.5 * width) - integral(x - 0.5 * width)) / width
}

impl Pattern {
    /// Whether it looks alike at every period, so that a matcher can be wrong by whole periods.
    /// Bricks do not: each has its own shade.
    pub fn is_repeated(self) -> bool {
        matches!(
            self,
            Self::Stripes { .. } | Self::Checks { .. } | Self::Dots { .. } | Self::Windows { .. }
        )
    }

    /// The pattern's value in [0, 1] at a point, averaged over about `footprint`.
    fn value(&self, p: Vector, footprint: f64, seed: u64) -> f64 {
        match *self {
            Self::Blank => 0.5,
            Self::Speckle { size } => {
                0.5 + 0.75 * fractal(p, size, 4, 0.9, footprint, seed).clamp(-0.66, 0.66)
            }
            Self::Cloudy { size } => {
                0.5 + 0.75 * fractal(p, size, 5, 0.5, footprint, seed).clamp(-0.66, 0.66)
            }
            Self::Stripes { period } => pulse(p.x / period, 0.5, footprint / period),
            Self::Checks { period } => {
                let wave = |x: f64| 2.0 * pulse(x / period, 0.5, footprint / period) - 1.0;
                // Off the grid's planes by a little, so that a face at 0 does not flicker.
                let shift = 0.137 * period;
                0.5 + 0.5 * wave(p.x + shift) * wave(p.y + shift) * wave(p.z + shift)
            }
            Self::Dots { period } => {
                let off = |x: f64| x / period - (x / period).floor() - 0.5;
                let (x, y) = (off(p.x), off(p.y));
                let distance = (x * x + y * y).sqrt();
                let soft = 0.5 * footprint / period + 1e-9;
                let dot = smoothstep(0.3 - soft, 0.3 + soft, distance);
                // A whole dot is pi 0.09 of its cell; far away only that mean is left.
                mix(0.717, dot, resolved(period, footprint))
            }
            Self::Bricks { length, height } => {
                let row = (p.y / height).floor();
                let x = p.x / length + 0.5 * (row - 2.0 * (row * 0.5).floor());
                let mortar = 0.12 * height;
                let brick = pulse(x, 1.0 - mortar / length, footprint / length)
                    * pulse(p.y / height, 0.88, footprint / height);
                let shade = 0.45 * unit(hash(seed, x.floor() as i64, row as i64, 0));
                mix(1.0, shade, brick)
            }
            Self::Print { line } => {
                let row = (p.y / line).floor();
                let letter = 0.35 * line;
                // A word is a run of letters; each run is dark or a gap, each letter has a shade.
                let word =
                    (p.x / (4.0 * letter) + 7.3 * unit(hash(seed, row as i64, 1, 0))).floor();
                let gap = unit(hash(seed, word as i64, row as i64, 2)) < 0.18;
                let ink = unit(hash(seed, (p.x / letter).floor() as i64, row as i64, 3));
                let rows = pulse(p.y / line, 0.55, footprint / line);
                let dark = if gap { 0.0 } else { 0.55 + 0.45 * ink };
                1.0 - rows * mix(0.5, dark, resolved(letter, footprint))
            }
            Self::Wood { ring } => {
                let wobble = 1.5 * ring * gradient(p * (0.12 / ring), seed);
                let r = (p.x * p.x + p.y * p.y).sqrt() + wobble + 0.15 * p.z;
                let phase = r / ring - (r / ring).floor();
                let tooth = smoothstep(0.0, 0.75, phase) * (1.0 - smoothstep(0.85, 1.0, phase));
                mix(0.45, tooth, resolved(ring, footprint))
            }
            Self::Regolith { size } => {
                let soil = 0.62 + 0.5 * fractal(p, size, 9, 0.86, footprint, seed);
                let pebbles = [0.19, 0.07, 0.026].map(|pitch| pebble(p, pitch, footprint, seed));
                pebbles.into_iter().fold(soil.clamp(0.0, 1.0), |soil, shade| soil * shade)
            }
            Self::Windows { width, height } => {
                let pane = |x: f64, period: f64, from: f64, to: f64| {
                    pulse(x / period - from, to - from, footprint / period)
                };
                let hole = pane(p.x, width, 0.22, 0.78) * pane(p.y, height, 0.2, 0.75);
                let cross = 1.0 - pane(p.x, width, 0.48, 0.52).clamp(0.0, 1.0);
                let number =
                    hash(seed, (p.x / width).floor() as i64, (p.y / height).floor() as i64, 4);
                1.0 - hole * cross * (0.75 + 0.25 * unit(number))
            }
        }
    }
}

/// 1 on bare soil, less on the pebble that every fourth cell of a grid in x and y holds.
fn pebble(p: Vector, pitch: f64, footprint: f64, seed: u64) -> f64 {
    let left = resolved(0.3 * pitch, footprint);
    if left == 0.0 {
        return 1.0;
    }
    let (x, y) = ((p.x / pitch).floor(), (p.y / pitch).floor());
    let number = hash(seed, x as i64, y as i64, 5);
    if number & 3 != 0 {
        return 1.0;
    }
    // Its place, size and shade are parts of one hash.
    let part = |shift: u32| (number >> shift & 0xff) as f64 / 255.0;
    let (dx, dy) = (p.x / pitch - x - 0.3 - 0.4 * part(8), p.y / pitch - y - 0.3 - 0.4 * part(16));
    let radius = 0.1 + 0.18 * part(24);
    let distance = (dx * dx + dy * dy).sqrt() / radius;
    let cover = 1.0 - smoothstep(0.7, 1.1, distance);
    1.0 - left * cover * (0.15 + 0.5 * part(32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::vector;

    const ALL: [Pattern; 11] = [
        Pattern::Blank,
        Pattern::Speckle { size: 0.3 },
        Pattern::Cloudy { size: 0.3 },
        Pattern::Stripes { period: 0.3 },
        Pattern::Checks { period: 0.3 },
        Pattern::Dots { period: 0.3 },
        Pattern::Bricks { length: 0.5, height: 0.2 },
        Pattern::Print { line: 0.2 },
        Pattern::Wood { ring: 0.1 },
        Pattern::Windows { width: 0.4, height: 0.5 },
        Pattern::Regolith { size: 0.5 },
    ];

    #[test]
    fn every_pattern_stays_between_0_and_1_and_only_blank_is_blank() {
        for pattern in ALL {
            let values: Vec<f64> = (0..2000)
                .map(|i| {
                    let s = f64::from(i);
                    pattern.value(vector(s * 0.0137, s * 0.0071, s * 0.0053), 0.01, 4)
                })
                .collect();
            assert!(values.iter().all(|v| (-1e-9..=1.0 + 1e-9).contains(v)), "{pattern:?}");
            let varies = values.iter().any(|v| (v - values[0]).abs() > 0.2);
            assert_eq!(varies, pattern != Pattern::Blank, "{pattern:?}");
        }
    }

    #[test]
    fn a_pulse_is_averaged_exactly() {
        assert!((pulse(0.25, 0.5, 0.1) - 1.0).abs() < 1e-12);
        assert!(pulse(0.75, 0.5, 0.1).abs() < 1e-12);
        assert!((pulse(0.5, 0.5, 0.1) - 0.5).abs() < 1e-12);
        assert!((pulse(0.123, 0.3, 1.0) - 0.3).abs() < 1e-12);
    }

    #[test]
    fn repeated_patterns_repeat() {
        for pattern in &ALL[3..6] {
            let p = vector(0.11, 0.27, 0.05);
            let a = pattern.value(p, 0.01, 4);
            let b = pattern.value(p + vector(0.3 * 5.0, 0.0, 0.0), 0.01, 4);
            assert!((a - b).abs() < 1e-9, "{pattern:?}");
        }
    }

    #[test]
    fn without_contrast_a_surface_is_blank() {
        let m = Material::patterned(ALL[4], vector(0.0, 0.0, 0.0), vector(1.0, 1.0, 1.0))
            .with_grain(0.5, 0.1);
        let a = m.colour(vector(0.1, 0.2, 0.3), 0.01, 0.0, 1);
        assert_eq!(a, m.colour(vector(0.3, 0.9, 0.7), 0.01, 0.0, 1));
        assert_ne!(
            m.colour(vector(0.1, 0.2, 0.3), 0.01, 1.0, 1),
            m.colour(vector(0.31, 0.2, 0.3), 0.01, 1.0, 1)
        );
    }
}
