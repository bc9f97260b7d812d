//! Absolute differences of the filtered images: `A(x, y, d) = |L(x, y) - R(x - d, y)|`.
//!
//! The differences themselves are taken inside [`crate::kernels::sad`], which sums them up on the
//! spot. Here are the rows that it takes them of: filtered, and the right one reversed, so that the
//! right samples of rising disparities follow each other in memory. Right columns beyond the image
//! repeat its border; they only ever support a match whose centre lies inside.
//!
//! A window that slides down needs the row that enters and the one that leaves: filtered rows are
//! kept in a ring that is just long enough, and so stay in the first-level cache.

use crate::cost::SearchSpace;
use crate::kernels::level::Level;
use crate::kernels::sad::{LARGEST_DIFFERENCE, RADIUS, RowPair};
use crate::prepare::grey::GreyView;
use crate::prepare::prefilter::{LARGEST_CLIP, Smoothed, clipped_gradient};

/// The gradient is clipped to plus and minus this.
const CLIP: u8 = LARGEST_DIFFERENCE / 2;
const _: () = assert!(CLIP <= LARGEST_CLIP);
/// Rows in the ring: a window and the row that leaves it.
const KEPT: usize = 2 * RADIUS + 2;

/// Writes `right[top], right[top - 1], ...` to `out`; columns beyond the row repeat its border.
pub(crate) fn reverse_row(right: &[u8], top: i64, out: &mut [u8]) {
    let last = right.len() as i64 - 1;
    // Places before `first` lie beyond the row's end, places from `end` on before its start.
    let first = (top - last).clamp(0, out.len() as i64) as usize;
    let end = (top + 1).clamp(first as i64, out.len() as i64) as usize;
    out[..first].fill(right[last as usize]);
    if first < end {
        let from = &right[(top - end as i64 + 1) as usize..=(top - first as i64) as usize];
        for (sample, &from) in out[first..end].iter_mut().zip(from.iter().rev()) {
            *sample = from;
        }
    }
    out[end..].fill(right[0]);
}

/// The filtered rows around a sliding window.
#[derive(Debug, Default)]
pub(crate) struct FilteredRows {
    smoothed: Smoothed,
    whole: Vec<u8>,
    left: Vec<u8>,
    reversed: Vec<u8>,
    /// A row above or below the image.
    nothing: Vec<u8>,
    supporting: (usize, usize),
}

impl FilteredRows {
    /// Makes room for the rows of a search space.
    pub fn begin(&mut self, space: &SearchSpace) {
        let (first, last) = supporting_columns(space);
        self.supporting = (first, last);
        let columns = last - first + 1;
        self.whole.resize(space.width, 0);
        self.left.resize(KEPT * columns, 0);
        self.reversed.resize(KEPT * (columns + space.lanes), 0);
        self.nothing.clear();
        self.nothing.resize(columns + space.lanes, 0);
    }

    fn columns(&self) -> usize {
        self.supporting.1 - self.supporting.0 + 1
    }

    /// Filters row `y` of both images into the ring.
    pub fn load(&mut self, level: Level, images: [GreyView<'_>; 2], space: &SearchSpace, y: usize) {
        let ((first, last), columns, slot) = (self.supporting, self.columns(), y % KEPT);
        let (whole, smoothed) = (&mut self.whole[..], &mut self.smoothed);
        clipped_gradient(level, images[0], y, CLIP, smoothed, whole);
        self.left[slot * columns..][..columns].copy_from_slice(&whole[first..=last]);
        clipped_gradient(level, images[1], y, CLIP, smoothed, whole);
        let stride = columns + space.lanes;
        let top = last as i64 - i64::from(space.min);
        reverse_row(whole, top, &mut self.reversed[slot * stride..][..stride]);
    }

    /// Row `y`, which was among the last loaded.
    pub fn row(&self, y: usize) -> RowPair<'_> {
        let (columns, stride) = (self.columns(), self.nothing.len());
        let slot = y % KEPT;
        RowPair {
            left: &self.left[slot * columns..][..columns],
            reversed: &self.reversed[slot * stride..][..stride],
        }
    }

    /// A row outside the image: it adds nothing to any sum.
    pub fn nothing(&self) -> RowPair<'_> {
        RowPair { left: &self.nothing[..self.columns()], reversed: &self.nothing }
    }
}

/// First and last left column in the windows around the answered columns.
pub(crate) fn supporting_columns(space: &SearchSpace) -> (usize, usize) {
    (space.first.saturating_sub(RADIUS), (space.last + RADIUS).min(space.width - 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::{BoundingBox, DisparityRange, Plane};

    #[test]
    fn a_row_reversed_repeats_its_border() {
        let row = [10, 20, 40];
        for top in -6..9 {
            for length in 0..12 {
                let mut reversed = vec![0; length];
                reverse_row(&row, top, &mut reversed);
                let expected: Vec<u8> =
                    (0..length as i64).map(|j| row[(top - j).clamp(0, 2) as usize]).collect();
                assert_eq!(reversed, expected, "from {top}, {length} samples");
            }
        }
    }

    #[test]
    fn a_right_sample_stands_where_its_disparity_says() {
        let left = Plane::from_fn(40, 12, |x, y| (x * x * 3 + y * 31) as u8);
        let right = Plane::from_fn(40, 12, |x, y| (x * 29 + y * y * 5) as u8);
        let images = [&left, &right].map(|image| GreyView::Depth8(image.view()));
        let range = DisparityRange::new(-3, 9).unwrap();
        let space = SearchSpace::new(40, BoundingBox::new(6, 0, 20, 11).unwrap(), range);
        let (level, mut rows) = (Level::detect(), FilteredRows::default());
        rows.begin(&space);
        let whole = |image: GreyView<'_>, y: usize| {
            let mut row = vec![0; 40];
            clipped_gradient(level, image, y, CLIP, &mut Smoothed::default(), &mut row);
            row
        };
        for y in 0..12 {
            rows.load(level, images, &space, y);
            // The oldest row that is still kept.
            let y = y.saturating_sub(KEPT - 1);
            let (left, right) = (whole(images[0], y), whole(images[1], y));
            let pair = rows.row(y);
            let last = pair.left.len() - 1;
            for (c, &sample) in pair.left.iter().enumerate() {
                let x = c + 6 - RADIUS;
                assert_eq!(sample, left[x]);
                for k in 0..space.count {
                    let match_at = (x as i64 + 3 - k as i64).clamp(0, 39) as usize;
                    assert_eq!(pair.reversed[last - c + k], right[match_at]);
                }
            }
        }
    }
}
