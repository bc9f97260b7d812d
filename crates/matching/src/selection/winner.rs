//! Winner takes all, in both views, from the costs of one row.
//!
//! Left: `k(x) = argmin_k C(x, k)` over the disparities whose match lies inside the right image.
//! Right: `k'(x') = argmin_k C(x' + min + k, k)`: the same costs read along their diagonal, so the
//! second view costs no second matching (Fua 1993; Muehlmann et al. 2002). Of equal costs the
//! smallest disparity wins, in both views.
//!
//! The fraction of a pixel comes from the V-shape ("equiangular") that absolute differences have
//! around their minimum (Shimizu & Okutomi 2001): with `a, c, b` the costs before, at and after it,
//! `(a - b) / (2 (max(a, b) - c))`, between -1/2 and 1/2.

use crate::cost::SearchSpace;

/// No disparity could be tried.
pub(crate) const NONE: u16 = u16::MAX;

/// The disparity of least cost, counted from the smallest, for every column of the left row.
pub(crate) fn left_winners(space: &SearchSpace, costs: &[u16], winners: &mut [u16]) {
    for (x, (costs, winner)) in costs.chunks_exact(space.lanes).zip(winners).enumerate() {
        let (mut best, mut least) = (NONE, u16::MAX);
        for k in space.candidates(space.first + x) {
            if costs[k] < least {
                (best, least) = (k as u16, costs[k]);
            }
        }
        *winner = best;
    }
}

/// The disparity of least cost for every column of the right row, over the left columns of the
/// search space; [`NONE`] where no left column can match. `least` is scratch of the same length.
pub(crate) fn right_winners(
    space: &SearchSpace,
    costs: &[u16],
    least: &mut [u16],
    winners: &mut [u16],
) {
    least.fill(u16::MAX);
    winners.fill(NONE);
    for (x, costs) in costs.chunks_exact(space.lanes).enumerate() {
        let x = space.first + x;
        for k in space.candidates(x) {
            let right = space.right_column(x, k);
            if costs[k] < least[right] {
                (winners[right], least[right]) = (k as u16, costs[k]);
            }
        }
    }
}

/// What is added to a winner for its fraction of a pixel: 0 at the ends of the range.
pub(crate) fn fraction(costs: &[u16], winner: usize, candidates: std::ops::Range<usize>) -> f32 {
    if winner <= candidates.start || winner + 1 >= candidates.end {
        return 0.0;
    }
    let [before, least, after] = [winner - 1, winner, winner + 1].map(|k| f32::from(costs[k]));
    tip_of_v(before, least, after)
}

/// Where the tip of a V through three costs lies, the second of which is the least: 0 where all are
/// equal.
#[inline(always)]
pub(crate) fn tip_of_v(before: f32, least: f32, after: f32) -> f32 {
    let rise = before.max(after) - least;
    if rise > 0.0 { (before - after) / (2.0 * rise) } else { 0.0 }
}

/// The fraction of right column `x` whose winner is `winner`: its costs lie along a diagonal.
pub(crate) fn right_fraction(space: &SearchSpace, costs: &[u16], x: usize, winner: usize) -> f32 {
    let column = (x as i64 + i64::from(space.min) + winner as i64) as usize - space.first;
    if winner == 0 || column == 0 || winner + 1 >= space.count || column + 1 >= space.columns() {
        return 0.0;
    }
    let at = column * space.lanes + winner;
    let diagonal = [at - space.lanes - 1, at, at + space.lanes + 1].map(|i| costs[i]);
    fraction(&diagonal, 1, 0..3)
}

/// How much the winner's cost lies below that of any disparity but its neighbours.
pub(crate) fn margin(costs: &[u16], winner: usize, candidates: std::ops::Range<usize>) -> u16 {
    let before = &costs[candidates.start..winner.saturating_sub(1).max(candidates.start)];
    let after = &costs[(winner + 2).min(candidates.end)..candidates.end];
    let least = |costs: &[u16]| costs.iter().copied().fold(u16::MAX, u16::min);
    match least(before).min(least(after)) {
        u16::MAX => 0,
        second => second - costs[winner],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::{BoundingBox, DisparityRange};

    fn space(columns: usize, min: i32, max: i32) -> SearchSpace {
        SearchSpace::new(
            columns,
            BoundingBox::whole(columns, 1),
            DisparityRange::new(min, max).unwrap(),
        )
    }

    #[test]
    fn the_least_cost_inside_the_right_image_wins() {
        let space = space(3, 0, 2);
        let mut costs = vec![9; 3 * space.lanes];
        for (x, row) in [[5, 0, 0], [7, 7, 0], [4, 2, 3]].iter().enumerate() {
            costs[x * space.lanes..][..3].copy_from_slice(row);
        }
        let mut left = [0; 3];
        left_winners(&space, &costs, &mut left);
        // Column 0 may only match right column 0; of equal costs the smaller disparity wins.
        assert_eq!(left, [0, 0, 1]);
        let (mut least, mut right) = ([0; 3], [0; 3]);
        right_winners(&space, &costs, &mut least, &mut right);
        // Right 0: left 0, 1, 2 at disparity 0, 1, 2 cost 5, 7, 3. Right 1: 7 and 2. Right 2: 4.
        assert_eq!((right, least), ([2, 1, 0], [3, 2, 4]));
    }

    #[test]
    fn nothing_wins_where_nothing_can_be_tried() {
        let space = space(3, 2, 5);
        let costs = vec![1; 3 * space.lanes];
        let mut left = [0; 3];
        left_winners(&space, &costs, &mut left);
        assert_eq!(left, [NONE, NONE, 0]);
    }

    #[test]
    fn a_v_shape_gives_its_tip() {
        // Costs 4 |k - 1.25| + 3.
        assert_eq!(fraction(&[8, 4, 6, 10], 1, 0..4), 0.25);
        assert_eq!(fraction(&[8, 4, 6, 10], 1, 1..4), 0.0);
        assert_eq!(fraction(&[4, 4, 4], 1, 0..3), 0.0);
    }
}
