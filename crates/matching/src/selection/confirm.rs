//! Winners of one row become disparities: confirmed by the right view, with a fraction of a pixel
//! and a confidence.
//!
//! In: what [`crate::kernels::sad`] found. Out: disparities in fixed point, [`HOLE`] where the
//! right view does not confirm, and a confidence.
//!
//! * **Confirmed** is a winner `(x, k)` when the right pixel it points at has its own least sum at
//!   `k - 1`, `k` or `k + 1` (Fua 1993); of several least ones the first counts, as in the left view. The
//!   right view's sums stand along diagonals of the left one's, so it costs no second matching.
//! * **Where nothing tells disparities apart**, on a blank wall, all sums are the same, and both views take the first
//!   of them. So a winner that is no less than the next disparity must not be the first one in either view. Where one
//!   disparity alone lies within the right image, or in the range, nothing is told.
//! * **The fraction** is that of a V through the sums `a, c, b` before, at and after the winner,
//!   the shape that absolute differences have around their minimum: `(a - b) / (2 (max(a, b) - c))`
//!   (Shimizu & Okutomi 2001); 0 at the ends of the range.
//! * **The confidence** is `(max(a, b) - c) / max(a, b)`: 1 for a sum of zero among others, near 0
//!   for a flat valley, as blank walls have, and 0 at the ends of the range, beyond which things may go on. A measure of our own, after the margins that Hu & Mordohai
//!   compare (PAMI 2012).

use crate::kernels::level::at_every_level;
use crate::kernels::look_up::{LANES, LookUp};
use crate::kernels::rounding::nearest;
use crate::kernels::sad::{OUT, Winners};
use crate::kernels::stripes::Layout;
use crate::selection::fixed_point::{FixedPoint, HOLE};
use crate::selection::winner::tip_of_v;

/// So many columns are evaluated at once.
const BLOCK: usize = 64;

at_every_level! {
    /// Fills one row of `disparities` and `confidence`, a value of each for every answered column.
    pub(crate) fn confirm_row[tables](
        winners: &Winners,
        layout: &Layout,
        numbers: FixedPoint,
        disparities: &mut [u16],
        confidence: &mut [f32],
    ) {
        let n = layout.answered();
        let last = (layout.tried() - 1) as u16;
        let rows = disparities[..n].chunks_mut(BLOCK).zip(confidence[..n].chunks_mut(BLOCK));
        for (x, (disparities, confidence)) in (0..n).step_by(BLOCK).zip(rows) {
            let block = x..x + disparities.len();
            let index = &winners.index[block.clone()];
            let mut opposite = [0; BLOCK];
            let farthest = layout.shift(0);
            let reach = &winners.right_index[x..][..disparities.len() + farthest];
            let opposite = &mut opposite[..index.len()];
            winners_opposite(tables, index, reach, farthest, opposite);
            let [least, before, after] =
                [&winners.least, &winners.before, &winners.after].map(|row| &row[block.clone()]);
            evaluate(index, opposite, least, before, after, last, numbers, disparities, confidence);
        }
    }
}

/// Of columns next to each other the index that wins at the right pixel that their winner points at; `farthest` is
/// how far on from the column that of the first index is.
#[inline(always)]
fn winners_opposite(
    tables: impl LookUp,
    index: &[u16],
    reach: &[u16],
    farthest: usize,
    opposite: &mut [u16],
) {
    let blocks = index.chunks(LANES).zip(opposite.chunks_mut(LANES));
    for (first, (index, opposite)) in (0..).step_by(LANES).zip(blocks) {
        let n = index.len();
        let mut places = [0; LANES];
        for (i, (place, &k)) in (farthest as u16..).zip(places.iter_mut().zip(index)) {
            *place = i - k;
        }
        let table = &reach[first..][..n + farthest];
        opposite.copy_from_slice(&tables.look_up(table, &places)[..n]);
    }
}

/// Disparities and confidence of some winners. After the `last` disparity there is no other. Written without
/// conditions, of which the compiler would make jumps below AVX-512, and with a loop for each width of numbers.
#[inline(always)]
fn evaluate(
    index: &[u16],
    opposite: &[u16],
    least: &[u8],
    before: &[u8],
    after: &[u8],
    last: u16,
    numbers: FixedPoint,
    disparities: &mut [u16],
    confidence: &mut [f32],
) {
    let scale = f32::from(numbers.scale());
    let n = disparities.len();
    let (index, opposite, confidence) = (&index[..n], &opposite[..n], &mut confidence[..n]);
    let (least, before, after) = (&least[..n], &before[..n], &after[..n]);
    let (mut is_found, mut is_inner) = ([0u16; BLOCK], [0u16; BLOCK]);
    let (is_found, is_inner) = (&mut is_found[..n], &mut is_inner[..n]);
    for i in 0..n {
        let inner = index[i] < last;
        let blank = (index[i].min(opposite[i]) == 0) & inner & (least[i] == after[i]);
        let alone = (before[i] >= OUT) & (!inner | (after[i] >= OUT));
        let confirmed = index[i].abs_diff(opposite[i]) <= 1;
        let found = (u16::from(least[i]) < OUT.into()) & confirmed & !blank & !alone;
        is_found[i] = u16::from(found).wrapping_neg();
        is_inner[i] = u16::from(inner).wrapping_neg();
    }
    let mut nearest_steps = [0u16; BLOCK];
    let nearest_steps = &mut nearest_steps[..n];
    for i in 0..n {
        let inner = is_inner[i];
        let after = u16::from(after[i]) & inner | u16::from(OUT) & !inner;
        let valley = valley(before[i], least[i], after);
        nearest_steps[i] = nearest((f32::from(index[i]) + valley.fraction) * scale) as u16;
        confidence[i] = masked(valley.confidence, is_found[i]);
    }
    for i in 0..n {
        disparities[i] = nearest_steps[i] & is_found[i] | HOLE & !is_found[i];
    }
}

/// The number where all bits of the mask are set, 0 where none is.
#[inline(always)]
fn masked(number: f32, mask: u16) -> f32 {
    f32::from_bits(number.to_bits() & i32::from(mask as i16) as u32)
}

/// The shape of the costs around a winner.
struct Valley {
    fraction: f32,
    confidence: f32,
}

#[inline(always)]
fn valley(before: u8, least: u8, after: u16) -> Valley {
    let (before, least, after) = (f32::from(before), f32::from(least), f32::from(after));
    let higher = before.max(after);
    let rise = higher - least;
    // No sum beside the winner at one end of the range: nothing is known there.
    let known = u16::from((higher < f32::from(OUT)) & (rise > 0.0)).wrapping_neg();
    Valley {
        fraction: masked(tip_of_v(before, least, after), known),
        confidence: masked(rise / higher, known),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::SearchSpace;
    use crate::kernels::level::Level;
    use raster::{BoundingBox, DisparityRange};

    /// Winners of answered columns, of each its index, its sum, those before and after it, and the index of the
    /// right pixel's winner, which no two columns share.
    fn winners(columns: &[[u8; 5]], layout: &Layout) -> Winners {
        let mut winners = Winners {
            right_index: vec![9; columns.len() + layout.count() - 1],
            ..Winners::default()
        };
        for (x, &[index, least, before, after, opposite]) in columns.iter().enumerate() {
            winners.index.push(index.into());
            winners.least.push(least);
            winners.before.push(before);
            winners.after.push(after);
            winners.right_index[x + layout.shift(index.into())] = opposite.into();
        }
        winners
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
            // The ends of the range: no fraction, nothing to be sure of.
            ([0, 4, OUT, 6, 0], (-1.0, 0.0)),
            ([4, 4, 6, 5, 4], (3.0, 0.0)),
            // As on a blank wall, and beside it, where the first disparity does not fit; a winner in between.
            ([0, 4, OUT, 4, 0], (f32::NAN, 0.0)),
            ([1, 4, 9, 4, 0], (f32::NAN, 0.0)),
            ([1, 4, 9, 4, 1], (0.5, 0.5555556)),
            // Alone at either end of the range, and between two whose matches lie outside.
            ([0, 4, OUT, OUT, 0], (f32::NAN, 0.0)),
            ([4, 4, OUT, 6, 4], (f32::NAN, 0.0)),
            ([2, 4, OUT, OUT, 2], (f32::NAN, 0.0)),
            // A flat valley.
            ([3, 5, 5, 5, 3], (2.0, 0.0)),
        ];
        let untried = ([0, OUT, OUT, OUT, 0], (f32::NAN, 0.0));
        let range = DisparityRange::new(-1, 3).unwrap();
        for level in Level::available() {
            eprintln!("level {}", level.name());
            // Less than a block, whole blocks, and some more.
            for n in [1, 40, 64, 113, 128, 300] {
                // Far enough from each other for right pixels of their own.
                let columns = (0..n).map(|x| match x % range.count() {
                    0 => cases[x / range.count() % cases.len()],
                    _ => untried,
                });
                let (columns, expected): (Vec<_>, Vec<_>) = columns.unzip();
                let bounds = BoundingBox::new(50, 0, 49 + n, 0).unwrap();
                let space = SearchSpace::new(400, bounds, range);
                let (numbers, layout) = (FixedPoint::new(&space), Layout::new(&space));
                let winners = winners(&columns, &layout);
                let (mut found, mut confidence) = (vec![7; n], vec![7.0; n]);
                confirm_row(level, &winners, &layout, numbers, &mut found, &mut confidence);
                for (x, (disparity, sure)) in expected.into_iter().enumerate() {
                    let found = numbers.pixels(found[x]);
                    let is_found = found == disparity || found.is_nan() && disparity.is_nan();
                    assert!(is_found, "{found}, not {disparity} at {x} of {n}");
                    assert_eq!(confidence[x], sure, "{x} of {n}");
                }
            }
        }
    }
}
