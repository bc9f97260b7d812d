//! A fixed square window, by running sums.
//!
//! `C(x, y, d) = sum of |L(x', y') - R(x' - d, y')| over |x' - x| <= r, |y' - y| <= r`, of whose columns
//! whole fours count, up to a bound ([`crate::kernels::sad`]), the window
//! clipped at the image's border: all disparities of a pixel are compared over the same left
//! pixels, so nothing needs to be normalised.
//!
//! From one row to the next one row enters the window and one leaves it, so a pixel and disparity
//! cost a handful of operations, not one for each pixel of the window (McDonnell, *Box-Filtering
//! Techniques*, 1981). [`crate::kernels::sad`] does the sums and finds
//! the winners while they are at hand; here the window is led down a band of rows.
//!
//! In: grey images. Out: the winners of one row after the other. Rows above the band are summed up
//! anew, so bands of any height give the same winners.

use crate::cost::SearchSpace;
use crate::cost::absolute_difference::FilteredRows;
use crate::kernels::level::Level;
use crate::kernels::sad::{RADIUS, Sad, Winners, match_row, slide_down};
use crate::kernels::stripes::Layout;
use crate::prepare::grey::GreyView;

/// A window that slides down the rows of two images, with its memory.
#[derive(Debug, Default)]
pub(crate) struct SlidingWindow {
    rows: FilteredRows,
    sums: Sad,
}

impl SlidingWindow {
    /// The memory for a search space.
    pub fn bytes(space: &SearchSpace) -> usize {
        let layout = Layout::new(space);
        FilteredRows::bytes(space, &layout) + Sad::bytes(&layout)
    }

    /// Gives the winners of rows `first ..` to `each`, `count` rows in turn. The images are `height`
    /// rows high.
    pub fn slide(
        &mut self,
        level: Level,
        images: [GreyView<'_>; 2],
        space: &SearchSpace,
        height: usize,
        (first, count): (usize, usize),
        mut each: impl FnMut(usize, &Winners, &Layout),
    ) {
        let Self { rows, sums } = self;
        let layout = Layout::new(space);
        rows.begin(space, &layout);
        sums.begin(&layout);
        let top = first.saturating_sub(RADIUS);
        for y in top..(first + RADIUS).min(height) {
            rows.load(level, images, space, &layout, y);
            slide_down(level, sums, &layout, rows.row(&layout, y), rows.nothing(&layout));
        }
        for y in first..first + count {
            let below = y + RADIUS;
            if below < height {
                rows.load(level, images, space, &layout, below);
            }
            let row = |y: usize, there: bool| {
                if there { rows.row(&layout, y) } else { rows.nothing(&layout) }
            };
            let entering = row(below, below < height);
            let leaving = row(y.saturating_sub(RADIUS + 1), y > top + RADIUS);
            match_row(level, sums, &layout, entering, leaving);
            each(y - first, sums.winners(), &layout);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::{BoundingBox, DisparityRange, Plane};

    #[test]
    fn bands_of_any_height_give_the_same_winners() {
        let scramble = |x: usize, y: usize| (x * 7919 + y * 104_729 + x * x * y * 31) as u8;
        let left = Plane::from_fn(50, 23, scramble);
        let right = Plane::from_fn(50, 23, |x, y| scramble(x + 5, y));
        let images = [&left, &right].map(|image| GreyView::Depth8(image.view()));
        let range = DisparityRange::new(0, 20).unwrap();
        let space = SearchSpace::new(50, BoundingBox::new(3, 2, 48, 21).unwrap(), range);
        let winners = |height: usize| {
            let mut window = SlidingWindow::default();
            let mut all = Vec::new();
            for first in (2..=21).step_by(height) {
                let rows = (first, height.min(22 - first));
                window.slide(Level::detect(), images, &space, 23, rows, |row, winners, layout| {
                    all.push((first + row, winners.columns(layout)));
                });
            }
            all
        };
        let whole = winners(20);
        for height in 1..20 {
            assert!(winners(height) == whole, "bands of {height}");
        }
        // Away from the border, where the window finds what the right image was shifted by.
        let (y, row) = &whole[8];
        assert_eq!((*y, row[20][0], row[20][1]), (10, 5, 0));
    }
}
