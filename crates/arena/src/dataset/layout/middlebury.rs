//! Middlebury 2005 and 2006: `view1.png`, `view5.png`, `disp1.png`, `disp5.png`.

use formats::Encoding;

use super::{Case, Folder, course};
use crate::dataset::case::{Files, TruthFile};

/// The scene that a folder is, if it is one.
///
/// The value of a truth pixel is the disparity times 3, 2 or 1 at third, half or full size, which
/// only the name of a folder above tells: without `ThirdSize`, `HalfSize` or `FullSize` there, the
/// scene is taken without its truth rather than with a wrong one.
pub(super) fn cases(folder: &Folder) -> Vec<Case> {
    let (Some(left), Some(right)) = (folder.file("view1.png"), folder.file("view5.png")) else {
        return Vec::new();
    };
    let size = folder.name.split('/').rev().find_map(|part| match part {
        "ThirdSize" => Some(3.0),
        "HalfSize" => Some(2.0),
        "FullSize" => Some(1.0),
        _ => None,
    });
    let truth = |name: &str| {
        let (path, divisor) = folder.file(name).zip(size)?;
        Some(TruthFile::new(path, Encoding::Png8 { divisor }))
    };
    let files = Files {
        left,
        right,
        truth: truth("disp1.png"),
        truth_right: truth("disp5.png"),
        ..Files::default()
    };
    vec![Case::new(folder.id(None), course::purpose(folder.last()), files)]
}
