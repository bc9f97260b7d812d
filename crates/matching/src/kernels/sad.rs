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
#[derive(Clone, Copy)]
pub(crate) struct RowPair<'a> {
    pub left: &'a [u8],
    pub reversed: &'a [u8],
}

/// The sums of a band of rows, and what the last row's winners are.
#[derive(Default)]
pub(crate) struct Sad {
    /// `V`: per supporting column all disparities.
    columns: Vec<u8>,
    /// `C` of a tile: per column `lanes` sums and `PAD` times [`OUT`].
    costs: Vec<u16>,
    /// A column of zeros, then one of 0 where a disparity is searched and [`OUT`] where not.
    zeros: Vec<u8>,
    start: Vec<u16>,
    /// A column that cannot be tried, and a copy of one that can be tried in part.
    part: Vec<u16>,
    /// The right view's least sums: see [`Winners::right_least`].
    right: Vec<u16>,
    winners: Vec<u16>,
    least: Vec<u16>,
    before: Vec<u16>,
    after: Vec<u16>,
    confirming: Vec<u16>,
}
