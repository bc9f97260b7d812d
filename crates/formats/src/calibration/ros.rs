//! What ROS keeps of a camera (`camera_info_manager`, `camera_calibration`): of a pair the right one's.
//!
//! `projection_matrix = [f 0 cx -f b; 0 f cy 0; 0 0 1 0]`, where `b` is the right camera's place to the right of the
//! left one in metres; of the left camera the fourth number is 0 (`sensor_msgs/CameraInfo`). ROS rectifies pairs so
//! that both principal points are in one place.

use serde::Deserialize;

use super::yaml::{self, Matrix};
use super::{Calibration, CalibrationLayout, Entries};
use crate::FormatError;

const PROJECTION: &str = "projection_matrix";

#[derive(Deserialize)]
struct CameraInfo {
    image_width: Option<usize>,
    image_height: Option<usize>,
    projection_matrix: Matrix,
}

/// Whether a file is one of ROS's.
pub(super) fn is_ros(entries: &Entries<'_>) -> bool {
    entries.has(PROJECTION)
}

/// The pair of the right camera.
pub(super) fn parse(entries: &Entries<'_>, text: &str) -> Result<Calibration, FormatError> {
    let info: CameraInfo = yaml::read(entries, text)?;
    let right = info.projection_matrix.projection(entries, PROJECTION)?;
    if right[3] == 0.0 {
        let problem = "projection_matrix is that of a left camera or of one alone, its fourth number is 0: give the \
                       right camera's file, which has the baseline";
        return Err(entries.fail(None, problem.into()));
    }
    let mut left = right;
    left[3] = 0.0;
    let camera = entries.projected([PROJECTION; 2], &[left, right])?;
    Ok(Calibration {
        width: info.image_width,
        height: info.image_height,
        ..Calibration::of(CalibrationLayout::Ros, camera)
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{read, refused};
    use super::*;
    use camera::StereoCamera;

    /// As `camera_calibration` writes it; f = 700, 0.12 m apart.
    const SAMPLE: &str = "image_width: 640\nimage_height: 480\ncamera_name: rig/right\ncamera_matrix:\n  rows: 3\n  \
        cols: 3\n  data: [705.0, 0.0, 322.0, 0.0, 706.0, 241.0, 0.0, 0.0, 1.0]\ndistortion_model: plumb_bob\n\
        distortion_coefficients: {rows: 1, cols: 5, data: [-0.1, 0.02, 0.0, 0.0, 0.0]}\nprojection_matrix:\n  \
        rows: 3\n  cols: 4\n  data: [700.0, 0.0, 320.5, -84.0, 0.0, 700.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]\n";

    #[test]
    fn the_right_camera_tells_of_both() {
        let calibration = read(SAMPLE).unwrap();
        assert_eq!(calibration.layout, CalibrationLayout::Ros);
        assert_eq!(calibration.camera, StereoCamera::new(700.0, 0.12, 0.0, 320.5, 240.0).unwrap());
        assert_eq!((calibration.width, calibration.height), (Some(640), Some(480)));
    }

    #[test]
    fn what_is_wrong_is_named() {
        let changes = [
            ("-84.0", "0.0", "give the right camera's file"),
            ("-84.0", "84.0", "baseline in metres"),
            ("-84.0", "-.inf", "baseline in metres"),
            ("-84.0, 0.0", "-84.0, 0.0, 0.0", "projection_matrix is 3 x 4 with 13 numbers"),
            ("cols: 4", "cols: 3", "projection_matrix is 3 x 3 with 12 numbers"),
            ("0.0, 700.0", "0.0, 900.0", "the focal lengths 700 across and 900 down"),
            ("240.0, 0.0", "240.0, -84.0", "side by side"),
            ("320.5", "wide", "the YAML cannot be read"),
            ("640", "-640", "the YAML cannot be read"),
        ];
        refused(SAMPLE, &changes);
    }
}
