//! KITTI 2012 (`image_0`, `image_1`, or `colored_0`, `colored_1`) and 2015 (`image_2`, `image_3`).

use formats::Encoding;

use super::{Case, Folder, course};
use crate::dataset::case::{Files, Purpose, TruthFile};

/// Left and right images, in the order of preference.
const VIEWS: [(&str, &str); 3] =
    [("image_0", "image_1"), (LEFT_2015, "image_3"), ("colored_0", "colored_1")];
/// The left images of 2015, whose frames are others by the same numbers.
const LEFT_2015: &str = "image_2";
/// Truths of all pixels and of those that both cameras see, of 2012 and of 2015.
const TRUTHS: [(&str, &str); 2] = [("disp_occ", "disp_noc"), ("disp_occ_0", "disp_noc_0")];

/// Every frame at time 10, the only one that has truth.
pub(super) fn cases(folder: &Folder) -> Vec<Case> {
    let has = |views: &(&str, &str)| folder.has_folder(views.0) && folder.has_folder(views.1);
    let Some((left, right)) = VIEWS.into_iter().find(has) else {
        return Vec::new();
    };
    let Ok(images) = super::read(&folder.path.join(left), String::new()) else {
        return Vec::new();
    };
    let truth = |name: &str, frame: &str| {
        let path = folder.path.join(name).join(frame);
        path.is_file().then_some(TruthFile::new(path, Encoding::Png16 { divisor: 256.0 }))
    };
    let frames = images.files.iter().filter(|name| name.ends_with("_10.png"));
    frames
        .filter(|frame| folder.path.join(right).join(frame).is_file())
        .map(|frame| {
            let occ = TRUTHS.iter().find_map(|(occ, _)| truth(occ, frame));
            let noc = TRUTHS.iter().find_map(|(_, noc)| truth(noc, frame));
            let files = Files {
                left: folder.path.join(left).join(frame),
                right: folder.path.join(right).join(frame),
                truth: occ.or_else(|| noc.clone()),
                truth_noc: noc,
                ..Files::default()
            };
            let scene = frame.trim_end_matches("_10.png");
            let purpose = if left == LEFT_2015 { Purpose::Tuning } else { course::purpose(scene) };
            Case::new(folder.id(Some(scene)), purpose, files)
        })
        .collect()
}
