//! KITTI's D1 and Out-T, and how its development kits fill holes before scoring.
//!
//! Menze & Geiger: *Object scene flow for autonomous vehicles*, CVPR 2015, and the benchmark's
//! development kit. A pixel is an outlier when its error exceeds both 3 px and 5 % of the truth:
//!
//! ```text
//! D1 = 1/N #{ |estimate - truth| > 3  and  |estimate - truth| > 0.05 |truth| }
//! ```
//!
//! That is the benchmark of 2015. The one of 2012 (Geiger, Lenz & Urtasun: *Are we ready for autonomous driving?*, CVPR
//! 2012) counts what is off by more than `T` = 2, 3, 4 and 5 px, whatever the truth:
//!
//! ```text
//! Out-T = 1/N #{ |estimate - truth| > T }
//! ```
//!
//! The benchmark scores dense maps: [`fill_from_background`] closes the holes first, from the whole
//! map, also from outside the region. [`Kitti::d1`] and [`Kitti::out`] are numbers after filling ("All / All" on the
//! benchmark's pages), [`Kitti::d1_est`] that of the pixels that had an estimate ("All / Est"), and
//! the density belongs beside it. Whether the score is `noc` or `occ` is decided by the truth or
//! the mask that it is given.

use raster::Plane;
use serde::Serialize;

use crate::pixels::check_size;
use crate::{Pixels, ScoreError};

/// An outlier is off by more than this many pixels ...
const PIXELS: f64 = 3.0;
/// ... and by more than this share of the true disparity.
const SHARE: f64 = 0.05;
/// The thresholds of 2012 in pixels.
const THRESHOLDS: [f64; 4] = [2.0, 3.0, 4.0, 5.0];

/// KITTI's outlier rates.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Kitti {
    /// Share of outliers after holes were filled from the background. A pixel that could not be
    /// filled is an outlier.
    pub d1: f64,
    /// Share of outliers among the pixels with an estimate; `None` without any.
    pub d1_est: Option<f64>,
    /// Out-2, Out-3, Out-4 and Out-5 of the benchmark of 2012, after the same filling.
    pub out: [Out; 4],
    /// Share of the scored pixels that had an estimate before filling.
    pub density: f64,
    /// What was counted, and how.
    pub protocol: String,
}

/// Outliers at one threshold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Out {
    /// An error strictly above this many pixels is an outlier.
    pub threshold: f64,
    /// Share of outliers after holes were filled from the background, from 0 to 1. A pixel that could not be filled is
    /// an outlier.
    pub share: f64,
}

/// The outlier rates of the pixels, whose estimate is the map as it is, and of the same pixels in `filled`, which
/// is that map after [`fill_from_background`].
///
/// Errors when `filled` has another size.
pub fn kitti(pixels: &Pixels<'_>, filled: &Plane<f32>) -> Result<Kitti, ScoreError> {
    check_size("filled map", filled.size(), pixels.estimate())?;
    let outlier =
        |error: f64, truth: f64| error.abs() > PIXELS && error.abs() > SHARE * truth.abs();
    let (mut estimates, mut of_estimates) = (0usize, 0usize);
    for pixel in pixels.iter() {
        if let Some(error) = pixel.error() {
            estimates += 1;
            of_estimates += usize::from(outlier(error, pixel.truth));
        }
    }
    let (mut after_filling, mut out) = (0usize, THRESHOLDS.map(|_| 0usize));
    for pixel in pixels.with_estimate(filled) {
        let error = pixel.error();
        after_filling += usize::from(error.is_none_or(|error| outlier(error, pixel.truth)));
        for (count, threshold) in out.iter_mut().zip(THRESHOLDS) {
            *count += usize::from(error.is_none_or(|error| error.abs() > threshold));
        }
    }
    let share = |count: usize| count as f64 / pixels.count() as f64;
    let out = std::array::from_fn(|i| Out { threshold: THRESHOLDS[i], share: share(out[i]) });
    Ok(Kitti {
        d1: share(after_filling),
        out,
        d1_est: (estimates > 0).then(|| of_estimates as f64 / estimates as f64),
        density: pixels.density(),
        protocol: format!(
            "KITTI: {} pixels with known truth in {}; an outlier is off by > {PIXELS} px and \
             > {} % (D1, 2015), or by > T px (OutT, 2012), after holes were filled from the \
             background in their row (holes: {}); D1-est of the estimates only",
            pixels.count(),
            pixels.describe(),
            SHARE * 100.0,
            pixels.holes()
        ),
    })
}

/// Closes holes as KITTI's development kit does.
///
/// Along each row, a gap between two values takes the smaller of them (the farther surface: the
/// background), and gaps at the row's ends take the nearest value. Rows without any value above the
/// first or below the last row that has one copy that row; such rows in between stay holes, as
/// they do in the kit. Values that exist are never changed.
pub fn fill_from_background(map: &Plane<f32>) -> Plane<f32> {
    let mut filled = map.clone();
    let mut rows_with_values = Vec::new();
    for y in 0..filled.rows() {
        if fill_row(filled.row_mut(y)) {
            rows_with_values.push(y);
        }
    }
    if let (Some(&first), Some(&last)) = (rows_with_values.first(), rows_with_values.last()) {
        let (top, bottom) = (filled.row(first).to_vec(), filled.row(last).to_vec());
        (0..first).for_each(|y| filled.row_mut(y).copy_from_slice(&top));
        (last + 1..filled.rows()).for_each(|y| filled.row_mut(y).copy_from_slice(&bottom));
    }
    filled
}

/// Fills one row; false when it holds no value at all.
fn fill_row(row: &mut [f32]) -> bool {
    let Some(first) = row.iter().position(|value| value.is_finite()) else { return false };
    let leading = row[first];
    row[..first].fill(leading);
    let mut previous = first;
    for x in first + 1..row.len() {
        if row[x].is_finite() {
            let background = row[previous].min(row[x]);
            row[previous + 1..x].fill(background);
            previous = x;
        }
    }
    let trailing = row[previous];
    row[previous + 1..].fill(trailing);
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Region;
    use crate::pixels::tests::row;

    const N: f32 = f32::NAN;

    fn of(estimate: &[f32], truth: &[f32]) -> Kitti {
        let (estimate, truth) = row(estimate, truth);
        let pixels = Pixels::select(&estimate, &truth, &Region::whole()).unwrap();
        kitti(&pixels, &fill_from_background(&estimate)).unwrap()
    }

    #[test]
    fn a_filled_map_of_another_size_is_refused() {
        let (estimate, truth) = row(&[1.0, 2.0], &[1.0, 2.0]);
        let pixels = Pixels::select(&estimate, &truth, &Region::whole()).unwrap();
        let error = kitti(&pixels, &Plane::filled(1, 1, 1.0)).unwrap_err().to_string();
        assert!(error.contains("1 x 1") && error.contains("2 x 1"), "{error}");
    }

    #[test]
    fn an_outlier_exceeds_both_thresholds() {
        // Off by 4 of 100 (4 %), 4 of 80 (not more than 5 %), 4 of 50 (8 %), 3 of 10 (not more than 3 px), 2.5 of 5.
        let got = of(&[104.0, 84.0, 54.0, 13.0, 7.5], &[100.0, 80.0, 50.0, 10.0, 5.0]);
        assert_eq!((got.d1, got.d1_est, got.density), (0.2, Some(0.2), 1.0));
    }

    #[test]
    fn outliers_of_2012_exceed_a_number_of_pixels() {
        // Off by 4 of 100, 5.5 of 50, 2 and 3 of 10; a gap that takes 10, which is off by 2.5.
        let got = of(&[104.0, 55.5, 12.0, 13.0, N, 10.0], &[100.0, 50.0, 10.0, 10.0, 7.5, 10.0]);
        let share = got.out.map(|out| out.share);
        assert_eq!(got.out.map(|out| out.threshold), [2.0, 3.0, 4.0, 5.0]);
        assert_eq!(share, [4.0 / 6.0, 2.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0]);
        assert_eq!(of(&[N, N], &[10.0, 10.0]).out.map(|out| out.share), [1.0; 4]);
    }

    #[test]
    fn holes_are_filled_for_d1_and_left_out_of_d1_est() {
        // The gap takes 10, which is right for the first hole and wrong for the second.
        let got = of(&[10.0, N, N, 30.0], &[10.0, 10.0, 30.0, 30.0]);
        assert_eq!((got.d1, got.d1_est, got.density), (0.25, Some(0.0), 0.5));
        let nothing = of(&[N, N], &[10.0, 10.0]);
        assert_eq!((nothing.d1, nothing.d1_est), (1.0, None));
    }

    #[test]
    fn gaps_take_the_smaller_neighbour_and_ends_the_nearest() {
        let map = Plane::new(6, 1, vec![N, 5.0, N, N, 3.0, N]).unwrap();
        assert_eq!(fill_from_background(&map).samples(), [5.0, 5.0, 3.0, 3.0, 3.0, 3.0]);
    }

    #[test]
    fn rows_without_values_take_the_nearest_row_at_top_and_bottom() {
        let map = Plane::new(1, 5, vec![N, 2.0, N, 7.0, N]).unwrap();
        let filled = fill_from_background(&map);
        assert_eq!(filled.samples()[..2], [2.0, 2.0]);
        assert!(filled.samples()[2].is_nan(), "the kit leaves a whole row in between empty");
        assert_eq!(filled.samples()[3..], [7.0, 7.0]);
        let empty = Plane::filled(2, 2, N);
        assert!(fill_from_background(&empty).samples().iter().all(|v| v.is_nan()));
    }
}
