//! The ways to colour points: what the page lets one choose from.

use raster::{Plane, Reason};
use serde::Serialize;

use super::View;
use crate::picture::{self, BLACK, ColourMap};

/// One way, in words, colours and the name of the numbers that it is about.
#[derive(Debug, Serialize)]
pub(super) struct Colouring {
    /// What it is called in the list.
    label: &'static str,
    /// Whose numbers in the page it colours.
    of: &'static str,
    #[serde(flatten)]
    scale: Scale,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "lowercase")]
enum Scale {
    /// The picture's own.
    Own {},
    /// Colours from `from` to `to`, in steps of equal size or else, `by_factor`, of equal factors.
    Ramp { from: f32, to: f32, by_factor: bool, colours: Vec<[u8; 3]> },
    /// A colour and words for each number from 0 on.
    Palette(Vec<([u8; 3], String)>),
}

/// How finely ramps are stepped: as finely as colours are.
const STEPS: usize = 256;
/// Depths farther than this share of all get one colour: a few far ones would take the colours of all others.
const FARTHEST: f64 = 0.95;

/// All that there is something for.
pub(super) fn all(view: &View<'_>) -> Vec<Colouring> {
    let turbo = (0..STEPS).map(|at| ColourMap::Turbo.colour(at as f32 / (STEPS - 1) as f32));
    let turbo: Vec<[u8; 3]> = turbo.collect();
    let mut all = Vec::new();
    if view.image.is_some() {
        all.push(Colouring { label: "Left image", of: "image", scale: Scale::Own {} });
    }
    let (from, to) = picture::value_range(view.disparities).unwrap_or((0.0, 1.0));
    let scale = Scale::Ramp { from, to, by_factor: false, colours: turbo.clone() };
    all.push(Colouring { label: "Disparity", of: "disparities", scale });
    if let Some((near, far)) = view.depths().and_then(|depths| near_and_far(&depths)) {
        // As for disparities, near is red. From where an error is as large as the disparity a point may be anywhere.
        let anywhere = view.camera.map(|at| at.focal_px * at.baseline_m / view.disparity_error);
        let far = anywhere.map_or(far, |anywhere| far.min(anywhere as f32).max(near));
        let scale = Scale::Ramp { from: far, to: near, by_factor: true, colours: turbo };
        all.push(Colouring { label: "Depth", of: "depths", scale });
    }
    if view.confidence.is_some() {
        let ramp = Plane::from_fn(STEPS, 1, |at, _| at as f32 / (STEPS - 1) as f32);
        let colours = picture::confidence(&ramp).samples().iter().map(|&grey| [grey; 3]).collect();
        let scale = Scale::Ramp { from: 0.0, to: 1.0, by_factor: false, colours };
        all.push(Colouring { label: "Confidence", of: "confidence", scale });
    }
    if view.reasons.is_some() {
        let entries =
            Reason::ALL.map(|reason| (picture::reason_colour(reason), words(reason).to_owned()));
        all.push(Colouring {
            label: "Reason",
            of: "reasons",
            scale: Scale::Palette(entries.to_vec()),
        });
    }
    if view.truth.is_some() {
        all.push(Colouring { label: "Error", of: "errors", scale: Scale::Palette(errors()) });
    }
    all
}

/// What the colours of errors stand for, black last.
pub(super) fn errors() -> Vec<([u8; 3], String)> {
    let mut legend = picture::log_error_legend();
    legend.push((BLACK, "no truth".to_owned()));
    legend
}

fn words(reason: Reason) -> &'static str {
    match reason {
        Reason::OutsideBox => "outside the box that was asked for",
        Reason::Matched => "found in the right image and confirmed",
        Reason::OccludedFilled => "seen by the left camera only, filled",
        Reason::MismatchedFilled => "matched wrongly or ambiguously, filled",
        Reason::OutsideRightFilled => "outside the right image, filled",
        Reason::OccludedHole => "seen by the left camera only, left open",
        Reason::MismatchedHole => "matched wrongly or ambiguously, left open",
        Reason::OutsideRightHole => "outside the right image, left open",
    }
}

/// The least depth and the one that most do not reach; `None` where there is none.
fn near_and_far(depths: &Plane<f32>) -> Option<(f32, f32)> {
    let mut known: Vec<f32> = depths.samples().iter().copied().filter(|d| !d.is_nan()).collect();
    let last = known.len().checked_sub(1)?;
    let at = (last as f64 * FARTHEST).ceil() as usize;
    let (nearer, &mut far, _) = known.select_nth_unstable_by(at, f32::total_cmp);
    Some((nearer.iter().copied().fold(far, f32::min), far))
}

#[cfg(test)]
mod tests {
    use super::*;
    use camera::StereoCamera;

    #[test]
    fn colours_of_depths_end_where_a_point_may_be_anywhere() {
        // A disparity of 0.5 px, as large as its error, is 200 m away.
        let camera = StereoCamera::new(100.0, 1.0, 0.0, 0.0, 0.0).unwrap();
        for (disparities, far, near) in [
            ([4.0, 8.0], 25.0, 12.5),
            ([0.125, 8.0], 200.0, 12.5),
            // Where all are farther than that, from the nearest to the nearest.
            ([0.0625, 0.125], 800.0, 800.0),
        ] {
            let map = Plane::new(2, 1, disparities.to_vec()).unwrap();
            let view = View::new("map", &map).with_camera(camera, 0.5);
            let depths = serde_json::to_value(&all(&view)[1]).unwrap();
            assert_eq!((&depths["of"], &depths["ramp"]["to"]), (&"depths".into(), &near.into()));
            assert_eq!(depths["ramp"]["from"], far);
        }
    }

    #[test]
    fn a_few_far_points_do_not_take_all_colours() {
        let depths = Plane::from_fn(101, 1, |x, _| if x == 100 { 9e9 } else { 1.0 + x as f32 });
        assert_eq!(near_and_far(&depths), Some((1.0, 96.0)));
        assert_eq!(near_and_far(&Plane::new(2, 1, vec![f32::NAN, 3.0]).unwrap()), Some((3.0, 3.0)));
        assert_eq!(near_and_far(&Plane::filled(2, 1, f32::NAN)), None);
    }

    #[test]
    fn there_is_a_way_for_all_that_was_given_and_no_other() {
        let map = Plane::new(2, 1, vec![4.0, 8.0]).unwrap();
        let labels = |view: &View<'_>| all(view).iter().map(|way| way.label).collect::<Vec<_>>();
        assert_eq!(labels(&View::new("map", &map)), ["Disparity"]);
        let reasons = Plane::filled(2, 1, Reason::Matched);
        let view = View::new("map", &map).with_reasons(&reasons).unwrap();
        let view = view.with_truth(&map).unwrap().with_confidence(&map, 0.0).unwrap();
        assert_eq!(labels(&view), ["Disparity", "Confidence", "Reason", "Error"]);
        let disparity = serde_json::to_value(&all(&view)[0]).unwrap();
        assert_eq!(
            (&disparity["ramp"]["from"], &disparity["ramp"]["to"]),
            (&4.0.into(), &8.0.into())
        );
        assert_eq!(disparity["ramp"]["colours"].as_array().unwrap().len(), STEPS);
    }
}
