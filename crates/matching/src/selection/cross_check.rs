//! The check of one view against the other, and what a failure means.
//!
//! A match is confirmed when the pixel it points at in the other view points back, within
//! [`TOLERANCE`] pixels. A pixel that fails is *mismatched* when some pixel of the other view does
//! point at it (it is seen by both cameras, only its match was wrong) and *occluded* when none does
//! (Hirschmueller, *Stereo Processing by Semiglobal Matching and Mutual Information*, PAMI 2008).
//!
//! The right view is handled as it looks in a mirror: there its disparities also point to smaller
//! columns, so whatever is written for the left view serves both.

use raster::{Plane, Reason};
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::kernels::rounding::as_number;
use crate::profile::Work;

/// How far the two views may disagree, in pixels.
const TOLERANCE: f32 = 1.0;

/// A disparity map of some columns of a view; NaN where there is no disparity.
#[derive(Debug, Clone, Default)]
pub(crate) struct ViewMap {
    /// The column of the image at which the map begins, in the mirror for the right view.
    pub first: usize,
    /// Columns of the image from one to the next: 1, or 2 where a column stands for itself and the next.
    pub apart: usize,
    pub values: Plane<f32>,
    pub reasons: Plane<Reason>,
}

/// Confirms the matches of `view` by those of `other`, which has all columns: writes `view.reasons`, and NaN where
/// it does not. `width` is that of both images. Both views are read, and reasons written; each pixel of either
/// takes at least three subtractions and a comparison of 32 bits.
pub(crate) fn cross_check(
    level: Level,
    width: usize,
    view: &mut ViewMap,
    other: &Plane<f32>,
    other_first: usize,
) -> Work {
    let (columns, rows) = view.values.size();
    view.reasons.reshape(columns, rows, Reason::OccludedHole);
    let place = (view.first, view.apart);
    let rows = view.values.samples_mut().par_chunks_mut(columns);
    let rows = rows.zip(view.reasons.samples_mut().par_chunks_mut(columns)).enumerate();
    rows.for_each(|(y, (values, reasons))| {
        reasons.fill(Reason::OccludedHole);
        check_row(level, width, (values, place), (other.row(y), other_first), reasons);
    });
    let ViewMap { values, reasons, .. } = view;
    let (values, other) = (values.samples(), other.samples());
    let bytes = size_of_val(values) + size_of_val(other) + size_of_val(reasons.samples());
    Work::bytes(bytes) + Work::operations(4 * 4) * (values.len() + other.len())
}

/// So many pixels are looked up one by one, what they point at is reckoned together.
const BLOCK: usize = 64;
/// Stands for a pixel that points at nothing.
const NOWHERE: u32 = u32::MAX;

at_every_level! {
    /// Checks a row, of which `reasons` say that all of it is occluded. Rows come with the column at
    /// which they begin, that of the view with how far its columns are apart.
    fn check_row(
        width: usize,
        view: (&mut [f32], (usize, usize)),
        other: (&[f32], usize),
        reasons: &mut [Reason],
    ) {
        let ((values, (first, apart)), (other, other_first)) = (view, other);
        let columns = values.len();
        let mut block = [f32::NAN; BLOCK];
        for (i, other) in other.chunks(BLOCK).enumerate() {
            block[..other.len()].copy_from_slice(other);
            let inside = (0.0f32.next_down(), ((apart * columns - 1) as f32).next_up());
            let targets = targets(width, &block, (other_first + i * BLOCK, 1), first, inside);
            for &target in &targets[..other.len()] {
                if target != NOWHERE {
                    reasons[target as usize / apart] = Reason::MismatchedHole;
                }
            }
        }
        // What is pointed at, from the pixel before a block to the one after it.
        let mut pointed = [Reason::OccludedHole; BLOCK + 2];
        for (i, values) in values.chunks_mut(BLOCK).enumerate() {
            let start = i * BLOCK;
            block[..values.len()].copy_from_slice(values);
            let place = (first + apart * start, apart);
            let off = disagreements_of_block(width, &block, place, other, other_first);
            let mut confirmed = [f32::NAN; BLOCK];
            for x in 0..BLOCK {
                confirmed[x] = if off[x] <= TOLERANCE { block[x] } else { f32::NAN };
            }
            values.copy_from_slice(&confirmed[..values.len()]);

            pointed[0] = pointed[BLOCK];
            let end = columns.min(start + BLOCK + 1);
            pointed[1..].fill(Reason::OccludedHole);
            pointed[1..][..end - start].copy_from_slice(&reasons[start..end]);
            let mut told = [Reason::OccludedHole; BLOCK];
            for x in 0..BLOCK {
                // Beside what is pointed at too.
                let is_seen = (pointed[x] == Reason::MismatchedHole)
                    | (pointed[x + 1] == Reason::MismatchedHole)
                    | (pointed[x + 2] == Reason::MismatchedHole);
                told[x] = if is_seen { Reason::MismatchedHole } else { Reason::OccludedHole };
            }
            for x in 0..BLOCK {
                told[x] = if off[x] <= TOLERANCE { Reason::Matched } else { told[x] };
            }
            reasons[start..start + values.len()].copy_from_slice(&told[..values.len()]);
        }
    }

    /// By how much the two views differ in a row.
    fn disagreements_of_row(
        width: usize,
        view: (&[f32], (usize, usize)),
        other: (&[f32], usize),
        out: &mut [f32],
    ) {
        let ((values, (first, apart)), (other, other_first)) = (view, other);
        let mut block = [f32::NAN; BLOCK];
        let rows = values.chunks(BLOCK).zip(out.chunks_mut(BLOCK));
        for (i, (values, out)) in rows.enumerate() {
            block[..values.len()].copy_from_slice(values);
            let place = (first + apart * i * BLOCK, apart);
            let off = disagreements_of_block(width, &block, place, other, other_first);
            out.copy_from_slice(&off[..out.len()]);
        }
    }
}

/// By how much disparities differ from what the other view says where they point; NaN where either has
/// none.
#[inline(always)]
fn disagreements_of_block(
    width: usize,
    disparities: &[f32; BLOCK],
    place: (usize, usize),
    other: &[f32],
    other_first: usize,
) -> [f32; BLOCK] {
    let inside = (-0.5, other.len() as f32 - 0.5);
    let targets = targets(width, disparities, place, other_first, inside);
    let mut off = [f32::NAN; BLOCK];
    for (off, &target) in off.iter_mut().zip(&targets) {
        *off = other.get(target as usize).copied().unwrap_or(f32::NAN);
    }
    for i in 0..BLOCK {
        off[i] = (off[i] - disparities[i]).abs();
    }
    off
}

/// The columns of the other view, counted from `other_first`, that the disparities of columns point at, if these
/// lie between two bounds. The columns begin at one and lie some apart.
#[inline(always)]
fn targets(
    width: usize,
    disparities: &[f32; BLOCK],
    (first, apart): (usize, usize),
    other_first: usize,
    (above, below): (f32, f32),
) -> [u32; BLOCK] {
    let (mirrored, other_first) = (as_number(width - 1), as_number(other_first));
    let mut targets = [NOWHERE; BLOCK];
    for i in 0..BLOCK {
        let target = mirrored - (as_number(first + apart * i) - disparities[i]) - other_first;
        let inside = (target > above) & (target < below);
        // To the nearest: nothing here is below -0.5.
        targets[i] = if inside { (target + 0.5) as i32 as u32 } else { NOWHERE };
    }
    targets
}

/// By how much the two views differ in every pixel of `view`; NaN where either has no disparity.
pub(crate) fn disagreements(
    level: Level,
    width: usize,
    view: &ViewMap,
    other: &Plane<f32>,
    other_first: usize,
    out: &mut [f32],
) {
    let &ViewMap { first, apart, ref values, .. } = view;
    let rows = out.par_chunks_mut(values.columns()).enumerate();
    rows.for_each(|(y, out)| {
        let (row, other) = ((values.row(y), (first, apart)), (other.row(y), other_first));
        disagreements_of_row(level, width, row, other, out);
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    #[test]
    fn confirmed_mismatched_and_occluded_are_told_apart() {
        const NONE: f32 = f32::NAN;
        // Right 0 points at left 3, right 1 at left 1, right 6 at left 7.
        let right = [3.0, 0.0, NONE, NONE, NONE, NONE, 1.0, NONE];
        let mirror: Vec<f32> = right.into_iter().rev().collect();
        let mirror = Plane::new(8, 1, mirror).unwrap();
        let values = Plane::new(8, 1, vec![0.0, 0.4, NONE, 3.0, 2.0, 5.0, 1.0, 4.0]).unwrap();
        let reasons = Plane::filled(8, 1, Reason::OutsideBox);
        let mut view = ViewMap { first: 0, apart: 1, values, reasons };
        cross_check(Level::detect(), 8, &mut view, &mirror, 0);
        use Reason::{Matched as M, MismatchedHole as X, OccludedHole as O};
        // Left 2 and 4 stand beside what is pointed at; left 5 lands on right 0, which says 3.
        assert_eq!(view.reasons.row(0), [X, M, X, M, X, O, X, X]);
        assert_eq!(view.values.row(0)[1], 0.4);
        assert!(view.values.row(0)[7].is_nan());
    }

    /// By how much `value`, in this column of one view, differs from what the other says where it points.
    fn disagreement(
        mirrored: f32,
        column: f32,
        value: f32,
        other: &[f32],
        other_first: usize,
    ) -> f32 {
        let target = mirrored - (column - value) - other_first as f32;
        if target > -0.5 && target < other.len() as f32 - 0.5 {
            (other[(target + 0.5) as usize] - value).abs()
        } else {
            f32::NAN
        }
    }

    /// The check as it is described, pixel by pixel.
    fn definition(
        width: usize,
        view: &ViewMap,
        other: &[f32],
        other_first: usize,
    ) -> Vec<(Reason, u32)> {
        let values = view.values.row(0);
        let mirrored = (width - 1) as f32;
        let mut seen = vec![false; values.len()];
        for (u, d) in other.iter().enumerate() {
            let target = mirrored - ((u + other_first) as f32 - d) - view.first as f32;
            if (0.0..=(view.apart * values.len() - 1) as f32).contains(&target) {
                let target = (target + 0.5) as usize / view.apart;
                seen[target.saturating_sub(1)..(target + 2).min(values.len())].fill(true);
            }
        }
        let check = |(x, &value): (usize, &f32)| {
            let column = (view.first + view.apart * x) as f32;
            let off = disagreement(mirrored, column, value, other, other_first);
            match (off <= TOLERANCE, seen[x]) {
                (true, _) => (Reason::Matched, value.to_bits()),
                (false, true) => (Reason::MismatchedHole, f32::NAN.to_bits()),
                (false, false) => (Reason::OccludedHole, f32::NAN.to_bits()),
            }
        };
        values.iter().enumerate().map(check).collect()
    }

    #[test]
    fn rows_are_the_definitions_at_every_level() {
        let mut chance = Chance(5);
        let mut random = |n: u32| chance.below(n);
        for (width, first, columns, apart) in
            [(200, 0, 200, 1), (150, 20, 100, 1), (9, 3, 2, 1), (300, 5, 140, 2), (9, 0, 5, 2)]
        {
            // Halves, so that some point at the very middle between two.
            let mut row = |columns: usize| -> Vec<f32> {
                let value = |n: u32| if n < 6 { f32::NAN } else { n as f32 / 2.0 - 4.0 };
                (0..columns).map(|_| value(random(30))).collect()
            };
            let (values, other) = (row(columns), row(width));
            let values = Plane::new(columns, 1, values).unwrap();
            let reasons = values.map(|_| Reason::OutsideBox);
            let view = ViewMap { first, apart, values, reasons };
            let expected = definition(width, &view, &other, 0);
            let other = Plane::new(width, 1, other).unwrap();
            for level in Level::available() {
                eprintln!("level {}", level.name());
                let mut off = vec![9.0; columns];
                disagreements(level, width, &view, &other, 0, &mut off);
                for (x, (&off, &value)) in off.iter().zip(view.values.row(0)).enumerate() {
                    let column = (first + apart * x) as f32;
                    let by = disagreement((width - 1) as f32, column, value, other.row(0), 0);
                    assert!(
                        off == by || off.is_nan() && by.is_nan(),
                        "column {column}: {off}, {by}"
                    );
                }
                let mut view = view.clone();
                cross_check(level, width, &mut view, &other, 0);
                let values = view.values.samples().iter().map(|value| value.to_bits());
                let found: Vec<_> = view.reasons.samples().iter().copied().zip(values).collect();
                assert!(found == expected, "{width} columns, from {first} on {columns}");
            }
        }
    }
}
