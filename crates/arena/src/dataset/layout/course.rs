//! The course's hand-out: `images/` and `data/*_bounds.npy`, with the ranges of its assignment.

use std::fs;

use formats::Encoding;
use raster::DisparityRange;

use super::{Case, Folder, kitti, read};
use crate::dataset::case::{Files, Purpose, TruthFile};

/// Scene, largest disparity and file of the box, as the assignment states them.
const SCENES: [(&str, i32, &str); 2] =
    [("cones", 55, "cones_02_bounds.npy"), ("teddy", 55, "teddy_02_bounds.npy")];
const KITTI: (i32, &str) = (150, "kitti_070_bounds.npy");
/// Its frame in KITTI 2012.
const FRAME: &str = "000070";

/// What a scene of another data set is for, by its name there: the course measures with some of KITTI 2012 and
/// Middlebury, wherever they are found.
pub(super) fn purpose(scene: &str) -> Purpose {
    let is_measured_with = SCENES.iter().any(|(own, ..)| scene.eq_ignore_ascii_case(own));
    if is_measured_with || scene == FRAME { Purpose::Test } else { Purpose::Tuning }
}

/// Whether this is the folder above `images` and `data`.
pub(super) fn is_root(folder: &Folder) -> bool {
    folder.has_folder("images")
        && folder.has_folder("data")
        && fs::read_dir(folder.path.join("data")).is_ok_and(|mut entries| {
            entries.any(|entry| {
                entry.is_ok_and(|e| e.file_name().to_string_lossy().ends_with("_bounds.npy"))
            })
        })
}

/// Cones, Teddy, KITTI 000070 and the rover's pairs.
pub(super) fn cases(folder: &Folder) -> Vec<Case> {
    if !is_root(folder) {
        return Vec::new();
    }
    let (images, data) = (folder.path.join("images"), folder.path.join("data"));
    let bounds = |file: &str| Some(data.join(file)).filter(|path| path.is_file());
    let mut cases = Vec::new();
    for (scene, highest, box_file) in SCENES {
        let file = |name: &str| images.join(scene).join(format!("{scene}_{name}.png"));
        let files = Files {
            left: file("image_02"),
            right: file("image_06"),
            truth: Some(TruthFile::new(file("disp_02"), Encoding::Png8 { divisor: 4.0 })),
            bounds: bounds(box_file),
            ..Files::default()
        };
        if files.left.is_file() && files.right.is_file() {
            cases.push(course_case(&format!("course/{scene}"), highest, files));
        }
    }
    if let Ok(folder) = read(&images.join("kitti"), "course".into()) {
        // The hand-out has one frame, grey and in colour; the course matches the grey one.
        if let Some(frame) = kitti::cases(&folder).into_iter().next() {
            let files = frame.files().cloned().unwrap_or_default();
            let calibration = frame_calibration(&files);
            let files = Files { bounds: bounds(KITTI.1), calibration, ..files };
            cases.push(course_case("course/kitti", KITTI.0, files));
        }
    }
    if let Ok(mars) = read(&images.join("mars"), "course/mars".into()) {
        cases.extend(super::pair::cases(&mars));
    }
    cases
}

fn course_case(id: &str, highest: i32, files: Files) -> Case {
    let mut case = Case::new(id, Purpose::Test, files);
    case.range = DisparityRange::new(0, highest).ok();
    case
}

/// `calib/000070.txt` for `image_0/000070_10.png`.
fn frame_calibration(files: &Files) -> Option<std::path::PathBuf> {
    let frame = files.left.file_stem()?.to_string_lossy();
    let (sequence, _) = frame.split_once('_')?;
    let path = files.left.parent()?.parent()?.join("calib").join(format!("{sequence}.txt"));
    path.is_file().then_some(path)
}
