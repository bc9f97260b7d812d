//! The slopes of a disparity map: medians of differences over four pixels, in a 5 x 5 window, clamped
//! to 1/2. Beside an edge most of the window lies on one side.
//!
//! Medians are found among whole numbers of 16 bits, steps of 1/32768: twice as many at once as with floats.
//!
//! In: finite values. Beside an end of the map the nearest differences that do not reach beyond it
//! are repeated; a map of fewer than five columns or rows is flat that way.

use std::ops::Range;

use raster::Plane;
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::kernels::median::{self, BLOCK, medians_of_block};
use crate::kernels::rounding::nearest;
use crate::profile::Work;

/// Surfaces steeper than this do not count as such.
const STEEPEST: f32 = 0.5;
/// Steps per unit.
const STEPS: f32 = 32768.0;

/// The slopes of a map, or of some of its rows: changes per column and per row.
#[derive(Default)]
pub(crate) struct Slopes {
    pub along: Plane<f32>,
    pub down: Plane<f32>,
}

impl Slopes {
    /// The slopes of some rows of a map.
    pub fn compute(&mut self, level: Level, values: &Plane<f32>, rows: Range<usize>) -> Work {
        let columns = values.columns();
        self.along.reshape(columns, rows.len(), 0.0);
        self.down.reshape(columns, rows.len(), 0.0);
        let slopes = self.along.samples_mut().par_chunks_mut(columns);
        let slopes = slopes.zip(self.down.samples_mut().par_chunks_mut(columns)).enumerate();
        slopes.for_each(|(i, (along, down))| {
            slopes_of_row(level, values, rows.start + i, along, down);
        });
        let pixels = columns * rows.len();
        Work::bytes(3 * 4 * pixels) + Work::operations(2 * median::OPERATIONS) * pixels
    }
}

at_every_level! {
    /// The slopes of row `y`: changes per column and per row.
    fn slopes_of_row(values: &Plane<f32>, y: usize, along: &mut [f32], down: &mut [f32]) {
        for x in (0..along.len()).step_by(BLOCK) {
            let size = BLOCK.min(along.len() - x);
            let [wide, high] = slopes_around(values, x, y, size);
            for (slopes, around) in [(&mut *along, wide), (&mut *down, high)] {
                let medians = medians_of_block(around);
                for (slope, median) in slopes[x..x + size].iter_mut().zip(medians) {
                    *slope = f32::from(median) * (1.0 / STEPS);
                }
            }
        }
    }
}

/// The slope over four pixels, clamped, which does not change which of several is the median.
#[inline(always)]
fn slope(difference: f32) -> i16 {
    let slope = 0.25 * difference;
    let slope = if slope < STEEPEST { slope } else { STEEPEST };
    let slope = if slope > -STEEPEST { slope } else { -STEEPEST };
    nearest(slope * STEPS) as i16
}

/// The slopes along and down the map in the windows of so many pixels from `(x, y)` on.
#[inline(always)]
fn slopes_around(values: &Plane<f32>, x: usize, y: usize, size: usize) -> [median::Rows<i16>; 2] {
    let (columns, rows) = values.size();
    let [mut wide, mut high] = [[[0; BLOCK + 4]; 5]; 2];
    let inner = x >= 4 && x + BLOCK + 4 <= columns;
    for j in 0..5 {
        let v = (y + j).saturating_sub(2).min(rows - 1);
        let here = values.row(v);
        // Where there is no difference all are 0.
        let [above, below] = match middle(v, rows) {
            Some(v) => [v - 2, v + 2].map(|v| values.row(v)),
            None => [here; 2],
        };
        if inner {
            let [above, here, below] = [above, here, below].map(|row| &row[x - 4..][..BLOCK + 8]);
            for i in 0..BLOCK + 4 {
                wide[j][i] = slope(here[i + 4] - here[i]);
                high[j][i] = slope(below[i + 2] - above[i + 2]);
            }
        } else {
            for i in 0..size + 4 {
                let u = (x + i).saturating_sub(2).min(columns - 1);
                if let Some(u) = middle(u, columns) {
                    wide[j][i] = slope(here[u + 2] - here[u - 2]);
                }
                high[j][i] = slope(below[u] - above[u]);
            }
        }
    }
    [wide, high]
}

/// The nearest of so many places that has two more on both sides.
#[inline(always)]
fn middle(place: usize, places: usize) -> Option<usize> {
    (places > 4).then(|| place.clamp(2, places - 3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    /// The slopes at a pixel: the definition.
    fn slopes_at(values: &Plane<f32>, x: usize, y: usize) -> (f32, f32) {
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
                0.25 * (row[u + 2] - row[u - 2])
            }
        };
        let down = |u: usize, v: usize| match rows {
            0..5 => 0.0,
            _ => {
                let v = v.clamp(2, rows - 3);
                0.25 * (values.row(v + 2)[u] - values.row(v - 2)[u])
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
                for y in 0..rows {
                    let [mut along, mut down] = [vec![0.0; columns], vec![0.0; columns]];
                    slopes_of_row(level, &values, y, &mut along, &mut down);
                    for x in 0..columns {
                        let expected = slopes_at(&values, x, y);
                        assert_eq!((along[x], down[x]), expected, "column {x}, row {y}");
                    }
                }
            }
        }
    }
}
