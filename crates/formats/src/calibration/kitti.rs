//! KITTI's projection matrices after rectification.
//!
//! `P_i = [f 0 cx -f b_i; 0 f cy 0; 0 0 1 0]` with `b_i` the camera's place to the right of camera
//! 0 in metres (Geiger et al., *Vision meets Robotics: The KITTI Dataset*, IJRR 2013). Cameras 0
//! and 1 are grey, 2 and 3 are colour.

use super::{Calibration, CalibrationLayout, Entries};
use crate::FormatError;
use camera::StereoCamera;

/// The two spellings: of the stereo benchmarks, and of the raw recordings.
const NAMES: [[&str; 4]; 2] =
    [["P0", "P1", "P2", "P3"], ["P_rect_00", "P_rect_01", "P_rect_02", "P_rect_03"]];

/// Whether any of the matrices is there.
pub(super) fn is_kitti(entries: &Entries<'_>) -> bool {
    NAMES.iter().flatten().any(|name| entries.has(name))
}

/// Both pairs, where the file has them.
pub(super) fn parse(entries: &Entries<'_>) -> Result<Calibration, FormatError> {
    let [grey_left, grey_right, colour_left, colour_right] =
        NAMES[usize::from(!NAMES[0].iter().any(|name| entries.has(name)))];
    let grey = pair(entries, grey_left, grey_right)?;
    let colour = pair(entries, colour_left, colour_right)?;
    let camera = grey.or(colour).ok_or_else(|| {
        let problem = format!(
            "a pair is needed, {grey_left} and {grey_right} or {colour_left} and {colour_right}"
        );
        entries.fail(None, problem)
    })?;
    Ok(Calibration {
        layout: CalibrationLayout::Kitti,
        camera,
        colour_camera: colour,
        width: None,
        height: None,
        ndisp: None,
        isint: None,
        vmin: None,
        vmax: None,
    })
}

/// The pair of two matrices, or `None` unless both are there.
fn pair(
    entries: &Entries<'_>,
    left_name: &str,
    right_name: &str,
) -> Result<Option<StereoCamera>, FormatError> {
    if !(entries.has(left_name) && entries.has(right_name)) {
        return Ok(None);
    }
    let left: [f64; 12] = entries.numbers(left_name)?;
    let right: [f64; 12] = entries.numbers(right_name)?;
    let focal = left[0];
    if focal != right[0] {
        let problem = format!(
            "{left_name} and {right_name} have the focal lengths {focal} and {}: a rectified pair \
             has one",
            right[0]
        );
        return Err(entries.fail(None, problem));
    }
    entries.square(left_name, [focal, left[5]])?;
    let baseline = (left[3] - right[3]) / focal;
    entries.camera(focal, baseline, right[2] - left[2], left[2], left[6]).map(Some)
}

#[cfg(test)]
mod tests {
    use super::super::tests::read;

    /// f = 700; camera 1 stands 0.54 m, camera 2 -0.06 m, camera 3 0.47 m to the right.
    const SAMPLE: &str = "P0: 700 0 600 0 0 700 180 0 0 0 1 0\n\
        P1: 7.0e+02 0 600 -3.78e+02 0 700 180 0 0 0 1 0\n\
        P2: 700 0 600 42 0 700 180 -0.11 0 0 1 0.003\n\
        P3: 700 0 602 -329 0 700 180 2.3 0 0 1 0.004\n";

    #[test]
    fn both_pairs_are_read() {
        let calibration = read(SAMPLE).unwrap();
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        near(calibration.camera.baseline_m, 0.54);
        near(calibration.camera.doffs, 0.0);
        let colour = calibration.colour_camera.unwrap();
        near(colour.baseline_m, 0.53);
        near(colour.doffs, 2.0);
        assert_eq!((colour.focal_px, colour.cx, colour.cy), (700.0, 600.0, 180.0));
        assert_eq!(calibration.camera_of("training/image_2/000000_10.png"), colour);
        assert_eq!(calibration.camera_of("drive/image_02/data/0000000000.png"), colour);
        // What else is on the way there says nothing.
        for grey in ["image_0/000070_10.png", "image_2/image_0/000070_10.png", "left.png"] {
            assert_eq!(calibration.camera_of(grey), calibration.camera, "{grey}");
        }
    }

    #[test]
    fn the_raw_spelling_and_one_pair_are_enough() {
        let (_, colour) = SAMPLE.split_once("P2").unwrap();
        let text = format!("calib_time: 09-Jan-2012 13:57:47\nP2{colour}").replace('P', "P_rect_0");
        let calibration = read(&text).unwrap();
        assert_eq!(Some(calibration.camera), calibration.colour_camera);
    }

    #[test]
    fn half_a_pair_is_not_enough() {
        let (grey, _) = SAMPLE.split_once("P1").unwrap();
        assert!(read(grey).unwrap_err().contains("a pair is needed, P0 and P1"));
        let swapped = SAMPLE.replace("P0", "PX").replace("P1", "P0").replace("PX", "P1");
        assert!(read(&swapped).unwrap_err().contains("baseline"), "the right camera on the left");
    }
}
