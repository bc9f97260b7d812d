//! How the columns of a row lie in memory where neighbours are to stand in vectors that follow each other.
//!
//! A row is cut into [`LANES`] stripes of equal length, and lane `l` of vector `j` is column `j` of stripe
//! `l`. The neighbours of a whole vector's columns are then the vectors before and after it: sums along a
//! row are additions of vectors that begin where a cache line does, and nothing moves from lane to lane. What
//! comes after the last vector is the first one, moved by a lane.
//!
//! Rows of the right image begin as many columns earlier as there are disparities. They have a vector for each
//! column of a stripe and for each of these, so that what a disparity compares is so many vectors away, never
//! a lane: most columns stand there several times.

use std::ops::Range;

use crate::cost::SearchSpace;
use crate::kernels::level::at_every_level;
use crate::kernels::sad::{RADIUS, TOGETHER};

/// Columns of a vector.
pub(crate) const LANES: usize = 64;

/// So many neighbours go between stripes and a row at once.
const NEIGHBOURS: usize = 4;

/// Columns of a window but the last.
const BEFORE_LAST: usize = 2 * RADIUS;

/// The layout of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Columns of a stripe.
    stripe: usize,
    /// Where the vectors begin that the windows of the first vector see, but the last of them.
    first_vectors: [usize; BEFORE_LAST],
    /// Columns that are answered.
    answered: usize,
    /// Disparities that are tried, and as many rounded up to whole groups of those compared together.
    tried: usize,
    count: usize,
    /// Columns inside the image, as far as windows reach, of those that windows see.
    inside: (usize, usize),
    /// The first column of the right image that is looked at, and how many it has.
    right_first: i64,
    width: usize,
}

impl Layout {
    /// The layout of a search space.
    pub fn new(space: &SearchSpace) -> Self {
        let seen = space.columns() + 2 * RADIUS;
        // Of two columns at least, so that a vector a lane further on can be read while that a
        // stripe further on is written.
        let stripe = seen.div_ceil(LANES).max(2);
        let end = (space.width - space.first).min(space.columns() + RADIUS) + RADIUS;
        let count = space.count.next_multiple_of(TOGETHER);
        let right_first = space.first as i64 - i64::from(space.min) - (count as i64 - 1);
        let layout = Self {
            stripe,
            first_vectors: [0; BEFORE_LAST],
            answered: space.columns(),
            tried: space.count,
            count,
            inside: (RADIUS.saturating_sub(space.first), end),
            right_first,
            width: space.width,
        };
        Self { first_vectors: std::array::from_fn(|column| layout.place(column)), ..layout }
    }

    /// Columns that are answered.
    pub fn answered(&self) -> usize {
        self.answered
    }

    /// Disparities that are tried.
    pub fn tried(&self) -> usize {
        self.tried
    }

    /// As many, rounded up to whole groups of those that are compared together.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Columns of a stripe, as many as a row has vectors.
    pub fn stripe(&self) -> usize {
        self.stripe
    }

    /// Samples of a row of the left image: column `c` of it is `first - RADIUS + c`.
    pub fn left(&self) -> usize {
        self.stripe * LANES
    }

    /// Samples of a row of the right image.
    pub fn right(&self) -> usize {
        (self.stripe + self.count - 1) * LANES
    }

    /// How many vectors of a right row vector `j` and that which it is compared with at index `k` are apart.
    pub fn shift(&self, k: usize) -> usize {
        self.count - 1 - k
    }

    /// Where a column lies, and so where the vector of that number begins: what comes after the last one is the
    /// first, moved by a lane.
    #[inline(always)]
    pub fn place(&self, column: usize) -> usize {
        column % self.stripe * LANES + column / self.stripe
    }

    /// The column that lies there.
    pub fn column(&self, place: usize) -> usize {
        place % LANES * self.stripe + place / LANES
    }

    /// Where the vectors begin that the windows of the first vector see, but the last of them.
    pub fn first_vectors(&self) -> [usize; BEFORE_LAST] {
        self.first_vectors
    }

    /// Vectors, and where the last vector begins that the window of the first of them sees; those of the
    /// others follow.
    #[inline(always)]
    pub fn windows_ends(&self) -> impl Iterator<Item = (Range<usize>, usize)> {
        let stripe = self.stripe;
        let mut j = 0;
        std::iter::from_fn(move || {
            let end = j + 2 * RADIUS;
            let range = j..stripe.min(j + stripe - end % stripe);
            j = range.end;
            (!range.is_empty()).then(|| (range, self.place(end)))
        })
    }

    /// Whether a column that windows see is inside the left image, or supports none of its columns.
    pub fn is_inside(&self, column: usize) -> bool {
        (self.inside.0..self.inside.1).contains(&column)
    }

    /// Whether a column of the right image exists that stands in so many columns from the first of a right row on.
    pub fn is_match_inside(&self, column: usize) -> bool {
        (0..self.width as i64).contains(&(self.right_first + column as i64))
    }

    /// Puts what lies in the places of a left row in the order of the columns, four neighbours at once.
    #[inline(always)]
    pub fn gather(&self, row: &[u8], columns: &mut [u8]) {
        let vectors: &[[u8; LANES]] = row.as_chunks().0;
        let stripes = columns.chunks_exact_mut(self.stripe).take(LANES);
        let Some(last) = self.stripe.checked_sub(NEIGHBOURS) else {
            for (lane, stripe) in stripes.enumerate() {
                for (column, vector) in stripe.iter_mut().zip(vectors) {
                    *column = vector[lane];
                }
            }
            return;
        };
        for j in (0..self.stripe).step_by(NEIGHBOURS) {
            // Those at the end are some of the ones before once more.
            let j = j.min(last);
            let neighbours = by_lanes(vectors[j..].first_chunk().expect("not after the last"));
            let stripes = columns.chunks_exact_mut(self.stripe);
            for (stripe, neighbours) in stripes.zip(&neighbours) {
                stripe[j..j + NEIGHBOURS].copy_from_slice(neighbours);
            }
        }
    }
}

at_every_level! {
    /// Puts the first columns in the places of a left row.
    pub(crate) fn spread_left(layout: &Layout, columns: &[u8], row: &mut [u8]) {
        spread(layout, columns, row);
    }

    /// The same of a right row, from its columns from the first on.
    pub(crate) fn spread_right(layout: &Layout, columns: &[u8], row: &mut [u8]) {
        let length = layout.left();
        spread(layout, columns, &mut row[..length]);
        for at in (length..row.len()).step_by(LANES) {
            // A stripe further on lies what is in the next lane.
            let next: [u8; LANES] = *row[at + 1 - length..].first_chunk().expect("before here");
            row[at..at + LANES].copy_from_slice(&next);
            row[at + LANES - 1] = columns[(LANES - 1) * layout.stripe + at / LANES];
        }
    }
}

/// Puts the first columns in the places of a left row, four neighbours at once.
#[inline(always)]
fn spread(layout: &Layout, columns: &[u8], row: &mut [u8]) {
    let vectors: &mut [[u8; LANES]] = row.as_chunks_mut().0;
    let stripes = columns.chunks_exact(layout.stripe).take(LANES);
    let Some(last) = layout.stripe.checked_sub(NEIGHBOURS) else {
        for (lane, stripe) in stripes.enumerate() {
            for (vector, &column) in vectors.iter_mut().zip(stripe) {
                vector[lane] = column;
            }
        }
        return;
    };
    for j in (0..layout.stripe).step_by(NEIGHBOURS) {
        // Those at the end are some of the ones before once more.
        let j = j.min(last);
        let mut neighbours = [0; LANES];
        for (neighbours, stripe) in neighbours.iter_mut().zip(stripes.clone()) {
            let stripe = stripe[j..].first_chunk().expect("not after the last");
            *neighbours = u32::from_le_bytes(*stripe);
        }
        for (n, vector) in (0..).zip(&mut vectors[j..j + NEIGHBOURS]) {
            for l in 0..LANES {
                vector[l] = (neighbours[l] >> (n * u8::BITS)) as u8;
            }
        }
    }
}

/// Of vectors that follow each other the neighbours in each lane.
#[inline(always)]
fn by_lanes(vectors: &[[u8; LANES]; NEIGHBOURS]) -> [[u8; NEIGHBOURS]; LANES] {
    let mut neighbours = [[0; NEIGHBOURS]; LANES];
    for l in 0..LANES {
        for n in 0..NEIGHBOURS {
            neighbours[l][n] = vectors[n][l];
        }
    }
    neighbours
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::level::Level;
    use raster::{BoundingBox, DisparityRange};

    fn layout(columns: usize, range: (i32, i32)) -> Layout {
        let range = DisparityRange::new(range.0, range.1).unwrap();
        Layout::new(&SearchSpace::new(columns, BoundingBox::whole(columns, 1), range))
    }

    #[test]
    fn neighbours_are_in_vectors_that_follow_each_other() {
        // 130 columns and four to each side: 64 stripes of three.
        let layout = layout(130, (0, 20));
        assert_eq!((layout.left(), layout.right()), (3 * LANES, (3 + 23) * LANES));
        assert_eq!([0, 1, 2, 3].map(|column| layout.place(column)), [0, LANES, 2 * LANES, 1]);
        for place in 0..layout.left() {
            assert_eq!(layout.place(layout.column(place)), place);
        }
    }

    #[test]
    fn every_window_ends_where_its_last_column_lies() {
        for columns in [1, 57, 130, 500, 505, 600] {
            let layout = layout(columns, (0, 0));
            let mut all = 0;
            for (range, enters) in layout.windows_ends() {
                assert_eq!(range.start, all);
                for (i, vector) in range.clone().enumerate() {
                    // The first lane tells of all.
                    assert_eq!(enters + i * LANES, layout.place(vector + 2 * RADIUS));
                }
                all = range.end;
            }
            assert_eq!(all * LANES, layout.left());
        }
    }

    #[test]
    fn a_row_is_spread_and_gathered_again() {
        for columns in [1, 57, 130, 180, 249, 500, 600] {
            let layout = layout(columns, (0, 0));
            let line: Vec<u8> = (0..layout.left()).map(|i| (i * 37 % 251) as u8).collect();
            for level in Level::available() {
                let [mut row, mut gathered] = [(); 2].map(|()| vec![0; layout.left()]);
                spread_left(level, &layout, &line, &mut row);
                for (column, sample) in line.iter().enumerate() {
                    assert_eq!(row[layout.place(column)], *sample, "{columns} columns, {level:?}");
                }
                layout.gather(&row, &mut gathered);
                assert_eq!(gathered, line, "{columns} columns, {level:?}");
            }
        }
    }

    #[test]
    fn a_right_row_has_what_is_compared_in_the_same_lane() {
        let (columns, range) = (200, (-3, 11));
        let layout = layout(columns, range);
        let line: Vec<u8> =
            (0..layout.left() + layout.count() - 1).map(|i| (i * 37 % 251) as u8).collect();
        for level in Level::available() {
            let mut row = vec![0; layout.right()];
            spread_right(level, &layout, &line, &mut row);
            for (vector, lanes) in row.as_chunks::<LANES>().0.iter().enumerate() {
                for (lane, &sample) in lanes.iter().enumerate() {
                    assert_eq!(sample, line[vector + lane * layout.left() / LANES], "{level:?}");
                }
            }
        }
    }
}
