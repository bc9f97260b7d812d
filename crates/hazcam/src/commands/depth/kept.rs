//! Which pixels of a map get a depth, and why the others do not.

use camera::StereoCamera;
use raster::Plane;
use serde::Serialize;

/// What makes a pixel's depth not worth having.
pub struct Limits<'a> {
    /// How sure each pixel is, and how sure it must be.
    pub confidence: Option<(&'a Plane<f32>, f32)>,
    /// In metres.
    pub max_depth: Option<f64>,
}

/// How many pixels there are of each kind.
#[derive(Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// With a depth.
    pub kept: usize,
    /// Whose map has no value.
    pub without_disparity: usize,
    /// Whose disparity, with `doffs`, is of nothing in front of the cameras, or of a depth that no float
    /// of 32 bits holds.
    pub behind: usize,
    /// Less sure than they must be.
    pub unsure: usize,
    /// Beyond the largest depth.
    pub too_far: usize,
}

impl Counts {
    /// Why no pixel has a depth, which is so, and what to do: what stopped most of those that have a disparity.
    pub fn nothing_left(&self) -> String {
        let Self { without_disparity, behind, unsure, too_far, .. } = *self;
        let (count, why, remedy) = [
            (behind, "nothing in front of the cameras", "give the pair's own doffs"),
            (unsure, "not sure enough", "lower --min-confidence"),
            (too_far, "too far away", "raise --max-depth"),
        ]
        .into_iter()
        .max_by_key(|kind| kind.0)
        .expect("there are three");
        match count {
            0 => format!(
                "no pixel has a depth: none of {without_disparity} has a disparity; was anything matched?"
            ),
            _ => format!("no pixel has a depth: {count} are {why}; {remedy}"),
        }
    }
}

/// The depth of each pixel in metres, NaN where there is none.
pub fn depths(
    disparities: &Plane<f32>,
    camera: &StereoCamera,
    limits: &Limits<'_>,
) -> (Plane<f32>, Counts) {
    let mut counts = Counts::default();
    let mut at = 0;
    let depths = disparities.map(|&disparity| {
        let sure = limits.confidence.is_none_or(|(map, least)| map.samples()[at] >= least);
        at += 1;
        let depth = camera.depth_in_32_bits(disparity);
        let (count, depth) = match depth {
            _ if disparity.is_nan() => (&mut counts.without_disparity, None),
            None => (&mut counts.behind, None),
            Some(_) if !sure => (&mut counts.unsure, None),
            Some(depth) if limits.max_depth.is_some_and(|most| f64::from(depth) > most) => {
                (&mut counts.too_far, None)
            }
            Some(depth) => (&mut counts.kept, Some(depth)),
        };
        *count += 1;
        depth.unwrap_or(f32::NAN)
    });
    (depths, counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_counted_once_with_its_reason() {
        // Depth 200 / d.
        let camera = StereoCamera::new(1000.0, 0.2, 0.0, 0.0, 0.0).unwrap();
        let map = Plane::new(6, 1, vec![50.0, f32::NAN, 0.0, 100.0, 2.0, -3.0]).unwrap();
        let sure = Plane::new(6, 1, vec![0.5, 1.0, 1.0, 0.4, 0.9, 1.0]).unwrap();
        let limits = Limits { confidence: Some((&sure, 0.5)), max_depth: Some(80.0) };
        let (depth, counts) = depths(&map, &camera, &limits);
        assert_eq!(depth.samples()[0], 4.0);
        assert!(depth.samples()[1..].iter().all(|depth| depth.is_nan()));
        let expected = Counts { kept: 1, without_disparity: 1, behind: 2, unsure: 1, too_far: 1 };
        assert_eq!(counts, expected);
    }

    #[test]
    fn what_left_nothing_is_what_stopped_most_of_those_with_a_disparity() {
        let told = |without_disparity, behind, unsure, too_far| {
            Counts { kept: 0, without_disparity, behind, unsure, too_far }.nothing_left()
        };
        assert!(told(9, 0, 0, 0).ends_with("none of 9 has a disparity; was anything matched?"));
        assert!(told(9, 2, 1, 1).contains("2 are nothing in front of the cameras; give"));
        assert!(told(9, 1, 2, 1).contains("2 are not sure enough; lower --min-confidence"));
        assert!(told(60, 0, 0, 40).contains("40 are too far away; raise --max-depth"));
    }

    #[test]
    fn a_depth_that_no_float_holds_is_none() {
        // Files in another byte order than they say are full of such disparities.
        for (baseline, disparity) in [(0.5, 1e-40), (1e-20, 1e38)] {
            let camera = StereoCamera::new(700.0, baseline, 0.0, 0.0, 0.0).unwrap();
            let map = Plane::filled(1, 1, disparity);
            let limits = Limits { confidence: None, max_depth: None };
            let (depth, counts) = depths(&map, &camera, &limits);
            assert!(depth.samples()[0].is_nan());
            assert_eq!(counts, Counts { behind: 1, ..Counts::default() });
        }
    }

    #[test]
    fn a_confidence_that_is_no_number_is_not_sure() {
        let camera = StereoCamera::new(1000.0, 0.2, 0.0, 0.0, 0.0).unwrap();
        let map = Plane::filled(1, 1, 10.0);
        let sure = Plane::filled(1, 1, f32::NAN);
        let limits = Limits { confidence: Some((&sure, 0.0)), max_depth: None };
        assert_eq!(depths(&map, &camera, &limits).1.unsure, 1);
    }
}
