//! How much the grey changes on the way from one pixel to another.
//!
//! A plane that comes from beyond an edge of the image is less likely the pixel's own. The way is a
//! straight one along a row, a column or a diagonal, so the change is the difference of two running
//! sums: one pixel costs the same however long its ways are. Those along rows and columns become part of its
//! [note](super::notes).

use raster::Plane;
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;

/// Steps of so many grey values are noise, and no edge counts more than this above it.
const NOISE: u8 = 3;
const LARGEST: u8 = 40;

/// The ways that there are.
const WAYS: usize = 4;

/// Of each way, per pixel the sum of the steps before it. Sums wrap around, as do their differences.
#[derive(Default)]
pub(crate) struct Edges([Plane<u16>; WAYS]);

/// Which way leads to a place so many columns and rows away; any to the pixel itself.
pub(crate) const fn way((dx, dy): (i32, i32)) -> usize {
    match (dx, dy) {
        (_, 0) => 0,
        (0, _) => 1,
        _ if dx == dy => 2,
        _ => {
            assert!(dx == -dy, "neither a row, nor a column, nor a diagonal");
            3
        }
    }
}

#[inline(always)]
fn step(a: u8, b: u8) -> u16 {
    u16::from(a.abs_diff(b).saturating_sub(NOISE).min(LARGEST))
}

impl Edges {
    /// What they take for so many pixels.
    pub fn bytes(pixels: usize) -> usize {
        WAYS * size_of::<u16>() * pixels
    }

    /// Adds up the steps of an image.
    pub fn compute(&mut self, level: Level, image: &Plane<u8>) -> Work {
        let columns = image.columns();
        let row = |y: usize| image.row(y);
        self.0.par_iter_mut().enumerate().for_each(|(way, sums)| {
            sums.reshape(columns, image.rows(), 0);
            for y in 0..image.rows() {
                let (above, sums) = sums.samples_mut().split_at_mut(y * columns);
                let (grey, sums) = (row(y), &mut sums[..columns]);
                // Where a way begins.
                match way {
                    _ if y == 0 => sums.fill(0),
                    3 => sums[columns - 1] = 0,
                    _ => sums[0] = 0,
                }
                if way == 0 {
                    let mut sum = 0u16;
                    for (sum_here, grey) in sums[1..].iter_mut().zip(grey.windows(2)) {
                        sum = sum.wrapping_add(step(grey[0], grey[1]));
                        *sum_here = sum;
                    }
                } else if y > 0 {
                    let above = &above[(y - 1) * columns..];
                    let grey_above = row(y - 1);
                    let last = columns - 1;
                    match way {
                        1 => add_steps(level, above, grey_above, grey, sums),
                        2 => add_steps(level, above, grey_above, &grey[1..], &mut sums[1..]),
                        _ => {
                            let sums = &mut sums[..last];
                            add_steps(level, &above[1..], &grey_above[1..], &grey[..last], sums);
                        }
                    }
                }
            }
        });
        Work::bytes(columns * image.rows() + Self::bytes(columns * image.rows()))
    }

    /// The sums of the steps before all pixels, on a way.
    #[inline(always)]
    pub fn samples(&self, way: usize) -> &[u16] {
        self.0[way].samples()
    }

    /// Those of row `y`.
    #[inline(always)]
    pub fn row(&self, way: usize, y: usize) -> &[u16] {
        self.0[way].row(y)
    }
}

at_every_level! {
    /// Adds the steps from the row above, of which each slice begins where a way comes from.
    fn add_steps(above: &[u16], grey_above: &[u8], grey: &[u8], sums: &mut [u16]) {
        let from = above.iter().zip(grey_above);
        for (sum, ((&above, &grey_above), &grey)) in sums.iter_mut().zip(from.zip(grey)) {
            *sum = above.wrapping_add(step(grey_above, grey));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_those_on_the_way_at_every_level() {
        let grey = Plane::from_fn(30, 9, |x, y| ((x * x * 13 + y * 57 + x * y * 5) % 251) as u8);
        for level in Level::available() {
            let mut edges = Edges::default();
            edges.compute(level, &grey);
            check(&grey, &edges);
        }
    }

    #[test]
    fn rows_of_steps_are_their_definition_at_every_level() {
        let grey = |i: usize| ((i * i * 31 + i * 7) % 256) as u8;
        let (from, to): (Vec<u8>, Vec<u8>) = (0..100).map(|i| (grey(i), grey(i + 41))).unzip();
        // Sums wrap around.
        let above: Vec<u16> = (0..100).map(|i| 65_500 + i % 36).collect();
        let expected: Vec<u16> = (0..100)
            .map(|i| above[i].wrapping_add(u16::from(from[i].abs_diff(to[i]).clamp(3, 43) - 3)))
            .collect();
        assert!(expected.iter().any(|&sum| sum < 40) && expected.iter().any(|&sum| sum > 65_500));
        for level in Level::available() {
            for columns in [0, 1, 31, 100] {
                let mut sums = vec![9; columns];
                add_steps(level, &above, &from, &to, &mut sums);
                assert_eq!(sums, expected[..columns], "level {}", level.name());
            }
        }
    }

    /// Some ways of each direction, pixel by pixel.
    fn check(grey: &Plane<u8>, edges: &Edges) {
        let ways: [((i32, i32), (i32, i32)); 9] = [
            ((0, 0), (3, 3)),
            ((7, 0), (20, 0)),
            ((-5, 0), (5, 8)),
            ((0, 4), (29, 4)),
            ((0, -8), (0, 8)),
            ((6, 6), (23, 2)),
            ((-3, -3), (3, 3)),
            ((5, -5), (24, 8)),
            ((-8, 8), (8, 0)),
        ];
        for (place, (x, y)) in ways {
            let (length, (sx, sy)) =
                (i32::max(place.0.abs(), place.1.abs()), (place.0.signum(), place.1.signum()));
            let at = |n: i32| (x + n * sx, y + n * sy);
            let shade = |(x, y): (i32, i32)| grey.row(y as usize)[x as usize];
            let expected: u16 = (0..length)
                .map(|n| {
                    u16::from(shade(at(n)).abs_diff(shade(at(n + 1))).saturating_sub(3).min(40))
                })
                .sum();
            let sum = |(x, y): (i32, i32)| edges.row(way(place), y as usize)[x as usize];
            let between = sum(at(0)).wrapping_sub(sum(at(length))) as i16;
            assert_eq!(between.unsigned_abs(), expected);
        }
    }
}
