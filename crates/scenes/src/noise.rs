//! Band-limited noise in space: Perlin's gradient noise and sums of its octaves.
//!
//! K. Perlin, *Improving noise* (SIGGRAPH 2002): a random gradient at every whole-numbered point,
//! blended with a quintic. Gradients come from a hash of the cell, not from a permutation table, so
//! the noise does not repeat. Octaves finer than the `footprint` of a pixel are faded out, so that
//! both cameras see the same surface instead of two different aliases of it.

use crate::number::{mix, smoothstep};
use crate::random::key;
use crate::vector::{Vector, vector};

/// The edges of a cube as seen from its middle; four of the twelve are listed twice, as Perlin
/// does, so that a choice takes four bits and no branch.
const EDGES: [[f64; 3]; 16] = [
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [-1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [-1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [-1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, -1.0, 1.0],
    [0.0, 1.0, -1.0],
    [0.0, -1.0, -1.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [0.0, -1.0, 1.0],
    [0.0, -1.0, -1.0],
];

/// The dot product of an offset with the gradient that a hash's top four bits choose.
#[inline]
fn corner(hash: u64, x: f64, y: f64, z: f64) -> f64 {
    let [a, b, c] = EDGES[(hash >> 60) as usize];
    a * x + b * y + c * z
}

/// The whole number below. `f64::floor` is a call on processors without SSE 4.1.
#[inline]
fn whole(x: f64) -> i64 {
    let cut = x as i64;
    if (cut as f64) > x { cut - 1 } else { cut }
}

#[inline]
fn quintic(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// Gradient noise with features about one unit wide: 0 at whole-numbered points, mean 0,
/// deviation about 0.27, within [-1.05, 1.05].
pub(crate) fn gradient(p: Vector, seed: u64) -> f64 {
    let (ix, iy, iz) = (whole(p.x), whole(p.y), whole(p.z));
    let (x, y, z) = (p.x - ix as f64, p.y - iy as f64, p.z - iz as f64);
    let cell = key(ix, iy, iz).wrapping_add(seed);
    let at = |dx: i64, dy: i64, dz: i64| {
        // One multiplication is mixing enough for a choice among twelve.
        let folded = cell.wrapping_add(key(dx, dy, dz));
        let hash = (folded ^ folded >> 32).wrapping_mul(0xd6e8_feb8_6659_fd93);
        corner(hash, x - dx as f64, y - dy as f64, z - dz as f64)
    };
    let (u, v, w) = (quintic(x), quintic(y), quintic(z));
    let near = mix(mix(at(0, 0, 0), at(1, 0, 0), u), mix(at(0, 1, 0), at(1, 1, 0), u), v);
    let far = mix(mix(at(0, 0, 1), at(1, 0, 1), u), mix(at(0, 1, 1), at(1, 1, 1), u), v);
    mix(near, far, w)
}

/// How much of a feature of this `size` is left when a pixel is `footprint` wide: all of it from
/// 2.5 pixels, none below 1.
#[inline]
pub(crate) fn resolved(size: f64, footprint: f64) -> f64 {
    smoothstep(1.0, 2.5, size / footprint)
}

/// A sum of `octaves`, the first with features `size` wide, each next one half as wide and
/// `roughness` as strong; mean 0, deviation about 0.3.
pub(crate) fn fractal(
    p: Vector,
    size: f64,
    octaves: u32,
    roughness: f64,
    footprint: f64,
    seed: u64,
) -> f64 {
    let (mut sum, mut squares, mut strength, mut size) = (0.0, 0.0, 1.0, size);
    for octave in 0..octaves {
        let left = resolved(size, footprint);
        squares += strength * strength;
        if left > 0.0 {
            // Shifted, so that the octaves' grids, where each is 0, do not fall together, nor on
            // the flat faces of objects at 0.
            let shift = 0.37 * f64::from(octave + 1);
            let q = p * (1.0 / size) + vector(shift, 0.59 * shift, 1.21 * shift);
            sum += left * strength * gradient(q, seed.wrapping_add(octave.into()));
        }
        strength *= roughness;
        size *= 0.5;
    }
    sum / squares.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn noise_is_bounded_centred_and_smooth() {
        let mut random = Random::new(3, "test");
        let (mut sum, mut squares) = (0.0, 0.0);
        let n = 20_000;
        for _ in 0..n {
            let p = vector(
                random.between(-9.0, 9.0),
                random.between(-9.0, 9.0),
                random.between(-9.0, 9.0),
            );
            let v = gradient(p, 1);
            assert!(v.abs() < 1.05);
            let moved = gradient(p + vector(1e-6, 0.0, 0.0), 1);
            assert!((moved - v).abs() < 1e-5);
            sum += v;
            squares += v * v;
        }
        assert!((sum / f64::from(n)).abs() < 0.02);
        let deviation = (squares / f64::from(n)).sqrt();
        assert!((0.2..0.35).contains(&deviation), "{deviation}");
    }

    #[test]
    fn fine_octaves_fade_with_the_footprint() {
        let p = vector(0.3, 0.4, 0.5);
        assert_eq!(fractal(p, 1.0, 5, 0.5, 2.0, 9), 0.0);
        assert_ne!(fractal(p, 1.0, 5, 0.5, 0.01, 9), 0.0);
    }
}
