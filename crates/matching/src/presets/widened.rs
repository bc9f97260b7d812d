//! Of narrow boxes more is matched than is asked for.

use raster::{BoundingBox, DisparityRange};

/// The box with the columns of two ranges at the least, where images of a width have them: what the right pixel shows
/// that a left one meets may stand a range away from that, and for want of it a narrow box would confirm what lies
/// outside the right image. That is at its left end where disparities are above zero, and the rightful partners stand
/// to the right then; where disparities are below zero it is the other way.
pub(super) fn widened(bounds: BoundingBox, range: DisparityRange, width: usize) -> BoundingBox {
    let BoundingBox { x0, x1, .. } = bounds;
    let columns = 2 * (range.count() - 1);
    BoundingBox {
        x0: if range.min() < 0 { x0.min(x1.saturating_sub(columns)) } else { x0 },
        x1: if range.max() > 0 { x1.max((x0 + columns).min(width - 1)) } else { x1 },
        ..bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_grows_to_where_partners_may_stand() {
        let grown = |x0: usize, x1: usize, min: i32, max: i32| {
            let bounds = BoundingBox::new(x0, 3, x1, 4).unwrap();
            let BoundingBox { x0, y0, x1, y1 } =
                widened(bounds, DisparityRange::new(min, max).unwrap(), 100);
            assert_eq!((y0, y1), (3, 4));
            (x0, x1)
        };
        assert_eq!(grown(10, 12, 0, 20), (10, 50));
        assert_eq!(grown(85, 90, 0, 20), (85, 99));
        assert_eq!(grown(85, 90, -20, 0), (50, 90));
        assert_eq!(grown(5, 9, -20, -10), (0, 9));
        assert_eq!(grown(50, 52, -5, 5), (32, 70));
        for (min, max) in [(0, 20), (-20, 0), (-10, 10), (0, 0)] {
            assert_eq!(grown(20, 80, min, max), (20, 80));
        }
    }
}
