//! The check of the left view against the right one, and what a failure means.
//!
//! A match is confirmed when the right pixel it points at points back, within `tolerance`:
//! `|k(x) - k'(x - d)| <= tolerance`. A pixel that fails is *mismatched* when some right pixel does
//! point at it (it is seen by both cameras, only its match was wrong) and *occluded* when none does
//! (Hirschmueller, *Stereo Processing by Semiglobal Matching and Mutual Information*, 2008,
//! section 2.6).

use raster::Reason;

use crate::cost::SearchSpace;
use crate::selection::winner::NONE;

/// Says for every column of the left row whether its winner is confirmed: [`Reason::Matched`], or
/// one of [`Reason::OccludedHole`] and [`Reason::MismatchedHole`]. `pointed_at` is scratch of the
/// same length.
pub(crate) fn cross_check(
    space: &SearchSpace,
    left: &[u16],
    right: &[u16],
    tolerance: u16,
    pointed_at: &mut [bool],
    reasons: &mut [Reason],
) {
    pointed_at.fill(false);
    for (x, &k) in right.iter().enumerate() {
        if k != NONE {
            let target = x as i64 + i64::from(space.min) + i64::from(k);
            pointed_at[(target - space.first as i64) as usize] = true;
        }
    }
    let reach = usize::from(tolerance);
    let last = left.len() - 1;
    for (x, (&k, reason)) in left.iter().zip(reasons).enumerate() {
        let confirmed = k != NONE && {
            let back = right[space.right_column(space.first + x, usize::from(k))];
            back.abs_diff(k) <= tolerance
        };
        *reason = if confirmed {
            Reason::Matched
        } else if pointed_at[x.saturating_sub(reach)..=(x + reach).min(last)].contains(&true) {
            Reason::MismatchedHole
        } else {
            Reason::OccludedHole
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::{BoundingBox, DisparityRange};

    #[test]
    fn confirmed_mismatched_and_occluded_are_told_apart() {
        let range = DisparityRange::new(0, 7).unwrap();
        let space = SearchSpace::new(8, BoundingBox::whole(8, 1), range);
        // Right 0 points at left 3, right 1 at left 1, right 4 at left 7.
        let right = [3, 0, NONE, NONE, 3, NONE, NONE, NONE];
        let left = [0, 0, NONE, 3, 2, 1, 0, 4];
        let mut reasons = [Reason::OutsideBox; 8];
        cross_check(&space, &left, &right, 0, &mut [false; 8], &mut reasons);
        use Reason::{Matched as M, MismatchedHole as X, OccludedHole as O};
        assert_eq!(reasons, [O, M, O, M, O, O, O, X]);
        // A tolerance of one pixel forgives left 7 its disparity 3 + 1 only where right 3 agrees.
        cross_check(&space, &left, &right, 1, &mut [false; 8], &mut reasons);
        assert_eq!(reasons, [X, M, X, M, X, O, X, X]);
    }
}
