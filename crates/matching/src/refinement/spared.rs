//! What the median of 5 x 5 pixels spares: matches that are nearer than it would have them, and that some of their
//! neighbours lie beside.
//!
//! A median takes the corners off all that stands out, and of what is five pixels wide it leaves little. Of stones that
//! `best` missed it was a third. What stands alone still goes, and so does all that is farther than the median: a
//! small thing that is nearer may be what a vehicle must see, a small thing that is farther hardly is.
//!
//! In: three rows of disparities in fixed point, beyond their ends repeated, and the medians of the middle one. Out: medians
//! or, where these are spared, the disparities as they were.

use raster::Reason;

use crate::kernels::level::at_every_level;
use crate::kernels::median::copy_with_ends;

/// Pixels that are done together.
const BLOCK: usize = 128;
/// So many of the eight neighbours at least say the same.
const ALIKE: u16 = 3;
/// Neighbours that differ by at most so many pixels do.
pub(crate) const SAME: f32 = 1.0;

/// Operations on bytes per pixel of 16 bits: nine differences (two subtractions, of which one leaves nothing), compared and
/// counted, then the larger number where there are enough.
pub(crate) const OPERATIONS: usize = (9 * 5 + 3) * 2;

at_every_level! {
    /// Spares the disparities of the second of three rows, which are equally long, from column `first` on. `same` is
    /// [`SAME`] in fixed point.
    pub(crate) fn spare_row(
        rows: [&[u16]; 3],
        first: usize,
        same: u16,
        reasons: &[Reason],
        medians: &mut [u16],
    ) {
        let mut near = [[0; BLOCK + 2]; 3];
        let blocks = medians.chunks_mut(BLOCK).zip(reasons.chunks(BLOCK));
        for (block, (medians, reasons)) in blocks.enumerate() {
            for (row, near) in rows.iter().zip(&mut near) {
                copy_with_ends(row, first + block * BLOCK, 1, near);
            }
            let mut spared = [0; BLOCK];
            for i in 0..BLOCK {
                let own = near[1][i + 1];
                // It is like itself.
                let mut alike = 0;
                for row in &near {
                    for other in &row[i..i + 3] {
                        alike += u16::from(other.abs_diff(own) <= same);
                    }
                }
                spared[i] = if alike > ALIKE { own } else { 0 };
            }
            for ((median, reason), &spared) in medians.iter_mut().zip(reasons).zip(&spared) {
                let spared = if *reason == Reason::Matched { spared } else { 0 };
                *median = (*median).max(spared);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::kernels::level::Level;
    use Reason::{Matched, MismatchedFilled, OccludedFilled, OutsideRightFilled};

    #[test]
    fn a_case_worked_by_hand() {
        #[rustfmt::skip]
        let rows = [
            [10, 10, 10, 10, 10, 10, 10, 10],
            [10, 30, 34, 10, 10, 90, 10,  0],
            [10, 32, 10, 31, 10, 10, 10, 10],
        ];
        let spared = |reasons: &[Reason]| {
            let mut medians = [10; 8];
            let rows = rows.each_ref().map(|row| row.as_slice());
            spare_row(Level::detect(), rows, 0, 4, reasons, &mut medians);
            medians
        };
        // 30 has 34 and 32 beside it, 34 has 30, 32 and 31; 90 stands alone, 0 is farther.
        assert_eq!(spared(&[Matched; 8]), [10, 10, 34, 10, 10, 10, 10, 10]);
        // What was filled is a guess.
        assert_eq!(spared(&[MismatchedFilled; 8]), [10; 8]);
    }

    #[test]
    fn what_is_spared_is_its_definition_at_every_level() {
        let reasons =
            [Matched, MismatchedFilled, Matched, OccludedFilled, Matched, OutsideRightFilled];
        for (width, first, columns) in [(1, 0, 1), (40, 0, 40), (140, 3, 130), (400, 7, 393)] {
            let mut chance = Chance(5);
            let mut number = || ((chance.share().abs() * 4.0) as u16) * 16 + 100;
            let rows: [Vec<u16>; 3] =
                std::array::from_fn(|_| (0..width).map(|_| number()).collect());
            let medians: Vec<u16> = (0..columns).map(|_| number()).collect();
            let reasons: Vec<Reason> = (0..columns).map(|x| reasons[x * 7 % 6]).collect();
            let alike = |x: usize| {
                let near = |i: usize| (x + i).saturating_sub(1).min(width - 1);
                let all = rows.iter().flat_map(|row| (0..3).map(move |i| row[near(i)]));
                all.filter(|other| other.abs_diff(rows[1][x]) <= 16).count() - 1
            };
            let expected: Vec<u16> = (0..columns)
                .map(|i| match rows[1][first + i] {
                    own if reasons[i] == Matched && alike(first + i) >= 3 => own.max(medians[i]),
                    _ => medians[i],
                })
                .collect();
            assert!(columns == 1 || expected != medians, "nothing is spared");
            for level in Level::available() {
                eprintln!("level {}", level.name());
                let mut found = medians.clone();
                spare_row(
                    level,
                    rows.each_ref().map(Vec::as_slice),
                    first,
                    16,
                    &reasons,
                    &mut found,
                );
                assert_eq!(found, expected, "{columns} columns");
            }
        }
    }
}
