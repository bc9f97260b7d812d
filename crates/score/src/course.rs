//! The course's two numbers.
//!
//! Over the `N` pixels of the inclusive box whose true disparity `I_t` is nonzero (a zero in the
//! course's files says that nobody knows):
//!
//! ```text
//! E_RMS = sqrt(1/N sum (I_d - I_t)^2)          in pixels
//! p_bad = 1/N sum [ |I_d - I_t| > 2 ]          a share, 0 to 1
//! ```
//!
//! **A hole** counts as disparity 0 in E_RMS, which is what the course's arrays hold where a
//! submission answered nothing, and as bad in p_bad. Leaving holes out would reward a matcher for
//! answering only what is easy.

use serde::Serialize;

use crate::Pixels;

/// An error above this many pixels is bad.
pub(crate) const BAD: f64 = 2.0;

/// E_RMS and p_bad as the course defines them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Course {
    /// Root mean square error in pixels, a hole counted as disparity 0.
    pub e_rms: f64,
    /// Share of pixels that are off by more than 2 px, holes included.
    pub p_bad: f64,
    /// Pixels counted: those with a known, nonzero truth.
    pub pixels: usize,
    /// How many of them have no estimate.
    pub holes: usize,
    /// What was counted, and how.
    pub protocol: String,
}

/// E_RMS and p_bad, or `None` when every known truth of the region is zero.
pub fn course(pixels: &Pixels<'_>) -> Option<Course> {
    let (mut count, mut holes, mut bad, mut squares) = (0usize, 0usize, 0usize, 0.0);
    for pixel in pixels.iter().filter(|pixel| pixel.truth != 0.0) {
        count += 1;
        holes += usize::from(pixel.estimate.is_none());
        bad += usize::from(pixel.error().is_none_or(|error| error.abs() > BAD));
        squares += (pixel.estimate.unwrap_or(0.0) - pixel.truth).powi(2);
    }
    if count == 0 {
        return None;
    }
    Some(Course {
        e_rms: (squares / count as f64).sqrt(),
        p_bad: bad as f64 / count as f64,
        pixels: count,
        holes,
        protocol: format!(
            "course: {count} pixels with known, nonzero truth in {}; bad is > {BAD} px; a hole \
             counts as disparity 0 in E_RMS and as bad in p_bad (holes: {holes})",
            pixels.describe()
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Region;
    use crate::pixels::tests::row;

    fn of(estimate: &[f32], truth: &[f32]) -> Option<Course> {
        let (estimate, truth) = row(estimate, truth);
        course(&Pixels::select(&estimate, &truth, &Region::whole()).unwrap())
    }

    #[test]
    fn by_hand() {
        // Errors 0, 1, -2, 3 and an unknown: squares 0 + 1 + 4 + 9 = 14 over 4 pixels.
        let got = of(&[5.0, 6.0, 3.0, 8.0, 9.0], &[5.0, 5.0, 5.0, 5.0, 0.0]).unwrap();
        assert_eq!(got.e_rms, 3.5f64.sqrt());
        assert_eq!(got.p_bad, 0.25); // exactly 2 px off is not bad
        assert_eq!((got.pixels, got.holes), (4, 0));
    }

    #[test]
    fn a_hole_counts_as_disparity_zero_and_as_bad() {
        // A true disparity of 1 shows the difference: 0 would be off by 1 only.
        let got = of(&[f32::NAN, 1.0], &[1.0, 1.0]).unwrap();
        assert_eq!(got.e_rms, 0.5f64.sqrt());
        assert_eq!((got.p_bad, got.holes), (0.5, 1));
        assert!(got.protocol.ends_with("as bad in p_bad (holes: 1)"));
    }

    #[test]
    fn zero_truth_alone_cannot_be_scored() {
        assert_eq!(of(&[1.0], &[0.0]), None);
    }
}
