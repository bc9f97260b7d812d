//! Disparities of both views, and how sure they are, from the sums of one row after the other.
//!
//! The confidence of a winner whose sum lies `m` below that of any other disparity is
//! `m / (m + HALF_SURE)`.

use crate::cost::SearchSpace;
use crate::kernels::level::Level;
use crate::profile::Work;
use crate::selection::winner::{self, Winners, fraction, right_fraction};

/// A winner whose sum is so much below that of any other disparity has confidence 1/2.
const HALF_SURE: f32 = 60.0;

/// Some rows that are selected, in any order.
pub(crate) struct Selection<'a> {
    pub level: Level,
    pub space: &'a SearchSpace,
    /// Whether disparities have fractions.
    pub sub_pixel: bool,
    /// Winners of the left view with a smaller margin are no matches.
    pub least_margin: u16,
    /// The first of the rows.
    pub first: usize,
    /// Per row `space.columns()` disparities of the left view.
    pub left: &'a mut [f32],
    /// Per row `space.width` disparities of the right view, as it looks in a mirror.
    pub right: &'a mut [f32],
    /// Rows of the image: the confidence of the columns that are answered.
    pub confidence: &'a mut [f32],
    /// Scratch.
    pub winners: &'a mut Winners,
}

impl Selection<'_> {
    /// What a row amounts to besides its sums: two disparities and a confidence are written.
    pub fn work(space: &SearchSpace) -> Work {
        let written = size_of::<f32>() * (2 * space.columns() + space.width);
        Work::bytes(written) + Work::operations(winner::OPERATIONS) * space.pairs()
    }

    /// Selects row `y` from its sums.
    pub fn row(&mut self, y: usize, sums: &[u16]) {
        let (space, row, columns) = (self.space, y - self.first, self.space.columns());
        self.winners.select(self.level, space, sums);
        let disparity = |k: usize, part: f32| {
            (space.min + k as i32) as f32 + if self.sub_pixel { part } else { 0.0 }
        };
        let left = &mut self.left[row * columns..][..columns];
        let confidence = &mut self.confidence[row * space.width + space.first..][..columns];
        let winners = self.winners.left.iter().zip(left.iter_mut().zip(confidence));
        for (x, (&(winner, margin), (value, confidence))) in winners.enumerate() {
            let sums = &sums[x * space.lanes..][..space.lanes];
            let unique = winner.disparity().filter(|_| margin >= self.least_margin);
            *value = unique.map_or(f32::NAN, |k| {
                disparity(k, fraction(sums, k, space.candidates(space.first + x)))
            });
            *confidence = f32::from(margin) / (f32::from(margin) + HALF_SURE);
        }
        let right = &mut self.right[row * space.width..][..space.width];
        let winners = self.winners.right(space).zip((0..space.width).rev());
        for ((winner, x), value) in winners.zip(right) {
            *value = winner
                .disparity()
                .map_or(f32::NAN, |k| disparity(k, right_fraction(space, sums, x, k)));
        }
    }
}
