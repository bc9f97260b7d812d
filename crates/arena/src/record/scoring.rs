//! An answer against a scene's truth, region by region.

use score::{Evaluation, RankedError, Region, ScoreError, Scores, sparsification};
use serde::Serialize;

use raster::{BoundingBox, Reason};

use super::obstacles::{FalseAlarms, Missed, false_alarms, missed};
use crate::dataset::CaseData;
use crate::engine::Answer;

/// Errors above this many pixels are what a confidence should rank last.
pub const RANKED_BAD: f64 = 2.0;

/// How sure a pixel may have to be.
pub const LEAST_CONFIDENCES: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 0.9];

/// How well a confidence ranks errors.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConfidenceScore {
    /// Area under the sparsification curve of bad pixels, less the least possible: 0 is perfect.
    pub ause: f64,
    /// `ause` over the share of bad pixels at full density; `None` without any bad pixel.
    pub relative_ause: Option<f64>,
    /// Area under the curve.
    pub auc: f64,
    /// The least possible area.
    pub optimal_auc: f64,
    /// What was counted, and how.
    pub protocol: String,
}

/// Scores of one answer.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RegionScores {
    /// Over all pixels with truth, then over each region that has any.
    pub scores: Vec<Scores>,
    /// Over the pixels of each reason that any pixel with truth was given; their regions are the
    /// names of the reasons.
    pub by_reason: Vec<Scores>,
    /// Over the pixels that are at least as sure as each of [`LEAST_CONFIDENCES`], if there is a
    /// confidence and any is; their regions are named by [`at_least`].
    pub by_confidence: Vec<Scores>,
    /// How much of small obstacles is missed, by their width and step; empty where none were laid.
    pub missed: Vec<Missed>,
    /// How much of what is around them is taken for some, by how near it looks; empty where none were laid.
    pub false_alarms: Vec<FalseAlarms>,
    /// How well the confidence ranks errors, if there is a confidence and an estimate to rank.
    pub confidence: Option<ConfidenceScore>,
}

/// Scores an answer inside the scene's box. Without truth there are no scores.
///
/// Middlebury's measures clip estimates to 0 to the largest disparity, as its benchmark does, where
/// the scene's range begins at 0 or above; that benchmark knows no negative disparities.
pub fn score(answer: &Answer, data: &CaseData) -> Result<RegionScores, ScoreError> {
    let Some(truth) = &data.truth else { return Ok(RegionScores::default()) };
    let whole = BoundingBox::whole(data.left.columns(), data.left.rows());
    let bounds = Some(data.bounds).filter(|bounds| *bounds != whole);
    let clips = data.range.min() >= 0 && data.range.max() > 0;
    let highest = clips.then_some(f64::from(data.range.max()));
    let evaluation = Evaluation::new(&answer.disparity, truth)?.clipped_to(highest);
    let all = Region::whole().within(bounds);
    let mut scores = vec![evaluation.scores(&all)?];
    let mut by_reason = Vec::new();
    if let Some(reasons) = &answer.reasons {
        for reason in Reason::ALL {
            let mask = reasons.map(|&other| other == reason);
            let selected = Region::masked(reason.name(), &mask).within(bounds);
            by_reason.extend(if_any(evaluation.scores(&selected))?);
        }
    }
    let mut by_confidence = Vec::new();
    if let Some(confidence) = &answer.confidence {
        for least in LEAST_CONFIDENCES {
            let mask = confidence.map(|&sure| sure >= least);
            let selected = Region::masked(at_least(least), &mask).within(bounds);
            by_confidence.extend(if_any(evaluation.scores(&selected))?);
        }
    }
    for region in &data.regions {
        let selected = Region::masked(region.name, &region.mask).within(bounds);
        let scored = match &region.truth {
            None => evaluation.scores(&selected),
            Some(own) => {
                Evaluation::new(&answer.disparity, own)?.clipped_to(highest).scores(&selected)
            }
        };
        scores.extend(if_any(scored)?);
    }
    let confidence = match &answer.confidence {
        None => None,
        Some(confidence) => {
            let pixels = evaluation.pixels(&all)?;
            match sparsification(&pixels, confidence, RankedError::Bad(RANKED_BAD)) {
                Ok(found) => Some(ConfidenceScore {
                    ause: found.ause,
                    relative_ause: found.relative_ause,
                    auc: found.auc,
                    optimal_auc: found.optimal_auc,
                    protocol: found.protocol,
                }),
                Err(ScoreError::NoEstimate { .. }) => None,
                Err(other) => return Err(other),
            }
        }
    };
    Ok(RegionScores {
        scores,
        by_reason,
        by_confidence,
        missed: missed(answer, data),
        false_alarms: false_alarms(answer, data),
        confidence,
    })
}

/// The region of pixels that are at least so sure.
pub fn at_least(confidence: f32) -> String {
    format!("confidence >= {confidence}")
}

/// The scores of a region, which may well be empty: nothing is occluded on a plane.
fn if_any(scored: Result<Scores, ScoreError>) -> Result<Option<Scores>, ScoreError> {
    match scored {
        Ok(found) => Ok(Some(found)),
        Err(ScoreError::NoTruth { .. }) => Ok(None),
        Err(other) => Err(other),
    }
}

#[cfg(test)]
mod tests {
    use raster::{DisparityRange, Image, Plane};

    use super::*;
    use crate::dataset::CaseRegion;

    #[test]
    fn regions_are_scored_inside_the_box_and_empty_ones_left_out() {
        let image = Image::Grey8(Plane::filled(4, 1, 0));
        let mut data = CaseData::new(image.clone(), image, DisparityRange::new(0, 9).unwrap());
        data.bounds = BoundingBox::new(1, 0, 3, 0).unwrap();
        data.truth = Some(Plane::filled(4, 1, 5.0));
        let mask = |pixels: [bool; 4]| Plane::new(4, 1, pixels.to_vec()).unwrap();
        data.add_occlusions(&mask([true, false, false, false]));
        data.regions.push(CaseRegion {
            name: "own truth",
            mask: mask([false, false, true, false]),
            truth: Some(Plane::filled(4, 1, 6.0)),
        });
        let answer = Answer {
            disparity: Plane::new(4, 1, vec![99.0, 5.0, 5.5, 9.0]).unwrap(),
            reasons: Some(
                Plane::new(4, 1, [1, 1, 2, 1].map(|reason| Reason::ALL[reason]).to_vec()).unwrap(),
            ),
            confidence: Some(Plane::new(4, 1, vec![1.0, 0.9, 0.8, 0.1]).unwrap()),
        };
        let scored = score(&answer, &data).unwrap();
        let regions: Vec<_> = scored.scores.iter().map(|s| (&s.region[..], s.pixels)).collect();
        assert_eq!(regions, [("all", 3), ("non-occluded", 3), ("own truth", 1)]);
        assert_eq!(scored.scores[0].course.as_ref().unwrap().p_bad, 1.0 / 3.0);
        assert_eq!(scored.scores[2].middlebury.avgerr, Some(0.5));
        let reasons: Vec<_> = scored.by_reason.iter().map(|s| (&s.region[..], s.pixels)).collect();
        assert_eq!(reasons, [("matched", 2), ("occluded-filled", 1)]);
        let sure: Vec<_> = scored.by_confidence.iter().map(|s| (&s.region[..], s.pixels)).collect();
        let expected = [(0.0, 3), (0.25, 2), (0.5, 2), (0.75, 2), (0.9, 1)];
        let expected = expected.map(|(least, pixels)| (at_least(least), pixels));
        assert!(sure.iter().zip(&expected).all(|(a, (name, pixels))| *a == (&name[..], *pixels)));
        assert_eq!(sure.len(), expected.len(), "every bound has a row");
        assert_eq!(scored.confidence.unwrap().ause, 0.0, "the bad pixel is the least sure");
        assert_eq!(
            scored.scores[1].middlebury.clipped, 0,
            "what lies outside the box is not asked"
        );
        data.truth = None;
        assert_eq!(score(&answer, &data).unwrap(), RegionScores::default());
    }

    #[test]
    fn estimates_are_clipped_to_the_range_unless_it_holds_negative_disparities() {
        let image = Image::Grey8(Plane::filled(2, 1, 0));
        for (min, clipped, bad) in [(0, 2, 1.0), (-8, 0, 0.5)] {
            let range = DisparityRange::new(min, 9).unwrap();
            let mut data = CaseData::new(image.clone(), image.clone(), range);
            data.truth = Some(Plane::new(2, 1, vec![-6.0, 5.0]).unwrap());
            let disparity = Plane::new(2, 1, vec![-6.0, 99.0]).unwrap();
            let answer = Answer { disparity, reasons: None, confidence: None };
            let scored = score(&answer, &data).unwrap();
            let middlebury = &scored.scores[0].middlebury;
            assert_eq!((middlebury.clipped, middlebury.bad[2].totbad), (clipped, bad), "{min}");
        }
    }
}
