//! What the kernel keeps from one row to the next, and what it finds.

use super::{LARGEST_COLUMN, OUT, TOGETHER};
use crate::kernels::aligned::{Aligned, LINE};
use crate::kernels::stripes::{LANES, Layout};

/// What stands before the vectors of what counts of the columns' sums: a vector of each disparity that is compared
/// together.
pub(super) const BEFORE: usize = TOGETHER * LANES;

/// What won in one row, column by column. An index is that of a row before where nothing could be tried.
#[derive(Debug, Default)]
pub(crate) struct Winners {
    /// Of every left column the index of the disparity with the least sum, the smallest of several.
    pub index: Vec<u16>,
    /// That least sum; [`OUT`] or more where nothing could be tried.
    pub least: Vec<u8>,
    /// The sum of the disparity before the winner, [`OUT`] or more where there is none.
    pub before: Vec<u8>,
    /// The sum of the disparity after the winner; anything where the winner is the last.
    pub after: Vec<u8>,
    /// The index that wins at every right column that is matched: that of left column `x` at index `k` is
    /// number `x + count - 1 - k`.
    pub right_index: Vec<u16>,
}

#[cfg(test)]
impl Winners {
    /// Of every answered column the index of the winner, its sum, those before and after it, and the index
    /// that wins at the right pixel that the winner points at.
    pub fn columns(&self, layout: &Layout) -> Vec<[u16; 5]> {
        let column = |x: usize| {
            let k = self.index[x];
            let is_last = usize::from(k) + 1 == layout.tried();
            let after = if is_last { OUT } else { self.after[x] };
            let opposite = self.right_index[x + layout.shift(k.into())];
            [k, self.least[x].into(), self.before[x].into(), after.into(), opposite]
        };
        (0..layout.answered()).map(column).collect()
    }
}

/// Indices in stripes, byte by byte, so that as many go into a vector as sums.
#[derive(Debug, Default)]
pub(super) struct Indices {
    pub low: Aligned<u8>,
    /// 0 where there are not more disparities than a byte tells apart.
    pub high: Aligned<u8>,
}

/// The memory of the kernel: sums of a band of rows, in stripes, and tables of what counts of them.
#[derive(Debug, Default)]
pub(crate) struct Sad {
    /// `V`: of disparities that are compared together vector beside vector.
    pub(super) columns: Aligned<u8>,
    /// Of those at hand what counts of `V`, after [`BEFORE`], and after the last a vector more.
    pub(super) counted: Aligned<u8>,
    /// `C` of the disparities that are compared together, in groups of a vector of each: of left vector `j`, counted
    /// from the one before the first, that of the last index lies in group `j`, that of each before it in the next
    /// one. So what matches the same right columns is in one group. Where there is no left vector nothing counts.
    pub(super) sums: Aligned<u8>,
    /// Of the left view the least sums, their indices, and the sums beside them.
    pub(super) least: Aligned<u8>,
    pub(super) left: Indices,
    pub(super) before: Aligned<u8>,
    pub(super) after: Aligned<u8>,
    /// Of the right view the least sums and their indices, as its rows lie.
    pub(super) right_least: Aligned<u8>,
    pub(super) right: Indices,
    /// A row of bytes, column by column.
    pub(super) row: Vec<u8>,
    /// What won.
    pub(super) winners: Winners,
    /// How much of `V` counts at the most: of left columns outside the image nothing.
    pub(super) largest: Aligned<u8>,
    /// All bits set where right columns are outside the image, as they lie in a right row with a vector more.
    pub(super) outside: Aligned<u8>,
    /// All bits set where left columns are not answered.
    pub(super) beyond: Aligned<u8>,
    /// Of what layout these tables are.
    prepared_for: Option<Layout>,
}

/// All bits set, or none.
fn mask(set: bool) -> u8 {
    if set { u8::MAX } else { 0 }
}

impl Sad {
    /// What won in the row that was matched last.
    pub fn winners(&self) -> &Winners {
        &self.winners
    }

    /// The memory for a search space.
    pub fn bytes(layout: &Layout) -> usize {
        let (left, right) = (layout.left(), layout.right());
        let columns = layout.count() * left + BEFORE + TOGETHER * left + LANES;
        let sums = TOGETHER * (left + TOGETHER * LANES);
        let striped = 5 * left + 3 * right;
        let winners = (size_of::<u16>() + 4) * left + size_of::<u16>() * (left + layout.count());
        let tables = 2 * left + right + LANES;
        columns + sums + striped + winners + tables + 14 * LINE
    }

    /// Begins a band of rows with an empty window.
    pub fn begin(&mut self, layout: &Layout) {
        let (left, right) = (layout.left(), layout.right());
        self.columns.refill(layout.count() * left, 0);
        self.counted.refill(BEFORE + TOGETHER * left + LANES, 0);
        self.sums.refill(TOGETHER * (left + TOGETHER * LANES), OUT);
        for row in [&mut self.least, &mut self.before, &mut self.after] {
            row.refill(left, 0);
        }
        self.right_least.refill(right, 0);
        for (indices, places) in [(&mut self.left, left), (&mut self.right, right)] {
            indices.low.refill(places, 0);
            indices.high.refill(places, 0);
        }
        let Winners { index, least, before, after, right_index } = &mut self.winners;
        for row in [least, before, after, &mut self.row] {
            row.resize(left, 0);
        }
        index.resize(left, 0);
        right_index.resize(left + layout.count() - 1, 0);
        // The rest is the same for every band and frame of a size.
        if self.prepared_for.replace(*layout) == Some(*layout) {
            return;
        }
        self.largest.refill(left, 0);
        for (largest, place) in self.largest.iter_mut().zip(0..) {
            *largest = if layout.is_inside(layout.column(place)) { LARGEST_COLUMN } else { 0 };
        }
        self.outside.refill(right + LANES, 0);
        for (outside, place) in self.outside.iter_mut().zip(0..) {
            *outside = mask(!layout.is_match_inside(layout.column(place)));
        }
        self.beyond.refill(left, 0);
        for (beyond, place) in self.beyond.iter_mut().zip(0..) {
            *beyond = mask(layout.column(place) >= layout.answered());
        }
    }
}
