//! `hazcam.score`: a disparity map against ground truth.

use pyo3::prelude::*;
use raster::Plane;
use score::{Evaluation, Measure, Region, ScoreError, Scores, suspected_scale};

use crate::arguments::{bounding_box, real};
use crate::detached::detached;
use crate::errors::of_scoring;
use crate::planes::{DISPARITIES, map, mask};

/// A measure's name, its value, and the protocol of its family.
type Row = (&'static str, Option<f64>, Option<String>);

/// Every measure; how many pixels were scored, how many of these have no value; the factor by which the
/// estimate seems to be too large.
#[pyfunction]
#[pyo3(name = "score")]
pub fn score_map(
    py: Python<'_>,
    disparity: &Bound<'_, PyAny>,
    truth: &Bound<'_, PyAny>,
    r#box: &Bound<'_, PyAny>,
    mask: &Bound<'_, PyAny>,
    max_disparity: &Bound<'_, PyAny>,
) -> PyResult<(Vec<Row>, usize, usize, Option<f64>)> {
    let (estimate, truth) =
        (map("disparity", disparity, DISPARITIES)?, map("truth", truth, DISPARITIES)?);
    let bounds = bounding_box(r#box)?;
    let mask = (!mask.is_none()).then(|| self::mask("mask", mask)).transpose()?;
    let clip = !max_disparity.is_none();
    let clip = clip.then(|| real("max_disparity", max_disparity)).transpose()?;
    let region = match &mask {
        Some(mask) => Region::masked("mask", mask),
        None => Region::whole(),
    };
    let region = region.within(bounds);
    let scored = detached(py, || evaluate(&estimate, &truth, &region, clip))?;
    let (scores, suspected) = scored.map_err(of_scoring)?;
    let row = |measure: Measure| {
        (measure.name, measure.value(&scores), measure.protocol(&scores).map(str::to_owned))
    };
    let rows = Measure::ALL.into_iter().map(row).collect();
    Ok((rows, scores.pixels, scores.holes, suspected))
}

fn evaluate(
    estimate: &Plane<f32>,
    truth: &Plane<f32>,
    region: &Region<'_>,
    clip: Option<f64>,
) -> Result<(Scores, Option<f64>), ScoreError> {
    let evaluation = Evaluation::new(estimate, truth)?.clipped_to(clip);
    let scores = evaluation.scores(region)?;
    let suspected = suspected_scale(&evaluation.pixels(region)?);
    Ok((scores, suspected))
}
