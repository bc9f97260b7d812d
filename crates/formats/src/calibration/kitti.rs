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

/// Where files of raw recordings have the size of rectified images.
const SIZES: [&str; 4] = ["S_rect_00", "S_rect_01", "S_rect_02", "S_rect_03"];

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
        entries.lacks(problem)
    })?;
    let size = size(entries)?;
    let calibration = Calibration::of(CalibrationLayout::Kitti, camera)
        .sized(size.map_or([None; 2], |size| size.map(Some)));
    Ok(Calibration { colour_camera: colour, ..calibration })
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
    let matrices = [entries.numbers(left_name)?, entries.numbers(right_name)?];
    entries.projected([left_name, right_name], &matrices).map(Some)
}

/// The size of all images after rectification, which files of raw recordings state.
fn size(entries: &Entries<'_>) -> Result<Option<[usize; 2]>, FormatError> {
    let mut stated: Option<[usize; 2]> = None;
    for name in SIZES.into_iter().filter(|name| entries.has(name)) {
        let numbers: [f64; 2] = entries.numbers(name)?;
        let is_size = |number: &f64| *number >= 1.0 && *number < 1e9 && number.fract() == 0.0;
        let size = numbers.map(|number| number as usize);
        if !numbers.iter().all(is_size) || stated.is_some_and(|stated| stated != size) {
            let [width, height] = numbers;
            let problem = match stated {
                Some([columns, rows]) if numbers.iter().all(is_size) => format!(
                    "`{name}` is {width} x {height}, another camera's {columns} x {rows}: \
                     rectified images have one size"
                ),
                _ => format!("`{name}` is {width} x {height}, but must be columns and rows"),
            };
            return Err(entries.fail(None, problem));
        }
        stated = Some(size);
    }
    Ok(stated)
}

#[cfg(test)]
mod tests {
    use super::super::tests::read;
    use raster::Plane;

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
        assert_eq!(calibration.camera_of("training/image_2/000000_10.png").0, colour);
        assert_eq!(calibration.camera_of("drive/image_02/data/0000000000.png").0, colour);
        // What else is on the way there says nothing.
        for grey in ["image_0/000070_10.png", "image_2/image_0/000070_10.png", "left.png"] {
            assert_eq!(calibration.camera_of(grey).0, calibration.camera, "{grey}");
        }
    }

    #[test]
    fn a_coloured_picture_is_of_the_colour_pair_wherever_it_lies() {
        let calibration = read(SAMPLE).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let left = folder.path().join("left.png");
        crate::picture::write_png_rgb(&left, &Plane::filled(3, 2, [9u8; 3])).unwrap();
        assert_eq!(Some(calibration.camera_of(&left).0), calibration.colour_camera);
        let (grey, _) = SAMPLE.split_at(SAMPLE.find("P2").unwrap());
        assert!(read(grey).unwrap().camera_of(&left).1.unwrap().starts_with("P2 and P3"));
        // The folder's name counts more.
        let grey = folder.path().join("image_0");
        std::fs::create_dir(&grey).unwrap();
        std::fs::copy(&left, grey.join("left.png")).unwrap();
        assert_eq!(calibration.camera_of(grey.join("left.png")).0, calibration.camera);
    }

    #[test]
    fn a_pair_that_is_not_there_is_told() {
        let (grey, colour) = SAMPLE.split_at(SAMPLE.find("P2").unwrap());
        let [both, grey, colour] = [SAMPLE, grey, colour].map(|text| read(text).unwrap());
        let (of_grey, of_colour) = ("image_00/data/0000000000.png", "image_2/000000_10.png");
        assert_eq!([of_grey, of_colour].map(|left| both.camera_of(left).1), [None, None]);
        let doubt = grey.camera_of(of_colour).1.unwrap();
        assert!(
            doubt.starts_with("P2 and P3, of the pair") && doubt.contains(of_colour),
            "{doubt}"
        );
        assert!(colour.camera_of(of_grey).1.unwrap().starts_with("P0 and P1"));
        assert_eq!([grey.camera_of(of_grey).1, grey.camera_of("left.png").1], [None, None]);
    }

    #[test]
    fn the_raw_spelling_and_one_pair_are_enough() {
        let (_, colour) = SAMPLE.split_once("P2").unwrap();
        let text = format!("calib_time: 09-Jan-2012 13:57:47\nP2{colour}").replace('P', "P_rect_0");
        let calibration = read(&text).unwrap();
        assert_eq!(Some(calibration.camera), calibration.colour_camera);
    }

    #[test]
    fn raw_recordings_say_how_large_images_are() {
        let sized = |sizes: &str| read(&format!("{sizes}{SAMPLE}"));
        let calibration =
            sized("S_00: 1392 512\nS_rect_00: 1.242000e+03 3.750000e+02\nS_rect_02: 1242 375\n");
        let calibration = calibration.unwrap();
        assert_eq!((calibration.width, calibration.height), (Some(1242), Some(375)));
        for (sizes, word) in [
            ("S_rect_00: 1242 375\nS_rect_01: 1241 375\n", "have one size"),
            ("S_rect_00: 1242.5 375\n", "must be columns and rows"),
            ("S_rect_00: -1 375\n", "must be columns and rows"),
            ("S_rect_00: 0 0\n", "must be columns and rows"),
            ("S_rect_00: 1242 0\n", "must be columns and rows"),
            ("S_rect_00: 1242\n", "must be 2 numbers"),
        ] {
            let error = sized(sizes).unwrap_err();
            assert!(error.contains(word), "{error}");
        }
    }

    #[test]
    fn half_a_pair_is_not_enough() {
        let (grey, _) = SAMPLE.split_once("P1").unwrap();
        assert!(read(grey).unwrap_err().contains("a pair is needed, P0 and P1"));
        let swapped = SAMPLE.replace("P0", "PX").replace("P1", "P0").replace("PX", "P1");
        assert!(read(&swapped).unwrap_err().contains("baseline"), "the right camera on the left");
    }
}
