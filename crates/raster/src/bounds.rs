//! Where to look: the box of pixels to answer, and the range of disparities to search.

use std::fmt;

/// A rectangle of pixels, **inclusive** on all four sides, in left-image coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct BoundingBox {
    /// First column.
    pub x0: usize,
    /// First row.
    pub y0: usize,
    /// Last column, part of the box.
    pub x1: usize,
    /// Last row, part of the box.
    pub y1: usize,
}

/// The box or the range of disparities makes no sense.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BoundsError {
    /// The box ends before it begins.
    Inverted(BoundingBox),
    /// The box has more columns or rows than can be counted.
    TooLarge(BoundingBox),
    /// The box leaves an image of this many columns and rows.
    Outside(BoundingBox, usize, usize),
    /// The largest disparity is below the smallest.
    EmptyRange(i32, i32),
}

impl fmt::Display for BoundsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Inverted(b) => write!(
                f,
                "the box {b} ends before it begins: give x0,y0,x1,y1 with x0 <= x1 and y0 <= y1"
            ),
            Self::TooLarge(b) => write!(
                f,
                "the box {b} has more columns or rows than can be counted: give x1 and y1 inside \
                 an image"
            ),
            Self::Outside(b, columns, rows) => write!(
                f,
                "the box {b} leaves the image of {columns} x {rows}: its last column may be at \
                 most {} and its last row at most {} (the box is inclusive)",
                columns.saturating_sub(1),
                rows.saturating_sub(1)
            ),
            Self::EmptyRange(min, max) => write!(
                f,
                "the disparity range {min} to {max} is empty: the largest disparity must not be \
                 below the smallest"
            ),
        }
    }
}

impl std::error::Error for BoundsError {}

impl fmt::Display for BoundingBox {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{},{}", self.x0, self.y0, self.x1, self.y1)
    }
}

impl BoundingBox {
    /// The box from `(x0, y0)` to `(x1, y1)`, both part of it. Errors when it ends before it begins, or
    /// has more columns or rows than can be counted.
    pub fn new(x0: usize, y0: usize, x1: usize, y1: usize) -> Result<Self, BoundsError> {
        let this = Self { x0, y0, x1, y1 };
        if x0 > x1 || y0 > y1 {
            Err(BoundsError::Inverted(this))
        } else if x1 - x0 == usize::MAX || y1 - y0 == usize::MAX {
            Err(BoundsError::TooLarge(this))
        } else {
            Ok(this)
        }
    }

    /// All of an image. Panics when the image has no pixel.
    pub fn whole(columns: usize, rows: usize) -> Self {
        assert!(columns > 0 && rows > 0, "an image without pixels has no box");
        Self { x0: 0, y0: 0, x1: columns - 1, y1: rows - 1 }
    }

    /// Errors unless the box is upright and lies inside an image of `columns x rows`.
    pub fn check_within(&self, columns: usize, rows: usize) -> Result<(), BoundsError> {
        if self.x0 > self.x1 || self.y0 > self.y1 {
            Err(BoundsError::Inverted(*self))
        } else if self.x1 >= columns || self.y1 >= rows {
            Err(BoundsError::Outside(*self, columns, rows))
        } else {
            Ok(())
        }
    }

    /// Its pixels `(x, y)`, row after row.
    pub fn pixels(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let Self { x0, y0, x1, y1 } = *self;
        (y0..=y1).flat_map(move |y| (x0..=x1).map(move |x| (x, y)))
    }

    /// Width in pixels, at least 1 in a box that [`BoundingBox::new`] made.
    pub fn columns(&self) -> usize {
        self.x1 - self.x0 + 1
    }

    /// Height in pixels, at least 1 in a box that [`BoundingBox::new`] made.
    pub fn rows(&self) -> usize {
        self.y1 - self.y0 + 1
    }

    /// Whether the pixel is part of the box.
    pub fn contains(&self, x: usize, y: usize) -> bool {
        (self.x0..=self.x1).contains(&x) && (self.y0..=self.y1).contains(&y)
    }
}

/// The disparities to search, **inclusive** at both ends, in pixels. Negative ones are legal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct DisparityRange {
    min: i32,
    max: i32,
}

impl fmt::Display for DisparityRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} to {}", self.min, self.max)
    }
}

impl DisparityRange {
    /// All whole disparities from `min` to `max`. Errors when `max < min`.
    pub fn new(min: i32, max: i32) -> Result<Self, BoundsError> {
        if min <= max { Ok(Self { min, max }) } else { Err(BoundsError::EmptyRange(min, max)) }
    }

    /// The smallest disparity.
    pub fn min(&self) -> i32 {
        self.min
    }

    /// The largest disparity, part of the range.
    pub fn max(&self) -> i32 {
        self.max
    }

    /// How many whole disparities the range holds, at least 1.
    pub fn count(&self) -> usize {
        (i64::from(self.max) - i64::from(self.min) + 1) as usize
    }

    /// Whether any of its disparities has its match within images of so many columns.
    pub fn meets(&self, columns: usize) -> bool {
        let columns = i64::try_from(columns).unwrap_or(i64::MAX);
        i64::from(self.min) < columns && i64::from(self.max) > -columns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_inclusive() {
        let b = BoundingBox::new(2, 3, 2, 5).unwrap();
        assert_eq!((b.columns(), b.rows()), (1, 3));
        assert!(b.contains(2, 5) && !b.contains(2, 6) && !b.contains(1, 4));
        assert_eq!(b.pixels().collect::<Vec<_>>(), [(2, 3), (2, 4), (2, 5)]);
        let wide = BoundingBox::new(0, 1, 1, 2).unwrap();
        assert_eq!(wide.pixels().collect::<Vec<_>>(), [(0, 1), (1, 1), (0, 2), (1, 2)]);
        assert!(b.check_within(3, 6).is_ok());
        for (columns, rows) in [(3, 5), (2, 6)] {
            let outside = BoundsError::Outside(b, columns, rows);
            assert_eq!(b.check_within(columns, rows), Err(outside));
        }
    }

    #[test]
    fn a_box_whose_sides_cannot_be_counted_is_refused() {
        for (x1, y1) in [(usize::MAX, 0), (0, usize::MAX)] {
            let error = BoundingBox::new(0, 0, x1, y1).unwrap_err();
            assert_eq!(error, BoundsError::TooLarge(BoundingBox { x0: 0, y0: 0, x1, y1 }));
        }
        let wide = BoundingBox::new(1, 0, usize::MAX, 0).unwrap();
        assert_eq!(wide.columns(), usize::MAX);
    }

    #[test]
    fn inverted_boxes_and_empty_ranges_are_refused() {
        for (x0, y0, x1, y1) in [(3, 0, 2, 0), (0, 3, 0, 2)] {
            let literal = BoundingBox { x0, y0, x1, y1 };
            let inverted = BoundsError::Inverted(literal);
            assert_eq!(BoundingBox::new(x0, y0, x1, y1), Err(inverted.clone()));
            assert_eq!(literal.check_within(9, 9), Err(inverted));
        }
        assert!(DisparityRange::new(1, 0).is_err());
        assert_eq!(DisparityRange::new(-3, 4).unwrap().count(), 8);
        assert_eq!(DisparityRange::new(i32::MIN, i32::MAX).unwrap().count(), 1 << 32);
    }

    #[test]
    fn a_range_meets_images_that_are_as_wide() {
        let meets = |min, max, columns| DisparityRange::new(min, max).unwrap().meets(columns);
        assert!(meets(9, 20, 10) && meets(-20, -9, 10) && meets(-20, 20, 1));
        assert!(!meets(10, 20, 10) && !meets(-20, -10, 10) && !meets(0, 5, 0));
    }
}
