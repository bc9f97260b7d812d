//! Pictures of one map: disparities, reasons, confidence.

use raster::{Plane, Reason};

use super::{BLACK, ColourMap};

/// Disparities in colours, from `min` (the start of the map) to `max` (its end); what lies outside
/// gets the colour of the nearer end. No value is black.
pub fn disparity(values: &Plane<f32>, min: f32, max: f32, map: ColourMap) -> Plane<[u8; 3]> {
    let width = if max > min { max - min } else { 1.0 };
    values.map(|&value| if value.is_nan() { BLACK } else { map.colour((value - min) / width) })
}

/// The smallest and largest finite value, or `None` when there is none.
pub fn value_range(values: &Plane<f32>) -> Option<(f32, f32)> {
    values.samples().iter().filter(|v| v.is_finite()).fold(None, |range, &v| match range {
        None => Some((v, v)),
        Some((min, max)) => Some((v.min(min), v.max(max))),
    })
}

/// The colour of a reason: grey for what is matched, blue for occluded, orange for mismatched,
/// purple for outside the right image; filled pixels bright, holes dark; black outside the box.
pub fn reason_colour(reason: Reason) -> [u8; 3] {
    match reason {
        Reason::OutsideBox => BLACK,
        Reason::Matched => [208, 208, 208],
        Reason::OccludedFilled => [66, 146, 214],
        Reason::MismatchedFilled => [245, 145, 40],
        Reason::OutsideRightFilled => [176, 106, 204],
        Reason::OccludedHole => [20, 64, 110],
        Reason::MismatchedHole => [122, 62, 6],
        Reason::OutsideRightHole => [80, 36, 98],
    }
}

/// Why each pixel has its value or none, in the colours of [`reason_colour`].
pub fn reasons(reasons: &Plane<Reason>) -> Plane<[u8; 3]> {
    reasons.map(|&reason| reason_colour(reason))
}

/// Confidence from 0 (black) to 1 (white) in grey.
pub fn confidence(confidence: &Plane<f32>) -> Plane<u8> {
    confidence.map(|&value| (value.clamp(0.0, 1.0) * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn the_range_spans_the_map_and_holes_are_black() {
        let values = Plane::new(4, 1, vec![10.0, 20.0, f32::NAN, 99.0]).unwrap();
        let picture = disparity(&values, 10.0, 20.0, ColourMap::Grey);
        assert_eq!(picture.samples(), [[1; 3], [255; 3], BLACK, [255; 3]]);
        assert_eq!(value_range(&values), Some((10.0, 99.0)));
        assert_eq!(value_range(&Plane::filled(2, 2, f32::NAN)), None);
        // A flat map has a picture as well.
        assert_eq!(disparity(&values, 10.0, 10.0, ColourMap::Grey).samples()[0], [1; 3]);
    }

    #[test]
    fn every_reason_has_its_own_colour() {
        let all = Plane::new(8, 1, Reason::ALL.to_vec()).unwrap();
        let colours: HashSet<_> = reasons(&all).into_samples().into_iter().collect();
        assert_eq!(colours.len(), 8);
    }

    #[test]
    fn confidence_is_grey() {
        let values = Plane::new(4, 1, vec![0.0, 0.5, 1.0, f32::NAN]).unwrap();
        assert_eq!(confidence(&values).samples(), [0, 128, 255, 0]);
    }
}
