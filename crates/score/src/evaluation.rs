//! All families of measures at once, for one region or for several.

use std::borrow::Cow;

use raster::Plane;
use serde::Serialize;

use crate::kitti::fill_from_background;
use crate::pixels::check_size;
use crate::{Course, EndPoint, Kitti, Middlebury, Pixels, Region, ScoreError};
use crate::{course, end_point, kitti, middlebury};

/// An estimate and its truth, ready to be scored over as many regions as wanted.
#[derive(Debug, Clone)]
pub struct Evaluation<'a> {
    estimate: &'a Plane<f32>,
    truth: &'a Plane<f32>,
    filled: Cow<'a, Plane<f32>>,
    max_disparity: Option<f64>,
}

/// Every score of an estimate over one region. Each family names its protocol.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scores {
    /// The region's name: "all", "non-occluded", ...
    pub region: String,
    /// Pixels of the region whose truth is known.
    pub pixels: usize,
    /// How many of them have no estimate.
    pub holes: usize,
    /// E_RMS and p_bad; `None` when every known truth is zero, which the course reads as unknown.
    pub course: Option<Course>,
    /// Bad pixels, average errors and quantiles.
    pub middlebury: Middlebury,
    /// Outliers after filling.
    pub kitti: Kitti,
    /// End-point errors, bias and sub-pixel error.
    pub end_point: EndPoint,
}

impl<'a> Evaluation<'a> {
    /// Errors when the two differ in size.
    pub fn new(estimate: &'a Plane<f32>, truth: &'a Plane<f32>) -> Result<Self, ScoreError> {
        check_size("truth", truth.size(), estimate)?;
        let dense = estimate.samples().iter().all(|value| value.is_finite());
        let filled = match dense {
            true => Cow::Borrowed(estimate),
            false => Cow::Owned(fill_from_background(estimate)),
        };
        Ok(Self { estimate, truth, filled, max_disparity: None })
    }

    /// Clips estimates to the range from 0 to this many pixels for the Middlebury measures, as the
    /// benchmark does. The other families never clip.
    pub fn clipped_to(mut self, max_disparity: Option<f64>) -> Self {
        self.max_disparity = max_disparity;
        self
    }

    /// The pixels of a region, for measures that are not part of [`Scores`].
    pub fn pixels(&self, region: &Region<'a>) -> Result<Pixels<'a>, ScoreError> {
        Pixels::select(self.estimate, self.truth, region)
    }

    /// Every score over a region. Errors when the mask has another size, the box leaves the image,
    /// or no truth is known there.
    pub fn scores(&self, region: &Region<'a>) -> Result<Scores, ScoreError> {
        let pixels = self.pixels(region)?;
        Ok(Scores {
            region: region.name().into(),
            pixels: pixels.count(),
            holes: pixels.holes(),
            course: course(&pixels),
            middlebury: middlebury(&pixels, self.max_disparity)?,
            kitti: kitti(&pixels, &self.filled)?,
            end_point: end_point(&pixels),
        })
    }
}

/// Every score of an estimate over one region, without clipping: a shorthand for
/// [`Evaluation::scores`].
pub fn evaluate(
    estimate: &Plane<f32>,
    truth: &Plane<f32>,
    region: &Region<'_>,
) -> Result<Scores, ScoreError> {
    Evaluation::new(estimate, truth)?.scores(region)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_holds_numbers_and_protocols() {
        let truth = Plane::filled(2, 1, 5.0);
        let estimate = Plane::new(2, 1, vec![5.0, f32::NAN]).unwrap();
        let scores = evaluate(&estimate, &truth, &Region::whole()).unwrap();
        let json = serde_json::to_value(&scores).unwrap();
        assert_eq!(json["holes"], 1);
        assert_eq!(json["middlebury"]["bad"][2]["totbad"], 0.5);
        for family in ["course", "middlebury", "kitti", "end_point"] {
            let protocol = json[family]["protocol"].as_str().unwrap();
            assert!(protocol.contains("in the whole image"), "{protocol}");
        }
    }

    #[test]
    fn filling_uses_what_lies_outside_the_region() {
        let truth = Plane::filled(2, 1, 50.0);
        let mask = Plane::new(2, 1, vec![false, true]).unwrap();
        for hole in [f32::NAN, f32::INFINITY] {
            let estimate = Plane::new(2, 1, vec![50.0, hole]).unwrap();
            let scores = evaluate(&estimate, &truth, &Region::masked("right", &mask)).unwrap();
            assert_eq!((scores.kitti.d1, scores.kitti.density), (0.0, 0.0));
            assert_eq!(scores.region, "right");
        }
    }

    #[test]
    fn only_middlebury_clips() {
        let (estimate, truth) = (Plane::filled(1, 1, 90.0), Plane::filled(1, 1, 60.0));
        let scores = Evaluation::new(&estimate, &truth)
            .and_then(|evaluation| evaluation.clipped_to(Some(60.0)).scores(&Region::whole()))
            .unwrap();
        assert_eq!(scores.middlebury.avgerr, Some(0.0));
        assert_eq!(scores.end_point.mean, Some(30.0));
        assert_eq!(scores.course.unwrap().e_rms, 30.0);
    }
}
