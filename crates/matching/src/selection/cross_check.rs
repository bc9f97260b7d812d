//! The check of one view against the other, and what a failure means.
//!
//! A match is confirmed when the pixel it points at in the other view points back, within
//! [`TOLERANCE`] pixels. A pixel that fails is *mismatched* when some pixel of the other view does
//! point at it (it is seen by both cameras, only its match was wrong) and *occluded* when none does
//! (Hirschmueller, *Stereo Processing by Semiglobal Matching and Mutual Information*, 2008,
//! section 2.6).
//!
//! The right view is handled as it looks in a mirror: there its disparities also point to smaller
//! columns, so whatever is written for the left view serves both.

use raster::{Plane, Reason};
use rayon::prelude::*;

use crate::profile::Work;

/// How far the two views may disagree, in pixels.
const TOLERANCE: f32 = 1.0;

/// A disparity map of some columns of a view; NaN where there is no disparity.
#[derive(Debug, Clone, Default)]
pub(crate) struct ViewMap {
    /// The column of the image at which the map begins, in the mirror for the right view.
    pub first: usize,
    pub values: Plane<f32>,
    pub reasons: Plane<Reason>,
}

/// Confirms the matches of `view` by those of `other`: writes `view.reasons`, and NaN where it does
/// not. `width` is that of both images. Both views are read, and reasons written; each pixel of either
/// takes at least three subtractions and a comparison of 32 bits.
pub(crate) fn cross_check(
    width: usize,
    view: &mut ViewMap,
    other: &Plane<f32>,
    other_first: usize,
) -> Work {
    let (columns, rows) = view.values.size();
    view.reasons.reset(columns, rows, Reason::OccludedHole);
    let first = view.first as f32;
    // A column of one view, seen from the other, which stands in the mirror.
    let mirrored = (width - 1) as f32;
    let rows = view.values.samples_mut().par_chunks_mut(columns);
    rows.zip(view.reasons.samples_mut().par_chunks_mut(columns)).enumerate().for_each(
        |(y, (values, reasons))| {
            let other = other.row(y);
            for (u, &d) in other.iter().enumerate() {
                // The column that this one points at, and one to each side.
                let target = mirrored - ((u + other_first) as f32 - d) - first;
                if target >= 0.0 && target <= (columns - 1) as f32 {
                    let target = (target + 0.5) as i32 as usize;
                    for near in [target.saturating_sub(1), target, (target + 1).min(columns - 1)] {
                        reasons[near] = Reason::MismatchedHole;
                    }
                }
            }
            for (x, (value, reason)) in values.iter_mut().zip(reasons).enumerate() {
                let column = first + x as f32;
                if disagreement(mirrored, column, *value, other, other_first) <= TOLERANCE {
                    *reason = Reason::Matched;
                } else {
                    *value = f32::NAN;
                }
            }
        },
    );
    let ViewMap { values, reasons, .. } = view;
    let (values, other) = (values.samples(), other.samples());
    let bytes = size_of_val(values) + size_of_val(other) + size_of_val(reasons.samples());
    Work::bytes(bytes) + Work::operations(4 * 4) * (values.len() + other.len())
}

/// By how much the two views differ in every pixel of `view`; NaN where either has no disparity. `out`
/// has rows of the image, from the first row of `view` on.
pub(crate) fn disagreements(
    width: usize,
    view: &ViewMap,
    other: &Plane<f32>,
    other_first: usize,
    out: &mut [f32],
) {
    let mirrored = (width - 1) as f32;
    let rows = out.par_chunks_mut(width).take(view.values.rows());
    rows.enumerate().for_each(|(y, out)| {
        let columns = (view.first..).map(|column| column as f32);
        for ((column, &value), out) in columns.zip(view.values.row(y)).zip(&mut out[view.first..]) {
            *out = disagreement(mirrored, column, value, other.row(y), other_first);
        }
    });
}

/// By how much `value`, in this column of one view, differs from what the other says where it points.
fn disagreement(mirrored: f32, column: f32, value: f32, other: &[f32], other_first: usize) -> f32 {
    let target = mirrored - (column - value) - other_first as f32;
    if target > -0.5 && target < other.len() as f32 - 0.5 {
        // To the nearest: nothing here is below -0.5.
        (other[(target + 0.5) as i32 as usize] - value).abs()
    } else {
        f32::NAN
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn confirmed_mismatched_and_occluded_are_told_apart() {
        const NONE: f32 = f32::NAN;
        // Right 0 points at left 3, right 1 at left 1, right 6 at left 7.
        let right = [3.0, 0.0, NONE, NONE, NONE, NONE, 1.0, NONE];
        let mirror: Vec<f32> = right.into_iter().rev().collect();
        let mirror = Plane::new(8, 1, mirror).unwrap();
        let values = Plane::new(8, 1, vec![0.0, 0.4, NONE, 3.0, 2.0, 5.0, 1.0, 4.0]).unwrap();
        let reasons = Plane::filled(8, 1, Reason::OutsideBox);
        let mut view = ViewMap { first: 0, values, reasons };
        cross_check(8, &mut view, &mirror, 0);
        use Reason::{Matched as M, MismatchedHole as X, OccludedHole as O};
        // Left 2 and 4 stand beside what is pointed at; left 5 lands on right 0, which says 3.
        assert_eq!(view.reasons.row(0), [X, M, X, M, X, O, X, X]);
        assert_eq!(view.values.row(0)[1], 0.4);
        assert!(view.values.row(0)[7].is_nan());
    }
}
