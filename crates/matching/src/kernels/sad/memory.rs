//! What the kernel keeps from one row to the next, and what it finds.

use super::{OUT, TOGETHER};
use crate::kernels::aligned::{Aligned, LINE};
use crate::kernels::stripes::{LANES, Layout};

/// Sums have this bit where a disparity is not tried but makes up their number, the next one where the left
/// column is not answered, and the third where the match is outside. The sign's is not used: older processors
/// compare numbers with signs alone.
pub(super) const UNTRIED: u16 = OUT;
pub(super) const BEYOND: u16 = OUT << 1;
const OUTSIDE: u16 = OUT << 2;

/// Bytes before the columns' sums: of each disparity that is compared together a vector.
pub(super) const BEFORE: usize = TOGETHER * LANES;
/// Sums of all disparities that are compared together but the last, in as many vectors.
const RECENT: usize = TOGETHER * (TOGETHER - 1) * LANES;

/// What won in one row, in stripes. An index is that of a row before where nothing could be tried.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Winners<'a> {
    /// Of the left view the index of the disparity with the least sum, the smallest of several.
    pub index: &'a [u16],
    /// That least sum; [`OUT`] or more where nothing could be tried.
    pub least: &'a [u16],
    /// The sum of the disparity before the winner, [`OUT`] or more where there is none.
    pub before: &'a [u16],
    /// The sum of the disparity after the winner; anything where the winner is the last.
    pub after: &'a [u16],
    /// The index that wins at each place of the right view.
    pub right_index: &'a [u16],
    /// The places of all right columns that are matched: that of left column `x` at index `k` is
    /// number `x + count - 1 - k`.
    pub right_places: &'a [u32],
}

#[cfg(test)]
impl Winners<'_> {
    /// Of every answered column the index of the winner, its sum, those before and after it, and the index
    /// that wins at the right pixel that the winner points at.
    pub fn columns(&self, layout: &Layout) -> Vec<[u16; 5]> {
        let column = |x: usize| {
            let place = layout.place(x);
            let k = self.index[place];
            let apart = layout.shift(usize::from(k));
            let is_last = usize::from(k) + 1 == layout.tried();
            let after = if is_last { OUT } else { self.after[place] };
            let opposite = self.right_index[self.right_places[x + apart] as usize];
            [k, self.least[place], self.before[place], after, opposite]
        };
        (0..layout.answered()).map(column).collect()
    }
}

/// The memory of the kernel: sums of a band of rows, in stripes.
#[derive(Debug, Default)]
pub(crate) struct Sad {
    /// `V`: of disparities that are compared together vector beside vector, and [`BEFORE`] the first ones;
    /// after the last a vector more.
    pub(super) columns: Aligned<u8>,
    /// `C` of the disparities that are compared together, [`OUT`] or more where one cannot be tried: of the last
    /// of them in all vectors, after that before the first, and of the others in as many vectors as there are.
    pub(super) last: Aligned<u16>,
    pub(super) recent: Aligned<u16>,
    /// Of the left view the least sums, their indices, and the sums beside them.
    pub(super) least: Aligned<u16>,
    pub(super) index: Aligned<u16>,
    pub(super) before: Aligned<u16>,
    pub(super) after: Aligned<u16>,
    /// Of the right view the least sums and their indices, as its rows lie.
    pub(super) right_least: Aligned<u16>,
    pub(super) right_index: Aligned<u16>,
    /// The places of all right columns that are matched.
    pub(super) right_places: Vec<u32>,
    /// 0 where left columns are outside the image and do not count, as a mask of bits.
    pub(super) inside: Aligned<u8>,
    /// [`OUTSIDE`] where right columns are outside the image, as they lie in a right row after a vector more;
    /// and where that differs from the vector before.
    pub(super) outside: Aligned<u16>,
    pub(super) outside_flips: Aligned<u16>,
    /// [`BEYOND`] where a left column is answered and the one in the vector before is not, or the other way round;
    /// before a row none is.
    pub(super) beyond_flips: Aligned<u16>,
    /// Of what layout these tables are.
    prepared_for: Option<Layout>,
}

impl Sad {
    /// What won in the row that was matched last.
    pub fn winners(&self) -> Winners<'_> {
        Winners {
            index: &self.index,
            least: &self.least,
            before: &self.before,
            after: &self.after,
            right_index: &self.right_index,
            right_places: &self.right_places,
        }
    }

    /// The memory for a search space.
    pub fn bytes(layout: &Layout) -> usize {
        let (left, right) = (layout.left(), layout.right());
        let sums = BEFORE + layout.count() * left + LANES + left;
        let costs = left + LANES + RECENT;
        let rows = 5 * left + 4 * right + LANES;
        let tables = size_of::<u32>() * (layout.answered() + layout.count());
        sums + size_of::<u16>() * (costs + rows) + tables + 13 * LINE
    }

    /// Begins a band of rows with an empty window.
    pub fn begin(&mut self, layout: &Layout) {
        let (left, right) = (layout.left(), layout.right());
        self.columns.refill(BEFORE + layout.count() * left + LANES, 0);
        self.last.refill(left + LANES, OUT);
        self.recent.refill(RECENT, OUT);
        for row in [&mut self.least, &mut self.index, &mut self.before, &mut self.after] {
            row.refill(left, 0);
        }
        for row in [&mut self.right_least, &mut self.right_index] {
            row.refill(right, 0);
        }
        // The rest is the same for every band and frame of a size.
        if self.prepared_for.replace(*layout) == Some(*layout) {
            return;
        }
        self.inside.refill(left, 0);
        for (mask, place) in self.inside.iter_mut().zip(0..) {
            *mask = if layout.is_inside(layout.column_of_byte(place)) { u8::MAX } else { 0 };
        }
        self.outside.refill(right + LANES, 0);
        for (sample, place) in self.outside.iter_mut().zip(0..) {
            *sample = if layout.is_match_inside(place) { 0 } else { OUTSIDE };
        }
        self.outside_flips.refill(right, 0);
        for (flip, pair) in self.outside_flips.iter_mut().zip(self.outside.windows(LANES + 1)) {
            *flip = pair[0] ^ pair[LANES];
        }
        self.beyond_flips.refill(left, 0);
        for (flip, place) in self.beyond_flips.iter_mut().zip(0..) {
            let changes = layout.is_answered(place) != layout.is_answered(place + LANES);
            *flip = if changes { BEYOND } else { 0 };
        }
        self.right_places.clear();
        let rights = layout.answered() + layout.count() - 1;
        self.right_places.extend((0..rights).map(|x| layout.right_place(x) as u32));
    }
}
