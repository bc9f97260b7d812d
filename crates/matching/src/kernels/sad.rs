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

use super::level::at_every_level;
use crate::cost::SearchSpace;

/// Half the window: it is `2 RADIUS + 1` pixels wide and high.
pub(crate) const RADIUS: usize = 4;
/// No difference of the filtered images may be larger: sums down a column must fit a byte.
pub(crate) const LARGEST_DIFFERENCE: u8 = u8::MAX / (2 * RADIUS as u8 + 1);
/// What stands for "cannot be tried": no sum over the window comes near.
const OUT: u16 = 0x8000;

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
    /// `V`: per supporting column all disparities.
    columns: Vec<u8>,
    /// `C` of a tile: per column all disparities and `PAD` times [`OUT`].
    costs: Vec<u16>,
    /// A column of `V` outside the image.
    nothing: Vec<u8>,
    /// A column of `C` over an empty window: [`OUT`] where no disparity is searched.
    empty: Vec<u16>,
    /// A column of `C` of which a part can be tried.
    part: Vec<u16>,
    pub winners: Winners,
}

fn refill<T: Clone>(buffer: &mut Vec<T>, length: usize, value: T) {
    buffer.clear();
    buffer.resize(length, value);
}

impl Sad {
    /// Begins a band of rows with an empty window.
    pub fn begin(&mut self, space: &SearchSpace, supporting: usize) {
        let lanes = space.lanes;
        assert!(lanes > 0 && lanes.is_multiple_of(GROUP), "{lanes} lanes are not whole groups");
        refill(&mut self.columns, supporting * lanes, 0);
        refill(&mut self.costs, PAD + (CARRIED + TILE) * (lanes + PAD), OUT);
        refill(&mut self.nothing, lanes, 0);
        refill(&mut self.empty, lanes, OUT);
        self.empty[..space.count].fill(0);
        refill(&mut self.part, lanes, OUT);
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
        let Sad { columns, costs, nothing, empty, part, winners } = sad;
        let (lanes, total, supporting) = (space.lanes, space.columns(), entering.left.len());
        let stride = lanes + PAD;
        let column = |c: usize| PAD + c * stride..PAD + c * stride + lanes;

        winners.right.fill(OUT);
        let mut slid = supporting.min(margin + RADIUS);
        slide_columns(columns, 0..slid, lanes, entering, leaving);
        // The window around the column before the first one: from there it slides.
        let before = &mut costs[column(CARRIED - 1)];
        before.copy_from_slice(empty);
        for c in 0..slid {
            slide_window(before, &columns[c * lanes..][..lanes], nothing);
        }

        let mut done = 0;
        while done < total {
            let size = TILE.min(total - done);
            let upto = supporting.min(margin + done + size + RADIUS);
            slide_columns(columns, slid..upto, lanes, entering, leaving);
            slid = upto;
            for i in 0..size {
                let (front, back) = costs.split_at_mut(PAD + (CARRIED + i) * stride);
                let sums = &mut back[..lanes];
                sums.copy_from_slice(&front[PAD + (CARRIED + i - 1) * stride..][..lanes]);
                let centre = margin + done + i;
                let supply = |c: usize| &columns[c * lanes..][..lanes];
                let entering =
                    if centre + RADIUS < supporting { supply(centre + RADIUS) } else { nothing };
                let leaving = if centre > RADIUS { supply(centre - RADIUS - 1) } else { nothing };
                slide_window(sums, entering, leaving);
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
                lessen(minima, &costs[column(CARRIED + i)]);
            }
            // The winner of a column looks at both its neighbours: it is found one column late.
            for i in 0..size {
                if done + i > 0 {
                    let at = CARRIED + i - 1;
                    find_winner(costs, at, space, done + i - 1, part, winners);
                }
            }
            done += size;
            if done < total {
                costs.copy_within(size * stride..PAD + (size + CARRIED) * stride, 0);
            } else {
                if size < TILE {
                    costs[column(CARRIED + size)].fill(OUT);
                }
                find_winner(costs, CARRIED + size - 1, space, total - 1, part, winners);
            }
        }
    }
}
