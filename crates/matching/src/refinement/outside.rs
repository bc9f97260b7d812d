//! Which pixels show what lies outside the right image, said once more of the finished disparities: columns and
//! rows between the matched ones, and the median, move disparities across its border.

use raster::Reason;

use crate::kernels::level::at_every_level;

/// Whether a pixel of the left image with this disparity matches none of the right one, of so many columns.
#[inline(always)]
pub(crate) fn is_outside(width: usize, column: usize, disparity: f32) -> bool {
    let right = column as f32 - disparity;
    (right < -0.5) | (right > width as f32 - 0.5)
}

at_every_level! {
    /// Sets the reasons of a row of disparities that begins at a column of the image: what lies outside is so
    /// marked, and nothing else is. What was marked and came back was extrapolated, not matched.
    pub(crate) fn mark(width: usize, first: usize, disparities: &[f32], reasons: &mut [Reason]) {
        use Reason::{MismatchedFilled, OutsideRightFilled};
        for (x, (&disparity, reason)) in disparities.iter().zip(reasons).enumerate() {
            let inside = if *reason == OutsideRightFilled { MismatchedFilled } else { *reason };
            *reason = if is_outside(width, first + x, disparity) { OutsideRightFilled } else { inside };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::level::Level;
    use Reason::{Matched, MismatchedFilled, OccludedFilled, OutsideRightFilled};

    #[test]
    fn a_match_lies_outside_beyond_the_edge_of_the_outermost_pixels() {
        assert!(!is_outside(10, 8, 8.5) && is_outside(10, 8, 8.75));
        assert!(!is_outside(10, 8, -1.5) && is_outside(10, 8, -1.75));
    }

    #[test]
    fn finished_disparities_say_what_lies_outside_at_every_level() {
        let all = [Matched, MismatchedFilled, OccludedFilled, OutsideRightFilled];
        // Columns 3 to 72 of 60, with disparities that leave it at both sides.
        let row: Vec<(f32, Reason)> =
            (0..70).map(|x| ((x * 7 % 23) as f32 / 4.0 - 1.0, all[x % 4])).collect();
        let disparities: Vec<f32> = row.iter().map(|pixel| pixel.0).collect();
        for level in Level::available() {
            eprintln!("level {}", level.name());
            let mut reasons: Vec<Reason> = row.iter().map(|pixel| pixel.1).collect();
            mark(level, 60, 3, &disparities, &mut reasons);
            let mut moved = [0; 2];
            for (x, (&(disparity, before), &now)) in row.iter().zip(&reasons).enumerate() {
                let right = (3 + x) as f32 - disparity;
                let expected = match before {
                    _ if !(-0.5..=59.5).contains(&right) => OutsideRightFilled,
                    OutsideRightFilled => MismatchedFilled,
                    before => before,
                };
                assert_eq!(now, expected, "column {x}");
                moved[usize::from(now == OutsideRightFilled)] += usize::from(now != before);
            }
            assert!(moved.iter().all(|&moved| moved > 2), "{moved:?}");
        }
    }
}
