//! Holes filled from the background in their row.
//!
//! What the right camera cannot see is hidden by something nearer, so it belongs to whatever lies
//! behind: a hole takes the smaller of the two nearest values in its row. A hole at the row's end
//! has one neighbour and takes its value; when that puts the match outside the right image, the
//! pixel was outside its view, not hidden, and is marked so. A row without any value takes those of
//! the nearest row that has some.
//!
//! In: values (NaN in holes) and reasons (`..Hole` in holes). Out: every value finite, the reasons
//! `..Filled`.

use raster::Reason;

/// Fills the holes of one row whose first pixel is column `first` of an image of `width` columns.
/// Says whether the row has values now; a row of holes only stays as it is.
pub(crate) fn fill_row(
    width: usize,
    first: usize,
    values: &mut [f32],
    reasons: &mut [Reason],
) -> bool {
    let mut before = f32::NAN;
    let mut x = 0;
    while x < values.len() {
        if !values[x].is_nan() {
            before = values[x];
            x += 1;
            continue;
        }
        let end = values[x..].iter().position(|v| !v.is_nan()).map_or(values.len(), |n| x + n);
        let after = values.get(end).copied().unwrap_or(f32::NAN);
        // `min` passes over a NaN: at the row's ends the only neighbour is taken.
        let background = before.min(after);
        if background.is_nan() {
            return false;
        }
        for (column, (value, reason)) in
            (first + x..).zip(values[x..end].iter_mut().zip(&mut reasons[x..end]))
        {
            *value = background;
            *reason = filled(width, column, background, *reason);
        }
        x = end;
    }
    true
}

/// The reason of a filled pixel.
pub(crate) fn filled(width: usize, column: usize, value: f32, hole: Reason) -> Reason {
    let right = column as f32 - value;
    if right < -0.5 || right > width as f32 - 0.5 {
        Reason::OutsideRightFilled
    } else if hole == Reason::MismatchedHole {
        Reason::MismatchedFilled
    } else {
        Reason::OccludedFilled
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Reason::{
        Matched, MismatchedFilled, MismatchedHole, OccludedFilled, OccludedHole, OutsideRightFilled,
    };

    #[test]
    fn the_background_fills_and_the_reason_says_how() {
        let hole = f32::NAN;
        let mut values = [hole, hole, hole, 2.0, hole, hole, 7.0, hole];
        let mut reasons = [OccludedHole; 8];
        reasons[3] = Matched;
        reasons[5] = MismatchedHole;
        reasons[6] = Matched;
        assert!(fill_row(20, 0, &mut values, &mut reasons));
        assert_eq!(values, [2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 7.0, 7.0]);
        assert_eq!(
            reasons,
            [
                OutsideRightFilled,
                OutsideRightFilled,
                OccludedFilled,
                Matched,
                OccludedFilled,
                MismatchedFilled,
                Matched,
                OccludedFilled
            ]
        );
    }

    #[test]
    fn negative_disparities_leave_the_right_image_on_its_other_side() {
        assert_eq!(filled(10, 8, -1.0, OccludedHole), OccludedFilled);
        assert_eq!(filled(10, 8, -2.0, OccludedHole), OutsideRightFilled);
    }

    #[test]
    fn a_row_of_holes_stays_a_row_of_holes() {
        let mut values = [f32::NAN; 3];
        assert!(!fill_row(3, 0, &mut values, &mut [OccludedHole; 3]));
        assert!(values.iter().all(|v| v.is_nan()));
    }
}
