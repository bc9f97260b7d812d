//! The measures of the Middlebury benchmark, version 3.
//!
//! Scharstein, Hirschmüller, Kitajima, Krathwohl, Nešić, Wang, Westling: *High-resolution stereo
//! datasets with subpixel-accurate ground truth*, GCPR 2014, and the benchmark's SDK, whose
//! counting is followed, but for its rounding and scaling (METHODOLOGY.md). Over the `N` pixels of the
//! region whose truth is known, of which `V` have an estimate (the other `N - V` are holes, "invalid" in the SDK), with
//! `e = |estimate - truth|`:
//!
//! ```text
//! bad T   = 1/N #{ estimates with e > T }        T = 0.5, 1, 2, 4
//! totbad  = bad T + (N - V)/N                    holes counted as bad
//! density = V/N
//! avgerr  = 1/V sum e                            of the estimates only
//! rms     = sqrt(1/V sum e^2)                    of the estimates only
//! Aq      = the smallest error that at least q % of the estimates do not exceed
//! ```
//!
//! `bad` alone flatters a sparse map: a matcher that answers nothing has `bad = 0`. The share of
//! wrong ones among the estimates stands beside it as [`Bad::of_estimates`].
//!
//! The SDK clips estimates to the scene's range 0 to `max_disparity` before it compares them; this
//! is done when a largest disparity is given, and the number of clipped estimates is shown. The
//! SDK does not say how it interpolates quantiles; here a quantile is always an error that occurs
//! (nearest rank).

use serde::Serialize;

use crate::{Pixels, ScoreError};

/// The benchmark's thresholds in pixels.
const THRESHOLDS: [f64; 4] = [0.5, 1.0, 2.0, 4.0];

/// The measures of the Middlebury benchmark.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Middlebury {
    /// Bad pixels at 0.5, 1, 2 and 4 px.
    pub bad: [Bad; 4],
    /// Mean absolute error of the estimates in pixels; `None` without any estimate.
    pub avgerr: Option<f64>,
    /// Root mean square error of the estimates in pixels; `None` without any estimate.
    pub rms: Option<f64>,
    /// Half of the estimates are off by no more than this, in pixels.
    pub a50: Option<f64>,
    /// 90 % of the estimates are off by no more than this, in pixels.
    pub a90: Option<f64>,
    /// 95 % of the estimates are off by no more than this, in pixels.
    pub a95: Option<f64>,
    /// 99 % of the estimates are off by no more than this, in pixels.
    pub a99: Option<f64>,
    /// Share of the scored pixels that have an estimate.
    pub density: f64,
    /// Estimates that were clipped to the scene's range.
    pub clipped: usize,
    /// What was counted, and how.
    pub protocol: String,
}

/// Bad pixels at one threshold, as shares from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bad {
    /// An error strictly above this many pixels is bad.
    pub threshold: f64,
    /// Wrong estimates and holes, over all scored pixels ("totbad" on the benchmark's pages).
    pub totbad: f64,
    /// Wrong estimates over all scored pixels; holes count as not bad.
    pub bad: f64,
    /// Wrong estimates over all estimates; `None` without any.
    pub of_estimates: Option<f64>,
}

/// The benchmark's measures. With `max_disparity` (finite, not negative), estimates are clipped to
/// the range from 0 to it first.
pub fn middlebury(
    pixels: &Pixels<'_>,
    max_disparity: Option<f64>,
) -> Result<Middlebury, ScoreError> {
    if let Some(value) = max_disparity.filter(|&value| !(value.is_finite() && value >= 0.0)) {
        let allowed = "it must be a finite number of pixels, 0 or more";
        return Err(ScoreError::Parameter { field: "max-disparity", value, allowed });
    }
    let mut clipped = 0;
    let mut errors: Vec<f64> = Vec::with_capacity(pixels.count() - pixels.holes());
    for pixel in pixels.iter() {
        let Some(estimate) = pixel.estimate else { continue };
        let inside = max_disparity.map_or(estimate, |largest| estimate.clamp(0.0, largest));
        clipped += usize::from(inside != estimate);
        errors.push((inside - pixel.truth).abs());
    }
    let (all, holes) = (pixels.count() as f64, pixels.holes() as f64);
    let estimates = errors.len() as f64;
    let of_estimates = |value: f64| (!errors.is_empty()).then(|| value / estimates);
    let bad = THRESHOLDS.map(|threshold| {
        let wrong = errors.iter().filter(|&&error| error > threshold).count() as f64;
        Bad {
            threshold,
            totbad: (wrong + holes) / all,
            bad: wrong / all,
            of_estimates: of_estimates(wrong),
        }
    });
    let avgerr = of_estimates(errors.iter().sum());
    let rms = of_estimates(errors.iter().map(|error| error * error).sum()).map(f64::sqrt);
    errors.sort_unstable_by(f64::total_cmp);
    let [a50, a90, a95, a99] = [50, 90, 95, 99].map(|percent| quantile(&errors, percent));
    Ok(Middlebury {
        bad,
        avgerr,
        rms,
        a50,
        a90,
        a95,
        a99,
        density: pixels.density(),
        clipped,
        protocol: format!(
            "Middlebury v3: {} pixels with known truth in {}; bad T is off by > T px, or a hole \
             (holes: {}); avgerr, rms, A50 to A99 and everything that ends in -est are of the \
             estimates only; {}",
            pixels.count(),
            pixels.describe(),
            pixels.holes(),
            match max_disparity {
                Some(largest) => format!("{clipped} estimates clipped to 0 to {largest}"),
                None => "estimates not clipped".into(),
            }
        ),
    })
}

/// The smallest of the sorted errors that at least `percent` % of them do not exceed.
fn quantile(sorted: &[f64], percent: usize) -> Option<f64> {
    let rank = (sorted.len() * percent).div_ceil(100);
    sorted.get(rank.checked_sub(1)?).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Region;
    use crate::pixels::tests::row;

    fn of(estimate: &[f32], truth: &[f32], max_disparity: Option<f64>) -> Middlebury {
        let (estimate, truth) = row(estimate, truth);
        let pixels = Pixels::select(&estimate, &truth, &Region::whole()).unwrap();
        middlebury(&pixels, max_disparity).unwrap()
    }

    #[test]
    fn by_hand() {
        // Errors .5, 1, 3, -5 and a hole, over five pixels.
        let truth = [10.0; 5];
        let got = of(&[10.5, 11.0, 13.0, 5.0, f32::NAN], &truth, None);
        let shares = |b: &Bad| (b.threshold, b.bad, b.totbad, b.of_estimates);
        assert_eq!(got.bad.each_ref().map(shares)[0], (0.5, 0.6, 0.8, Some(0.75)));
        assert_eq!(got.bad.each_ref().map(shares)[1], (1.0, 0.4, 0.6, Some(0.5)));
        assert_eq!(got.bad.each_ref().map(shares)[2], (2.0, 0.4, 0.6, Some(0.5)));
        assert_eq!(got.bad.each_ref().map(shares)[3], (4.0, 0.2, 0.4, Some(0.25)));
        assert_eq!(got.avgerr, Some(9.5 / 4.0));
        assert_eq!(got.rms, Some(f64::sqrt((0.25 + 1.0 + 9.0 + 25.0) / 4.0)));
        assert_eq!((got.a50, got.a90, got.density), (Some(1.0), Some(5.0), 0.8));
    }

    #[test]
    fn quantiles_are_errors_that_occur() {
        let sorted: Vec<f64> = (1..=200).map(f64::from).collect();
        assert_eq!(quantile(&sorted, 50), Some(100.0));
        assert_eq!(quantile(&sorted, 99), Some(198.0));
        assert_eq!(quantile(&sorted[..1], 50), Some(1.0));
        assert_eq!(quantile(&[], 50), None);
    }

    #[test]
    fn estimates_are_clipped_to_the_range_when_it_is_given() {
        let got = of(&[-3.0, 70.0, 20.0], &[1.0, 60.0, 20.0], Some(64.0));
        assert_eq!((got.clipped, got.avgerr), (2, Some(5.0 / 3.0)));
        assert!(got.protocol.ends_with("2 estimates clipped to 0 to 64"));
    }

    #[test]
    fn no_estimate_is_no_error_but_all_bad() {
        let got = of(&[f32::NAN], &[1.0], None);
        assert_eq!((got.avgerr, got.a99, got.density), (None, None, 0.0));
        assert_eq!((got.bad[3].totbad, got.bad[3].bad), (1.0, 0.0));
    }

    #[test]
    fn a_range_that_is_none_is_refused() {
        let (estimate, truth) = row(&[1.0], &[1.0]);
        let pixels = Pixels::select(&estimate, &truth, &Region::whole()).unwrap();
        for largest in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(middlebury(&pixels, Some(largest)).is_err());
        }
        assert_eq!(middlebury(&pixels, Some(0.0)).unwrap().avgerr, Some(1.0));
    }
}
