//! MiddEval3, Middlebury 2014, ETH3D and what follows them: `im0.png`, `im1.png`, `disp0GT.pfm`
//! (2014: `disp0.pfm`), `mask0nocc.png`, `calib.txt`.

use formats::Encoding;

use super::{Case, Folder, course};
use crate::dataset::case::{Files, TruthFile};

/// The scene that a folder is, if it is one.
pub(super) fn cases(folder: &Folder) -> Vec<Case> {
    let (Some(left), Some(right)) = (folder.file("im0.png"), folder.file("im1.png")) else {
        return Vec::new();
    };
    let truth = |names: [&str; 2]| {
        let path = names.into_iter().find_map(|name| folder.file(name))?;
        Some(TruthFile::new(path, Encoding::Pfm))
    };
    let files = Files {
        left,
        right,
        truth: truth(["disp0GT.pfm", "disp0.pfm"]),
        truth_right: truth(["disp1GT.pfm", "disp1.pfm"]),
        mask_nocc: folder.file("mask0nocc.png"),
        calibration: folder.file("calib.txt"),
        ..Files::default()
    };
    vec![Case::new(folder.id(None), course::purpose(folder.last()), files)]
}
