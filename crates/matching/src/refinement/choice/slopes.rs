//! The slopes of a disparity map: medians of differences over four samples, in a 5 x 5 window, clamped
//! to 1/2 per pixel. Beside an edge most of the window lies on one side.
//!
//! Medians are found among whole numbers of 16 bits, steps of 1/32768: twice as many at once as with floats.
//! Five windows above each other see the same row: its differences are taken once.
//!
//! In: finite values. Beside an end of the map the nearest differences that do not reach beyond it
//! are repeated; a map of fewer than five columns or rows is flat that way.

use std::ops::Range;

use raster::Plane;
use rayon::prelude::*;

use super::taken;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::median::{self, REACH, SIDE, median_of_5_rows};
use crate::kernels::rounding::nearest;
use crate::profile::Work;

/// Surfaces steeper than this do not count as such.
const STEEPEST: f32 = 0.5;
/// Steps per unit.
const STEPS: f32 = 32768.0;
/// Keeps slopes above zero, where the order of numbers with a sign is that of numbers without.
const ZERO: i32 = 32768;

/// Changes per column and per row, in steps.
pub(crate) type Slope = [i16; 2];

/// The slopes of a map, or of some of its rows.
#[derive(Default)]
pub(crate) struct Slopes {
    slopes: Plane<Slope>,
    bands: Vec<Band>,
}

/// The memory of a band of rows: differences of the rows of a window, used in turns, and medians of a row.
#[derive(Default)]
struct Band {
    along: [Vec<u16>; SIDE],
    down: [Vec<u16>; SIDE],
    medians: [Vec<u16>; 2],
}

impl Slopes {
    /// What they take of a map of so many columns and rows.
    pub fn bytes(columns: usize, rows: usize) -> usize {
        let bands = rayon::current_num_threads() * (2 * SIDE + 2) * size_of::<u16>() * columns;
        size_of::<Slope>() * columns * rows + bands
    }

    /// The slopes per pixel of some rows of a map, whose samples are so many pixels apart.
    pub fn compute(
        &mut self,
        level: Level,
        values: &Plane<f32>,
        apart: usize,
        rows: Range<usize>,
    ) -> Work {
        let columns = values.columns();
        let Self { slopes, bands } = self;
        slopes.reshape(columns, rows.len(), [0; 2]);
        let threads = rayon::current_num_threads();
        bands.resize_with(threads, Band::default);
        bands.iter_mut().for_each(|band| band.reset(columns));
        let height = rows.len().div_ceil(threads);
        let share = 1.0 / (4 * apart) as f32;
        let slopes = slopes.samples_mut().par_chunks_mut(height * columns);
        slopes.zip(bands).enumerate().for_each(|(i, (slopes, band))| {
            band.slopes(level, (values, share), rows.start + i * height, slopes);
        });
        let pixels = columns * rows.len();
        Work::bytes((size_of::<f32>() + size_of::<Slope>()) * pixels)
            + Work::operations(2 * median::OPERATIONS) * pixels
    }

    /// Those of a row.
    #[inline(always)]
    pub fn row(&self, y: usize) -> &[Slope] {
        self.slopes.row(y)
    }
}

impl Band {
    fn reset(&mut self, columns: usize) {
        let Self { along, down, medians } = self;
        for row in along.iter_mut().chain(down).chain(medians) {
            taken(row, columns, 0);
        }
    }

    /// The slopes of rows from `first` on; that over four samples is this share of their difference.
    fn slopes(
        &mut self,
        level: Level,
        (values, share): (&Plane<f32>, f32),
        first: usize,
        slopes: &mut [Slope],
    ) {
        let (columns, rows) = values.size();
        let last = rows - 1;
        let mut next = first.saturating_sub(REACH);
        for (y, slopes) in (first..).zip(slopes.chunks_exact_mut(columns)) {
            while next <= (y + REACH).min(last) {
                let place = next % SIDE;
                differences_along(level, values.row(next), share, &mut self.along[place]);
                // Where there is no difference all are 0.
                let [above, below] = match rows {
                    0..SIDE => [next; 2],
                    _ => [0, SIDE - 1].map(|v| next.clamp(REACH, last - REACH) - REACH + v),
                }
                .map(|v| values.row(v));
                differences(level, above, below, share, &mut self.down[place]);
                next += 1;
            }
            let near: [usize; SIDE] =
                std::array::from_fn(|j| (y + j).saturating_sub(REACH).min(last) % SIDE);
            for (differences, medians) in
                [&self.along, &self.down].into_iter().zip(&mut self.medians)
            {
                let window = near.map(|place| &differences[place][..]);
                median_of_5_rows(level, window, medians);
            }
            side_by_side(level, &self.medians[0], &self.medians[1], slopes);
        }
    }
}

at_every_level! {
    /// The slopes over four samples from one row to another.
    fn differences(from: &[f32], to: &[f32], share: f32, out: &mut [u16]) {
        for (out, (from, to)) in out.iter_mut().zip(from.iter().zip(to)) {
            *out = steps(share * (to - from));
        }
    }

    /// The slopes over four samples along a row.
    fn differences_along(row: &[f32], share: f32, out: &mut [u16]) {
        let columns = row.len();
        if columns < SIDE {
            out.fill(steps(0.0));
            return;
        }
        let inner = &mut out[REACH..columns - REACH];
        for (out, (from, to)) in inner.iter_mut().zip(row.iter().zip(&row[2 * REACH..])) {
            *out = steps(share * (to - from));
        }
        let (first, last) = (out[REACH], out[columns - 1 - REACH]);
        out[..REACH].fill(first);
        out[columns - REACH..].fill(last);
    }

    fn side_by_side(along: &[u16], down: &[u16], slopes: &mut [Slope]) {
        for (slope, (&along, &down)) in slopes.iter_mut().zip(along.iter().zip(down)) {
            *slope = [along, down].map(|median| (i32::from(median) - ZERO) as i16);
        }
    }
}

/// By how much planes of a slope rise on the way over so many columns and rows, in pixels of disparity. A slope
/// is at most half of what 16 bits hold, so every number on the way is exact.
#[inline(always)]
pub(super) fn rise([along, down]: Slope, [columns, rows]: [f32; 2]) -> f32 {
    (f32::from(along) * columns + f32::from(down) * rows) * (1.0 / STEPS)
}

/// The plane of a pixel, a disparity and its slope, continued over so many columns and rows, within the range; or, of
/// one outside the map, what stands `here`.
#[inline(always)]
pub(super) fn continued(
    (disparity, slope): (f32, Slope),
    way: [f32; 2],
    is_inside: bool,
    here: f32,
    [least, most]: [f32; 2],
) -> f32 {
    // From there to here it is the other way.
    let d = if is_inside { disparity - rise(slope, way) } else { here };
    let d = if d < least { least } else { d };
    if d > most { most } else { d }
}

/// How steep a plane is, the sum of both ways.
#[inline(always)]
pub(super) fn steep([along, down]: Slope) -> f32 {
    (f32::from(along).abs() + f32::from(down).abs()) * (1.0 / STEPS)
}

/// A slope in steps, clamped, which does not change which of several is the median.
#[inline(always)]
fn steps(slope: f32) -> u16 {
    let slope = if slope < STEEPEST { slope } else { STEEPEST };
    let slope = if slope > -STEEPEST { slope } else { -STEEPEST };
    (nearest(slope * STEPS) + ZERO) as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    /// The slopes at a pixel: the definition.
    fn slopes_at(values: &Plane<f32>, apart: usize, x: usize, y: usize) -> (f32, f32) {
        let (columns, rows) = values.size();
        let window = |at: usize, end: usize| {
            (-2..=2).map(move |i| (at as i64 + i).clamp(0, end as i64 - 1) as usize)
        };
        let median = |difference: &dyn Fn(usize, usize) -> f32| {
            let pixels = window(y, rows).flat_map(|v| window(x, columns).map(move |u| (u, v)));
            let mut all: Vec<f32> = pixels.map(|(u, v)| difference(u, v)).collect();
            all.sort_by(f32::total_cmp);
            (all[12].clamp(-0.5, 0.5) * 32768.0).round_ties_even() / 32768.0
        };
        let along = |u: usize, v: usize| match columns {
            0..5 => 0.0,
            _ => {
                let (u, row) = (u.clamp(2, columns - 3), values.row(v));
                0.25 / apart as f32 * (row[u + 2] - row[u - 2])
            }
        };
        let down = |u: usize, v: usize| match rows {
            0..5 => 0.0,
            _ => {
                let v = v.clamp(2, rows - 3);
                0.25 / apart as f32 * (values.row(v + 2)[u] - values.row(v - 2)[u])
            }
        };
        (median(&along), median(&down))
    }

    #[test]
    fn slopes_are_those_of_the_definition_at_every_level() {
        for (columns, rows) in
            [(1, 1), (4, 12), (5, 5), (6, 4), (65, 3), (131, 5), (132, 6), (150, 14)]
        {
            let mut chance = Chance(columns as u32);
            let values = Plane::from_fn(columns, rows, |x, y| {
                let step = if x > columns / 2 { 9.0 } else { 0.0 };
                0.1 * x as f32 - 0.2 * y as f32 + chance.bits(16) as f32 / 65536.0 + step
            });
            for level in Level::available() {
                eprintln!("level {}", level.name());
                for (threads, apart, part) in
                    [(1, 1, 0..rows), (2, 2, 0..rows), (3, 1, rows / 3..rows)]
                {
                    let mut slopes = Slopes::default();
                    let pool =
                        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                    pool.install(|| slopes.compute(level, &values, apart, part.clone()));
                    for (y, x) in part.clone().flat_map(|y| (0..columns).map(move |x| (y, x))) {
                        let slope = slopes.row(y - part.start)[x];
                        let (along, down) = slopes_at(&values, apart, x, y);
                        assert_eq!(rise(slope, [1.0, 0.0]), along, "column {x}, row {y}");
                        assert_eq!(rise(slope, [0.0, 1.0]), down, "column {x}, row {y}");
                        assert_eq!(rise(slope, [-7.0, 24.0]), -7.0 * along + 24.0 * down);
                        assert_eq!(steep(slope), along.abs() + down.abs());
                    }
                }
            }
        }
    }
}
