//! What ROS keeps of a camera (`camera_info_manager`, `camera_calibration`): of a pair the right one's.
//!
//! `projection_matrix = [f 0 cx -f b; 0 f cy 0; 0 0 1 0]`, where `b` is the right camera's place to the right of the
//! left one in metres; of the left camera the fourth number is 0 (`sensor_msgs/CameraInfo`). ROS rectifies pairs so
//! that both principal points are in one place. The same matrix is `P` in a message that was printed (`rostopic echo`),
//! `p` in one of ROS 2 (`ros2 topic echo`).

use serde::Deserialize;

use super::matrix::Matrix;
use super::yaml;
use super::{Calibration, CalibrationLayout, Entries};
use crate::FormatError;

const PROJECTION: &str = "projection_matrix";

#[derive(Deserialize)]
struct CameraInfo {
    image_width: Option<f64>,
    image_height: Option<f64>,
    projection_matrix: Matrix,
}

/// A `sensor_msgs/CameraInfo` as it is printed.
#[derive(Deserialize)]
struct Message {
    width: Option<f64>,
    height: Option<f64>,
    #[serde(alias = "P")]
    p: Vec<f64>,
}

/// Whether a file is one of ROS's.
pub(super) fn is_file(entries: &Entries<'_>) -> bool {
    entries.has(PROJECTION)
}

/// Whether a text is a message of ROS's.
pub(super) fn is_message(entries: &Entries<'_>) -> bool {
    entries.has("distortion_model") && (entries.has("P") || entries.has("p"))
}

/// The pair of the right camera.
pub(super) fn parse(entries: &Entries<'_>, text: &str) -> Result<Calibration, FormatError> {
    let (name, right, size) = if is_file(entries) {
        let info: CameraInfo = yaml::read(entries, text)?;
        let stated = [info.image_width, info.image_height];
        let size = entries.size(["image_width", "image_height"], stated)?;
        (PROJECTION, info.projection_matrix.projection(entries, PROJECTION)?, size)
    } else {
        let (right, size) = right_of_messages(entries, text)?;
        ("P", right, entries.size(["width", "height"], size)?)
    };
    if right[3] == 0.0 {
        let problem = format!(
            "{name} is that of a left camera or of one alone, its fourth number is 0: give the right camera's file, \
             which has the baseline"
        );
        return Err(entries.lacks(problem));
    }
    let mut left = right;
    left[3] = 0.0;
    let camera = entries.projected([name; 2], &[left, right])?;
    Ok(Calibration::of(CalibrationLayout::Ros, camera).sized(size))
}

/// A projection, columns and rows.
type Projected = ([f64; 12], [Option<f64>; 2]);

/// What the first message says that is of a right camera, or else the first one.
fn right_of_messages(entries: &Entries<'_>, text: &str) -> Result<Projected, FormatError> {
    // After each message there is a line that parts it from the next.
    let mut messages = text.split("\n---");
    let first = projected(entries, messages.next().unwrap_or(text))?;
    if first.0[3] != 0.0 {
        return Ok(first);
    }
    // The last one may be cut off.
    let mut others = messages.filter_map(|text| projected(entries, text).ok());
    Ok(others.find(|(right, _)| right[3] != 0.0).unwrap_or(first))
}

/// What a message says.
fn projected(entries: &Entries<'_>, text: &str) -> Result<Projected, FormatError> {
    let Message { width, height, p } = yaml::read(entries, text)?;
    let count = p.len();
    let right = p.try_into().map_err(|_| {
        entries.fail(None, format!("`P` has {count} numbers, but a projection of 3 x 4 has 12"))
    })?;
    Ok((right, [width, height]))
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
            ("640", "-640", "`image_width` is -640"),
            ("640", "640.5", "`image_width` is 640.5"),
            ("480", "0", "`image_height` is 0"),
        ];
        refused(SAMPLE, &changes);
        let decimals = read(&SAMPLE.replace("640", "640.0")).unwrap();
        assert_eq!((decimals.width, decimals.height), (Some(640), Some(480)));
    }

    #[test]
    fn messages_that_were_printed_are_read() {
        let one = "header:\n  seq: 7\n  frame_id: \"right\"\nheight: 480\nwidth: 640\n\
            distortion_model: \"plumb_bob\"\nD: [-0.1, 0.02]\nK: [705.0, 0.0, 322.0]\n\
            P: [700.0, 0.0, 320.5, -84.0, 0.0, 700.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]\nbinning_x: 0\n---\n";
        let two = "height: 480\nwidth: 640\ndistortion_model: plumb_bob\nd:\n- -0.1\np:\n- 700.0\n- 0.0\n- 320.5\n\
            - -84.0\n- 0.0\n- 700.0\n- 240.0\n- 0.0\n- 0.0\n- 0.0\n- 1.0\n- 0.0\n---\n";
        for text in [one.to_owned(), two.to_owned(), one.to_owned() + "height: 480\n"] {
            assert_eq!(read(&text).unwrap(), read(SAMPLE).unwrap(), "{text}");
        }
        // Of both cameras, in any order; of the second copy of the last one only a part.
        let left = one.replace("-84.0", "0.0");
        for text in
            [format!("{left}{one}"), format!("{one}{left}"), format!("{left}{one}height: 4")]
        {
            assert_eq!(read(&text).unwrap(), read(SAMPLE).unwrap(), "{text}");
        }
        refused(
            one,
            &[
                ("-84.0", "0.0", "P is that of a left camera"),
                ("-84.0, ", "", "`P` has 11 numbers"),
                ("width: 640", "width: 0", "`width` is 0"),
            ],
        );
    }
}
