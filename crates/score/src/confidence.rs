//! Does a confidence know which disparities are wrong? ROC and sparsification curves.
//!
//! Rank the `n` scored pixels that have an estimate by falling confidence. The curve `S` gives the
//! mean error of the `k` most confident ones over the density `k/n`; the oracle `O` is the same
//! curve when ranked by the error itself, the best that any confidence can do:
//!
//! ```text
//! S(k) = 1/k sum of the errors of the k most confident pixels
//! O(k) = 1/k sum of the k smallest errors
//! AUC  = 1/n sum_k S(k)         optimum = 1/n sum_k O(k)         AUSE = AUC - optimum
//! ```
//!
//! * With [`RankedError::Bad`] an error is 1 when the pixel is off by more than the threshold, else
//!   0. `S` is then the ROC curve of Hu & Mordohai, *A quantitative evaluation of confidence
//!   measures for stereo vision*, PAMI 2012: error rate over density. Their optimum for an error
//!   rate `b`, `b + (1 - b) ln(1 - b)`, is the limit of ours for many pixels.
//! * With [`RankedError::EndPoint`] an error is the absolute error in pixels. `S` and `O`, read from
//!   right to left, are the sparsification and oracle curves of Ilg et al., *Uncertainty estimates
//!   and multi-hypotheses networks for optical flow*, ECCV 2018, and AUSE is their area under the
//!   sparsification error. They divide the errors by `S(n)`, the error at full density:
//!   [`Sparsification::relative_ause`].
//!
//! **Ties.** Pixels of equal confidence have no order, so each counts with the mean error of its
//! group: the curve is what all orders of the group give on average, and does not depend on where
//! the pixels lie. A constant confidence thus gives `S(k) = S(n)` for every `k`.
//!
//! **Holes** have no confidence and cannot be ranked: they are left out, and their number is
//! stated.

use raster::Plane;
use serde::Serialize;

use crate::pixels::check_size;
use crate::{Pixels, ScoreError};

/// A curve has at most this many points; the areas are taken over all pixels.
const POINTS: usize = 100;

/// What counts as the error of a pixel when pixels are ranked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RankedError {
    /// The absolute error in pixels.
    EndPoint,
    /// 1 when the pixel is off by more than this many pixels, else 0.
    Bad(f64),
}

/// The curves and areas of a confidence.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sparsification {
    /// Which error was ranked.
    pub error: RankedError,
    /// At most 100 points from low to full density, evenly spaced.
    pub curve: Vec<CurvePoint>,
    /// Area under the curve, in the unit of the error.
    pub auc: f64,
    /// Area under the oracle's curve: the least possible.
    pub optimal_auc: f64,
    /// `auc - optimal_auc`, 0 for a perfect ranking.
    pub ause: f64,
    /// `ause` over the error at full density, which makes matchers of different quality
    /// comparable; `None` when there is no error at all.
    pub relative_ause: Option<f64>,
    /// Pixels ranked: those with known truth and an estimate.
    pub pixels: usize,
    /// Scored pixels without an estimate, not ranked.
    pub holes: usize,
    /// What was counted, and how.
    pub protocol: String,
}

/// One point of the curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CurvePoint {
    /// Share of the ranked pixels that is kept, the most confident ones.
    pub density: f64,
    /// Their mean error.
    pub error: f64,
    /// The mean error of as many pixels when ranked by the error itself.
    pub oracle: f64,
}

/// Ranks the estimates by `confidence` (larger is surer, any scale) and draws the curves.
///
/// Errors when the confidence has another size than the estimate, when it is NaN where there is an
/// estimate, or when there is no estimate to rank.
pub fn sparsification(
    pixels: &Pixels<'_>,
    confidence: &Plane<f32>,
    error: RankedError,
) -> Result<Sparsification, ScoreError> {
    check_size("confidence", confidence.size(), pixels.estimate())?;
    if let RankedError::Bad(value) = error
        && !(value.is_finite() && value >= 0.0)
    {
        let allowed = "it must be a finite number of pixels, 0 or more";
        return Err(ScoreError::Parameter { field: "bad threshold", value, allowed });
    }
    let mut ranked: Vec<(f32, f64)> = Vec::with_capacity(pixels.count() - pixels.holes());
    for pixel in pixels.iter() {
        let Some(signed) = pixel.error() else { continue };
        let sure = confidence.row(pixel.y)[pixel.x];
        if sure.is_nan() {
            return Err(ScoreError::Confidence { x: pixel.x, y: pixel.y });
        }
        let size = match error {
            RankedError::EndPoint => signed.abs(),
            RankedError::Bad(threshold) => f64::from(u8::from(signed.abs() > threshold)),
        };
        ranked.push((sure, size));
    }
    let n = ranked.len();
    if n == 0 {
        return Err(ScoreError::NoEstimate { region: pixels.describe().into() });
    }
    let mut errors: Vec<f64> = ranked.iter().map(|&(_, error)| error).collect();
    errors.sort_unstable_by(f64::total_cmp);
    let oracle = means(errors.into_iter());
    ranked.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    spread_ties(&mut ranked);
    let by_confidence = means(ranked.into_iter().map(|(_, error)| error));
    let area = |curve: &[f64]| curve.iter().sum::<f64>() / n as f64;
    let (auc, optimal_auc, full) = (area(&by_confidence), area(&oracle), oracle[n - 1]);
    let points = n.min(POINTS);
    let curve = (1..=points)
        .map(|i| {
            let kept = (n * i).div_ceil(points);
            CurvePoint {
                density: kept as f64 / n as f64,
                error: by_confidence[kept - 1],
                oracle: oracle[kept - 1],
            }
        })
        .collect();
    Ok(Sparsification {
        error,
        curve,
        auc,
        optimal_auc,
        ause: auc - optimal_auc,
        relative_ause: (full > 0.0).then(|| (auc - optimal_auc) / full),
        pixels: n,
        holes: pixels.holes(),
        protocol: format!(
            "ranked by confidence: {n} estimates with known truth in {}; {}; ties count with \
             their mean error; holes are not ranked (holes: {})",
            pixels.describe(),
            match error {
                RankedError::EndPoint => "the error is |estimate - truth| in pixels".into(),
                RankedError::Bad(threshold) => format!("an error is being off by > {threshold} px"),
            },
            pixels.holes()
        ),
    })
}

/// Gives each pixel of a run of equal confidence the mean error of the run.
fn spread_ties(ranked: &mut [(f32, f64)]) {
    for group in ranked.chunk_by_mut(|a, b| a.0 == b.0).filter(|group| group.len() > 1) {
        let mean = group.iter().map(|&(_, error)| error).sum::<f64>() / group.len() as f64;
        group.iter_mut().for_each(|(_, error)| *error = mean);
    }
}

/// The mean of the first 1, 2, 3, ... values.
fn means(values: impl Iterator<Item = f64>) -> Vec<f64> {
    values
        .scan((0.0, 0.0), |(sum, count), value| {
            *sum += value;
            *count += 1.0;
            Some(*sum / *count)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Region;
    use crate::pixels::tests::row;

    fn of(errors: &[f32], confidence: &[f32], error: RankedError) -> Sparsification {
        let (estimate, truth) = row(errors, &vec![0.0; errors.len()]);
        let pixels = Pixels::select(&estimate, &truth, &Region::whole()).unwrap();
        let confidence = Plane::new(errors.len(), 1, confidence.to_vec()).unwrap();
        sparsification(&pixels, &confidence, error).unwrap()
    }

    #[test]
    fn by_hand() {
        // In order of confidence the errors are 1, 4, 0, 3; sorted 0, 1, 3, 4.
        let got = of(&[3.0, 1.0, 0.0, 4.0], &[0.1, 0.9, 0.2, 0.8], RankedError::EndPoint);
        let curve: Vec<_> = got.curve.iter().map(|p| (p.density, p.error, p.oracle)).collect();
        let expected =
            [(0.25, 1.0, 0.0), (0.5, 2.5, 0.5), (0.75, 5.0 / 3.0, 4.0 / 3.0), (1.0, 2.0, 2.0)];
        assert_eq!(curve, expected);
        assert_eq!(got.auc, (1.0 + 2.5 + 5.0 / 3.0 + 2.0) / 4.0);
        assert_eq!(got.optimal_auc, (0.0 + 0.5 + 4.0 / 3.0 + 2.0) / 4.0);
        assert_eq!(got.relative_ause, Some((got.auc - got.optimal_auc) / 2.0));
    }

    #[test]
    fn of_many_pixels_a_hundred_parts_are_kept_none_of_them_less_than_its_share() {
        let errors: Vec<f32> = (0..250).map(|i| i as f32).collect();
        let got = of(&errors, &vec![0.5; 250], RankedError::EndPoint);
        assert_eq!(got.curve.len(), 100);
        let kept = [0, 1, 99].map(|i| got.curve[i].density * 250.0);
        assert_eq!(kept, [3.0, 5.0, 250.0]);
    }

    #[test]
    fn the_best_ranking_has_no_ause_and_the_worst_the_most() {
        let errors = [0.0, 1.0, 2.0, 5.0];
        let best = of(&errors, &[4.0, 3.0, 2.0, 1.0], RankedError::Bad(1.0));
        let worst = of(&errors, &[1.0, 2.0, 3.0, 4.0], RankedError::Bad(1.0));
        assert_eq!(best.ause, 0.0);
        assert_eq!(worst.auc, (1.0 + 1.0 + 2.0 / 3.0 + 0.5) / 4.0);
    }

    #[test]
    fn ties_count_with_their_mean_wherever_they_lie() {
        let constant = of(&[4.0, 0.0, 2.0], &[0.5; 3], RankedError::EndPoint);
        assert!(constant.curve.iter().all(|point| point.error == 2.0));
        assert_eq!(constant.auc, 2.0);
    }

    #[test]
    fn the_optimum_tends_to_the_formula_of_hu_and_mordohai() {
        // 30 % of 10000 pixels are bad: 0.3 + 0.7 ln 0.7.
        let errors: Vec<f32> = (0..10_000).map(|i| if i % 10 < 3 { 9.0 } else { 0.0 }).collect();
        let got = of(&errors, &vec![1.0; 10_000], RankedError::Bad(2.0));
        assert!((got.optimal_auc - (0.3 + 0.7 * f64::ln(0.7))).abs() < 1e-3);
    }

    #[test]
    fn without_an_error_there_is_none_to_relate_to() {
        for error in [RankedError::EndPoint, RankedError::Bad(0.0)] {
            let got = of(&[0.0; 3], &[0.1, 0.9, 0.5], error);
            assert_eq!((got.auc, got.ause, got.relative_ause), (0.0, 0.0, None));
        }
        // Off by more than nothing is bad.
        assert_eq!(of(&[0.0, 0.25], &[0.9, 0.1], RankedError::Bad(0.0)).auc, 0.25);
    }

    #[test]
    fn holes_are_stated_and_bad_input_is_refused() {
        let got = of(&[f32::NAN, 1.0], &[f32::NAN, 0.5], RankedError::EndPoint);
        assert_eq!((got.pixels, got.holes), (1, 1));

        let (estimate, truth) = row(&[1.0, 1.0], &[1.0, 1.0]);
        let pixels = Pixels::select(&estimate, &truth, &Region::whole()).unwrap();
        let nan = Plane::new(2, 1, vec![0.5, f32::NAN]).unwrap();
        let error = sparsification(&pixels, &nan, RankedError::EndPoint).unwrap_err();
        assert_eq!(error, ScoreError::Confidence { x: 1, y: 0 });
        let small = Plane::filled(1, 1, 0.5);
        assert!(sparsification(&pixels, &small, RankedError::EndPoint).is_err());
        for threshold in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(sparsification(&pixels, &truth, RankedError::Bad(threshold)).is_err());
        }

        let (estimate, truth) = row(&[f32::NAN], &[1.0]);
        let pixels = Pixels::select(&estimate, &truth, &Region::whole()).unwrap();
        let error = sparsification(&pixels, &truth, RankedError::EndPoint).unwrap_err();
        assert!(matches!(error, ScoreError::NoEstimate { .. }));
    }
}
