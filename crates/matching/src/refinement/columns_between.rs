//! Columns between those that were matched, every second one: as [rows between](super::rows_between), halfway where
//! both neighbours are of one surface, else as the neighbour whose grey value is nearer to its own.
//!
//! What is matched stands for four pixels and was compared by all of them, so its disparity is that of their middle, half
//! a pixel to the right of its own place and below it. On a slope that is another one: first it is taken back, towards
//! the matched pixels before it in its row and its column, where they are of one surface.

use raster::{Plane, Reason, View};
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;

/// Why the disparities of a map are there, and how sure they are.
#[derive(Default)]
pub(crate) struct Sources {
    pub reasons: Plane<Reason>,
    pub confidence: Plane<f32>,
}

/// Some columns of a map without holes: disparities in pixels, why they are there and how sure they are.
#[derive(Clone, Copy)]
pub(crate) struct Matched<'a> {
    pub values: &'a Plane<f32>,
    pub reasons: &'a Plane<Reason>,
    pub confidence: &'a Plane<f32>,
}

impl Sources {
    /// What they take for so many pixels.
    pub fn bytes(pixels: usize) -> usize {
        (size_of::<Reason>() + size_of::<f32>()) * pixels
    }

    /// Become, with disparities in `values`, what was matched of every second column, and the columns between. `grey`
    /// has all columns of the rows of the map; disparities of one surface differ by at most `same` pixels.
    pub fn spread(
        &mut self,
        level: Level,
        grey: View<'_, u8>,
        same: f32,
        matched: Matched<'_>,
        values: &mut Plane<f32>,
    ) -> Work {
        let (columns, rows) = (grey.columns(), grey.rows());
        values.reshape(columns, rows, 0.0);
        self.reasons.reshape(columns, rows, Reason::Matched);
        self.confidence.reshape(columns, rows, 0.0);
        let values = values.samples_mut().par_chunks_mut(columns);
        let reasons = self.reasons.samples_mut().par_chunks_mut(columns);
        let confidence = self.confidence.samples_mut().par_chunks_mut(columns);
        let out = values.zip(reasons).zip(confidence).enumerate();
        out.for_each(|(y, ((values, reasons), confidence))| {
            let row = Row {
                grey: grey.row(y),
                above: matched.values.row(y.saturating_sub(1)),
                values: matched.values.row(y),
                reasons: matched.reasons.row(y),
                confidence: matched.confidence.row(y),
            };
            row_spread(level, same, row, values, reasons, confidence);
        });
        let pixel = size_of::<f32>() + Self::bytes(1);
        Work::bytes(columns * rows + (columns + columns / 2) * rows * pixel)
    }
}

/// What a row is made of: all of its grey values, the others in every second column; and the disparities above.
#[derive(Clone, Copy)]
struct Row<'a> {
    grey: &'a [u8],
    above: &'a [f32],
    values: &'a [f32],
    reasons: &'a [Reason],
    confidence: &'a [f32],
}

/// So much of the way to the matched pixel before is taken back in each direction. Half a pixel is a quarter of it; some
/// of that least squares find afterwards, from the image itself.
const BACK: f32 = 0.15;

/// Matched columns that are worked on together, and those with the columns between.
const GROUP: usize = 32;
const ALL: usize = 2 * GROUP;

/// Samples from a place on; beyond the end of the row its last one is repeated.
#[inline(always)]
fn samples<T: Copy, const N: usize>(row: &[T], from: usize) -> [T; N] {
    if let Some(&samples) = row[from..].first_chunk() {
        return samples;
    }
    let mut samples = [row[row.len() - 1]; N];
    samples[..row.len() - from].copy_from_slice(&row[from..]);
    samples
}

/// The samples before those from a place on: before the first one itself, and beyond the end before the last one.
#[inline(always)]
fn samples_before(row: &[f32], from: usize) -> [f32; GROUP + 1] {
    let others = &row[..(row.len() - 1).max(1)];
    if from > 0 {
        return samples(others, from - 1);
    }
    let mut before = [others[0]; GROUP + 1];
    before[1..].copy_from_slice(&samples::<_, GROUP>(others, 0));
    before
}

/// Those of every second column and the next, and the columns between: whether they are nearer to the next.
#[inline(always)]
fn is_nearer_to_next(grey: &[u8], from: usize) -> [bool; GROUP] {
    let grey: [u8; ALL + 1] = samples(grey, from);
    let mut nearer = [false; GROUP];
    for i in 0..GROUP {
        let (one, own, next) = (grey[2 * i], grey[2 * i + 1], grey[2 * i + 2]);
        nearer[i] = own.abs_diff(next) < own.abs_diff(one);
    }
    nearer
}

/// Puts samples and those between into a row, as far as it goes.
#[inline(always)]
fn put<T: Copy>(one: &[T], between: &[T; GROUP], row: &mut [T]) {
    let mut all = [one[0]; ALL];
    for i in 0..GROUP {
        (all[2 * i], all[2 * i + 1]) = (one[i], between[i]);
    }
    match row.first_chunk_mut() {
        Some(row) => *row = all,
        None => row.copy_from_slice(&all[..row.len()]),
    }
}

at_every_level! {
    fn row_spread(
        same: f32,
        row: Row<'_>,
        values: &mut [f32],
        reasons: &mut [Reason],
        confidence: &mut [f32],
    ) {
        let out = values.chunks_mut(ALL).zip(reasons.chunks_mut(ALL));
        for (group, ((values, reasons), confidence)) in out.zip(confidence.chunks_mut(ALL)).enumerate() {
            let first = group * GROUP;
            let nearer = is_nearer_to_next(row.grey, 2 * first);
            let own: [f32; GROUP + 1] = samples(row.values, first);
            let above: [f32; GROUP + 1] = samples(row.above, first);
            let before = samples_before(row.values, first);
            let mut disparities = own;
            for i in 0..=GROUP {
                let [down, along] = [own[i] - above[i], own[i] - before[i]];
                let [down, along] = [down, along].map(|step| if step.abs() <= same { step } else { 0.0 });
                disparities[i] -= BACK * (down + along);
            }
            let why: [Reason; GROUP + 1] = samples(row.reasons, first);
            let sure: [f32; GROUP + 1] = samples(row.confidence, first);
            let (mut between, mut sure_between) = ([0.0; GROUP], [0.0; GROUP]);
            let mut why_between = [Reason::Matched; GROUP];
            // One loop per width of number, so that each fills its vectors.
            for i in 0..GROUP {
                let (one, next) = (disparities[i], disparities[i + 1]);
                let taken = if nearer[i] { next } else { one };
                between[i] = if (one - next).abs() <= same { (one + next) / 2.0 } else { taken };
            }
            for i in 0..GROUP {
                why_between[i] = if nearer[i] { why[i + 1] } else { why[i] };
            }
            for i in 0..GROUP {
                sure_between[i] = if nearer[i] { sure[i + 1] } else { sure[i] };
            }
            put(&disparities, &between, values);
            put(&why, &why_between, reasons);
            put(&sure, &sure_between, confidence);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    fn spread(
        level: Level,
        grey: &Plane<u8>,
        values: &Plane<f32>,
        reasons: &Plane<Reason>,
    ) -> Vec<(f32, Reason, f32)> {
        let confidence = values.map(|value| value / 100.0);
        let (mut sources, mut all) = (Sources::default(), Plane::default());
        let matched = Matched { values, reasons, confidence: &confidence };
        sources.spread(level, grey.view(), 3.0, matched, &mut all);
        assert_eq!(all.size(), grey.size());
        let pixels = all.samples().iter().zip(sources.reasons.samples());
        let pixels = pixels.zip(sources.confidence.samples());
        pixels.map(|((&value, &reason), &sure)| (value, reason, sure)).collect()
    }

    /// Pixel by pixel.
    fn definition(
        grey: &Plane<u8>,
        values: &Plane<f32>,
        reasons: &Plane<Reason>,
    ) -> Vec<(f32, Reason, f32)> {
        let at = |column: usize, y: usize| {
            let own = values.row(y)[column];
            let step = |before: f32| if (own - before).abs() <= 3.0 { own - before } else { 0.0 };
            let down = step(values.row(y.saturating_sub(1))[column]);
            own - BACK * (down + step(values.row(y)[column.saturating_sub(1)]))
        };
        let pixel = |x: usize, y: usize| {
            let last = values.columns() - 1;
            let (one, next) = (x / 2, x.div_ceil(2).min(last));
            let [a, b] = [one, next].map(|column| at(column, y));
            let unlike = |column: usize| {
                let column = (2 * column).min(grey.columns() - 1);
                grey.row(y)[x].abs_diff(grey.row(y)[column])
            };
            let taken = if unlike(next) < unlike(one) { next } else { one };
            let value = if (a - b).abs() <= 3.0 { (a + b) / 2.0 } else { at(taken, y) };
            (value, reasons.row(y)[taken], values.row(y)[taken] / 100.0)
        };
        let (columns, rows) = grey.size();
        (0..rows)
            .flat_map(|y| (0..columns).map(move |x| (x, y)))
            .map(|(x, y)| pixel(x, y))
            .collect()
    }

    #[test]
    fn on_a_slope_disparities_are_those_of_their_own_place() {
        // A plane, seen half a pixel to the right and below.
        let plane = |x: f32, y: f32| 20.0 + 0.2 * x - 0.3 * y;
        let values =
            Plane::from_fn(40, 9, |x, y| plane(2.0 * x as f32 + 0.5, 2.0 * y as f32 + 0.5));
        let grey = Plane::filled(80, 9, 7);
        let reasons = values.map(|_| Reason::Matched);
        let found = spread(Level::available()[0], &grey, &values, &reasons);
        let off = |value: f32, x: usize, y: usize| value - plane(x as f32, 2.0 * y as f32);
        // So much of the half is left to least squares.
        let left = 1.0 - 4.0 * BACK;
        for (y, row) in found.chunks(80).enumerate().skip(1) {
            for (x, &(value, ..)) in row.iter().enumerate().take(78).skip(2) {
                let expected = left * (0.5 * 0.2 - 0.5 * 0.3);
                assert!((off(value, x, y) - expected).abs() < 1e-4, "{x}, {y}");
            }
        }
    }

    #[test]
    fn columns_between_are_their_definition_at_every_level() {
        for (columns, rows) in [(1, 1), (2, 2), (5, 3), (64, 2), (65, 2), (131, 3), (200usize, 2)] {
            let mut chance = Chance(columns as u32);
            let grey = Plane::from_fn(columns, rows, |_, _| chance.bits(4) as u8);
            let values = Plane::from_fn(columns.div_ceil(2), rows, |_, _| 9.0 * chance.share());
            let reasons = values.map(|&value| match value {
                ..5.0 => Reason::Matched,
                _ => Reason::OccludedFilled,
            });
            let expected = definition(&grey, &values, &reasons);
            for level in Level::available() {
                eprintln!("level {}", level.name());
                let found = spread(level, &grey, &values, &reasons);
                assert_eq!(found, expected, "{columns} x {rows}");
            }
        }
    }
}
