//! The answer of `balanced` and `best` to all rows of an image, from those that were matched.

use raster::{BoundingBox, DisparityMap, Plane, Reason};
use rayon::prelude::*;

use super::view::Search;
use crate::ingredient::Ingredient;
use crate::kernels::level::at_every_level;
use crate::profile::Work;
use crate::refinement::blank;
use crate::refinement::median_in_steps::{Medians, Smoothing, Steps};
use crate::refinement::repetition::Repetition;
use crate::refinement::rows_between::{self, All, Matched};

/// Between two matched columns or rows that differ by no more, in pixels, a pixel lies halfway.
pub(super) const ONE_SURFACE: f32 = 3.0;
/// What confidence is left of a pixel that got its disparity from its neighbours.
const FILLED: f32 = 0.05;

/// Its memory.
#[derive(Default)]
pub(super) struct Answer {
    /// The left view in fixed point, with the rows between.
    steps: Plane<u16>,
    medians: Medians,
}

impl Answer {
    /// Spreads the left view, which is there in fixed point with its reasons, and its confidence over all rows. What
    /// shows nothing is taken for a guess, and what repeats is not believed. Where the view was `judged`, the confidence
    /// of what the paths did not see is a judge's.
    pub fn spread(
        &mut self,
        search: Search<'_>,
        judged: bool,
        repetition: &Repetition,
        (steps, reasons): (&Plane<u16>, &mut Plane<Reason>),
        confidence: &mut Plane<f32>,
        map: &mut DisparityMap,
    ) -> Work {
        let Search { level, left, work, rows, numbers, range, .. } = search;
        let columns = work.columns();
        let of_rows = confidence.samples_mut().par_chunks_exact_mut(columns);
        let of_rows = of_rows.zip(reasons.samples_mut().par_chunks_exact_mut(columns)).enumerate();
        of_rows.for_each(|(y, (confidence, reasons))| {
            let first = (work.x0, work.y0 + rows.apart * y);
            blank::reject(level, left, first, reasons);
            trust(level, judged, reasons, confidence);
            let disparities = steps.row(y);
            repetition.doubt(range, first, |x| numbers.pixels(disparities[x]), confidence);
        });
        let matched = Matched { steps, reasons: &*reasons, confidence: &*confidence };
        let all = All {
            steps: &mut self.steps,
            reasons: &mut map.reasons,
            confidence: &mut map.confidence,
            first: work.x0,
            top: work.y0,
        };
        let same = numbers.steps(ONE_SURFACE);
        // Confidence is read and written for what becomes of it by reasons and disparities.
        let trusted = (Work::bytes(2 * 4 + 1) + blank::work(left)) * (columns * rows.count);
        trusted + rows_between::spread(level, rows.apart, same, search.left_part(), matched, all)
    }

    /// The median of 5 x 5 pixels of the left view, of which all rows are there in fixed point, for a box of the
    /// image; matches nearer than it that some neighbours lie beside stay.
    pub fn smooth(
        &mut self,
        search: Search<'_>,
        bounds: BoundingBox,
        answer: &mut DisparityMap,
    ) -> Work {
        let Search { ingredients, level, work, numbers, range, .. } = search;
        let height = bounds.rows().div_ceil(rayon::current_num_threads());
        let map = Steps { steps: &self.steps, numbers, first: (work.x0, work.y0), range };
        let smoothing =
            match [Ingredient::Median, Ingredient::NearDetail].map(|i| ingredients.has(i)) {
                [false, _] => Smoothing::None,
                [true, false] => Smoothing::All,
                [true, true] => Smoothing::Sparing,
            };
        self.medians.of_box(level, smoothing, map, bounds, height, answer)
    }
}

at_every_level! {
    /// Lowers the confidence of what was filled. Where no judge looks, the paths know nothing of what they do not see.
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
