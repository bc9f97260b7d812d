//! YAML, JSON and XML files of OpenCV's `FileStorage`, or of lists, with the matrices of `stereoRectify`.
//!
//! `P1 = [f 0 cx1 0; 0 f cy 0; 0 0 1 0]`, `P2 = [f 0 cx2 -f b; 0 f cy 0; 0 0 1 0]`, where `b` is in the unit of the
//! squares that the cameras were calibrated with; or, where they are not there, what makes points of disparities,
//! `Q = [1 0 0 -cx1; 0 1 0 -cy; 0 0 0 f; 0 0 1/b (cx2 - cx1)/b]`.

use camera::StereoCamera;
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::matrix::Matrix;
use super::{Calibration, CalibrationLayout, Entries};
use super::{xml, yaml};
use crate::FormatError;

/// With these OpenCV's files begin; the colon, which no other YAML has, is that of versions before 5.
const BEGINNINGS: [&str; 2] = ["%YAML:1.0", "%YAML 1.2"];

/// What else is in the file does not matter.
#[derive(Deserialize)]
pub(super) struct Storage {
    #[serde(rename = "P1")]
    pub left: Option<Matrix>,
    #[serde(rename = "P2")]
    pub right: Option<Matrix>,
    #[serde(rename = "Q")]
    pub reprojection: Option<Matrix>,
    /// As the calibration programs of OpenCV write it.
    pub image_width: Option<f64>,
    pub image_height: Option<f64>,
    #[serde(alias = "imageSize")]
    pub image_size: Option<ImageSize>,
}

/// A `cv::Size`, or what somebody else calls so.
#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum ImageSize {
    Size([f64; 2]),
    Other(IgnoredAny),
}

/// The matrices that may stand in lists too.
const MATRICES: [&str; 3] = ["P1", "P2", "Q"];

/// Whether a text is one of OpenCV's, or holds its matrices as Python's writers of YAML and JSON have them: in
/// brackets, or line by line, where KITTI's are bare numbers.
pub(super) fn is_opencv(entries: &Entries<'_>, text: &str) -> bool {
    let is_list = |value: &str| value.is_empty() || value.starts_with(['[', '!']);
    header(text).is_some()
        || xml::is_storage(text)
        || MATRICES.iter().any(|name| entries.values(name).any(is_list))
        || text.trim_start().starts_with('{')
            && MATRICES.iter().any(|name| text.contains(&format!("\"{name}\"")))
}

/// Where the line ends with which OpenCV's YAML begins, if it does. Somebody may have written comments above it.
fn header(text: &str) -> Option<usize> {
    let mut begin = 0;
    for line in text.split_inclusive('\n') {
        if BEGINNINGS.iter().any(|beginning| line.starts_with(beginning)) {
            return Some(begin + line.trim_end().len());
        }
        if !line.trim().is_empty() && !line.starts_with('#') {
            return None;
        }
        begin += line.len();
    }
    None
}

/// The pair of `P1` and `P2`, or of `Q`.
pub(super) fn parse(entries: &Entries<'_>, text: &str) -> Result<Calibration, FormatError> {
    let storage = match xml::is_storage(text) {
        true => xml::read(entries, text)?,
        false => {
            let begin = header(text).unwrap_or(0);
            // As many lines above it as there are, so that lines are counted right.
            let above = "\n".repeat(text[..begin].matches('\n').count());
            yaml::read::<Storage>(entries, &(above + &text[begin..]))?
        }
    };
    let camera = match (storage.left, storage.right, storage.reprojection) {
        (Some(left), Some(right), _) => {
            let [left, right] = [left.projection(entries, "P1")?, right.projection(entries, "P2")?];
            entries.projected(["P1", "P2"], &[left, right])?
        }
        (_, _, Some(reprojection)) => reprojected(entries, reprojection)?,
        _ => {
            let problem = "neither P1 and P2 nor Q, which stereoRectify gives, are there; without \
                           them give the focal length in pixels and the baseline in metres";
            return Err(entries.lacks(problem.into()));
        }
    };
    let (names, stated) = match storage.image_size {
        Some(ImageSize::Size(size)) => (["image_size"; 2], size.map(Some)),
        Some(ImageSize::Other(IgnoredAny)) | None => {
            (["image_width", "image_height"], [storage.image_width, storage.image_height])
        }
    };
    let size = entries.size(names, stated)?;
    Ok(Calibration::of(CalibrationLayout::OpenCv, camera).sized(size))
}

/// The pair of `Q`.
fn reprojected(entries: &Entries<'_>, matrix: Matrix) -> Result<StereoCamera, FormatError> {
    let numbers: [f64; 16] = matrix.numbers(entries, "Q", [4, 4])?;
    let row = |row: usize| &numbers[4 * row..][..4];
    let fixed = [(0, 0, 1.0), (1, 1, 1.0), (0, 1, 0.0), (0, 2, 0.0), (1, 0, 0.0), (1, 2, 0.0)];
    let below = [(2, 0, 0.0), (2, 1, 0.0), (2, 2, 0.0), (3, 0, 0.0), (3, 1, 0.0)];
    for (down, along, expected) in fixed.into_iter().chain(below) {
        entries.holds("Q", (down, along), row(down)[along], expected)?;
    }
    let baseline = 1.0 / row(3)[2];
    // Not -0, which OpenCV writes where both principal points are in one column.
    entries.camera(row(2)[3], baseline, row(3)[3] * baseline + 0.0, -row(0)[3], -row(1)[3])
}

#[cfg(test)]
mod tests {
    use super::super::tests::{read, refused};
    use super::*;

    /// As OpenCV 4 writes it; f = 700, 0.12 apart.
    const SAMPLE: &str = "%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   \
        data: [ 705., 0., 322., 0., 706., 241., 0.,\n       0., 1. ]\n\
        P1: !!opencv-matrix\n   rows: 3\n   cols: 4\n   dt: d\n   \
        data: [ 700., 0., 320.5, 0., 0., 7.0000000000000000e+02, 240., 0., 0., 0., 1., 0. ]\n\
        P2: !!opencv-matrix\n   rows: 3\n   cols: 4\n   dt: d\n   \
        data: [ 700., 0., 324.5, -84., 0., 700., 240., 0.,\n       0., 0., 1., 0. ]\nnote: \"a b\"\n";

    #[test]
    fn the_matrices_of_stereo_rectify_are_a_camera() {
        for beginning in BEGINNINGS {
            let calibration = read(&SAMPLE.replace("%YAML:1.0", beginning)).unwrap();
            assert_eq!(calibration.layout, CalibrationLayout::OpenCv);
            assert_eq!(
                calibration.camera,
                StereoCamera::new(700.0, 0.12, 4.0, 320.5, 240.0).unwrap()
            );
        }
    }

    /// Of the same pair.
    const REPROJECTION: &str = "%YAML:1.0\n---\nQ: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n   \
        data: [ 1., 0., 0., -320.5, 0., 1., 0., -240., 0., 0., 0., 700., 0., 0.,\n       8.3333333333333339, \
        33.333333333333336 ]\nimage_width: 640\nimage_height: 480\n";

    #[test]
    fn what_makes_points_of_disparities_is_the_same_camera() {
        let numbers = |camera: StereoCamera| {
            let StereoCamera { focal_px, baseline_m, doffs, cx, cy, .. } = camera;
            [focal_px, baseline_m, doffs, cx, cy]
        };
        let expected = read(SAMPLE).unwrap().camera;
        let calibration = read(REPROJECTION).unwrap();
        assert_eq!((calibration.width, calibration.height), (Some(640), Some(480)));
        for (own, expected) in numbers(calibration.camera).into_iter().zip(numbers(expected)) {
            assert!((own - expected).abs() < 1e-12 * expected, "{:?}", calibration.camera);
        }
        // Where the projections are there too they count.
        let (_, reprojection) = REPROJECTION.split_once("---\n").unwrap();
        assert_eq!(read(&format!("{SAMPLE}{reprojection}")).unwrap().camera, expected);
        refused(
            REPROJECTION,
            &[
                ("cols: 4", "cols: 3", "Q is 4 x 3 with 16 numbers, but must be 4 x 4 with 16"),
                ("[ 1., 0.,", "[ 1., 0.5,", "Q has 0.5 in row 1, column 2"),
                ("8.3333333333333339", "-8.3", "exchanged"),
                ("8.3333333333333339", "0.", "baseline"),
                ("700.,", ".nan,", "focal length"),
            ],
        );
    }

    #[test]
    fn the_size_of_images_is_read_where_it_is_stated() {
        let size = |more: &str| read(&format!("{SAMPLE}{more}")).map(|c| c.width.zip(c.height));
        assert_eq!(size(""), Ok(None));
        for more in [
            "image_width: 640\nimage_height: 480\n",
            "image_size: [ 640, 480 ]\n",
            "imageSize: [ 640, 480 ]\n",
        ] {
            assert_eq!(size(more), Ok(Some((640, 480))), "{more}");
        }
        assert_eq!(size("image_size: \"640 x 480\"\n"), Ok(None));
        for (more, word) in [
            ("image_width: 0\nimage_height: 480\n", "`image_width` is 0"),
            ("image_size: [ 640, 48.5 ]\n", "`image_size` is 48.5"),
        ] {
            let error = size(more).unwrap_err();
            assert!(error.contains(word), "{error}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let changes = [
            ("P2:", "P3:", "is a calibration, but neither P1 and P2 nor Q"),
            (
                "P1: !!opencv-matrix\n   rows: 3",
                "P1: !!opencv-matrix\n   rows: 2",
                "P1 is 2 x 4 with 12 numbers",
            ),
            ("324.5, -84.,", "324.5,", "P2 is 3 x 4 with 11 numbers"),
            ("324.5, -84.,", "324.5, 84.,", "baseline in metres"),
            ("[ 700., 0., 324.5", "[ 701., 0., 324.5", "the focal lengths 700 and 701"),
            ("700., 240., 0.,\n", "700., 240., -84.,\n", "side by side"),
            ("700., 240., 0.,\n", "700., 250., 0.,\n", "the rows 240 and 250"),
            ("[ 700., 0., 324.5", "[ seven, 0., 324.5", "the YAML cannot be read"),
            ("P1: ", "P1: [", "the YAML cannot be read"),
        ];
        refused(SAMPLE, &changes);
        let bomb = format!(
            "%YAML:1.0\n---\na: &a [{}]\n{}P1: *j\n",
            "1,".repeat(100),
            ('b'..='j')
                .map(|c| format!(
                    "{c}: &{c} [{}]\n",
                    format!("*{},", (c as u8 - 1) as char).repeat(50)
                ))
                .collect::<String>()
        );
        assert!(read(&bomb).is_err());
        // Lines are those of the file.
        let text = SAMPLE.replace("[ 700., 0., 324.5", "[ seven, 0., 324.5");
        let line = text[..text.find("seven").unwrap()].lines().count();
        let error = read(&text).unwrap_err();
        assert!(error.contains(&format!("line {line}")), "{error}");
        let error = read(&format!("# our rig\n\n{text}")).unwrap_err();
        assert!(error.contains(&format!("line {}", line + 2)), "{error}");
    }

    #[test]
    fn what_else_is_in_the_file_does_not_matter() {
        let other = SAMPLE.replace("[ 705.,", "[ .Inf,");
        let (header, body) = SAMPLE.split_once("---\n").unwrap();
        let commented = format!("# our rig\n\n{header}---\n{body}");
        for text in [
            other.replace("706.", "-.Nan"),
            format!("\u{feff}{SAMPLE}"),
            commented.clone(),
            format!("\r\n{}", SAMPLE.replace('\n', "\r\n")),
            body.to_owned(),
        ] {
            assert_eq!(read(&text).unwrap().camera, read(SAMPLE).unwrap().camera);
        }
        let error = read(&SAMPLE.replace("324.5, -84.", "324.5, -.Inf")).unwrap_err();
        assert!(error.contains("baseline"), "{error}");
    }

    #[test]
    fn lists_of_numbers_and_of_rows_in_yaml_and_json_are_the_same_camera() {
        let left = "700.0, 0, 320.5, 0], [0, 700, 240, 0], [0, 0, 1, 0";
        let right = "700, 0.0, 324.5, -84.0], [0, 700, 240, 0], [0, 0, 1, 0";
        let flat = |rows: &str| rows.replace("], [", ", ");
        let lines = |rows: &str| format!("- [{}]\n", rows.replace("], [", "]\n- ["));
        let stored = |rows: &str| {
            format!("{{ \"rows\": 3, \"cols\": 4, \"dt\": \"d\", \"data\": [{}] }}", flat(rows))
        };
        let (a, b) = (left, right);
        for text in [
            format!("P1: [{}]\nP2: [{}]\nimage_width: 640\n", flat(a), flat(b)),
            format!("rms: 0.2\nP1: [[{a}]]\nP2: [[{b}]]\nimage_width: 640\n"),
            format!("P1:\n{}P2:\n{}image_width: 640\n", lines(a), lines(b)),
            format!("{{\"P1\": [[{a}]], \"P2\": [[{b}]], \"image_width\": 640}}"),
            format!(
                "{{\n \"P1\": {},\n \"P2\": {}, \"image_width\": 640\n}}",
                stored(a),
                stored(b)
            ),
        ] {
            let calibration = read(&text).unwrap_or_else(|error| panic!("{text}\n{error}"));
            let expected = StereoCamera::new(700.0, 0.12, 4.0, 320.5, 240.0).unwrap();
            assert_eq!((calibration.camera, calibration.width), (expected, Some(640)), "{text}");
        }
        let text = format!("P1: [[{a}]]\nP2: [[{b}]]\n");
        refused(
            &text,
            &[
                ("[700.0, 0,", "[700.0,", "P1 is 3 rows of different length with 11 numbers"),
                (", [0, 0, 1, 0]]\nP2", "]\nP2", "P1 is 2 x 4 with 8 numbers, but must be 3 x 4"),
                ("P2: [[700, 0.0,", "P2: [[700, x,", "the YAML cannot be read"),
                ("P2", "P3", "neither P1 and P2 nor Q"),
            ],
        );
        let text = format!("P1: [{}]\nP2: [{}]\n", flat(a), flat(b));
        refused(
            &text,
            &[("[700.0, ", "[", "P1 is a list of 11 numbers, but must be 3 x 4 with 12")],
        );
    }
}
