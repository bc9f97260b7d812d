//! MiddEval3, Middlebury 2014, ETH3D and what follows them: `im0.png`, `im1.png`, `disp0GT.pfm`
//! (2014: `disp0.pfm`), `mask0nocc.png`, `calib.txt`. ETH3D's truth may lie beside the folder of its scenes, in one whose
//! name ends in `_gt`.

use std::path::PathBuf;

use formats::Encoding;

use super::{Case, Folder, course};
use crate::dataset::case::{Files, TruthFile};

/// Where the truth of a scene may lie that is not in its folder.
fn beside(folder: &Folder) -> Option<PathBuf> {
    let path = std::path::absolute(&folder.path).ok()?;
    let (scenes, scene) = (path.parent()?, path.file_name()?);
    let mut name = scenes.file_name()?.to_owned();
    name.push("_gt");
    Some(scenes.with_file_name(name).join(scene))
}

/// The scene that a folder is, if it is one.
pub(super) fn cases(folder: &Folder) -> Vec<Case> {
    let Some(left) = folder.file("im0.png") else { return Vec::new() };
    // Where it is not there, with the calibration of a pair, loading it tells so.
    let right = folder.file("im1.png");
    let right = right.or_else(|| folder.has("calib.txt").then(|| folder.path.join("im1.png")));
    let Some(right) = right else { return Vec::new() };
    let beside = beside(folder);
    let file = |name: &str| {
        let other = || Some(beside.as_ref()?.join(name)).filter(|path| path.is_file());
        folder.file(name).or_else(other)
    };
    let truth = |names: [&str; 2]| {
        let path = names.into_iter().find_map(file)?;
        Some(TruthFile::new(path, Encoding::Pfm))
    };
    let files = Files {
        left,
        right,
        truth: truth(["disp0GT.pfm", "disp0.pfm"]),
        truth_right: truth(["disp1GT.pfm", "disp1.pfm"]),
        mask_nocc: file("mask0nocc.png"),
        calibration: folder.file("calib.txt"),
        ..Files::default()
    };
    vec![Case::new(folder.id(None), course::purpose(folder.last()), files)]
}
