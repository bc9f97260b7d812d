//! Absolute differences of the filtered images: `A(x, y, d) = |L(x, y) - R(x - d, y)|`.
//!
//! The differences themselves are taken inside [`crate::kernels::sad`], which sums them up on the
//! spot. Here are the rows that it takes them of: filtered, with room on both sides for windows and
//! disparities that leave the image. There the border is repeated: right samples beyond it only
//! ever support a match whose centre lies inside, left ones are not counted.
//!
//! A window that slides down needs the row that enters and the one that leaves: filtered rows are
//! kept in a ring that is just long enough, and so stay in the first-level cache.

use crate::cost::SearchSpace;
use crate::kernels::aligned::{Aligned, LINE};
use crate::kernels::border::repeat_border;
use crate::kernels::level::Level;
use crate::kernels::sad::{LARGEST_DIFFERENCE, RADIUS, RowPair};
use crate::kernels::stripes::{Layout, spread_left, spread_right};
use crate::prepare::grey::GreyView;
use crate::prepare::prefilter::{LARGEST_CLIP, Smoothed, clipped_gradient};

/// The gradient is clipped to plus and minus this.
const CLIP: u8 = LARGEST_DIFFERENCE / 2;
const _: () = assert!(CLIP <= LARGEST_CLIP);
/// Rows in the ring: a window and the row that leaves it.
const KEPT: usize = 2 * RADIUS + 2;

/// The filtered rows around a sliding window.
#[derive(Debug, Default)]
pub(crate) struct FilteredRows {
    smoothed: Smoothed,
    whole: Vec<u8>,
    /// A row with its border repeated.
    extended: Vec<u8>,
    left: Aligned<u8>,
    right: Aligned<u8>,
    /// A row above or below the image.
    nothing: Aligned<u8>,
}

impl FilteredRows {
    /// The memory for the rows of a search space.
    pub fn bytes(space: &SearchSpace, layout: &Layout) -> usize {
        // A row as it is and, at 16 bits, smoothed; extended; the ring; a row outside.
        (1 + size_of::<u32>()) * space.width
            + layout.left()
            + layout.count()
            + KEPT * (layout.left() + layout.right())
            + layout.right()
            + 3 * LINE
    }

    /// Makes room for the rows of a search space.
    pub fn begin(&mut self, space: &SearchSpace, layout: &Layout) {
        self.whole.resize(space.width, 0);
        self.extended.resize(layout.left() + layout.count() - 1, 0);
        self.left.refill(KEPT * layout.left(), 0);
        self.right.refill(KEPT * layout.right(), 0);
        self.nothing.refill(layout.right(), 0);
    }

    /// Filters row `y` of both images into the ring.
    pub fn load(
        &mut self,
        level: Level,
        images: [GreyView<'_>; 2],
        space: &SearchSpace,
        layout: &Layout,
        y: usize,
    ) {
        let Self { smoothed, whole, extended, left, right, .. } = self;
        let slot = y % KEPT;
        let first = space.first as i64 - RADIUS as i64;
        let largest = i64::from(space.min) + layout.shift(0) as i64;
        clipped_gradient(level, images[0], y, CLIP, smoothed, whole);
        repeat_border(whole, first, &mut extended[..layout.left()]);
        let row = &mut left[slot * layout.left()..][..layout.left()];
        spread_left(level, layout, extended, row);
        clipped_gradient(level, images[1], y, CLIP, smoothed, whole);
        repeat_border(whole, first - largest, extended);
        let row = &mut right[slot * layout.right()..][..layout.right()];
        spread_right(level, layout, extended, row);
    }

    /// Row `y`, which was among the last loaded.
    pub fn row(&self, layout: &Layout, y: usize) -> RowPair<'_> {
        let slot = y % KEPT;
        RowPair {
            left: &self.left[slot * layout.left()..][..layout.left()],
            right: &self.right[slot * layout.right()..][..layout.right()],
        }
    }

    /// A row outside the image: it adds nothing to any sum.
    pub fn nothing(&self, layout: &Layout) -> RowPair<'_> {
        RowPair { left: &self.nothing[..layout.left()], right: &self.nothing }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::stripes::LANES;
    use raster::{BoundingBox, DisparityRange, Plane};

    #[test]
    fn a_right_sample_stands_where_its_disparity_says() {
        let left = Plane::from_fn(40, 12, |x, y| (x * x * 3 + y * 31) as u8);
        let right = Plane::from_fn(40, 12, |x, y| (x * 29 + y * y * 5) as u8);
        let images = [&left, &right].map(|image| GreyView::Depth8(image.view()));
        let range = DisparityRange::new(-3, 9).unwrap();
        let space = SearchSpace::new(40, BoundingBox::new(6, 0, 20, 11).unwrap(), range);
        let layout = Layout::new(&space);
        let (level, mut rows) = (Level::detect(), FilteredRows::default());
        rows.begin(&space, &layout);
        let whole = |image: GreyView<'_>, y: usize| {
            let mut row = vec![0; 40];
            clipped_gradient(level, image, y, CLIP, &mut Smoothed::default(), &mut row);
            row
        };
        for y in 0..12 {
            rows.load(level, images, &space, &layout, y);
            // The oldest row that is still kept.
            let y = y.saturating_sub(KEPT - 1);
            let (left, right) = (whole(images[0], y), whole(images[1], y));
            let pair = rows.row(&layout, y);
            for x in 6 - RADIUS..=20 + RADIUS {
                let place = layout.place(x + RADIUS - 6);
                assert_eq!(pair.left[place], left[x]);
                for k in 0..space.count {
                    let match_at = (x as i64 + 3 - k as i64).clamp(0, 39) as usize;
                    assert_eq!(pair.right[place + layout.shift(k) * LANES], right[match_at]);
                }
            }
        }
    }
}
