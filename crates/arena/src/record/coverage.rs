//! How much of a box an answer speaks of: all that can be said of a pair without truth.

use raster::{BoundingBox, Plane, Reason};
use serde::Serialize;

use crate::engine::Answer;

/// A pixel counts as sure from this confidence on.
pub const SURE: f32 = 0.5;

/// How many pixels of the box an answer says what of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Coverage {
    /// All of the box.
    pub pixels: usize,
    /// Those with a disparity.
    pub estimates: usize,
    /// Those that were matched and not filled, if the engine gives reasons.
    pub matched: Option<usize>,
    /// Those with a disparity whose confidence is at least [`SURE`], if the engine says how sure it is.
    pub sure: Option<usize>,
}

impl Coverage {
    /// Counts inside `bounds`, which lies inside the answer.
    pub fn of(answer: &Answer, bounds: BoundingBox) -> Self {
        let Answer { disparity, reasons, confidence } = answer;
        let count = |counts: &dyn Fn(usize, usize) -> bool| {
            bounds.pixels().filter(|&(x, y)| counts(x, y)).count()
        };
        let is_known = |x: usize, y: usize| disparity.row(y)[x].is_finite();
        let matched = |reasons: &Plane<Reason>| count(&|x, y| reasons.row(y)[x] == Reason::Matched);
        let sure = |sure: &Plane<f32>| count(&|x, y| is_known(x, y) && sure.row(y)[x] >= SURE);
        Self {
            pixels: bounds.columns() * bounds.rows(),
            estimates: count(&is_known),
            matched: reasons.as_ref().map(matched),
            sure: confidence.as_ref().map(sure),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_of_the_box_are_counted_and_no_others() {
        let row = |values: [f32; 5]| Plane::new(5, 1, values.to_vec()).unwrap();
        let reasons = [1, 1, 3, 1, 5].map(|reason| Reason::ALL[reason]).to_vec();
        let answer = Answer {
            disparity: row([1.0, 2.0, 3.0, 4.0, f32::NAN]),
            reasons: Some(Plane::new(5, 1, reasons).unwrap()),
            confidence: Some(row([1.0, 0.5, 0.25, 0.75, 0.9])),
        };
        let bounds = BoundingBox::new(1, 0, 4, 0).unwrap();
        let expected = Coverage { pixels: 4, estimates: 3, matched: Some(2), sure: Some(2) };
        assert_eq!(Coverage::of(&answer, bounds), expected);
        let silent = Answer { reasons: None, confidence: None, ..answer };
        let expected = Coverage { matched: None, sure: None, ..expected };
        assert_eq!(Coverage::of(&silent, bounds), expected);
    }
}
