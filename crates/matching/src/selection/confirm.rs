//! Winners of one row become disparities: confirmed by the right view, with a fraction of a pixel
//! and a confidence.
//!
//! In: what [`crate::kernels::sad`] found. Out: disparities in fixed point, [`HOLE`] where the
//! right view does not confirm, and a confidence.
//!
//! * **Confirmed** is a winner `(x, k)` when the right pixel it points at has its own least sum at
//!   `k - 1`, `k` or `k + 1` (Fua 1993): when one of these three sums equals that least sum. The
//!   sums stand along a diagonal of the left view's costs, so the second view costs no second
//!   matching, and sums are compared rather than indices, so that ties count as agreement.
//! * **The fraction** is that of a V through the sums `a, c, b` before, at and after the winner,
//!   the shape that absolute differences have around their minimum: `(a - b) / (2 (max(a, b) - c))`
//!   (Shimizu & Okutomi 2001); 0 at the ends of the range.
//! * **The confidence** is `(max(a, b) - c) / max(a, b)`: 1 for a sum of zero among others, near 0
//!   for a flat valley, as blank walls have.

use crate::cost::SearchSpace;
use crate::kernels::level::at_every_level;
use crate::kernels::rounding::nearest;
use crate::kernels::sad::{Layout, OUT, Winners};
use crate::selection::fixed_point::{FixedPoint, HOLE};
use crate::selection::winner::tip_of_v;

at_every_level! {
    /// Fills one row of `disparities` and `confidence`. `opposite` is scratch of the same length.
    pub(crate) fn confirm_row(
        winners: &Winners,
        space: &SearchSpace,
        numbers: FixedPoint,
        opposite: &mut [u16],
        disparities: &mut [u16],
        confidence: &mut [f32],
    ) {
        let n = space.columns();
        let (index, least) = (&winners.index[..n], &winners.least[..n]);
        let (before, after) = (&winners.before[..n], &winners.after[..n]);
        let confirming = &winners.confirming[..n];
        let (opposite, disparities) = (&mut opposite[..n], &mut disparities[..n]);
        let confidence = &mut confidence[..n];
        let shift = Layout::new(space).shift(0);
        // The least sums of the right pixels that the winners point at.
        for x in 0..n {
            opposite[x] = winners.right[x + shift - usize::from(index[x])];
        }
        let scale = f32::from(numbers.scale());
        for x in 0..n {
            let found = (least[x] < OUT) & (confirming[x] == opposite[x]);
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
    use crate::kernels::level::Level;
    use raster::{BoundingBox, DisparityRange};

    /// Winners of four columns, five disparities from -1 upwards, with the fields' order:
    /// index, least, before, after, confirming, least of the right pixel.
    fn winners(columns: &[[u16; 6]]) -> Winners {
        let n = columns.len();
        let field = |i: usize| columns.iter().map(|c| c[i]).collect::<Vec<_>>();
        let mut right = vec![OUT; n + 8];
        for (x, c) in columns.iter().enumerate() {
            right[x + 7 - usize::from(c[0])] = c[5];
        }
        Winners {
            index: field(0),
            least: field(1),
            before: field(2),
            after: field(3),
            confirming: field(4),
            right,
        }
    }

    #[test]
    fn cases_worked_by_hand_at_every_level() {
        let cases = [
            // A V with its tip at 2.25: sums 8, 4, 6 around index 2.
            ([2, 4, 8, 6, 4, 4], (2.25 - 1.0, 0.5)),
            // The right pixel has a better match two disparities away.
            ([2, 4, 8, 6, 4, 3], (f32::NAN, 0.0)),
            // Its better match is a neighbour's: within the tolerance.
            ([2, 4, 6, 8, 3, 3], (1.75 - 1.0, 0.5)),
            // The end of the range: no fraction, nothing to be sure of.
            ([0, 4, OUT, 6, 4, 4], (-1.0, 0.0)),
            // Nothing was tried.
            ([0, OUT, OUT, OUT, OUT, OUT], (f32::NAN, 0.0)),
            // A flat valley.
            ([3, 5, 5, 5, 5, 5], (2.0, 0.0)),
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
                    confirm_row(
                        level,
                        &winners,
                        &space,
                        numbers,
                        &mut vec![0; n],
                        &mut found,
                        &mut confidence,
                    );
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
