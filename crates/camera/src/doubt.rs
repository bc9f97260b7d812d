//! What is doubtful about a camera and about maps of disparities that it is given, each in a sentence.

use raster::Plane;

use crate::StereoCamera;

/// Of cameras that look at scenes: pixels of the focal length at the least, metres of baselines.
const LEAST_FOCAL: f64 = 10.0;
const BASELINES: std::ops::RangeInclusive<f64> = 0.001..=5.0;
/// Principal points lie within so much of the size of images from their middle.
const OFF_MIDDLE: f64 = 0.25;

/// Disparities of more pixels are not believed in a map of so many columns. Matches lie within the image, but a map may
/// be a part of it.
pub fn widest(columns: usize) -> f32 {
    (2 * columns.max(64)) as f32
}

/// Says that disparities of a map, NaN or infinite where there is none, are larger than those of matches, if so, and what
/// that usually comes from.
pub fn too_large(disparities: &Plane<f32>) -> Option<String> {
    let columns = disparities.columns();
    let most = disparities.samples().iter().copied().filter(|d| d.is_finite()).fold(0.0, f32::max);
    (most > widest(columns)).then(|| {
        format!(
            "disparities of up to {most} px in a map of {columns} columns: nothing is matched as far away; is it a map \
             of depth, or one in another encoding (KITTI's pictures hold 256 times the disparity, OpenCV's maps 16 times)?"
        )
    })
}

impl StereoCamera {
    /// What is unusual about its numbers, as it is where one is in another unit.
    pub fn doubt(&self) -> Option<String> {
        let Self { focal_px, baseline_m, .. } = *self;
        if focal_px < LEAST_FOCAL {
            Some(format!(
                "the focal length is {} px, which is less than cameras have: is it in millimetres or metres? \
                 Divide it by the width of a pixel",
                focal_px as f32
            ))
        } else if !BASELINES.contains(&baseline_m) {
            Some(format!(
                "the baseline is {} m, which is unusual: was it in metres (Middlebury's calib.txt: millimetres; boards mostly in milli- or centimetres)?",
                baseline_m as f32
            ))
        } else {
            None
        }
    }

    /// Says that its principal point lies far from the middle of a map of `(columns, rows)`, if so, as it does where that
    /// was made at another scale than the camera is of, or cut out.
    pub fn doubt_of_size(&self, (columns, rows): (usize, usize)) -> Option<String> {
        let Self { cx, cy, .. } = *self;
        let share = |place: f64, size: usize| ((place + 0.5) / size as f64 - 0.5).abs();
        (share(cx, columns).max(share(cy, rows)) > OFF_MIDDLE).then(|| {
            format!(
                "the principal point, column {cx:.2} and row {cy:.2}, is far from the middle of the map of {columns} x \
                 {rows}, and nothing says of which size the camera's images are: if they have another scale, depth is \
                 wrong; give the camera at that of the map"
            )
        })
    }

    /// Says that most of a map's disparities, NaN or infinite where there is none, are of nothing in front of the cameras,
    /// if so, or that all of them lie between 0 and a pixel, and what that usually comes from.
    pub fn doubt_of(&self, disparities: &Plane<f32>) -> Option<String> {
        let known = disparities.samples().iter().filter(|d| d.is_finite());
        let all = known.clone().count();
        let are_shares = known.clone().all(|d| (0.0..=1.0).contains(d));
        let mut behind = known.filter(|d| self.depth_in_32_bits(**d).is_none());
        let count = behind.clone().count();
        if 2 * count <= all {
            return (all > 0 && are_shares && self.doffs == 0.0).then(|| {
                "all disparities lie between 0 and 1 px: is it a map of confidence, or one in parts of the images' \
                 width, as some networks give it? Disparities must be in pixels"
                    .into()
            });
        }
        let first = behind.next();
        let said = format!("{count} of {all} disparities are");
        Some(match first {
            Some(mark) if count < all && behind.all(|other| other == mark) => format!(
                "{said} {mark}, which is nothing in front of the cameras: if that stands for no value, as \
                 OpenCV's -1 and 0 in pictures do, it must be NaN"
            ),
            _ => format!(
                "{said} of nothing in front of the cameras{}: give the pair's own doffs (a pair that was cropped, \
                 turned inwards or exchanged has one), or exchange left and right",
                if count < all { ", so depths of the others are not to be trusted" } else { "" }
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(focal: f64, baseline: f64) -> StereoCamera {
        StereoCamera::new(focal, baseline, 0.0, 0.0, 0.0).unwrap()
    }

    #[test]
    fn numbers_in_other_units_are_doubted() {
        let about = |focal, baseline| camera(focal, baseline).doubt();
        assert_eq!([about(700.0, 0.12), about(10.0, 0.001), about(5e3, 5.0)], [None, None, None]);
        assert!(about(0.004, 0.12).unwrap().contains("focal length is 0.004 px"));
        for baseline in [1.67e-4, 19.3, 120.0] {
            assert!(about(700.0, baseline).unwrap().contains("the baseline is"));
        }
    }

    #[test]
    fn a_principal_point_far_from_the_middle_is_doubted() {
        let about =
            |cx, cy| StereoCamera::new(700.0, 0.5, 0.0, cx, cy).unwrap().doubt_of_size((620, 188));
        assert_eq!(
            [about(309.5, 93.5), about(160.0, 60.0), about(460.0, 139.0)],
            [None, None, None]
        );
        // A quarter of the size from the middle, from edge to edge.
        assert_eq!([about(154.5, 93.5), about(309.5, 140.5)], [None, None]);
        assert!(about(154.4, 93.5).is_some() && about(309.5, 140.6).is_some());
        for (cx, cy) in [(607.2, 185.2), (309.5, -0.5), (-371.0, 93.5)] {
            let said = about(cx, cy).unwrap();
            let place = format!("column {cx:.2} and row {cy:.2}");
            assert!(said.contains(&place) && said.contains("620 x 188"), "{said}");
        }
    }

    #[test]
    fn disparities_of_nothing_in_front_of_the_cameras_are_doubted() {
        let doubt = |values: [f32; 5]| {
            camera(1000.0, 0.2).doubt_of(&Plane::new(5, 1, values.to_vec()).unwrap())
        };
        assert_eq!(doubt([50.0, f32::NAN, 0.0, -3.0, 2.0]), None);
        let none = f32::INFINITY;
        assert_eq!(doubt([50.0, none, none, none, -none]), None);
        assert_eq!(too_large(&Plane::new(2, 1, vec![3.0, none]).unwrap()), None);
        let some = doubt([50.0, f32::NAN, 0.0, -3.0, -2.0]).unwrap();
        assert!(some.starts_with("3 of 4 disparities") && some.contains("doffs"), "{some}");
        assert!(some.contains("depths of the others"), "{some}");
        let all = doubt([-1.0, f32::NAN, -1.0, -3.0, -2.0]).unwrap();
        assert!(all.starts_with("4 of 4 disparities") && !all.contains("others"), "{all}");
        let shares = doubt([0.5, f32::NAN, 1.0, 0.2, 0.9]).unwrap();
        assert!(shares.starts_with("all disparities lie between 0 and 1 px"), "{shares}");
        assert_eq!(doubt([0.5, -0.2, 1.0, 0.2, 0.9]), None);
        // Of a pair that was cropped these are places like any others.
        let cropped = StereoCamera::new(1000.0, 0.2, 100.0, 0.0, 0.0).unwrap();
        assert_eq!(cropped.doubt_of(&Plane::new(2, 1, vec![0.5, 0.9]).unwrap()), None);
        // One number again and again stands for no value.
        let mark = doubt([-1.0, 50.0, -1.0, -1.0, f32::NAN]).unwrap();
        assert!(mark.starts_with("3 of 4 disparities are -1, "), "{mark}");
    }

    #[test]
    fn disparities_that_no_match_has_are_doubted() {
        let doubt = |most, columns| too_large(&Plane::filled(columns, 1, most));
        assert_eq!([doubt(128.0, 5), doubt(400.0, 200)], [None, None]);
        let told = doubt(401.0, 200).unwrap();
        assert!(told.contains("up to 401 px in a map of 200 columns"), "{told}");
    }
}
