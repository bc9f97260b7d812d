//! The slopes of a disparity map: medians of differences over four pixels, in a 5 x 5 window, clamped
//! to 1/2. Beside an edge most of the window lies on one side.
//!
//! In: finite values. Differences that reach beyond the map do not count.

use std::ops::Range;

use raster::Plane;
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::kernels::median::{self, BLOCK, medians_of_block};
use crate::profile::Work;

/// Surfaces steeper than this do not count as such.
const STEEPEST: f32 = 0.5;

/// The slopes of a map, or of some of its rows: changes per column and per row.
#[derive(Default)]
pub(crate) struct Slopes {
    pub along: Plane<f32>,
    pub down: Plane<f32>,
}

impl Slopes {
    pub fn compute(&mut self, level: Level, values: &Plane<f32>) -> Work {
        self.compute_rows(level, values, 0..values.rows())
    }

    /// The slopes of some rows of a map.
    pub fn compute_rows(&mut self, level: Level, values: &Plane<f32>, rows: Range<usize>) -> Work {
        let columns = values.columns();
        self.along.reset(columns, rows.len(), 0.0);
        self.down.reset(columns, rows.len(), 0.0);
        let slopes = self.along.samples_mut().par_chunks_mut(columns);
        let slopes = slopes.zip(self.down.samples_mut().par_chunks_mut(columns)).enumerate();
        slopes.for_each(|(i, (along, down))| {
            slopes_of_row(level, values, rows.start + i, along, down);
        });
        // Two medians of numbers of 32 bits, not 16.
        let pixels = columns * rows.len();
        Work::bytes(3 * 4 * pixels) + Work::operations(2 * 2 * median::OPERATIONS) * pixels
    }
}

/// The slopes of row `y`: changes per column and per row.
fn slopes_of_row(level: Level, values: &Plane<f32>, y: usize, along: &mut [f32], down: &mut [f32]) {
    let (columns, rows) = values.size();
    // Where no window of differences meets an end of the map.
    let whole = y >= 4 && y + 4 < rows && columns >= BLOCK + 8;
    let inner = if whole { 4..columns - 4 } else { 0..0 };
    for start in inner.clone().step_by(BLOCK) {
        let start = start.min(inner.end - BLOCK);
        let [along, down] = [&mut *along, &mut *down].map(|slopes| &mut slopes[start..]);
        slopes_of_block(level, values, start, y, along, down);
    }
    for x in (0..inner.start).chain(inner.end..columns) {
        (along[x], down[x]) = slopes_at(values, x, y);
    }
}

at_every_level! {
    /// The slopes of the planes from `(x, y)` on, away from the ends of the map.
    fn slopes_of_block(
        values: &Plane<f32>,
        x: usize,
        y: usize,
        along: &mut [f32],
        down: &mut [f32],
    ) {
        let [mut wide, mut high] = [[[0.0; BLOCK + 4]; 5]; 2];
        for j in 0..5 {
            let rows = [y + j - 4, y + j - 2, y + j];
            let [above, here, below] = rows.map(|v| &values.row(v)[x - 4..][..BLOCK + 8]);
            for i in 0..BLOCK + 4 {
                wide[j][i] = 0.25 * (here[i + 4] - here[i]);
                high[j][i] = 0.25 * (below[i + 2] - above[i + 2]);
            }
        }
        for (slopes, differences) in [(along, wide), (down, high)] {
            for (slope, median) in slopes.iter_mut().zip(medians_of_block(differences)) {
                *slope = median.clamp(-STEEPEST, STEEPEST);
            }
        }
    }
}

/// The slopes at a pixel: the definition.
fn slopes_at(values: &Plane<f32>, x: usize, y: usize) -> (f32, f32) {
    let (columns, rows) = values.size();
    let (mut along, mut down) = ([0.0f32; 25], [0.0f32; 25]);
    let (mut n, mut m) = (0, 0);
    for v in y.saturating_sub(2)..=(y + 2).min(rows - 1) {
        for u in x.saturating_sub(2)..=(x + 2).min(columns - 1) {
            if u >= 2 && u + 2 < columns {
                along[n] = 0.25 * (values.row(v)[u + 2] - values.row(v)[u - 2]);
                n += 1;
            }
            if v >= 2 && v + 2 < rows {
                down[m] = 0.25 * (values.row(v + 2)[u] - values.row(v - 2)[u]);
                m += 1;
            }
        }
    }
    let median = |differences: &mut [f32]| {
        let middle = differences.len() / 2;
        if differences.is_empty() {
            0.0
        } else {
            let (_, &mut median, _) = differences.select_nth_unstable_by(middle, f32::total_cmp);
            median.clamp(-STEEPEST, STEEPEST)
        }
    };
    (median(&mut along[..n]), median(&mut down[..m]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    #[test]
    fn slopes_are_those_of_the_definition_at_every_level() {
        for (columns, rows) in [(1, 1), (6, 12), (72, 9), (150, 14)] {
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
