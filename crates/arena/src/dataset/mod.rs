//! Scenes to measure on: pairs of images with their truth, box and range.
//!
//! A [`Case`] knows where a scene's files lie and loads them when asked ([`CaseData`]). Cases come
//! from a folder ([`open`]): from its catalogue `scenes.json` where there is one, else by the
//! layouts in which the data sets are distributed:
//!
//! | layout | files | truth | id |
//! | --- | --- | --- | --- |
//! | the course's hand-out | `images/SCENE/SCENE_image_02.png`, `_06`, `data/*_bounds.npy` | `_disp_02.png`, value / 4 | `course/SCENE` |
//! | Middlebury 2001, 2003 | `SCENE/im2`, `im6`, .png or .ppm | `disp2`, .png or .pgm, value / 8, / 4, / 2, / 1 by the scene's name | `FOLDER/SCENE` |
//! | Middlebury 2005, 2006 | `ThirdSize/SCENE/view1.png`, `view5.png`, other exposures in `Illum*/Exp*` below | `disp1.png`, value / 3, / 2, / 1 by size | `FOLDER/SCENE` |
//! | MiddEval3, Middlebury 2014, ETH3D | `SCENE/im0.png`, `im1.png`, `calib.txt` | `disp0GT.pfm` or `disp0.pfm`, `mask0nocc.png`, there or in `FOLDER_gt/SCENE` | `FOLDER/SCENE` |
//! | KITTI 2012, 2015 | `image_0` and `image_1`, `colored_0` and `_1`, or `image_2` and `image_3` | `disp_occ*`, `disp_noc*`, value / 256 | `FOLDER/FRAME`; `FOLDER/YEAR/FRAME` where both years lie in one |
//! | a pair | `left.png`, `right.png` or `NAMEl.png`, `NAMEr.png` | none | `FOLDER/NAME` |
//!
//! Rendered scenes come as [`Case::rendered`].

mod case;
mod catalogue;
mod error;
mod layout;
mod load;

use std::path::Path;

pub use case::{Case, CaseData, CaseRegion, Files, Obstacles, Purpose, TruthFile};
pub use error::DatasetError;
pub use load::{BEYOND_THE_RANGE, RANGE_BY_TRUTH, RANGE_BY_WIDTH};

/// The name of a catalogue.
const CATALOGUE: &str = "scenes.json";

/// Every case of a folder: what its `scenes.json` lists, or without one what its layouts show. The
/// course's three scenes come first.
///
/// Errors when the folder is missing or holds no scene, or two by the same id, or its catalogue is no catalogue. Images
/// are not opened yet.
pub fn open(root: &Path) -> Result<Vec<Case>, DatasetError> {
    if !root.is_dir() {
        return Err(DatasetError::NoFolder { path: root.to_owned() });
    }
    let catalogue = root.join(CATALOGUE);
    let mut cases = match catalogue.is_file() {
        true => catalogue::read(&catalogue)?,
        false => layout::discover(root)?,
    };
    if cases.is_empty() {
        return Err(DatasetError::NoScenes { path: root.to_owned() });
    }
    let place = |case: &Case| {
        ["course/cones", "course/teddy", "course/kitti"]
            .iter()
            .position(|id| *id == case.id)
            .unwrap_or(3)
    };
    // Stable: everything else keeps its order.
    cases.sort_by_key(place);
    Ok(cases)
}
