//! A rectangle of samples, owned ([`Plane`]) or borrowed ([`View`]).
//!
//! Rows are handed out as slices: loops run over slices, and no accessor per pixel stands in them.

use std::fmt;
use std::ops::Range;

use crate::BoundingBox;

/// The number of samples does not fit the size.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SizeError {
    /// Columns asked for.
    pub columns: usize,
    /// Rows asked for.
    pub rows: usize,
    /// Samples given.
    pub samples: usize,
}

impl fmt::Display for SizeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} samples do not make a plane of {} x {}: give exactly columns x rows samples",
            self.samples, self.columns, self.rows
        )
    }
}

impl std::error::Error for SizeError {}

/// A buffer does not hold rows of that length so far apart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StrideError {
    /// Columns asked for.
    pub columns: usize,
    /// Rows asked for.
    pub rows: usize,
    /// Samples from the beginning of a row to that of the next.
    pub stride: usize,
    /// Samples given.
    pub samples: usize,
}

impl fmt::Display for StrideError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { columns, rows, stride, samples } = self;
        write!(
            f,
            "{samples} samples do not hold {rows} rows of {columns}, each {stride} after the one before: give a stride, \
             counted in samples, of {columns} or more, and stride x (rows - 1) + columns samples or more"
        )
    }
}

impl std::error::Error for StrideError {}

/// How many samples a plane of this size has.
fn area(columns: usize, rows: usize) -> usize {
    let area = columns.checked_mul(rows);
    area.unwrap_or_else(|| {
        panic!("a plane of {columns} x {rows} has more samples than can be counted")
    })
}

/// Samples of type `T` in row order, without gaps between the rows.
///
/// [`Clone::clone_from`] and [`Plane::copy_from`] keep the memory of a plane that is large enough.
#[derive(Debug, PartialEq, Eq, Default)]
pub struct Plane<T> {
    columns: usize,
    rows: usize,
    samples: Vec<T>,
}

impl<T: Clone> Clone for Plane<T> {
    fn clone(&self) -> Self {
        Self { columns: self.columns, rows: self.rows, samples: self.samples.clone() }
    }

    fn clone_from(&mut self, source: &Self) {
        (self.columns, self.rows) = (source.columns, source.rows);
        self.samples.clone_from(&source.samples);
    }
}

impl<T> Plane<T> {
    /// Takes `samples` in row order. Errors when there are not exactly `columns * rows`.
    pub fn new(columns: usize, rows: usize, samples: Vec<T>) -> Result<Self, SizeError> {
        if columns.checked_mul(rows) == Some(samples.len()) {
            Ok(Self { columns, rows, samples })
        } else {
            Err(SizeError { columns, rows, samples: samples.len() })
        }
    }

    /// Computes every sample from its column and row, in row order.
    ///
    /// # Panics
    ///
    /// If `columns * rows` is larger than a `usize` can be.
    pub fn from_fn(columns: usize, rows: usize, mut f: impl FnMut(usize, usize) -> T) -> Self {
        let mut samples = Vec::with_capacity(area(columns, rows));
        for y in 0..rows {
            samples.extend((0..columns).map(|x| f(x, y)));
        }
        Self { columns, rows, samples }
    }

    /// Width in pixels.
    #[inline]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Height in pixels.
    #[inline]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// `(columns, rows)`.
    #[inline]
    pub fn size(&self) -> (usize, usize) {
        (self.columns, self.rows)
    }

    /// All samples in row order.
    #[inline]
    pub fn samples(&self) -> &[T] {
        &self.samples
    }

    /// All samples in row order.
    #[inline]
    pub fn samples_mut(&mut self) -> &mut [T] {
        &mut self.samples
    }

    /// Gives the samples back, in row order.
    pub fn into_samples(self) -> Vec<T> {
        self.samples
    }

    /// Row `y` from left to right. Panics when `y >= rows`, unless there are no columns.
    #[inline]
    pub fn row(&self, y: usize) -> &[T] {
        &self.samples[y * self.columns..][..self.columns]
    }

    /// Row `y` from left to right. Panics when `y >= rows`, unless there are no columns.
    #[inline]
    pub fn row_mut(&mut self, y: usize) -> &mut [T] {
        &mut self.samples[y * self.columns..][..self.columns]
    }

    /// The whole plane, borrowed.
    pub fn view(&self) -> View<'_, T> {
        View {
            samples: &self.samples,
            columns: self.columns,
            rows: self.rows,
            stride: self.columns,
        }
    }

    /// A plane of the same size with `f` applied to each sample.
    pub fn map<U>(&self, f: impl FnMut(&T) -> U) -> Plane<U> {
        Plane {
            columns: self.columns,
            rows: self.rows,
            samples: self.samples.iter().map(f).collect(),
        }
    }
}

impl<T: Clone> Plane<T> {
    /// A plane with the same `value` everywhere.
    ///
    /// # Panics
    ///
    /// If `columns * rows` is larger than a `usize` can be.
    pub fn filled(columns: usize, rows: usize, value: T) -> Self {
        Self { columns, rows, samples: vec![value; area(columns, rows)] }
    }

    /// Makes this a plane of `columns x rows` with the same `value` everywhere, and keeps its
    /// memory: no allocation happens unless the plane grows past its largest size so far.
    ///
    /// # Panics
    ///
    /// If `columns * rows` is larger than a `usize` can be.
    pub fn reset(&mut self, columns: usize, rows: usize, value: T) {
        self.reshape(columns, rows, value.clone());
        self.samples.fill(value);
    }

    /// Makes this a plane of `columns x rows` for someone who writes all of it: samples that it had are
    /// left as they are, whatever they meant, and new ones have the `value`. Memory is kept as by
    /// [`Plane::reset`].
    ///
    /// # Panics
    ///
    /// If `columns * rows` is larger than a `usize` can be. The plane is then as it was.
    pub fn reshape(&mut self, columns: usize, rows: usize, value: T) {
        let needed = area(columns, rows);
        (self.columns, self.rows) = (columns, rows);
        // No more than is needed: planes are large, and what they take is added up beforehand.
        self.samples.reserve_exact(needed.saturating_sub(self.samples.len()));
        self.samples.resize(needed, value);
    }

    /// Makes this a copy of a view, and keeps its memory as [`Plane::reset`] does.
    pub fn copy_from(&mut self, view: View<'_, T>) {
        (self.columns, self.rows) = (view.columns, view.rows);
        self.samples.clear();
        self.samples.reserve_exact(area(view.columns, view.rows));
        let rows = if view.columns == 0 { 0 } else { view.rows };
        (0..rows).for_each(|y| self.samples.extend_from_slice(view.row(y)));
    }

    /// Writes the same `value` everywhere outside a box, which lies in the plane.
    pub fn fill_around(&mut self, bounds: BoundingBox, value: T) {
        for y in 0..self.rows {
            let row = self.row_mut(y);
            if (bounds.y0..=bounds.y1).contains(&y) {
                row[..bounds.x0].fill(value.clone());
                row[bounds.x1 + 1..].fill(value.clone());
            } else {
                row.fill(value.clone());
            }
        }
    }
}

/// A rectangle of samples that belong to someone else, with `stride` samples from row to row.
#[derive(Debug)]
pub struct View<'a, T> {
    samples: &'a [T],
    columns: usize,
    rows: usize,
    stride: usize,
}

impl<T> Clone for View<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for View<'_, T> {}

impl<'a, T> View<'a, T> {
    /// Looks at somebody's buffer, such as a camera's: `rows` rows of `columns` samples each, the next one of which begins
    /// `stride` samples after the one before.
    ///
    /// ```
    /// use raster::{Plane, View};
    ///
    /// let buffer = [1, 2, 3, 0, 4, 5, 6];
    /// let mut plane = Plane::default();
    /// plane.copy_from(View::new(&buffer, 3, 2, 4)?);
    /// assert_eq!(plane.samples(), [1, 2, 3, 4, 5, 6]);
    /// # Ok::<(), raster::StrideError>(())
    /// ```
    ///
    /// Errors when rows would overlap, or when the buffer ends before the last of them.
    pub fn new(
        samples: &'a [T],
        columns: usize,
        rows: usize,
        stride: usize,
    ) -> Result<Self, StrideError> {
        let error = StrideError { columns, rows, stride, samples: samples.len() };
        let needed = match (rows, columns) {
            (0, _) | (_, 0) => Some(0),
            _ => stride.checked_mul(rows - 1).and_then(|last| last.checked_add(columns)),
        };
        match needed {
            Some(needed) if needed <= samples.len() && stride >= columns => {
                Ok(Self { samples, columns, rows, stride })
            }
            _ => Err(error),
        }
    }

    /// Width in pixels.
    #[inline]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Height in pixels.
    #[inline]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Row `y` from left to right. Panics when `y >= rows`.
    #[inline]
    pub fn row(&self, y: usize) -> &'a [T] {
        assert!(y < self.rows, "row {y} of a view with {} rows", self.rows);
        &self.samples[y * self.stride..][..self.columns]
    }

    /// The part that some of its columns and rows have in common. Panics when it has not all of them.
    pub fn part(&self, columns: Range<usize>, rows: Range<usize>) -> View<'a, T> {
        assert!(
            columns.start <= columns.end
                && columns.end <= self.columns
                && rows.start <= rows.end
                && rows.end <= self.rows,
            "columns {columns:?} and rows {rows:?} of a view of {} x {}",
            self.columns,
            self.rows
        );
        let first = (rows.start * self.stride + columns.start).min(self.samples.len());
        let (columns, rows) = (columns.len(), rows.len());
        Self { samples: &self.samples[first..], columns, rows, ..*self }
    }

    /// Every so many-th of its rows, from the first one on.
    ///
    /// # Panics
    ///
    /// If `apart` is 0.
    pub fn every_row(&self, apart: usize) -> View<'a, T> {
        assert!(apart > 0, "rows of a view are at least 1 apart, not 0");
        // Where that is too large to be counted there is one row.
        let stride = self.stride.saturating_mul(apart);
        Self { rows: self.rows.div_ceil(apart), stride, ..*self }
    }
}

impl<T: Clone> View<'_, T> {
    /// Copies the samples into a plane of their own.
    pub fn to_plane(&self) -> Plane<T> {
        let mut plane = Plane { columns: 0, rows: 0, samples: Vec::new() };
        plane.copy_from(*self);
        plane
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_slices_of_the_samples() {
        let plane = Plane::new(3, 2, vec![1, 2, 3, 4, 5, 6]).unwrap();
        assert_eq!(plane.row(0), [1, 2, 3]);
        assert_eq!(plane.row(1), [4, 5, 6]);
        assert_eq!(plane.view().row(1), [4, 5, 6]);
    }

    #[test]
    fn a_wrong_number_of_samples_is_refused() {
        let error = Plane::new(3, 2, vec![0u8; 5]).unwrap_err();
        assert_eq!(error, SizeError { columns: 3, rows: 2, samples: 5 });
        assert!(Plane::new(usize::MAX, 2, vec![0u8; 5]).is_err());
    }

    #[test]
    #[should_panic(expected = "a plane of 18446744073709551615 x 2 has more samples than")]
    #[cfg(target_pointer_width = "64")]
    fn a_filled_plane_of_more_samples_than_can_be_counted_is_refused() {
        Plane::filled(usize::MAX, 2, 0u8);
    }

    #[test]
    #[should_panic(expected = "has more samples than can be counted")]
    fn a_computed_plane_of_more_samples_than_can_be_counted_is_refused() {
        // Wrapped around, these would be none.
        Plane::from_fn(1 << (usize::BITS / 2), 1 << (usize::BITS / 2), |_, _| 0u8);
    }

    #[test]
    fn a_plane_that_cannot_be_reshaped_stays_as_it_was() {
        let mut plane = Plane::filled(2, 3, 1u8);
        let reshaped = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            plane.reshape(usize::MAX, usize::MAX, 0);
        }));
        assert!(reshaped.is_err());
        assert_eq!(plane, Plane::filled(2, 3, 1));
    }

    #[test]
    fn a_buffer_is_looked_at_row_by_row() {
        let buffer = [1, 2, 3, 0, 4, 5, 6];
        let view = View::new(&buffer, 3, 2, 4).unwrap();
        assert_eq!((view.row(0), view.row(1)), (&[1, 2, 3][..], &[4, 5, 6][..]));
        for (columns, rows, stride) in
            [(3, 2, 5), (4, 2, 4), (3, 3, 4), (3, 2, 2), (3, usize::MAX, usize::MAX)]
        {
            let error = View::new(&buffer, columns, rows, stride).unwrap_err();
            assert_eq!(error, StrideError { columns, rows, stride, samples: 7 });
        }
        assert_eq!(View::new(&buffer, 7, 0, 7).unwrap().to_plane().size(), (7, 0));
        let none = View::new(&buffer[..0], 0, usize::MAX, 0).unwrap();
        assert_eq!(none.to_plane().size(), (0, usize::MAX));
    }

    #[test]
    fn copies_keep_the_memory_of_a_plane() {
        let mut plane = Plane::filled(4, 4, 1u8);
        let place = plane.samples().as_ptr();
        let small = Plane::new(2, 1, vec![7, 8]).unwrap();
        plane.copy_from(small.view());
        assert_eq!((&plane, plane.samples().as_ptr()), (&small, place));
        plane.clone_from(&Plane::filled(4, 4, 2));
        assert_eq!((&plane, plane.samples().as_ptr()), (&Plane::filled(4, 4, 2), place));
    }

    #[test]
    fn a_part_has_the_columns_and_rows_that_it_was_asked_for() {
        let plane = Plane::from_fn(5, 4, |x, y| 10 * y + x);
        let part = plane.view().part(1..4, 2..4);
        assert_eq!(part.to_plane().samples(), [21, 22, 23, 31, 32, 33]);
        assert_eq!(part.part(1..2, 1..2).row(0), [32]);
        assert_eq!(plane.view().part(5..5, 4..4).to_plane().size(), (0, 0));
    }

    #[test]
    #[should_panic(expected = "columns 2..4 and rows 0..1 of a view of 3 x 2")]
    fn a_part_does_not_reach_into_the_next_row() {
        let plane = Plane::filled(5, 4, 0u8);
        plane.view().part(0..3, 0..2).part(2..4, 0..1);
    }

    #[test]
    #[should_panic(expected = "columns 0..1 and rows 1..3 of a view of 3 x 2")]
    fn a_part_has_no_row_below_its_last() {
        let plane = Plane::filled(5, 4, 0u8);
        plane.view().part(0..3, 0..2).part(0..1, 1..3);
    }

    #[test]
    #[should_panic(expected = "row 2 of a view with 2 rows")]
    fn a_view_hands_out_no_row_below_its_last() {
        let plane = Plane::filled(5, 4, 0u8);
        plane.view().part(0..3, 0..2).row(2);
    }

    #[test]
    fn every_so_many_th_row_begins_with_the_first() {
        let plane = Plane::from_fn(3, 5, |x, y| 10 * y + x);
        let part = plane.view().part(1..3, 0..5);
        assert_eq!(part.every_row(2).to_plane().samples(), [1, 2, 21, 22, 41, 42]);
        assert_eq!(part.every_row(4).to_plane().samples(), [1, 2, 41, 42]);
        assert_eq!(part.every_row(1).to_plane().samples(), part.to_plane().samples());
        assert_eq!(part.every_row(usize::MAX).to_plane().samples(), [1, 2]);
    }

    #[test]
    #[should_panic(expected = "at least 1 apart")]
    fn rows_that_are_not_apart_are_refused() {
        Plane::filled(3, 5, 0u8).view().every_row(0);
    }

    #[test]
    fn reset_keeps_its_memory() {
        let mut plane = Plane::filled(8, 8, 1u8);
        let before = plane.samples().as_ptr();
        plane.reset(4, 4, 7);
        assert_eq!((plane.size(), plane.samples().as_ptr()), ((4, 4), before));
        assert!(plane.samples().iter().all(|&s| s == 7));
    }

    #[test]
    fn around_a_box_there_is_one_value() {
        let mut plane = Plane::filled(4, 3, 1u8);
        plane.fill_around(BoundingBox::new(1, 1, 2, 2).unwrap(), 0);
        assert_eq!(plane.samples(), [0, 0, 0, 0, 0, 1, 1, 0, 0, 1, 1, 0]);
    }

    #[test]
    fn reshape_writes_only_what_is_new() {
        let mut plane = Plane::new(2, 2, vec![1u8, 2, 3, 4]).unwrap();
        plane.reshape(3, 1, 7);
        assert_eq!((plane.size(), plane.samples()), ((3, 1), &[1, 2, 3][..]));
        plane.reshape(1, 5, 7);
        assert_eq!((plane.size(), plane.samples()), ((1, 5), &[1, 2, 3, 7, 7][..]));
    }
}
