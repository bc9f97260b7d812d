//! How badly left `(x, y)` and right `(x - d, y)` fit, per disparity `d`.
//!
//! | file | cost | in | out |
//! | --- | --- | --- | --- |
//! | `absolute_difference` | absolute difference of prefiltered grey (`fast`) | rows of both images | a byte per disparity and column |
//! | `census_gradient` | Hamming distance of census words, truncated difference of grey steps, distance of descriptors (`balanced`, `best`) | words and steps of both images | per column a byte for each disparity in turn |
//!
//! Disparities count from the smallest that is tried anywhere ([`SearchSpace`]); what is not tried at a column has the
//! largest cost.

pub(crate) mod absolute_difference;
pub(crate) mod census_gradient;

use std::ops::Range;

use raster::{BoundingBox, DisparityRange};

use crate::kernels::path::padded;

/// The columns of the left image that are matched, and the disparities that can be tried there.
///
/// A disparity is tried at a column when its match lies inside the right image. Disparities that
/// are tried nowhere are left out, so that a range far wider than the image costs nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SearchSpace {
    /// Columns of either image.
    pub width: usize,
    /// First column that is matched.
    pub first: usize,
    /// Last column that is matched.
    pub last: usize,
    /// Columns of the image from one to the next: 1 or 2. Of 2 a column stands for itself and the next.
    pub apart: usize,
    /// The smallest disparity that is tried anywhere.
    pub min: i32,
    /// How many disparities are tried, from `min` upwards; 0 when no match can lie inside.
    pub count: usize,
    /// `count` in whole groups ([`padded`]): costs from one column to the next.
    pub lanes: usize,
}

impl SearchSpace {
    /// What there is to search for all columns of a box in an image of `width` columns.
    pub fn new(width: usize, bounds: BoundingBox, range: DisparityRange) -> Self {
        Self::of_every(1, width, bounds, range)
    }

    /// The same for every so many-th column.
    pub fn of_every(
        apart: usize,
        width: usize,
        bounds: BoundingBox,
        range: DisparityRange,
    ) -> Self {
        let first = bounds.x0;
        let last = first + (bounds.x1 - first) / apart * apart;
        // Left columns first ..= last meet right columns 0 ..= width - 1.
        let min = i64::from(range.min()).max(first as i64 - (width as i64 - 1));
        let max = i64::from(range.max()).min(last as i64);
        let count = (max - min + 1).max(0) as usize;
        Self { width, first, last, apart, min: min as i32, count, lanes: padded(count) }
    }

    /// How many columns are matched.
    pub fn columns(&self) -> usize {
        (self.last - self.first) / self.apart + 1
    }

    /// Where one of them lies in the image.
    pub fn in_image(&self, column: usize) -> usize {
        self.first + self.apart * column
    }

    /// Which disparities, counted from `min`, are tried at left column `x`.
    pub fn candidates(&self, x: usize) -> Range<usize> {
        let [lowest, highest] = self.ends(x as i32);
        lowest as usize..(highest + 1).max(lowest) as usize
    }

    /// The first and the last of them; where there are none the last lies below the first. In numbers of 32
    /// bits, so that many columns are reckoned with together.
    #[inline(always)]
    pub fn ends(&self, x: i32) -> [i32; 2] {
        let farthest = x - self.min;
        let lowest = (farthest - (self.width as i32 - 1)).max(0);
        [lowest, farthest.min(self.count as i32 - 1)]
    }

    /// How many pairs of a column and a disparity are tried in a row.
    pub fn pairs(&self) -> usize {
        (0..self.columns()).map(|x| self.candidates(self.in_image(x)).len()).sum()
    }

    /// Where left column `x` meets the right image at disparity `min`, if that stands in a mirror:
    /// there larger disparities lie at larger columns. May lie outside the image.
    pub fn mirrored(&self, x: usize) -> i64 {
        (self.width - 1) as i64 - x as i64 + i64::from(self.min)
    }
}

/// The rows of an image that are matched: of a part of it all, or every second one, which then stands for
/// itself and the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct MatchedRows {
    /// The first one.
    pub top: usize,
    pub count: usize,
    /// Rows of the image from one to the next: 1 or 2.
    pub apart: usize,
}

impl MatchedRows {
    /// Every so many-th of the rows of a part of an image.
    pub fn of(part: BoundingBox, apart: usize) -> Self {
        Self { top: part.y0, count: part.rows().div_ceil(apart), apart }
    }

    /// Where one of them lies in the image.
    pub fn in_image(&self, row: usize) -> usize {
        self.top + self.apart * row
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_matched_from_the_first_on() {
        let part = BoundingBox::new(2, 5, 3, 9).unwrap();
        let rows = |apart| {
            let rows = MatchedRows::of(part, apart);
            (0..rows.count).map(|row| rows.in_image(row)).collect::<Vec<_>>()
        };
        assert_eq!(rows(1), [5, 6, 7, 8, 9]);
        assert_eq!(rows(2), [5, 7, 9]);
    }

    fn space(width: usize, columns: (usize, usize), range: (i32, i32)) -> SearchSpace {
        let bounds = BoundingBox::new(columns.0, 0, columns.1, 0).unwrap();
        SearchSpace::new(width, bounds, DisparityRange::new(range.0, range.1).unwrap())
    }

    #[test]
    fn candidates_are_all_disparities_whose_match_lies_inside() {
        for (columns, range) in
            [((0, 9), (0, 5)), ((0, 9), (-4, 3)), ((3, 4), (-500, 500)), ((0, 9), (8, 40))]
        {
            let space = space(10, columns, range);
            for x in columns.0..=columns.1 {
                let expected: Vec<i32> =
                    (range.0..=range.1).filter(|d| (0..10).contains(&(x as i32 - d))).collect();
                let found: Vec<i32> =
                    space.candidates(x).map(|index| space.min + index as i32).collect();
                assert_eq!(found, expected, "column {x} of {columns:?}, range {range:?}");
            }
        }
    }

    #[test]
    fn a_range_wider_than_the_image_costs_no_more_than_the_image() {
        assert_eq!(space(10, (0, 9), (-1000, 1000)).count, 19);
        assert_eq!(space(10, (0, 9), (10, 1000)).count, 0);
        assert_eq!(space(10, (0, 9), (-1000, -10)).count, 0);
    }
}
