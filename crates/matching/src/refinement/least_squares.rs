//! The fraction of a pixel from the images, by least squares (Lucas & Kanade 1981; Ackermann 1984).
//!
//! Penalties of the paths press disparities towards whole numbers ("pixel locking"), and what pixels took from each
//! other is not theirs to the last part. Around a match at disparity `d` the images say how far it is off:
//!
//! ```text
//! e = L(x, y) - R(x - d, y)               what is left over
//! g = (L'(x, y) + R'(x - d, y)) / 2       the slope of grey along the row
//! s = -cov(e, g) / var(g)                 the shift that leaves least, up to half a pixel
//! v = CORRELATED (var(e) - cov(e, g)^2 / var(g) + ROUNDING) / (n var(g))      its variance
//! w = max(OWN^2, s^2 - CHANCE v)          how far off the map is there
//! d + s w / (w + v)
//! ```
//!
//! over the `n` matches among the pixels of a window, each with its own `d`; a mean of two guesses, each of which
//! weighs by its variance. Mostly a map is off by little, but planes go over what is small: a stone that stands 1 px
//! before the ground. So where the shift is larger than it would be by chance it says itself how far off the map is
//! (an empirical Bayes estimate: Efron & Morris 1973), and nearly all of it is done, in two rounds, since the slope of
//! grey holds over half a pixel only. Where there is no texture, or what is left over is no shift (noise, rows that are
//! off, a shine), `v` is large and nothing happens. Differences of exposure are the mean of `e`, which does not count.
//!
//! Between two columns `R` is a [cubic] and `R'` its slope. Both numbers are rounded to 1/16 of a
//! grey value, so that sums slide from window to window and no level or number of threads changes them.

use std::ops::Range;

use raster::{DisparityRange, Plane, Reason, View};
use rayon::prelude::*;

use super::Map;
use crate::kernels::border::around;
use crate::kernels::cubic::cubic;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::rounding::{as_number, nearest};
use crate::profile::Work;

/// Half the window, which is 7 columns by 7 matched rows: 13 rows of the image in `balanced`, which matches every
/// second one.
const RADIUS: usize = 3;
const SIDE: usize = 2 * RADIUS + 1;
/// How far off the disparities are that come here, in pixels, where the images say no more: a standard deviation.
const OWN: f32 = 0.1;
/// Two standard deviations of a shift, squared, may be chance.
const CHANCE: f32 = 4.0;
/// Each goes on from what the one before left.
const ROUNDS: usize = 2;
/// What is left over is alike in neighbours: so many say as much as one that stands alone.
const CORRELATED: f32 = 5.0;
/// The least variance of what is left over, in square grey values: that of rounding, in both images.
const ROUNDING: f32 = 0.3;
/// In a round no shift is larger, in pixels: the slope of grey holds no farther.
const LARGEST_SHIFT: f32 = 0.5;
/// Neighbours of one surface differ by at most so many pixels.
const ONE_SURFACE: f32 = 1.0;
/// Parts of a grey value.
const PARTS: f32 = 16.0;

/// The memory of the stage, kept between frames.
#[derive(Default)]
pub(crate) struct LeastSquares {
    bands: Vec<Band>,
}

/// That of a band of rows.
#[derive(Default)]
struct Band {
    /// The rows of the map before and after it, as they are before anything is changed.
    before: Plane<f32>,
    after: Plane<f32>,
    /// What is left over in the rows of a window, and in the one before them.
    rows: [Residuals; SIDE + 1],
    /// Down the columns of the window, with [`RADIUS`] columns before the first and whole blocks after them.
    sums: Sums,
}

/// What is left over in a row, in [`PARTS`]: 0 where there is no match.
#[derive(Default)]
struct Residuals {
    /// 1, or 0.
    is_match: Vec<i16>,
    error: Vec<i16>,
    slope: Vec<i16>,
}

/// Sums over matches.
#[derive(Default)]
struct Sums {
    count: Vec<i32>,
    error: Vec<i32>,
    slope: Vec<i32>,
    error_error: Vec<i32>,
    error_slope: Vec<i32>,
    slope_slope: Vec<i32>,
}

/// What residuals of a row are computed from, beside its disparities: both images' grey, the column at which the map
/// begins, and its reasons.
struct Seen<'a> {
    left: &'a [u8],
    right: &'a [u8],
    first: usize,
    reasons: &'a [Reason],
}

impl LeastSquares {
    /// What it takes for so many columns.
    pub fn bytes(columns: usize) -> usize {
        let row = 3 * size_of::<i16>();
        let column = 2 * RADIUS * size_of::<f32>() + (SIDE + 1) * row + SUMS * size_of::<i32>();
        rayon::current_num_threads() * column * (columns + BLOCK + MARGINS)
    }

    /// Shifts the matches of a map, whose reasons say which they are.
    pub fn refine(
        &mut self,
        level: Level,
        grey: [View<'_, u8>; 2],
        reasons: &Plane<Reason>,
        mut map: Map<'_>,
    ) -> Work {
        let (columns, rows) = map.values.size();
        (0..ROUNDS).for_each(|_| self.shift(level, grey, reasons, &mut map));
        let pixel = Work::bytes(2 + 1 + 2 * 4) + Work::operations(4 * OPERATIONS);
        pixel * (ROUNDS * columns * rows)
    }

    /// A round.
    fn shift(
        &mut self,
        level: Level,
        grey: [View<'_, u8>; 2],
        reasons: &Plane<Reason>,
        map: &mut Map<'_>,
    ) {
        let (columns, rows) = map.values.size();
        let height = rows.div_ceil(rayon::current_num_threads());
        self.bands.resize_with(rayon::current_num_threads(), Band::default);
        for (band, start) in self.bands.iter_mut().zip((0..rows).step_by(height)) {
            let end = rows.min(start + height);
            keep(map.values, start.saturating_sub(RADIUS)..start, &mut band.before);
            keep(map.values, end..rows.min(end + RADIUS), &mut band.after);
        }
        let &mut Map { ref mut values, first, rows: lines, range } = map;
        let seen = |y: usize| {
            let [left, right] = grey.map(|image| image.row(lines.in_image(y)));
            Seen { left, right, first, reasons: reasons.row(y) }
        };
        let bands = values.samples_mut().par_chunks_mut(height * columns);
        let bands = self.bands.par_iter_mut().zip(bands).enumerate();
        bands.for_each(|(i, (band, values))| {
            band.shift(level, i * height, seen, range, values);
        });
    }
}

/// Operations on numbers of 32 bits: of residuals (what is of one surface and inside, a cubic and its slope, the
/// slope of the left image), of sums that slide down, of those along the row, of the shift.
const OPERATIONS: usize = 40 + 2 * 9 + SUMS * (SIDE - 1) + 29;

/// Keeps some rows of a map.
fn keep(values: &Plane<f32>, rows: Range<usize>, kept: &mut Plane<f32>) {
    let columns = values.columns();
    kept.reshape(columns, rows.len(), 0.0);
    kept.samples_mut().copy_from_slice(&values.samples()[rows.start * columns..rows.end * columns]);
}

impl Band {
    /// Shifts the matches of its rows, of which number `start` of the map is the first.
    fn shift<'a>(
        &mut self,
        level: Level,
        start: usize,
        seen: impl Fn(usize) -> Seen<'a>,
        range: DisparityRange,
        values: &mut [f32],
    ) {
        let Self { before, after, rows: residuals, sums } = self;
        let columns = before.columns();
        residuals.iter_mut().for_each(|row| row.reset(columns));
        sums.reset(columns.next_multiple_of(BLOCK) + MARGINS);
        let end = start + values.len() / columns;
        let first = start - before.rows();
        let mut next = first;
        for y in start..end {
            while next < (y + RADIUS + 1).min(end + after.rows()) {
                let disparities = match next {
                    row if row < start => before.row(row - first),
                    row if row < end => &values[(row - start) * columns..][..columns],
                    row => after.row(row - end),
                };
                let entering = &mut residuals[next % (SIDE + 1)];
                residuals_of_row(level, &seen(next), disparities, entering);
                enter(level, entering, sums);
                next += 1;
            }
            if let Some(leaving) = y.checked_sub(RADIUS + 1).filter(|&row| row >= first) {
                leave(level, &residuals[leaving % (SIDE + 1)], sums);
            }
            let row = &mut values[(y - start) * columns..][..columns];
            let is_match = &residuals[y % (SIDE + 1)].is_match;
            shift_row(level, sums, is_match, [range.min(), range.max()], row);
        }
    }
}

impl Residuals {
    fn reset(&mut self, columns: usize) {
        for row in [&mut self.is_match, &mut self.error, &mut self.slope] {
            row.clear();
            row.resize(columns, 0);
        }
    }
}

impl Sums {
    fn reset(&mut self, columns: usize) {
        let Self { count, error, slope, error_error, error_slope, slope_slope } = self;
        for row in [count, error, slope, error_error, error_slope, slope_slope] {
            row.clear();
            row.resize(columns, 0);
        }
    }
}

/// Pixels that are worked on together, of which only what they look at is taken one by one.
const BLOCK: usize = 64;
/// Columns of sums beside those of the map.
const MARGINS: usize = 2 * RADIUS;
/// Numbers in a column of sums.
const SUMS: usize = 6;

at_every_level! {
    /// What is left over in a row, and the slopes there.
    fn residuals_of_row(seen: &Seen<'_>, values: &[f32], out: &mut Residuals) {
        let Seen { left, right, first, reasons } = *seen;
        for start in (0..values.len()).step_by(BLOCK) {
            let count = BLOCK.min(values.len() - start);
            let mut is_matched = [false; BLOCK];
            for (is_matched, reason) in is_matched.iter_mut().zip(&reasons[start..][..count]) {
                *is_matched = *reason == Reason::Matched;
            }
            // With a neighbour to each side; beyond the row there is none.
            let disparities: [f32; BLOCK + 2] = around(values, start, 1, f32::NAN);
            // Where in the right image, and which part of a column further on.
            let (mut columns, mut parts) = ([1u32; BLOCK], [0.0; BLOCK]);
            let mut is_match = [0i16; BLOCK];
            let last = right.len() as f32 - 3.0;
            for i in 0..BLOCK {
                let here = disparities[i + 1];
                let place = as_number(first + start + i) - here;
                let one_surface = ((disparities[i] - here).abs() <= ONE_SURFACE)
                    & ((disparities[i + 2] - here).abs() <= ONE_SURFACE);
                let is = is_matched[i] & one_surface & (place >= 1.0) & (place <= last);
                let place = if is { place } else { 1.0 };
                // Of a whole column the last part of the one before, which is the same.
                let column = nearest(place - 0.5).max(1);
                columns[i] = column as u32;
                parts[i] = place - column as f32;
                is_match[i] = i16::from(is);
            }
            let mut samples = [0u32; BLOCK];
            for (samples, &column) in samples.iter_mut().zip(&columns) {
                let row = right.get(column as usize - 1..).unwrap_or_default();
                *samples = row.first_chunk().map_or(0, |four| u32::from_le_bytes(*four));
            }
            let grey: [u8; BLOCK + 2] = around(left, first + start, 1, 0);
            let grey = grey.map(f32::from);
            let (mut error, mut slope) = ([0i16; BLOCK], [0i16; BLOCK]);
            for i in 0..BLOCK {
                let four = [0, 8, 16, 24].map(|bits| (samples[i] >> bits & 255) as f32);
                let (sample, of_right) = cubic(four, parts[i]);
                let of_left = 0.5 * (grey[i + 2] - grey[i]);
                error[i] = nearest(PARTS * (grey[i + 1] - sample)) as i16 * is_match[i];
                slope[i] = nearest(PARTS * 0.5 * (of_left + of_right)) as i16 * is_match[i];
            }
            out.is_match[start..][..count].copy_from_slice(&is_match[..count]);
            out.error[start..][..count].copy_from_slice(&error[..count]);
            out.slope[start..][..count].copy_from_slice(&slope[..count]);
        }
    }

    /// A row enters the window.
    fn enter(row: &Residuals, sums: &mut Sums) {
        slide(row, sums, |sum, number| sum + number);
    }

    /// A row leaves the window.
    fn leave(row: &Residuals, sums: &mut Sums) {
        slide(row, sums, |sum, number| sum - number);
    }

    /// Shifts the matches of the row in the middle of the window.
    fn shift_row(
        sums: &Sums,
        is_match: &[i16],
        range: [i32; 2],
        values: &mut [f32],
    ) {
        let [least, most] = range.map(|end| end as f32);
        let square = PARTS * PARTS;
        let blocks = values.chunks_mut(BLOCK).zip(is_match.chunks(BLOCK));
        for ((values, is_match), start) in blocks.zip((0..).step_by(BLOCK)) {
            let count = along(&sums.count, start);
            let error = along(&sums.error, start);
            let slope = along(&sums.slope, start);
            let error_error = along(&sums.error_error, start);
            let error_slope = along(&sums.error_slope, start);
            let slope_slope = along(&sums.slope_slope, start);
            let mut shifts = [0.0; BLOCK];
            for i in 0..BLOCK {
                let n = count[i].max(1) as f32;
                let (e, g) = (error[i] as f32, slope[i] as f32);
                // Sums of squares, to which a little is added so that nothing is divided by zero.
                let of_slopes = slope_slope[i] as f32 - g * g / n + 1.0;
                let shared = error_slope[i] as f32 - e * g / n;
                let of_errors = error_error[i] as f32 - e * e / n;
                let shift = shared / of_slopes;
                let left = (of_errors - shift * shared).max(0.0) / n + ROUNDING * square;
                let variance = CORRELATED * left / of_slopes;
                let shift = shift.clamp(-LARGEST_SHIFT, LARGEST_SHIFT);
                let own = (shift * shift - CHANCE * variance).max(OWN * OWN);
                shifts[i] = shift * own / (own + variance);
            }
            for ((value, shift), &is_match) in values.iter_mut().zip(shifts).zip(is_match) {
                let shifted = (*value - shift).clamp(least, most);
                // Of a condition the compiler would make another one, whether to write, which AVX2 is slow at.
                let stays = (i32::from(is_match) - 1) as u32;
                *value = f32::from_bits(shifted.to_bits() & !stays | value.to_bits() & stays);
            }
        }
    }
}

/// Adds a row to sums down the columns, or takes it away.
#[inline(always)]
fn slide(row: &Residuals, sums: &mut Sums, change: impl Fn(i32, i32) -> i32) {
    let n = row.error.len();
    let (is_match, error, slope) = (&row.is_match[..n], &row.error[..n], &row.slope[..n]);
    let Sums { count, error: errors, slope: slopes, error_error, error_slope, slope_slope } = sums;
    let [count, errors, slopes, error_error, error_slope, slope_slope] =
        [count, errors, slopes, error_error, error_slope, slope_slope]
            .map(|sums| &mut sums[RADIUS..][..n]);
    for x in 0..n {
        count[x] = change(count[x], is_match[x].into());
        errors[x] = change(errors[x], error[x].into());
        slopes[x] = change(slopes[x], slope[x].into());
    }
    for x in 0..n {
        let (error, slope) = (i32::from(error[x]), i32::from(slope[x]));
        error_error[x] = change(error_error[x], error * error);
        error_slope[x] = change(error_slope[x], error * slope);
        slope_slope[x] = change(slope_slope[x], slope * slope);
    }
}

/// The sums over the windows of the columns of a block.
#[inline(always)]
fn along(sums: &[i32], start: usize) -> [i32; BLOCK] {
    let sums: &[i32; BLOCK + MARGINS] = sums[start..].first_chunk().expect("whole blocks");
    let mut all = [0; BLOCK];
    for i in 0..BLOCK {
        let mut sum = sums[i];
        for n in 1..SIDE {
            sum += sums[i + n];
        }
        all[i] = sum;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::cost::MatchedRows;

    /// Texture that a cubic follows, in column `x` of a row, which need not be whole.
    fn texture(x: f32, y: usize) -> f32 {
        let wave = |length: f32, phase: f32| (x / length + phase * y as f32).sin();
        128.0 + 40.0 * wave(1.7, 0.9) + 30.0 * wave(2.9, 1.7) + 25.0 * wave(5.3, 0.4)
    }

    /// A pair whose right image is that of a wall at a disparity.
    fn wall(columns: usize, rows: usize, disparity: f32) -> [Plane<u8>; 2] {
        [0.0, disparity].map(|shift| {
            Plane::from_fn(columns, rows, |x, y| texture(x as f32 + shift, y).round() as u8)
        })
    }

    fn refine(
        level: Level,
        [left, right]: &[Plane<u8>; 2],
        values: &mut Plane<f32>,
        reasons: &Plane<Reason>,
        (first, rows): (usize, MatchedRows),
    ) {
        let range = DisparityRange::new(0, 20).unwrap();
        let map = Map { values, first, rows, range };
        LeastSquares::default().refine(level, [left.view(), right.view()], reasons, map);
    }

    #[test]
    fn what_is_off_by_a_fraction_is_mended_whatever_the_brightness() {
        let (columns, rows) = (90, 30);
        let lines = MatchedRows { top: 0, count: rows, apart: 1 };
        let [left, right] = wall(columns, rows, 6.3);
        // What is left over is no shift then, which is believed the less.
        let paler = right.map(|&sample| (0.9 * f32::from(sample)) as u8);
        let brighter = right.map(|&sample| sample + 20);
        let reasons = Plane::filled(columns, rows, Reason::Matched);
        for (right, most) in [(right, 0.03), (brighter, 0.03), (paler, 0.15)] {
            let mut values = Plane::filled(columns, rows, 6.1);
            refine(Level::detect(), &[left.clone(), right], &mut values, &reasons, (0, lines));
            for (y, x) in (0..rows).flat_map(|y| (10..columns - 10).map(move |x| (y, x))) {
                let off = (values.row(y)[x] - 6.3).abs();
                assert!(off < most, "column {x}, row {y}: off by {off}");
            }
            // Their matches lie outside the right image.
            assert_eq!(values.row(9)[..7], [6.1; 7]);
        }
    }

    #[test]
    fn a_stone_that_a_plane_went_over_comes_back() {
        // Of a wall at 6, 15 x 15 pixels stand .8 before it, and the map has the wall alone.
        let (columns, rows) = (70, 40);
        let is_stone = |x: usize, y: usize| (30..45).contains(&x) && (12..27).contains(&y);
        let left = Plane::from_fn(columns, rows, |x, y| texture(x as f32, y).round() as u8);
        let right = Plane::from_fn(columns, rows, |x, y| {
            let disparity = if is_stone(x + 6, y) { 6.8 } else { 6.0 };
            texture(x as f32 + disparity, y).round() as u8
        });
        let lines = MatchedRows { top: 0, count: rows, apart: 1 };
        let reasons = Plane::filled(columns, rows, Reason::Matched);
        let mut values = Plane::filled(columns, rows, 6.0);
        refine(Level::detect(), &[left, right], &mut values, &reasons, (0, lines));
        for (y, x) in (16..23).flat_map(|y| (34..41).map(move |x| (y, x))) {
            let off = (values.row(y)[x] - 6.8).abs();
            assert!(off < 0.05, "column {x}, row {y}: off by {off}");
        }
        for x in (10..25).chain(50..60) {
            let off = (values.row(20)[x] - 6.0).abs();
            assert!(off < 0.05, "column {x}: off by {off}");
        }
    }

    #[test]
    fn without_texture_or_match_nothing_moves() {
        let (columns, rows) = (70, 20);
        let lines = MatchedRows { top: 0, count: rows, apart: 1 };
        let values = Plane::filled(columns, rows, 6.1);
        let matched = Plane::filled(columns, rows, Reason::Matched);
        let filled = Plane::filled(columns, rows, Reason::OccludedFilled);
        let blank = [(); 2].map(|()| Plane::filled(columns, rows, 90));
        for (images, reasons) in [(blank, matched), (wall(columns, rows, 6.3), filled)] {
            let mut after = values.clone();
            refine(Level::detect(), &images, &mut after, &reasons, (0, lines));
            assert!(after == values);
        }
    }

    /// The formulas of a round one by one: of column `x` and row `y` of a map.
    fn definition(
        [left, right]: &[Plane<u8>; 2],
        values: &Plane<f32>,
        reasons: &Plane<Reason>,
        (first, rows): (usize, MatchedRows),
        (x, y): (usize, usize),
    ) -> f64 {
        let residual = |u: usize, v: usize| {
            let d = values.row(v)[u];
            let near = |other: usize| {
                let other = values.row(v).get(other);
                other.is_none_or(|other| (other - d).abs() <= ONE_SURFACE)
            };
            let inside = u > 0 && u + 1 < values.columns();
            let place = (first + u) as f32 - d;
            let last = right.columns() as f32 - 3.0;
            let is_match = inside && near(u - 1) && near(u + 1) && place >= 1.0 && place <= last;
            if !is_match || reasons.row(v)[u] != Reason::Matched {
                return None;
            }
            let (whole, t) = (place.floor() as usize, f64::from(place.fract()));
            let row = right.row(rows.in_image(v));
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| f64::from(row[whole + i - 1]));
            let cubic =
                [b, (c - a) / 2.0, a - 2.5 * b + 2.0 * c - d / 2.0, (d - a + 3.0 * (b - c)) / 2.0];
            let sample = cubic[0] + t * (cubic[1] + t * (cubic[2] + t * cubic[3]));
            let of_right = cubic[1] + t * (2.0 * cubic[2] + t * 3.0 * cubic[3]);
            let row = left.row(rows.in_image(v));
            let grey = |x: usize| f64::from(row[x]);
            let of_left = (grey(first + u + 1) - grey(first + u - 1)) / 2.0;
            Some((grey(first + u) - sample, (of_left + of_right) / 2.0))
        };
        let d = f64::from(values.row(y)[x]);
        if residual(x, y).is_none() {
            return d;
        }
        let window = |at: usize, end: usize| at.saturating_sub(RADIUS)..(at + RADIUS + 1).min(end);
        let pixels =
            window(y, values.rows()).flat_map(|v| window(x, values.columns()).map(move |u| (u, v)));
        let all: Vec<(f64, f64)> = pixels.filter_map(|(u, v)| residual(u, v)).collect();
        let n = all.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| all.iter().map(of).sum::<f64>() / n;
        let (e, g) = (mean(|r| r.0), mean(|r| r.1));
        let variance = mean(|r| r.1 * r.1) - g * g + 1.0 / f64::from(PARTS * PARTS) / n;
        let shared = mean(|r| r.0 * r.1) - e * g;
        let shift = -shared / variance;
        let left = mean(|r| r.0 * r.0) - e * e - shared * shared / variance;
        let of_shift =
            f64::from(CORRELATED) * (left.max(0.0) + f64::from(ROUNDING)) / (n * variance);
        let most = f64::from(LARGEST_SHIFT);
        let shift = shift.clamp(-most, most);
        let own = (shift * shift - f64::from(CHANCE) * of_shift).max(f64::from(OWN * OWN));
        (d + shift * own / (own + of_shift)).clamp(0.0, 20.0)
    }

    #[test]
    fn every_level_and_number_of_threads_does_what_the_formulas_say() {
        for (columns, rows, apart, first) in [(1, 1, 1, 0), (64, 9, 1, 0), (130, 23, 2, 7)] {
            let mut chance = Chance(columns as u32);
            let size = (columns + first + 3, apart * rows);
            let mut images = wall(size.0, size.1, 5.2);
            for sample in images.iter_mut().flat_map(|image| image.samples_mut()) {
                *sample = sample.saturating_add((12.0 * chance.share()) as u8);
            }
            // A wall that is off by up to a quarter, and some pixels of something nearer.
            let before = Plane::from_fn(columns, rows, |_, _| match chance.share() {
                share if share < 0.03 => 9.0,
                _ => 4.95 + 0.5 * chance.share(),
            });
            let reasons = before.map(|_| match chance.bits(3) {
                0 => Reason::MismatchedFilled,
                _ => Reason::Matched,
            });
            let lines = (first, MatchedRows { top: 0, count: rows, apart });
            let refined = |level, threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let mut values = before.clone();
                pool.install(|| refine(level, &images, &mut values, &reasons, lines));
                values
            };
            let expected = refined(Level::available()[0], 1);
            let mut between = before.clone();
            for _ in 0..ROUNDS {
                between = Plane::from_fn(columns, rows, |x, y| {
                    definition(&images, &between, &reasons, lines, (x, y)) as f32
                });
            }
            for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                let defined = f64::from(between.row(y)[x]);
                let found = f64::from(expected.row(y)[x]);
                assert!((found - defined).abs() < 2e-3, "{found}, not {defined} at ({x}, {y})");
            }
            assert!(columns == 1 || expected != before, "nothing moved");
            for level in Level::available() {
                eprintln!("{columns} x {rows}, level {}", level.name());
                for threads in [1, 2, 5] {
                    assert!(refined(level, threads) == expected, "{threads} threads");
                }
            }
        }
    }
}
