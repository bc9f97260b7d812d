//! Are estimate and truth on the same scale?
//!
//! Files hold disparities times 4 (the course's 8-bit PNG), times 256 (KITTI), times 16 (OpenCV),
//! times 3 or 2 (smaller Middlebury images). Reading one of them without its factor gives a score
//! that looks like a very bad matcher: the most common mistake with these data sets.

use crate::Pixels;
use crate::course::BAD;

/// Factors that occur between files; -1 where somebody counts from right to left.
const FACTORS: [f64; 7] = [-1.0, 2.0, 3.0, 4.0, 8.0, 16.0, 256.0];

/// The factor by which the estimate seems to be too large (below 1: too small; -1: of the other sign), or `None`.
///
/// It is suspected only when most estimates are bad as they are and dividing them by the factor
/// makes fewer than half as many bad, and fewer than half as many as no disparity at all would have: a large factor
/// brings everything near 0. Truths of 0, in files that mean "unknown" by it, say nothing. A guess for a message:
/// nothing is rescaled.
pub fn suspected_scale(pixels: &Pixels<'_>) -> Option<f64> {
    let known = || pixels.iter().filter(|pixel| pixel.truth != 0.0);
    let estimated = || known().filter_map(|pixel| Some((pixel.estimate?, pixel.truth)));
    let bad =
        |times: f64, most: f64| estimated().filter(|(e, t)| (e * times - t).abs() > most).count();
    let as_it_is = bad(1.0, BAD);
    if 2 * as_it_is <= estimated().count() {
        return None;
    }
    let rescued = |factor: f64| {
        let times = 1.0 / factor;
        // It may be the truth that is too large, and what is bad with it.
        let fewest = [BAD, BAD * times.max(1.0)].into_iter().filter_map(|most| {
            let left = bad(times, most);
            (2 * left < as_it_is.min(bad(0.0, most))).then_some(left)
        });
        Some((fewest.min()?, factor))
    };
    let factors = FACTORS.into_iter().flat_map(|factor| [factor, 1.0 / factor]);
    factors.filter_map(rescued).min_by_key(|&(left, _)| left).map(|(_, factor)| factor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Region;
    use raster::Plane;

    fn suspicion(estimate: impl Fn(f32) -> f32) -> Option<f64> {
        scale(&|x| 10.0 + x, &|x| estimate(10.0 + x))
    }

    /// What is suspected of a row of 50 pixels, whose truth and estimate depend on the column.
    fn scale(truth: &dyn Fn(f32) -> f32, estimate: &dyn Fn(f32) -> f32) -> Option<f64> {
        let truth = Plane::from_fn(50, 1, |x, _| truth(x as f32));
        let estimate = Plane::from_fn(50, 1, |x, _| estimate(x as f32));
        suspected_scale(&Pixels::select(&estimate, &truth, &Region::whole()).unwrap())
    }

    #[test]
    fn a_factor_between_the_files_is_found() {
        for factor in FACTORS {
            assert_eq!(suspicion(|d| d * factor as f32), Some(factor));
            assert_eq!(suspicion(|d| d / factor as f32), Some(1.0 / factor));
        }
        // Truth that was read without its factor: an estimate is half a pixel off.
        for factor in [2.0, 4.0, 16.0, 256.0f32] {
            let found = scale(&|x| factor * (10.0 + x), &|x| 10.5 + x);
            assert_eq!(found, Some(f64::from(1.0 / factor)));
        }
        assert_eq!(scale(&|x| 10.0 + x, &|x| x % 2.0 / 4.0), None, "nearly nothing is no scale");
    }

    #[test]
    fn holes_do_not_speak_for_the_scale() {
        let sparse = |d: f32| if d < 35.0 { f32::NAN } else { 4.0 * d };
        assert_eq!(suspicion(sparse), Some(4.0));
    }

    #[test]
    fn a_bad_matcher_is_not_taken_for_a_factor() {
        assert_eq!(suspicion(|d| d), None);
        assert_eq!(suspicion(|d| d + 40.0), None);
        assert_eq!(suspicion(|_| 0.0), None);
        assert_eq!(suspicion(|_| f32::NAN), None);
    }

    #[test]
    fn a_factor_is_suspected_from_more_than_half_on() {
        for (bad, suspected) in [(25.0, None), (26.0, Some(4.0))] {
            // What is near 0 is right, the others have a factor.
            let truth = |x: f32| if x < bad { 20.0 + x } else { 1.0 };
            assert_eq!(scale(&truth, &|x| if x < bad { 4.0 * truth(x) } else { 1.0 }), suspected);
        }
        for (good, suspected) in [(25.0, None), (26.0, Some(4.0))] {
            // All are bad, and so many would be right without the factor.
            let estimate = |x: f32| if x < good { 4.0 * (20.0 + x) } else { 1000.0 };
            assert_eq!(scale(&|x| 20.0 + x, &estimate), suspected);
        }
        // Off by 2 is not bad.
        assert_eq!(scale(&|_| 2.0, &|_| 4.0), None);
        assert_eq!(scale(&|_| 2.5, &|_| 5.0), Some(2.0));
    }

    #[test]
    fn what_is_near_0_or_unknown_speaks_for_no_factor() {
        assert_eq!(scale(&|x| x / 30.0, &|x| x / 30.0 + 8.0), None);
        // Zeros stand for what nobody knows, and what is known is right.
        let sparse = |x: f32| if x < 35.0 { 0.0 } else { x };
        assert_eq!(scale(&sparse, &|x| x + 5.0), None);
        assert_eq!(scale(&sparse, &|x| 4.0 * x), Some(4.0));
    }
}
