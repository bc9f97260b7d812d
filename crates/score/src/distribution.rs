//! How errors are distributed: a histogram of signed errors, and the cumulative share below each
//! threshold.
//!
//! The cumulative share is the empirical distribution function of the absolute error,
//! `F(t) = 1/N #{ |estimate - truth| <= t }` over all scored pixels. A hole is never within any
//! threshold, so the curve of a sparse map ends at its density, and `1 - F(t)` is `totbad t`.

use serde::Serialize;

use crate::{Pixels, ScoreError};

/// Signed errors `estimate - truth` counted in bins of equal width.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Histogram {
    /// Lower edge of the first bin in pixels. Bin `i` holds errors from `from + i * width` up to,
    /// but not including, `from + (i + 1) * width`.
    pub from: f64,
    /// Width of a bin in pixels.
    pub width: f64,
    /// How many errors each bin holds.
    pub counts: Vec<usize>,
    /// Errors below the first bin.
    pub below: usize,
    /// Errors at or above the end of the last bin.
    pub above: usize,
    /// Scored pixels without an estimate.
    pub holes: usize,
}

/// Counts signed errors from `-limit` to `limit` pixels in `bins` bins.
pub fn histogram(pixels: &Pixels<'_>, limit: f64, bins: usize) -> Result<Histogram, ScoreError> {
    let refuse = |field, value, allowed| Err(ScoreError::Parameter { field, value, allowed });
    if !(limit.is_finite() && limit > 0.0) {
        return refuse("limit", limit, "it must be a finite number of pixels above 0");
    }
    if bins == 0 {
        return refuse("bins", 0.0, "there must be at least one bin");
    }
    let width = 2.0 * limit / bins as f64;
    let holes = pixels.holes();
    let mut result =
        Histogram { from: -limit, width, counts: vec![0; bins], below: 0, above: 0, holes };
    for error in pixels.errors() {
        let bin = ((error + limit) / width).floor();
        if bin < 0.0 {
            result.below += 1;
        } else if let Some(count) = result.counts.get_mut(bin as usize) {
            *count += 1;
        } else {
            result.above += 1;
        }
    }
    Ok(result)
}

/// The share of scored pixels that are off by at most `threshold`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cumulative {
    /// Absolute error in pixels.
    pub threshold: f64,
    /// Share from 0 to 1; holes are in the denominator only.
    pub share: f64,
}

/// The empirical distribution function of the absolute error at each threshold.
pub fn cumulative(pixels: &Pixels<'_>, thresholds: &[f64]) -> Vec<Cumulative> {
    let mut errors: Vec<f64> = pixels.errors().map(f64::abs).collect();
    errors.sort_unstable_by(f64::total_cmp);
    let all = pixels.count() as f64;
    thresholds
        .iter()
        .map(|&threshold| {
            let within = errors.partition_point(|&error| error <= threshold);
            Cumulative { threshold, share: within as f64 / all }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Region;
    use crate::pixels::tests::row;

    #[test]
    fn every_error_is_in_one_bin_or_outside() {
        // Errors -2, -1, -0.5, 0, 0.99, 1, 7 and a hole, in bins [-1, 0) and [0, 1).
        let estimate = [8.0, 9.0, 9.5, 10.0, 10.99, 11.0, 17.0, f32::NAN];
        let (estimate, truth) = row(&estimate, &[10.0; 8]);
        let pixels = Pixels::select(&estimate, &truth, &Region::whole()).unwrap();
        let got = histogram(&pixels, 1.0, 2).unwrap();
        assert_eq!((got.from, got.width), (-1.0, 1.0));
        assert_eq!((got.below, &got.counts[..], got.above, got.holes), (1, &[2, 2][..], 2, 1));
        assert!(histogram(&pixels, 0.0, 2).is_err());
        assert!(histogram(&pixels, 1.0, 0).is_err());
    }

    #[test]
    fn the_cumulative_share_ends_at_the_density() {
        let (estimate, truth) = row(&[10.0, 11.0, 7.0, f32::NAN], &[10.0; 4]);
        let pixels = Pixels::select(&estimate, &truth, &Region::whole()).unwrap();
        let got = cumulative(&pixels, &[0.0, 1.0, 2.9, 100.0]);
        let shares: Vec<_> = got.iter().map(|point| point.share).collect();
        assert_eq!(shares, [0.25, 0.5, 0.5, 0.75]);
    }
}
