//! The answer of `balanced` and `best` to all rows of an image, from those that were matched.

use raster::{BoundingBox, DisparityMap, Plane, Reason};
use rayon::prelude::*;

use super::view::Search;
use crate::ingredient::Ingredient;
use crate::kernels::level::at_every_level;
use crate::kernels::median::{self, median_of_5_rows, rows_around};
use crate::profile::Work;
use crate::refinement::rows_between::{self, All, Matched};
use crate::selection::fixed_point::row_in_pixels;

/// Between two matched columns or rows that differ by no more, in pixels, a pixel lies halfway.
pub(super) const ONE_SURFACE: f32 = 3.0;
/// What confidence is left of a pixel that got its disparity from its neighbours.
const FILLED: f32 = 0.05;

/// Its memory.
#[derive(Default)]
pub(super) struct Answer {
    /// The left view in fixed point, with the rows between.
    steps: Plane<u16>,
    /// Rows of medians, one for each thread.
    medians: Vec<Vec<u16>>,
}

impl Answer {
    /// Spreads the left view, which is there in fixed point with its reasons, and its confidence over all rows. Where
    /// it was `judged`, the confidence of what the paths did not see is a judge's.
    pub fn spread(
        &mut self,
        search: Search<'_>,
        judged: bool,
        (steps, reasons): (&Plane<u16>, &Plane<Reason>),
        confidence: &mut Plane<f32>,
        map: &mut DisparityMap,
    ) -> Work {
        let Search { level, work, rows, numbers, .. } = search;
        let of_rows = confidence.samples_mut().par_chunks_exact_mut(work.columns()).enumerate();
        of_rows.for_each(|(y, confidence)| trust(level, judged, reasons.row(y), confidence));
        let matched = Matched { steps, reasons, confidence: &*confidence };
        let all = All {
            steps: &mut self.steps,
            reasons: &mut map.reasons,
            confidence: &mut map.confidence,
            first: work.x0,
            top: work.y0,
        };
        let same = numbers.steps(ONE_SURFACE);
        // Confidence is read and written for what becomes of it by the reasons.
        let trusted = Work::bytes((2 * 4 + 1) * work.columns() * rows.count);
        trusted + rows_between::spread(level, rows.apart, same, search.left_part(), matched, all)
    }

    /// The median of 5 x 5 pixels of the left view, of which all rows are there in fixed point, for a box of the
    /// image.
    pub fn smooth(
        &mut self,
        search: Search<'_>,
        bounds: BoundingBox,
        values: &mut Plane<f32>,
    ) -> Work {
        let Search { ingredients, level, work, numbers, .. } = search;
        let (dx, dy) = (bounds.x0 - work.x0, bounds.y0 - work.y0);
        let width = values.columns();
        let height = bounds.rows().div_ceil(rayon::current_num_threads());
        self.medians.resize_with(bounds.rows().div_ceil(height), Vec::new);
        let steps = &self.steps;
        let rows = &mut values.samples_mut()[bounds.y0 * width..(bounds.y1 + 1) * width];
        let bands = self.medians.par_iter_mut().zip(rows.par_chunks_mut(height * width));
        bands.enumerate().for_each(|(i, (medians, rows))| {
            medians.resize(work.columns(), 0);
            for (y, row) in (dy + i * height..).zip(rows.chunks_exact_mut(width)) {
                if ingredients.has(Ingredient::Median) {
                    median_of_5_rows(level, rows_around(steps, y), medians);
                } else {
                    medians.copy_from_slice(steps.row(y));
                }
                let row = &mut row[bounds.x0..=bounds.x1];
                row_in_pixels(level, numbers, &medians[dx..][..row.len()], row);
            }
        });
        let median = if ingredients.has(Ingredient::Median) { median::OPERATIONS } else { 0 };
        let pixel = Work::bytes(2 + 4) + Work::operations(median);
        pixel * (bounds.columns() * bounds.rows())
    }
}

at_every_level! {
    /// Lowers the confidence of what was filled. Where no judge looks, the paths know nothing of what they do
    /// not see.
    fn trust(judged: bool, reasons: &[Reason], confidence: &mut [f32]) {
        let unseen = if judged { FILLED } else { 0.0 };
        for (confidence, &reason) in confidence.iter_mut().zip(reasons) {
            let hidden =
                (reason == Reason::OccludedFilled) | (reason == Reason::OutsideRightFilled);
            let filled = if hidden { unseen } else { FILLED };
            *confidence *= if reason == Reason::Matched { 1.0 } else { filled };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::level::Level;

    #[test]
    fn what_was_filled_is_trusted_less_at_every_level() {
        use Reason::{Matched, MismatchedFilled, OccludedFilled, OutsideRightFilled};
        let reasons = [Matched, OccludedFilled, MismatchedFilled, OutsideRightFilled].repeat(9);
        for level in Level::available() {
            eprintln!("level {}", level.name());
            let confidence = |judged| {
                let mut confidence = vec![0.8; reasons.len()];
                trust(level, judged, &reasons, &mut confidence);
                confidence
            };
            let filled = 0.8 * FILLED;
            assert_eq!(confidence(true), [0.8, filled, filled, filled].repeat(9));
            assert_eq!(confidence(false), [0.8, 0.0, filled, 0.0].repeat(9));
        }
    }
}
