//! Which pixels show what lies outside the right image, and which of them are to be believed, said once more of the
//! finished disparities: columns and rows between the matched ones, and the median, move disparities across its border
//! and to the ends of the range.

use raster::{DisparityMap, DisparityRange, Reason};

use crate::kernels::level::at_every_level;
use crate::kernels::rounding::as_number;

/// Whether a pixel of the left image with this disparity matches none of the right one, of so many columns.
#[inline(always)]
pub(crate) fn is_outside(width: usize, column: usize, disparity: f32) -> bool {
    let right = as_number(column) - disparity;
    (right < -0.5) | (right > as_number(width) - 0.5)
}

/// The most that is believed of what was filled, and of what lies within half a pixel of an end of the range: of what is
/// nearer than the range a quarter to a half gets its disparity there, and at disparity 0, where most ranges begin, is
/// what both cameras have in one place, as dust on lenses and blocks of compression.
const UNSURE: f32 = DisparityMap::MOST_OF_A_GUESS;

at_every_level! {
    /// Sets the reasons of a row of disparities that begins at a column of the image: what lies outside is so
    /// marked, and nothing else is. What was marked and came back was extrapolated, not matched. Of all that is no
    /// match within the range little confidence is left.
    pub(crate) fn mark(
        width: usize,
        first: usize,
        range: DisparityRange,
        disparities: &[f32],
        reasons: &mut [Reason],
        confidence: &mut [f32],
    ) {
        use Reason::{Matched, MismatchedFilled, OutsideRightFilled};
        let (farthest, nearest) = (range.min() as f32 + 0.5, range.max() as f32 - 0.5);
        let known = reasons.iter_mut().zip(confidence);
        for (x, (&disparity, (reason, confidence))) in disparities.iter().zip(known).enumerate() {
            let inside = if *reason == OutsideRightFilled { MismatchedFilled } else { *reason };
            let told = if is_outside(width, first + x, disparity) { OutsideRightFilled } else { inside };
            let is_unsure =
                (told != Matched) | (disparity <= farthest) | (disparity >= nearest);
            let most = if is_unsure { UNSURE } else { 1.0 };
            debug_assert!(!confidence.is_sign_negative(), "confidence is {confidence}");
            // Bits of numbers that are not negative are in their order. Of a condition here the compiler makes
            // another one, whether to write, which AVX2 is slow at.
            *confidence = f32::from_bits(confidence.to_bits().min(most.to_bits()));
            *reason = told;
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
            let mut confidence: Vec<f32> = (0..70).map(|x| (x % 5) as f32 / 100.0 + 0.02).collect();
            confidence[20..].iter_mut().for_each(|confidence| *confidence += 0.5);
            (confidence[40..].iter_mut().step_by(2)).for_each(|confidence| *confidence = 0.0);
            (confidence[41..].iter_mut().step_by(4)).for_each(|confidence| *confidence = 1.0);
            let before = confidence.clone();
            let range = DisparityRange::new(-1, 4).unwrap();
            mark(level, 60, 3, range, &disparities, &mut reasons, &mut confidence);
            for (x, (now, before)) in confidence.iter().zip(before).enumerate() {
                let at_end = disparities[x] <= -0.5 || disparities[x] >= 3.5;
                let is_sure = reasons[x] == Matched && !at_end;
                assert_eq!(*now, if is_sure { before } else { before.min(UNSURE) }, "column {x}");
            }
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
