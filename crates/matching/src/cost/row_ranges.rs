//! How far the disparities of each row reach.

use super::SearchSpace;

/// How many disparities of a search space are tried in each of its rows, from the smallest on.
#[derive(Debug, Default)]
pub(crate) struct RowRanges {
    /// Without any, all are tried everywhere.
    counts: Vec<usize>,
}

impl RowRanges {
    /// All disparities are tried everywhere.
    pub fn widen(&mut self) {
        self.counts.clear();
    }

    /// So many disparities are tried in each row.
    pub fn set(&mut self, counts: impl Iterator<Item = usize>) {
        self.counts.clear();
        self.counts.extend(counts);
    }

    /// What there is to search in row `y`.
    pub fn of_row(&self, space: &SearchSpace, y: usize) -> SearchSpace {
        self.counts.get(y).map_or(*space, |&count| space.up_to(count))
    }

    /// How many pairs of a column and a disparity are tried in so many rows.
    pub fn pairs(&self, space: &SearchSpace, rows: usize) -> usize {
        if self.counts.is_empty() {
            return rows * space.pairs();
        }
        let alike = self.counts[..rows].chunk_by(|one, next| one == next);
        alike.map(|rows| rows.len() * space.up_to(rows[0]).pairs()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::{BoundingBox, DisparityRange};

    #[test]
    fn rows_are_searched_as_far_as_they_reach_and_never_beyond_the_range() {
        let bounds = BoundingBox::new(0, 0, 99, 3).unwrap();
        let space = SearchSpace::new(100, bounds, DisparityRange::new(-5, 69).unwrap());
        let mut ranges = RowRanges::default();
        assert_eq!(ranges.of_row(&space, 3), space);
        assert_eq!(ranges.pairs(&space, 4), 4 * space.pairs());
        ranges.set([32, 32, 500, 64].into_iter());
        let counts = [0, 1, 2, 3].map(|y| {
            let row = ranges.of_row(&space, y);
            (row.min, row.count, row.lanes)
        });
        assert_eq!(counts, [(-5, 32, 32), (-5, 32, 32), (-5, 75, 96), (-5, 64, 64)]);
        let pairs = (0..4).map(|y| ranges.of_row(&space, y).pairs()).sum::<usize>();
        assert_eq!(ranges.pairs(&space, 4), pairs);
        ranges.widen();
        assert_eq!(ranges.of_row(&space, 0), space);
    }
}
