//! Winners of one row become disparities: confirmed by the right view, with a fraction of a pixel
//! and a confidence.
//!
//! In: what [`crate::kernels::sad`] found. Out: disparities in fixed point, [`HOLE`] where the
//! right view does not confirm, and a confidence.
//!
//! * **Confirmed** is a winner `(x, k)` when the right pixel it points at has its own least sum at
//!   `k - 1`, `k` or `k + 1` (Fua 1993); of several least ones the first counts, as in the left view. The
//!   right view's sums stand along diagonals of the left one's, so it costs no second matching.
//! * **The fraction** is that of a V through the sums `a, c, b` before, at and after the winner,
//!   the shape that absolute differences have around their minimum: `(a - b) / (2 (max(a, b) - c))`
//!   (Shimizu & Okutomi 2001); 0 at the ends of the range.
//! * **The confidence** is `(max(a, b) - c) / max(a, b)`: 1 for a sum of zero among others, near 0
//!   for a flat valley, as blank walls have.

use crate::kernels::level::at_every_level;
use crate::kernels::rounding::nearest;
use crate::kernels::sad::{OUT, Winners};
use crate::selection::fixed_point::{FixedPoint, HOLE};
use crate::selection::winner::tip_of_v;

at_every_level! {
    /// Fills one row of `disparities` and `confidence`.
    pub(crate) fn confirm_row(
        winners: &Winners,
        numbers: FixedPoint,
        disparities: &mut [u16],
        confidence: &mut [f32],
    ) {
        let n = disparities.len();
        let (index, least) = (&winners.index[..n], &winners.least[..n]);
        let (before, after) = (&winners.before[..n], &winners.after[..n]);
        let opposite = &winners.opposite[..n];
        let confidence = &mut confidence[..n];
        let scale = f32::from(numbers.scale());
        for x in 0..n {
            let found = (least[x] < OUT) & (index[x].abs_diff(opposite[x]) <= 1);
            let valley = valley(before[x], least[x], after[x]);
            let steps = (f32::from(index[x]) + valley.fraction) * scale;
            let steps = nearest(steps) as u16;
            disparities[x] = if found { steps } else { HOLE };
            confidence[x] = if found { valley.confidence } else { 0.0 };
        }
    }
}

/// The shape of the costs around a winner.
struct Valley {
    fraction: f32,
    confidence: f32,
}

#[inline(always)]
fn valley(before: u16, least: u16, after: u16) -> Valley {
    let (before, least, after) = (f32::from(before), f32::from(least), f32::from(after));
    let higher = before.max(after);
    let rise = higher - least;
    // No sum beside the winner at one end of the range: nothing is known there.
    let known = (higher < f32::from(OUT)) & (rise > 0.0);
    let fraction = if known { tip_of_v(before, least, after) } else { 0.0 };
    let confidence = if known { rise / higher } else { 0.0 };
    Valley { fraction, confidence }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::SearchSpace;
    use crate::kernels::level::Level;
    use raster::{BoundingBox, DisparityRange};

    /// Winners of columns, five disparities from -1 upwards, with the fields' order:
    /// index, least, before, after, index of the right pixel's winner.
    fn winners(columns: &[[u16; 5]]) -> Winners {
        let field = |i: usize| columns.iter().map(|c| c[i]).collect();
        Winners {
            index: field(0),
            least: field(1),
            before: field(2),
            after: field(3),
            opposite: field(4),
        }
    }

    #[test]
    fn cases_worked_by_hand_at_every_level() {
        let cases = [
            // A V with its tip at 2.25: sums 8, 4, 6 around index 2.
            ([2, 4, 8, 6, 2], (2.25 - 1.0, 0.5)),
            // The right pixel has a better match two disparities away.
            ([2, 4, 8, 6, 4], (f32::NAN, 0.0)),
            ([2, 4, 8, 6, 0], (f32::NAN, 0.0)),
            // Its better match is a neighbour's: within the tolerance.
            ([2, 4, 6, 8, 3], (1.75 - 1.0, 0.5)),
            ([2, 4, 6, 8, 1], (1.75 - 1.0, 0.5)),
            // The end of the range: no fraction, nothing to be sure of.
            ([0, 4, OUT, 6, 0], (-1.0, 0.0)),
            // Nothing was tried.
            ([0, OUT, OUT, OUT, 0], (f32::NAN, 0.0)),
            // A flat valley.
            ([3, 5, 5, 5, 3], (2.0, 0.0)),
        ];
        let range = DisparityRange::new(-1, 3).unwrap();
        for level in Level::available() {
            eprintln!("level {}", level.name());
            for (case, (disparity, sure)) in cases {
                // One column, and forty alike: the vector's body and its rest.
                for n in [1, 40] {
                    let space =
                        SearchSpace::new(200, BoundingBox::new(50, 0, 49 + n, 0).unwrap(), range);
                    let numbers = FixedPoint::new(&space);
                    let winners = winners(&vec![case; n]);
                    let (mut found, mut confidence) = (vec![7; n], vec![7.0; n]);
                    confirm_row(level, &winners, numbers, &mut found, &mut confidence);
                    for (&found, &confidence) in found.iter().zip(&confidence) {
                        let found = numbers.pixels(found);
                        assert!(found == disparity || found.is_nan() && disparity.is_nan());
                        assert_eq!(confidence, sure, "{case:?}");
                    }
                }
            }
        }
    }
}
