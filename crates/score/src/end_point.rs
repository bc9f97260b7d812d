//! End-point errors: how far off the estimates are, and to which side.
//!
//! Over the `V` pixels that have an estimate, with the signed error `e = estimate - truth`:
//!
//! ```text
//! mean   = 1/V sum |e|          the "EPE" of learned stereo; as Middlebury's avgerr, never clipped
//! median = the middle |e|, or the mean of the two middle ones
//! bias   = 1/V sum e            positive: estimated too near
//! ```
//!
//! The sub-pixel error looks only at pixels with `|e| <= 1`: those whose whole-pixel match was
//! right, so that it measures the interpolation and not the outliers. A bias there points at
//! pixel locking or at a shift between the views.

use serde::Serialize;

use crate::Pixels;
use crate::statistics::{mean, median};

/// A match is right to the pixel when it is off by at most this.
const SUB_PIXEL: f64 = 1.0;

/// End-point errors in pixels, of the estimates only.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EndPoint {
    /// Mean absolute error; `None` without any estimate, as all below.
    pub mean: Option<f64>,
    /// Median absolute error.
    pub median: Option<f64>,
    /// Mean signed error.
    pub bias: Option<f64>,
    /// The errors of pixels that are off by at most 1 px.
    pub sub_pixel: SubPixel,
    /// What was counted, and how.
    pub protocol: String,
}

/// Errors of the pixels that are off by at most 1 px.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SubPixel {
    /// How many there are.
    pub pixels: usize,
    /// Mean absolute error in pixels; `None` when there are none, as below.
    pub mean: Option<f64>,
    /// Root mean square error in pixels.
    pub rms: Option<f64>,
    /// Mean signed error in pixels.
    pub bias: Option<f64>,
}

/// Mean, median, bias and sub-pixel error.
pub fn end_point(pixels: &Pixels<'_>) -> EndPoint {
    let errors: Vec<f64> = pixels.errors().collect();
    let close: Vec<f64> = errors.iter().copied().filter(|error| error.abs() <= SUB_PIXEL).collect();
    EndPoint {
        mean: mean(magnitudes(&errors)),
        median: median(magnitudes(&errors)),
        bias: mean(errors.iter().copied()),
        sub_pixel: SubPixel {
            pixels: close.len(),
            mean: mean(magnitudes(&close)),
            rms: mean(close.iter().map(|error| error * error)).map(f64::sqrt),
            bias: mean(close.iter().copied()),
        },
        protocol: format!(
            "end-point error: the {} estimates among {} pixels with known truth in {}; sub-pixel \
             error of the {} that are off by <= {SUB_PIXEL} px",
            errors.len(),
            pixels.count(),
            pixels.describe(),
            close.len()
        ),
    }
}

fn magnitudes(errors: &[f64]) -> impl Iterator<Item = f64> {
    errors.iter().copied().map(f64::abs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Region;
    use crate::pixels::tests::row;

    fn of(estimate: &[f32], truth: &[f32]) -> EndPoint {
        let (estimate, truth) = row(estimate, truth);
        end_point(&Pixels::select(&estimate, &truth, &Region::whole()).unwrap())
    }

    #[test]
    fn by_hand() {
        // Errors 0.5, -1, 0.25, 4 and a hole.
        let got = of(&[10.5, 9.0, 10.25, 14.0, f32::NAN], &[10.0; 5]);
        assert_eq!(got.mean, Some(5.75 / 4.0));
        assert_eq!(got.median, Some(0.75));
        assert_eq!(got.bias, Some(3.75 / 4.0));
        assert_eq!(got.sub_pixel.pixels, 3);
        assert_eq!(got.sub_pixel.mean, Some(1.75 / 3.0));
        assert_eq!(got.sub_pixel.rms, Some(f64::sqrt((0.25 + 1.0 + 0.0625) / 3.0)));
        assert_eq!(got.sub_pixel.bias, Some(-0.25 / 3.0));
    }

    #[test]
    fn an_odd_number_has_one_middle() {
        assert_eq!(of(&[1.0, 2.0, 9.0], &[0.0; 3]).median, Some(2.0));
    }

    #[test]
    fn without_estimates_there_is_no_mean() {
        let got = of(&[f32::NAN], &[1.0]);
        assert_eq!((got.mean, got.median, got.sub_pixel.rms), (None, None, None));
    }
}
