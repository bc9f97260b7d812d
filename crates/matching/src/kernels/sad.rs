//! One row of window sums of absolute differences, with the winners of both views.
//!
//! ```text
//! A(x, y, k) = |L(x, y) - R(x - min - k, y)|
//! C(x, y, k) = sum of A(x', y', k) over |x' - x| <= r, |y' - y| <= r inside the image
//! ```
//!
//! In: the filtered rows that enter and leave the window. Out: per column the least sum of the
//! left view, its index, its neighbours, and what confirms it in the right view.
//!
//! The row is done in tiles of columns that stay in the first-level cache. In each, four loops
//! follow each other, with the disparities of one column side by side in memory:
//!
//! 1. `V`, the sums down the window's columns, is slid by one row. Differences are at most
//!    [`LARGEST_DIFFERENCE`], so `V` fits a byte: 8 operations for 64 pixel-disparities.
//! 2. `C` is slid by one column: one column of `V` enters, one leaves.
//! 3. The right view's least sum is `min_k C(x' + min + k, k)`, along the diagonal. Eight columns
//!    are folded together before they meet the row's minima, whose places in memory shift by one
//!    from column to column: done one by one, each load would wait for the store before it.
//! 4. The left view's winner: the least sum first, then the first place where it stands.

use std::ops::Range;

use super::level::at_every_level;
use crate::cost::SearchSpace;

/// Half the window: it is `2 RADIUS + 1` pixels wide and high.
pub(crate) const RADIUS: usize = 4;
/// No difference of the filtered images may be larger: sums down a column must fit a byte.
pub(crate) const LARGEST_DIFFERENCE: u8 = u8::MAX / (2 * RADIUS as u8 + 1);
/// Sums from here on stand for "cannot be tried": no sum over the window comes near.
pub(crate) const OUT: u16 = 0x8000;

/// Disparities are handled in groups of this many.
const GROUP: usize = 32;
/// Columns of a tile.
const TILE: usize = 32;
/// Columns that are folded before they meet the right view's minima.
const FOLD: usize = 8;
/// Room between the costs of two columns, so that a fold may look past both ends of a column.
const PAD: usize = FOLD;
/// Costs of the tile before that are still needed: the last column's winner looks one column on.
const CARRIED: usize = 2;

/// A filtered row of both images: the left columns that support the answered ones, and the right
/// row as [`reverse_row`](crate::cost::absolute_difference::reverse_row) writes it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowPair<'a> {
    pub left: &'a [u8],
    pub reversed: &'a [u8],
}

/// What won in one row: per answered column of the left image, and per column of the right one.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub(crate) struct Winners {
    /// Index of the disparity with the least sum, the smallest of several.
    pub index: Vec<u16>,
    /// That least sum; 32768 or more where nothing could be tried.
    pub least: Vec<u16>,
    /// The sums of the disparities before and after the winner, 32768 or more at the range's ends.
    pub before: Vec<u16>,
    pub after: Vec<u16>,
    /// The least of the winner's sum and those of `(x - 1, k - 1)` and `(x + 1, k + 1)`, which
    /// match the same right pixel.
    pub confirming: Vec<u16>,
    /// The least sum of right column `last - min - i` at place `i`.
    pub right: Vec<u16>,
}

/// The memory of the kernel: sums of a band of rows.
#[derive(Debug, Default)]
pub(crate) struct Sad {
    /// `V`: per supporting column all disparities, with [`BEFORE`] and [`RADIUS`] columns of zeros
    /// before and after, for windows that leave the image.
    columns: Vec<u8>,
    /// `C` of a tile: per column all disparities and `PAD` times [`OUT`]. Disparities that cannot
    /// be tried are [`OUT`] as well.
    costs: Vec<u16>,
    /// `C` of the last column of the tile before: from there it slides on.
    sums: Vec<u16>,
    /// Per column of a tile, its groups of costs folded into one.
    minima: Vec<[u16; GROUP]>,
    pub winners: Winners,
}

/// Columns of zeros before the first supporting one: the one that leaves the first window is the
/// furthest.
const BEFORE: usize = RADIUS + 1;

fn refill<T: Clone>(buffer: &mut Vec<T>, length: usize, value: T) {
    buffer.clear();
    buffer.resize(length, value);
}

impl Sad {
    /// Begins a band of rows with an empty window.
    pub fn begin(&mut self, space: &SearchSpace, supporting: usize) {
        let lanes = space.lanes;
        assert!(lanes > 0 && lanes.is_multiple_of(GROUP), "{lanes} lanes are not whole groups");
        refill(&mut self.columns, (BEFORE + supporting + RADIUS) * lanes, 0);
        refill(&mut self.costs, PAD + (CARRIED + TILE + 1) * (lanes + PAD), OUT);
        refill(&mut self.sums, lanes, 0);
        refill(&mut self.minima, TILE + 1, [OUT; GROUP]);
        let winners = &mut self.winners;
        for buffer in [
            &mut winners.index,
            &mut winners.least,
            &mut winners.before,
            &mut winners.after,
            &mut winners.confirming,
        ] {
            refill(buffer, space.columns(), 0);
        }
        refill(&mut winners.right, space.columns() + lanes + PAD, OUT);
    }
}

at_every_level! {
    /// Slides the window down by one row.
    pub(crate) fn slide_down(sad: &mut Sad, lanes: usize, entering: RowPair<'_>, leaving: RowPair<'_>) {
        let supporting = entering.left.len();
        slide_columns(&mut sad.columns, 0..supporting, lanes, entering, leaving);
    }

    /// Slides the window down by one row, and finds what wins there. `margin` supporting columns
    /// stand before the first answered one.
    pub(crate) fn match_row(
        sad: &mut Sad,
        space: &SearchSpace,
        margin: usize,
        entering: RowPair<'_>,
        leaving: RowPair<'_>,
    ) {
        let Sad { columns, costs, sums, minima, winners } = sad;
        let (lanes, total, supporting) = (space.lanes, space.columns(), entering.left.len());
        let stride = lanes + PAD;
        let column = |c: usize| PAD + c * stride..PAD + c * stride + lanes;

        winners.right.fill(OUT);
        let mut slid = supporting.min(margin + RADIUS);
        slide_columns(columns, 0..slid, lanes, entering, leaving);
        // The window around the column before the first one: from there it slides.
        sums.fill(0);
        for c in margin.saturating_sub(BEFORE)..slid {
            add_column(sums, &columns[(BEFORE + c) * lanes..][..lanes]);
        }
        costs[column(CARRIED - 1)].fill(OUT);

        let mut done = 0;
        while done < total {
            let size = TILE.min(total - done);
            let upto = supporting.min(margin + done + size + RADIUS);
            slide_columns(columns, slid..upto, lanes, entering, leaving);
            slid = upto;
            let supply = &columns[(margin + done) * lanes..][..(size + 2 * RADIUS + 1) * lanes];
            let tile = &mut costs[PAD + CARRIED * stride..][..size * stride];
            slide_window(sums, tile, supply, lanes);
            for (x, column) in (space.first + done..).zip(tile.chunks_exact_mut(stride)) {
                let candidates = space.candidates(x);
                column[..candidates.start].fill(OUT);
                column[candidates.end..lanes].fill(OUT);
            }
            let folds = size / FOLD;
            for fold in 0..folds {
                let first = CARRIED + fold * FOLD;
                let place = total - (done + (fold + 1) * FOLD);
                let minima = &mut winners.right[place..][..stride];
                fold_into_right_view(&costs[first * stride..], stride, minima);
            }
            for i in folds * FOLD..size {
                let minima = &mut winners.right[total - 1 - (done + i)..][..lanes];
                for (least, &cost) in minima.iter_mut().zip(&costs[column(CARRIED + i)]) {
                    *least = cost.min(*least);
                }
            }
            // The winner of a column looks at both its neighbours: it is found one column late.
            let late = usize::from(done > 0);
            let last = done + size == total;
            if last {
                costs[column(CARRIED + size)].fill(OUT);
            }
            let found = size + late - usize::from(!last);
            find_winners(costs, CARRIED - late, lanes, done - late, &mut minima[..found], winners);
            costs.copy_within(size * stride..PAD + (size + CARRIED) * stride, 0);
            done += size;
        }
    }
}

// The loops below work on copies of whole groups: the compiler then knows that nothing overlaps,
// and keeps a group in registers from the first operation to the last.

/// `V` of supporting columns `range`, one row further down.
#[inline(always)]
fn slide_columns(
    columns: &mut [u8],
    range: Range<usize>,
    lanes: usize,
    entering: RowPair<'_>,
    leaving: RowPair<'_>,
) {
    let last = entering.left.len() - 1;
    let columns = &mut columns[(BEFORE + range.start) * lanes..(BEFORE + range.end) * lanes];
    for (c, column) in range.zip(columns.chunks_exact_mut(lanes)) {
        let left = (entering.left[c], leaving.left[c]);
        let right_in = &entering.reversed[last - c..][..lanes];
        let right_out = &leaving.reversed[last - c..][..lanes];
        let (pairs, single) = column.as_chunks_mut::<{ 2 * GROUP }>();
        let (in_pairs, in_single) = right_in.as_chunks::<{ 2 * GROUP }>();
        let (out_pairs, out_single) = right_out.as_chunks::<{ 2 * GROUP }>();
        for ((sums, right_in), right_out) in pairs.iter_mut().zip(in_pairs).zip(out_pairs) {
            *sums = slide_sums(*sums, left, *right_in, *right_out);
        }
        let single = single.as_chunks_mut::<GROUP>().0.iter_mut();
        let right = in_single.as_chunks::<GROUP>().0.iter().zip(out_single.as_chunks::<GROUP>().0);
        for (sums, (right_in, right_out)) in single.zip(right) {
            *sums = slide_sums(*sums, left, *right_in, *right_out);
        }
    }
}

#[inline(always)]
fn slide_sums<const N: usize>(
    mut sums: [u8; N],
    (left_in, left_out): (u8, u8),
    right_in: [u8; N],
    right_out: [u8; N],
) -> [u8; N] {
    for i in 0..N {
        let gain = left_in.max(right_in[i]) - left_in.min(right_in[i]);
        let loss = left_out.max(right_out[i]) - left_out.min(right_out[i]);
        sums[i] = sums[i].wrapping_add(gain).wrapping_sub(loss);
    }
    sums
}

#[inline(always)]
fn add_column(sums: &mut [u16], column: &[u8]) {
    for (sum, &v) in sums.iter_mut().zip(column) {
        *sum = sum.wrapping_add(u16::from(v));
    }
}

/// `C` of a tile. `sums` are those of the column before it; `columns` begins with the column of `V`
/// that leaves the first window.
#[inline(always)]
fn slide_window(sums: &mut [u16], tile: &mut [u16], columns: &[u8], lanes: usize) {
    let stride = lanes + PAD;
    let leaving = columns.chunks_exact(lanes);
    let entering = columns[(2 * RADIUS + 1) * lanes..].chunks_exact(lanes);
    for (at, running) in (0..).step_by(GROUP).zip(sums.as_chunks_mut::<GROUP>().0) {
        let mut sums = *running;
        let tile = tile.chunks_exact_mut(stride);
        for (costs, (entering, leaving)) in tile.zip(entering.clone().zip(leaving.clone())) {
            let gain: [u8; GROUP] = *entering[at..].first_chunk().expect("a whole group");
            let loss: [u8; GROUP] = *leaving[at..].first_chunk().expect("a whole group");
            for i in 0..GROUP {
                let gained = sums[i].wrapping_add(u16::from(gain[i]));
                sums[i] = gained.wrapping_sub(u16::from(loss[i]));
            }
            *costs[at..].first_chunk_mut().expect("a whole group") = sums;
        }
        *running = sums;
    }
}

/// Folds `FOLD` columns of costs along the diagonal, then into the right view's minima. Before
/// every column, and after the last, stand `PAD` places that cannot win.
#[inline(always)]
fn fold_into_right_view(costs: &[u16], stride: usize, minima: &mut [u16]) {
    // Place `i` belongs to index `i - (FOLD - 1) + j` of column `j`.
    let diagonal: [&[u16]; FOLD] =
        std::array::from_fn(|j| &costs[PAD + j * stride + j - (FOLD - 1)..][..stride]);
    let mut at = 0;
    while at + GROUP <= stride {
        fold_group::<GROUP>(&diagonal, at, minima);
        at += GROUP;
    }
    fold_group::<PAD>(&diagonal, at, minima);
}

#[inline(always)]
fn fold_group<const N: usize>(diagonal: &[&[u16]; FOLD], at: usize, minima: &mut [u16]) {
    let minima: &mut [u16; N] = minima[at..].first_chunk_mut().expect("a whole group");
    let mut least = *minima;
    for costs in diagonal {
        let costs: [u16; N] = *costs[at..].first_chunk().expect("a whole group");
        for i in 0..N {
            least[i] = least[i].min(costs[i]);
        }
    }
    *minima = least;
}

/// Finds what wins at as many columns as there are `minima`, from column `first` of the tile and
/// answered column `x` on.
#[inline(always)]
fn find_winners(
    costs: &[u16],
    first: usize,
    lanes: usize,
    x: usize,
    minima: &mut [[u16; GROUP]],
    winners: &mut Winners,
) {
    let stride = lanes + PAD;
    let answered = x..x + minima.len();
    let columns = costs[PAD + first * stride..].chunks_exact(stride);
    for (column, minima) in columns.clone().zip(minima.iter_mut()) {
        let mut least = [OUT; GROUP];
        for group in column.as_chunks::<GROUP>().0 {
            let group = *group;
            for i in 0..GROUP {
                least[i] = least[i].min(group[i]);
            }
        }
        *minima = least;
    }
    // From memory, the compiler folds a group by halves; from registers, lane after lane.
    let least = &mut winners.least[answered.clone()];
    for (minima, least) in minima.iter().zip(least.iter_mut()) {
        *least = minima.iter().fold(OUT, |least, &cost| least.min(cost));
    }
    let index = &mut winners.index[answered.clone()];
    for ((column, &least), index) in columns.zip(least.iter()).zip(index.iter_mut()) {
        *index = first_of(&column[..lanes], least);
    }
    let before = winners.before[answered.clone()].iter_mut();
    let after = winners.after[answered.clone()].iter_mut();
    let confirming = winners.confirming[answered].iter_mut();
    let here = (PAD + first * stride..).step_by(stride);
    let found = here.zip(index.iter()).zip(least.iter());
    for (((here, &index), &least), ((before, after), confirming)) in
        found.zip(before.zip(after).zip(confirming))
    {
        let at = here + usize::from(index);
        *before = costs[at - 1];
        *after = costs[at + 1];
        *confirming = least.min(costs[at - 1 - stride]).min(costs[at + 1 + stride]);
    }
}

/// The first place of a cost.
#[inline(always)]
fn first_of(costs: &[u16], cost: u16) -> u16 {
    let mut first = [u16::MAX; GROUP];
    let mut base = 0;
    for group in costs.as_chunks::<GROUP>().0 {
        let group = *group;
        for i in 0..GROUP {
            let index = if group[i] == cost { base + i as u16 } else { u16::MAX };
            first[i] = first[i].min(index);
        }
        base += GROUP as u16;
    }
    first.into_iter().fold(u16::MAX, u16::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::absolute_difference::reverse_row;
    use crate::kernels::level::Level;
    use raster::{BoundingBox, DisparityRange, Plane};

    /// The definition: every window summed anew, every candidate looked at.
    fn winners_by_definition(
        space: &SearchSpace,
        left: &Plane<u8>,
        right: &Plane<u8>,
        y: usize,
    ) -> Winners {
        let (width, height) = left.size();
        let cost = |x: usize, k: usize| -> u16 {
            let mut sum = 0;
            for v in y.saturating_sub(RADIUS)..=(y + RADIUS).min(height - 1) {
                for u in x.saturating_sub(RADIUS)..=(x + RADIUS).min(width - 1) {
                    let match_column = u as i64 - i64::from(space.min) - k as i64;
                    let match_column = match_column.clamp(0, width as i64 - 1) as usize;
                    sum += u16::from(left.row(v)[u].abs_diff(right.row(v)[match_column]));
                }
            }
            sum
        };
        let inside = |x: i64, k: i64| {
            x >= space.first as i64
                && x <= space.last as i64
                && (0..space.count as i64).contains(&k)
                && (0..width as i64).contains(&(x - i64::from(space.min) - k))
        };
        let cost = |x: i64, k: i64| if inside(x, k) { cost(x as usize, k as usize) } else { OUT };
        let mut winners = Winners::default();
        for x in space.first as i64..=space.last as i64 {
            let k = (0..space.count as i64).min_by_key(|&k| cost(x, k)).unwrap();
            winners.index.push(k as u16);
            winners.least.push(cost(x, k));
            winners.before.push(cost(x, k - 1));
            winners.after.push(cost(x, k + 1));
            let diagonal = [cost(x, k), cost(x - 1, k - 1), cost(x + 1, k + 1)];
            winners.confirming.push(*diagonal.iter().min().unwrap());
        }
        for i in 0..space.columns() + space.count - 1 {
            let right = space.last as i64 - i64::from(space.min) - i as i64;
            let costs = (0..space.count as i64).map(|k| cost(right + i64::from(space.min) + k, k));
            winners.right.push(costs.min().unwrap());
        }
        winners
    }

    /// Winners of every row, by the kernel.
    fn winners_by_kernel(
        level: Level,
        space: &SearchSpace,
        left: &Plane<u8>,
        right: &Plane<u8>,
    ) -> Vec<Winners> {
        let (width, height) = left.size();
        let c0 = space.first.saturating_sub(RADIUS);
        let c1 = (space.last + RADIUS).min(width - 1);
        let reversed: Vec<Vec<u8>> = (0..height)
            .map(|y| {
                let mut row = vec![0; c1 - c0 + 1 + space.lanes];
                reverse_row(right.row(y), c1 as i64 - i64::from(space.min), &mut row);
                row
            })
            .collect();
        let nothing = vec![0; c1 - c0 + 1 + space.lanes];
        let row = |y: usize| {
            if y < height {
                RowPair { left: &left.row(y)[c0..=c1], reversed: &reversed[y] }
            } else {
                RowPair { left: &nothing[..=c1 - c0], reversed: &nothing }
            }
        };
        let mut sad = Sad::default();
        sad.begin(space, c1 - c0 + 1);
        for y in 0..RADIUS {
            slide_down(level, &mut sad, space.lanes, row(y), row(usize::MAX));
        }
        let mut all = Vec::new();
        for y in 0..height {
            let (entering, leaving) = (row(y + RADIUS), row(y.wrapping_sub(RADIUS + 1)));
            match_row(level, &mut sad, space, space.first - c0, entering, leaving);
            all.push(sad.winners.clone());
        }
        all
    }

    #[test]
    fn the_kernel_is_its_definition_at_every_level() {
        let noise = |x: usize, y: usize, seed: usize| {
            let v = (x * 0x9E37 + y * 0x79B9 + seed * 0x7F4A).wrapping_mul(0x2545_F491_4F6C_DD1D);
            (v >> 40) as u8 % (LARGEST_DIFFERENCE + 1)
        };
        let shapes = [
            // width, height, first and last answered column, range
            (1, 1, (0, 0), (0, 0)),
            (3, 12, (0, 2), (-5, 5)),
            (40, 3, (0, 39), (0, 15)),
            (75, 11, (0, 74), (0, 63)),
            (75, 11, (9, 60), (3, 31)),
            (90, 10, (2, 88), (-20, 70)),
            (33, 9, (30, 32), (-40, 40)),
        ];
        for level in Level::available() {
            eprintln!("level {}", level.name());
            for (width, height, (x0, x1), (min, max)) in shapes {
                let left = Plane::from_fn(width, height, |x, y| noise(x, y, 1));
                let right = Plane::from_fn(width, height, |x, y| {
                    // Half noise, half a shifted copy; blank at the right, where sums are equal.
                    match x {
                        _ if x > 60 => 0,
                        _ if y % 2 == 0 => noise(x + 7, y, 1),
                        _ => noise(x, y, 2),
                    }
                });
                let bounds = BoundingBox::new(x0, 0, x1, 0).unwrap();
                let range = DisparityRange::new(min, max).unwrap();
                let space = SearchSpace::new(width, bounds, range);
                let found = winners_by_kernel(level, &space, &left, &right);
                for (y, found) in found.into_iter().enumerate() {
                    let expected = winners_by_definition(&space, &left, &right, y);
                    let tried: Vec<bool> = expected.least.iter().map(|&v| v < OUT).collect();
                    let only = |v: &[u16]| -> Vec<u16> {
                        // Above OUT, values only say that nothing was tried.
                        v.iter().map(|&v| v.min(OUT)).collect()
                    };
                    let at_winners = |v: &[u16]| -> Vec<u16> {
                        only(v).into_iter().zip(&tried).filter(|t| *t.1).map(|t| t.0).collect()
                    };
                    let what = format!("{width} x {height}, {x0}..{x1}, {min}..{max}, row {y}");
                    assert_eq!(only(&found.least), expected.least, "least, {what}");
                    assert_eq!(at_winners(&found.index), at_winners(&expected.index), "{what}");
                    assert_eq!(at_winners(&found.before), at_winners(&expected.before), "{what}");
                    assert_eq!(at_winners(&found.after), at_winners(&expected.after), "{what}");
                    assert_eq!(
                        at_winners(&found.confirming),
                        at_winners(&expected.confirming),
                        "confirming, {what}"
                    );
                    for (i, &least) in expected.right.iter().enumerate() {
                        // Columns outside the right image are of no interest.
                        let column = space.last as i64 - i64::from(space.min) - i as i64;
                        if (0..width as i64).contains(&column) {
                            assert_eq!(found.right[i].min(OUT), least, "right {column}, {what}");
                        }
                    }
                }
            }
        }
    }
}
