//! What medians spare: matches that are nearer than the median by half a pixel, and that some of their neighbours lie
//! beside.
//!
//! A median takes the corners off all that stands out, and of what is five pixels wide it leaves little. A pixel that
//! stands alone still goes, and so does all that is farther than the median: a small thing that is nearer may be what
//! a vehicle must see, a small thing that is farther hardly is. In `balanced` a match stands for four pixels, which lie
//! beside each other.
//!
//! In: three rows of disparities, beyond their ends repeated (so in a corner a pixel lies beside itself), and the medians
//! of the middle one. Out: medians or, where these are spared, the disparities as they were.

use std::ops::{Add, Sub};

use raster::{Plane, Reason};
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::kernels::median::{copy_with_ends, rows_around};
use crate::profile::Work;

/// Pixels that are done together.
const BLOCK: usize = 128;
/// So many of the eight neighbours at least say the same.
const ALIKE: u8 = 3;
/// Neighbours that differ by at most so many pixels do, and what exceeds the median by no more than half of that is not
/// nearer: of noise the larger half would stay otherwise.
pub(crate) const SAME: f32 = 1.0;

/// Operations on bytes per pixel of 16 bits: nine differences (the larger number less the smaller one), compared and
/// counted, then one number or the other.
pub(crate) const OPERATIONS: usize = (9 * 5 + 4) * 2;

/// Spares disparities of a map without holes, in pixels, of which there are the `medians`.
pub(crate) fn spare_map(
    level: Level,
    values: &Plane<f32>,
    reasons: &Plane<Reason>,
    medians: &mut Plane<f32>,
) -> Work {
    let (columns, rows) = values.size();
    let of_rows = medians.samples_mut().par_chunks_mut(columns).enumerate();
    of_rows.for_each(|(y, medians)| {
        spare_in_pixels(level, rows_around(values, y), reasons.row(y), medians);
    });
    let pixel = Work::bytes(3 * size_of::<f32>() + size_of::<Reason>());
    (pixel + Work::operations(2 * OPERATIONS)) * (columns * rows)
}

at_every_level! {
    /// Spares the disparities of the second of three rows, which are equally long, from column `first` on, in fixed
    /// point; `same` is [`SAME`] of it.
    pub(crate) fn spare_in_steps(
        rows: [&[u16]; 3],
        first: usize,
        same: u16,
        reasons: &[Reason],
        medians: &mut [u16],
    ) {
        spare(rows, first, (same, same / 2), reasons, medians);
    }

    /// The same in pixels, all of a row.
    fn spare_in_pixels(rows: [&[f32]; 3], reasons: &[Reason], medians: &mut [f32]) {
        spare(rows, 0, (SAME, SAME / 2.0), reasons, medians);
    }
}

/// Disparities in fixed point and in pixels. Neighbours are counted in the same kind of number, so that vectors have as
/// many of them.
trait Disparity:
    Copy + Default + PartialOrd + Add<Output = Self> + Sub<Output = Self> + From<bool> + From<u8>
{
}
impl Disparity for u16 {}
impl Disparity for f32 {}

#[inline(always)]
fn spare<T: Disparity>(
    rows: [&[T]; 3],
    first: usize,
    (same, beyond): (T, T),
    reasons: &[Reason],
    medians: &mut [T],
) {
    let mut near = [[T::default(); BLOCK + 2]; 3];
    let mut enough = [T::default(); BLOCK];
    let blocks = medians.chunks_mut(BLOCK).zip(reasons.chunks(BLOCK));
    for (block, (medians, reasons)) in blocks.enumerate() {
        for (row, near) in rows.iter().zip(&mut near) {
            copy_with_ends(row, first + block * BLOCK, 1, near);
        }
        for i in 0..BLOCK {
            let own = near[1][i + 1];
            // It is like itself.
            let mut alike = T::default();
            for row in &near {
                for &other in &row[i..i + 3] {
                    let apart = if other > own { other - own } else { own - other };
                    alike = alike + T::from(apart <= same);
                }
            }
            enough[i] = T::from(alike > T::from(ALIKE));
        }
        for (i, (median, reason)) in medians.iter_mut().zip(reasons).enumerate() {
            let own = near[1][i + 1];
            let nearer = if own > *median { own - *median } else { T::default() };
            let is_spared = (enough[i] > T::default()) & (nearer > beyond);
            *median = if is_spared & (*reason == Reason::Matched) { own } else { *median };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use Reason::{Matched, MismatchedFilled, OccludedFilled, OutsideRightFilled};

    #[test]
    fn a_case_worked_by_hand() {
        #[rustfmt::skip]
        let rows: [[u16; 8]; 3] = [
            [10, 10, 10, 10, 10, 10,  0,  0],
            [10, 30, 34, 10, 10, 90, 10,  0],
            [10, 32, 10, 31, 10, 10, 10,  0],
        ];
        let spared = |reasons: &[Reason]| {
            let mut medians = [10; 8];
            let rows = rows.each_ref().map(|row| row.as_slice());
            spare_in_steps(Level::detect(), rows, 0, 4, reasons, &mut medians);
            medians
        };
        // 30 has 34 and 32 beside it, 34 has 30, 32 and 31; 90 stands alone, 0 has others and is farther.
        assert_eq!(spared(&[Matched; 8]), [10, 10, 34, 10, 10, 10, 10, 10]);
        // What was filled is a guess.
        assert_eq!(spared(&[MismatchedFilled; 8]), [10; 8]);
    }

    /// Some disparities in steps of 1/16 px, many of which are alike, or half a pixel and a little more apart.
    fn step(chance: &mut Chance) -> u16 {
        (chance.share().abs() * 4.0) as u16 * 16 + (chance.share().abs() * 10.0) as u16 + 100
    }

    #[test]
    fn what_is_spared_is_its_definition_at_every_level() {
        let all = [Matched, MismatchedFilled, Matched, OccludedFilled, Matched, OutsideRightFilled];
        for (width, first, columns) in [(1, 0, 1), (40, 0, 40), (140, 3, 130), (400, 7, 393)] {
            let mut chance = Chance(5);
            let rows: [Vec<u16>; 3] =
                std::array::from_fn(|_| (0..width).map(|_| step(&mut chance)).collect());
            let medians: Vec<u16> = (0..columns).map(|_| step(&mut chance)).collect();
            let reasons: Vec<Reason> = (0..columns).map(|x| all[x * 7 % 6]).collect();
            let alike = |x: usize| {
                let near = |i: usize| (x + i).saturating_sub(1).min(width - 1);
                let all = rows.iter().flat_map(|row| (0..3).map(move |i| row[near(i)]));
                all.filter(|other| other.abs_diff(rows[1][x]) <= 16).count() - 1
            };
            let expected: Vec<u16> = (0..columns)
                .map(|i| match rows[1][first + i] {
                    own if reasons[i] == Matched
                        && alike(first + i) >= 3
                        && own > medians[i] + 8 =>
                    {
                        own
                    }
                    _ => medians[i],
                })
                .collect();
            assert!(columns == 1 || expected != medians, "nothing is spared");
            for level in Level::available() {
                eprintln!("level {}", level.name());
                let (near, mut found) = (rows.each_ref().map(Vec::as_slice), medians.clone());
                spare_in_steps(level, near, first, 16, &reasons, &mut found);
                assert_eq!(found, expected, "{columns} columns");
            }
        }
    }

    #[test]
    fn pixels_are_spared_as_steps_are_at_every_level() {
        let (columns, rows) = (150, 5);
        let mut chance = Chance(9);
        let mut map = || Plane::from_fn(columns, rows, |_, _| step(&mut chance));
        let (values, medians) = (map(), map());
        let reasons = Plane::from_fn(columns, rows, |x, y| [Matched, OccludedFilled][(x + y) % 2]);
        let in_pixels = |steps: &Plane<u16>| steps.map(|&steps| f32::from(steps) / 16.0);
        let mut expected = medians.clone();
        for y in 0..rows {
            let near = [y.saturating_sub(1), y, (y + 1).min(rows - 1)].map(|y| values.row(y));
            let (reasons, expected) = (reasons.row(y), expected.row_mut(y));
            spare_in_steps(Level::detect(), near, 0, 16, reasons, expected);
        }
        assert!(expected.samples() != medians.samples(), "nothing is spared");
        for level in Level::available() {
            let mut found = in_pixels(&medians);
            spare_map(level, &in_pixels(&values), &reasons, &mut found);
            assert!(found.samples() == in_pixels(&expected).samples(), "level {}", level.name());
        }
    }
}
