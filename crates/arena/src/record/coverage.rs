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
        let is_known = |value: &f32| value.is_finite();
        let sure = confidence.as_ref().map(|confidence| {
            let is_sure = Plane::from_fn(disparity.columns(), disparity.rows(), |x, y| {
                is_known(&disparity.row(y)[x]) && confidence.row(y)[x] >= SURE
            });
            count(&is_sure, bounds, |&sure| sure)
        });
        Self {
            pixels: bounds.columns() * bounds.rows(),
            estimates: count(disparity, bounds, is_known),
            matched: reasons
                .as_ref()
                .map(|r| count(r, bounds, |&reason| reason == Reason::Matched)),
            sure,
        }
    }
}

fn count<T>(plane: &Plane<T>, bounds: BoundingBox, counts: impl Fn(&T) -> bool) -> usize {
    let BoundingBox { x0, y0, x1, y1 } = bounds;
    (y0..=y1).map(|y| plane.row(y)[x0..=x1].iter().filter(|value| counts(value)).count()).sum()
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
