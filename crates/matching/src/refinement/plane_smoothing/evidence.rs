//! Whether the images speak against what smoothing did.
//!
//! Around a pixel the left image and what disparities `d` point at in the right one differ by
//!
//! ```text
//! e = L(x, y) - R(x - d, y)
//! E = sum of (e - mean of e)^2
//! ```
//!
//! over the pixels of a window, each with its own `d`; once with the disparities as they were, and once as they are
//! smoothed. They stay as they were where
//!
//! ```text
//! E_smoothed - E_before > AGAINST (E_before / n + ROUNDING)
//! ```
//!
//! The left side over the variance of noise is twice the logarithm of a likelihood ratio (Neyman & Pearson 1933), and
//! what is left over says what noise there is. A difference of exposure is the mean of `e`. On blank or noisy
//! surfaces the two differ by little, so planes stay there.
//!
//! Between two columns `R` is a line. Differences are rounded to 1/16 of a grey value, so that no level changes sums.

use crate::kernels::border::around;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::rounding::{as_number, nearest};

/// Half the window: in all directions so many disparities, which are so many pixels apart.
pub(super) const fn radius(apart: usize) -> usize {
    if apart == 1 { 3 } else { 2 }
}
/// The rows of a window, at most.
pub(super) const SIDE: usize = 2 * radius(1) + 1;
/// From which logarithm of the likelihood ratio on, twice, disparities stay: chance alone reaches a few.
const AGAINST: f32 = 12.0;
/// Added to the variance of what is left over, in square grey values: rounding of both images alone is a sixth, and a
/// line between columns is not what the camera saw.
const ROUNDING: f32 = 1.0;
/// Parts of a grey value.
const PARTS: f32 = 16.0;
/// A disparity stands for at most so many columns.
const MOST_APART: usize = 2;

/// Pixels that are worked on together.
const BLOCK: usize = 64;

/// Operations on bytes per disparity of two maps, each of which stands for so many columns: on numbers of 32 bits, of
/// differences, of sums along the row and down the columns, and of what they tell.
pub(super) const fn operations(apart: usize) -> usize {
    let side = 2 * radius(apart) + 1;
    4 * (2 * (apart * (9 + 3) + 2 * 2 * side) + 12)
}

/// A row of both images, and the column of the left one that the map begins at.
#[derive(Clone, Copy)]
pub(super) struct Row<'a> {
    pub left: &'a [u8],
    pub right: &'a [u8],
    pub first: usize,
}

/// Of the differences in a row, in [`PARTS`]: sums over the windows' columns, and those of squares.
#[derive(Default)]
pub(super) struct Differences {
    sums: Vec<i32>,
    squares: Vec<i32>,
}

impl Differences {
    /// What they take for each disparity.
    pub const BYTES: usize = 2 * size_of::<i32>();

    /// Become those of a row with these disparities. What `scratch` held is lost.
    pub fn become_those_of<const APART: usize>(
        &mut self,
        level: Level,
        row: Row<'_>,
        values: &[f32],
        scratch: &mut Vec<i16>,
    ) {
        scratch.resize(APART * values.len(), 0);
        differ::<APART>(level, row, values, scratch);
        self.sums.resize(values.len(), 0);
        self.squares.resize(values.len(), 0);
        along_row::<APART>(level, scratch, &mut self.sums, &mut self.squares);
    }
}

at_every_level! {
    /// By how much the images differ in a row: at the first columns that disparities stand for, then at the second ones.
    /// Beyond the ends of an image there is what is at its end.
    fn differ<const APART: usize>(seen: Row<'_>, values: &[f32], out: &mut [i16]) {
        let Row { left, right, first } = seen;
        let end = as_number(right.len()) - 1.0;
        let last = (right.len() as i32 - 2).max(0);
        let end_of_left = left.last().copied().unwrap_or_default();
        for (s, out) in out.chunks_mut(values.len()).enumerate() {
            let blocks = values.chunks(BLOCK).zip(out.chunks_mut(BLOCK));
            for ((values, out), start) in blocks.zip((0..).step_by(BLOCK)) {
                let column = first + APART * start;
                let d: [f32; BLOCK] = around(values, 0, 0, 0.0);
                let (mut columns, mut parts) = ([0u32; BLOCK], [0.0; BLOCK]);
                for i in 0..BLOCK {
                    let place = as_number(column + APART * i + s) - d[i];
                    let place = place.min(end).max(0.0);
                    // Of a whole column the last part of the one before, which is the same.
                    let whole = nearest(place - 0.5).max(0).min(last);
                    columns[i] = whole as u32;
                    parts[i] = place - whole as f32;
                }
                let mut samples = [0u16; BLOCK];
                for (samples, &column) in samples.iter_mut().zip(&columns) {
                    let row = right.get(column as usize..).unwrap_or_default();
                    *samples = row.first_chunk().map_or(0, |two| u16::from_le_bytes(*two));
                }
                let grey: [u8; MOST_APART * BLOCK] = around(left, column, 0, end_of_left);
                let mut differences = [0i16; BLOCK];
                for i in 0..BLOCK {
                    let (a, b) = (f32::from(samples[i] & 255), f32::from(samples[i] >> 8));
                    let sample = a + parts[i] * (b - a);
                    let grey = f32::from(grey[APART * i + s]);
                    differences[i] = nearest(PARTS * (grey - sample)) as i16;
                }
                out.copy_from_slice(&differences[..out.len()]);
            }
        }
    }

    /// Sums over the columns of windows; beyond the row nothing differs.
    fn along_row<const APART: usize>(differences: &[i16], sums: &mut [i32], squares: &mut [i32]) {
        const MOST: usize = radius(1);
        let radius = const { radius(APART) };
        let columns = sums.len();
        let blocks = sums.chunks_mut(BLOCK).zip(squares.chunks_mut(BLOCK));
        for ((out, out_squares), start) in blocks.zip((0..).step_by(BLOCK)) {
            let (mut here, mut of_squares) = ([0; BLOCK + 2 * MOST], [0; BLOCK + 2 * MOST]);
            for row in differences.chunks_exact(columns) {
                let differences: [i16; BLOCK + 2 * MOST] = around(row, start, radius, 0);
                for i in 0..BLOCK + 2 * MOST {
                    let difference = i32::from(differences[i]);
                    here[i] += difference;
                    of_squares[i] += difference * difference;
                }
            }
            let (mut sums, mut squares) = ([0; BLOCK], [0; BLOCK]);
            for k in 0..2 * radius + 1 {
                for i in 0..BLOCK {
                    sums[i] += here[i + k];
                    squares[i] += of_squares[i + k];
                }
            }
            out.copy_from_slice(&sums[..out.len()]);
            out_squares.copy_from_slice(&squares[..out_squares.len()]);
        }
    }

    /// A row of the map: smoothed, or as it was. `rows` are those of its window, before and after smoothing.
    pub(super) fn decide<const APART: usize>(
        rows: &[[&Differences; 2]],
        before: &[f32],
        smoothed: &[f32],
        out: &mut [f32],
    ) {
        let (columns, radius) = (out.len(), const { radius(APART) as i32 });
        let lines = (APART * rows.len()) as i32;
        for (start, out) in (0..).step_by(BLOCK).zip(out.chunks_mut(BLOCK)) {
            let mut n = [0.0; BLOCK];
            for (i, n) in (0..).zip(&mut n) {
                let first = (start as i32 + i - radius).max(0);
                let end = (start as i32 + i + radius + 1).min(columns as i32).max(first + 1);
                *n = (lines * (end - first)) as f32;
            }
            // One by one: what a closure calls is not compiled for the level.
            let of_before = left_over(rows, 0, start, &n);
            let of_smoothed = left_over(rows, 1, start, &n);
            let before: [f32; BLOCK] = around(before, start, 0, 0.0);
            let smoothed: [f32; BLOCK] = around(smoothed, start, 0, 0.0);
            let mut decided = [0.0; BLOCK];
            for i in 0..BLOCK {
                let noise = of_before[i] / n[i] + PARTS * PARTS * ROUNDING;
                let stays = of_smoothed[i] - of_before[i] > AGAINST * noise;
                decided[i] = if stays { before[i] } else { smoothed[i] };
            }
            out.copy_from_slice(&decided[..out.len()]);
        }
    }
}

/// What is left over around the pixels of a block, before smoothing (0) or after it (1); windows have `n` samples.
#[inline(always)]
fn left_over(
    rows: &[[&Differences; 2]],
    map: usize,
    start: usize,
    n: &[f32; BLOCK],
) -> [f32; BLOCK] {
    let (mut sums, mut squares) = ([0; BLOCK], [0; BLOCK]);
    for row in rows {
        let Differences { sums: sum, squares: square } = row[map];
        let (sum, square): ([i32; BLOCK], [i32; BLOCK]) =
            (around(sum, start, 0, 0), around(square, start, 0, 0));
        for i in 0..BLOCK {
            sums[i] += sum[i];
            squares[i] += square[i];
        }
    }
    let mut left = [0.0; BLOCK];
    for i in 0..BLOCK {
        let sum = sums[i] as f32;
        left[i] = squares[i] as f32 - sum * sum / n[i];
    }
    left
}

#[cfg(test)]
mod tests {
    use raster::Plane;

    use super::*;
    use crate::chance::Chance;

    /// Grey of both images, and disparities before and after smoothing, `APART` columns apart, from column `first` on.
    struct Seen {
        grey: [Plane<u8>; 2],
        first: usize,
        maps: [Plane<f32>; 2],
    }

    impl Seen {
        /// Noise, and what stands in both images, moved by 5 columns or none; disparities near that.
        fn by_chance(columns: usize, rows: usize, apart: usize, first: usize) -> Self {
            let mut chance = Chance((columns + apart) as u32);
            // Of the last disparity's columns the last one is beyond the image.
            let width = first + apart * columns - (apart - 1);
            let shift = if columns > 100 { 0 } else { 5 };
            let wide = Plane::from_fn(width + 5, rows, |_, _| chance.bits(8) as u8);
            let mut noisy = |shift: usize| {
                Plane::from_fn(width, rows, |x, y| {
                    wide.row(y)[x + shift].saturating_add((9.0 * chance.share()) as u8)
                })
            };
            let grey = [noisy(0), noisy(shift)];
            let mut near = |off: f32| {
                Plane::from_fn(columns, rows, |_, _| shift as f32 + off * (chance.share() - 0.5))
            };
            Self { grey, first, maps: [near(0.5), near(0.6)] }
        }

        fn decided<const APART: usize>(&self, level: Level, y: usize) -> Vec<f32> {
            let radius = radius(APART);
            let (columns, rows) = self.maps[0].size();
            let window = y.saturating_sub(radius)..(y + radius + 1).min(rows);
            let window: Vec<[Differences; 2]> = window
                .map(|v| {
                    let [left, right] = [0, 1].map(|i| self.grey[i].row(v));
                    let row = Row { left, right, first: self.first };
                    let mut differences = <[Differences; 2]>::default();
                    for (differences, map) in differences.iter_mut().zip(&self.maps) {
                        let (values, mut scratch) = (map.row(v), Vec::new());
                        differences.become_those_of::<APART>(level, row, values, &mut scratch);
                    }
                    differences
                })
                .collect();
            let window: Vec<_> = window.iter().map(|[before, after]| [before, after]).collect();
            let (before, smoothed) = (self.maps[0].row(y), self.maps[1].row(y));
            let mut out = vec![0.0; columns];
            decide::<APART>(level, &window, before, smoothed, &mut out);
            out
        }

        /// `E_smoothed - E_before - AGAINST (E_before / n + ROUNDING)`, by the formulas.
        fn definition(&self, apart: usize, x: usize, y: usize) -> f64 {
            let radius = radius(apart);
            let (columns, rows) = self.maps[0].size();
            let window =
                |at: usize, end: usize| at.saturating_sub(radius)..(at + radius + 1).min(end);
            let places = window(y, rows).flat_map(|v| {
                window(x, columns).flat_map(move |u| (0..apart).map(move |s| (u, s, v)))
            });
            let [(before, n), (smoothed, _)] = [0, 1].map(|map| {
                let all: Vec<f64> = places
                    .clone()
                    .map(|(u, s, v)| {
                        let right = self.grey[1].row(v);
                        let column = self.first + apart * u + s;
                        let place = column as f64 - f64::from(self.maps[map].row(v)[u]);
                        let place = place.min(right.len() as f64 - 1.0).max(0.0);
                        let whole = (place.floor() as usize).min(right.len() - 2);
                        let part = place - whole as f64;
                        let [a, b] = [0, 1].map(|i| f64::from(right[whole + i]));
                        let parts = f64::from(PARTS);
                        let left = self.grey[0].row(v);
                        let grey = f64::from(left[column.min(left.len() - 1)]);
                        ((grey - a - part * (b - a)) * parts).round() / parts
                    })
                    .collect();
                let n = all.len() as f64;
                let mean = all.iter().sum::<f64>() / n;
                (all.iter().map(|e| (e - mean).powi(2)).sum::<f64>(), n)
            });
            smoothed - before - f64::from(AGAINST) * (before / n + f64::from(ROUNDING))
        }

        fn check<const APART: usize>(&self) {
            let (columns, rows) = self.maps[0].size();
            let mut stayed = 0;
            for y in 0..rows {
                let expected = self.decided::<APART>(Level::available()[0], y);
                for (x, &decided) in expected.iter().enumerate() {
                    let [before, smoothed] = [0, 1].map(|map| self.maps[map].row(y)[x]);
                    let against = self.definition(APART, x, y);
                    let stays = against > 0.0;
                    stayed += usize::from(stays);
                    let is_sure = against.abs() > 0.5;
                    let defined = if stays { before } else { smoothed };
                    assert!(decided == defined || !is_sure, "{against} at ({x}, {y})");
                }
                for level in Level::available() {
                    assert_eq!(self.decided::<APART>(level, y), expected, "{}", level.name());
                }
            }
            let share = stayed as f64 / (columns * rows) as f64;
            assert!(columns < 9 || (0.1..0.9).contains(&share), "{share} stay");
        }
    }

    #[test]
    fn every_level_does_what_the_formulas_say() {
        for (columns, rows, first) in [(1, 1, 1), (5, 9, 0), (64, 3, 2), (130, 12, 9)] {
            eprintln!("{columns} x {rows}, {:?}", Level::available());
            Seen::by_chance(columns, rows, 1, first).check::<1>();
            Seen::by_chance(columns, rows, 2, first).check::<2>();
        }
    }

    #[test]
    fn where_an_image_is_a_column_wide_nothing_stays() {
        let column = Plane::filled(1, 1, 7);
        let maps = [Plane::filled(1, 1, 0.0), Plane::filled(1, 1, 1.0)];
        let seen = Seen { grey: [column.clone(), column], first: 0, maps };
        assert_eq!(seen.decided::<1>(Level::detect(), 0), [1.0]);
    }
}
