//! The right view chooses too, before the left one does: what it says at a match is one of the hints that
//! the left one's judges go by, and it says less that is wrong.
//!
//! In a mirror the right view is a left one: the same judges serve.

use raster::{Plane, Reason};
use rayon::prelude::*;

use super::view::{Search, View};
use crate::kernels::rounding::nearest;
use crate::profile::Work;
use crate::refinement::choice::{Choices, Given};

/// How many rounds: more give the left view nothing.
const ROUNDS: usize = 2;

/// What the right view is given to choose by, kept between frames.
#[derive(Default)]
pub(super) struct RightChoices {
    /// The rows of both images in a mirror, the right one first.
    grey: [Plane<u8>; 2],
    /// The disparities of the left view in all columns of the image.
    left: Plane<f32>,
    confidence: Plane<f32>,
}

impl RightChoices {
    /// What it takes for so many columns and rows of the images.
    pub fn bytes(width: usize, rows: usize) -> usize {
        (2 * size_of::<u8>() + 2 * size_of::<f32>()) * width * rows
    }

    /// Lets the pixels of the right view choose, once or in more rounds, into its map. Both views are checked
    /// against each other and filled; `confidence` is that of the left one. All columns and rows are matched.
    pub fn run(
        &mut self,
        search: Search<'_>,
        further: bool,
        choices: &mut Choices,
        left: &View,
        confidence: &Plane<f32>,
        right: &mut View,
    ) -> Work {
        let Search { level, work, width, range, .. } = search;
        let rows = work.rows();
        let [right_image, left_image] = &mut self.grey;
        mirror(search.grey[1], work.y0, rows, right_image);
        mirror(search.grey[0], work.y0, rows, left_image);
        widen(&left.filled, work.x0, width, &mut self.left);
        self.confidence.reshape(width, rows, 0.0);
        let of_rows = self.confidence.samples_mut().par_chunks_mut(width).enumerate();
        of_rows.for_each(|(y, to)| {
            let pixels = right.filled.row(y).iter().zip(right.map.reasons.row(y));
            confidence_of_matches(pixels, confidence.row(y), work.x0, to);
        });
        let given = Given {
            doubtful: &Plane::default(),
            grey: self.grey.each_ref().map(Plane::view),
            right: &self.left,
            first: 0,
            top: 0,
            least: range.min() as f32,
            most: range.max() as f32,
        };
        let rounds = if further { ROUNDS } else { 1 };
        let View { map, filled, .. } = right;
        let chosen = choices.run(level, rounds, &given, &self.confidence, filled, map);
        // Rounds leave either plane in the other's memory. The map's is that of the answer, and larger
        // than the part that is matched: it has to come back.
        std::mem::swap(filled, &mut map.values);
        // Both images are read and written; of either view the disparities are read, of the right one
        // reasons too, and of the left one's confidence, which is written for the right one.
        chosen + Work::bytes((2 * 2 + 2 * 4 + 4 + 1 + 2 * 4) * width * rows)
    }
}

/// Rows `first..first + rows` of an image in a mirror.
fn mirror(image: raster::View<'_, u8>, first: usize, rows: usize, out: &mut Plane<u8>) {
    out.reshape(image.columns(), rows, 0);
    let of_rows = out.samples_mut().par_chunks_mut(image.columns()).enumerate();
    of_rows.for_each(|(y, to)| {
        to.copy_from_slice(image.row(first + y));
        to.reverse();
    });
}

/// A map that begins at column `first` of an image of a width; beyond its ends its rows are repeated.
fn widen(map: &Plane<f32>, first: usize, width: usize, out: &mut Plane<f32>) {
    out.reshape(width, map.rows(), 0.0);
    let of_rows = out.samples_mut().par_chunks_mut(width).enumerate();
    of_rows.for_each(|(y, to)| {
        let (row, end) = (map.row(y), first + map.columns());
        to[..first].fill(row[0]);
        to[first..end].copy_from_slice(row);
        to[end..].fill(row[map.columns() - 1]);
    });
}

/// The confidence of the pixels of a row in the mirror: where there is a match, that of the left view at
/// the match, which begins at a column, if it has that of the match; 0 elsewhere.
fn confidence_of_matches<'a>(
    pixels: impl Iterator<Item = (&'a f32, &'a Reason)>,
    of_left: &[f32],
    first: usize,
    out: &mut [f32],
) {
    let last = out.len() as i32 - 1;
    for ((m, out), (&disparity, &reason)) in (0..).zip(out).zip(pixels) {
        let column = usize::try_from(last - m + nearest(disparity));
        let seen = column.ok().and_then(|column| of_left.get(column.checked_sub(first)?));
        *out = match seen {
            Some(&confidence) if reason == Reason::Matched => confidence,
            _ => 0.0,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_right_image_begins_at_its_end() {
        let image = Plane::from_fn(3, 4, |x, y| (10 * y + x) as u8);
        let mut out = Plane::default();
        mirror(image.view(), 1, 2, &mut out);
        assert_eq!(out.samples(), [12, 11, 10, 22, 21, 20]);
    }

    #[test]
    fn a_part_of_the_left_view_is_continued_over_the_image() {
        let part = Plane::from_fn(2, 1, |x, _| 3.0 + x as f32);
        let mut out = Plane::default();
        widen(&part, 1, 5, &mut out);
        assert_eq!(out.samples(), [3.0, 3.0, 4.0, 4.0, 4.0]);
    }

    #[test]
    fn a_match_is_as_confident_as_the_left_pixel() {
        // In the mirror column 0 of five is column 4: with disparity 0 it is seen at 4, with 1 beyond the image.
        let disparities = [0.0, 1.0, 1.2, 3.0, 1.0];
        let mut reasons = [Reason::Matched; 5];
        reasons[4] = Reason::OccludedFilled;
        let of_left = [0.2, 0.3, 0.4];
        let mut out = [9.0; 5];
        confidence_of_matches(disparities.iter().zip(&reasons), &of_left, 1, &mut out);
        // Columns 4, 4 (not of the left view's part), 3, 4, and one that is filled.
        assert_eq!(out, [0.0, 0.0, 0.4, 0.0, 0.0]);
    }
}
