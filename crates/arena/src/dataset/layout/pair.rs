//! Pairs without truth: `left.png` and `right.png`, or `NAMEl.png` and `NAMEr.png`.

use super::{Case, Folder};
use crate::dataset::case::{Files, Purpose};

/// The pairs in a folder.
pub(super) fn cases(folder: &Folder) -> Vec<Case> {
    let case = |id: String, left: &str, right: &str| {
        let path = |name: &str| folder.path.join(name);
        let files = Files { left: path(left), right: path(right), ..Files::default() };
        Case::new(id, Purpose::Rover, files)
    };
    if folder.has("left.png") && folder.has("right.png") {
        return vec![case(folder.id(None), "left.png", "right.png")];
    }
    folder
        .files
        .iter()
        .filter_map(|left| {
            let name = left.strip_suffix("l.png")?;
            let right = format!("{name}r.png");
            folder.has(&right).then(|| case(folder.id(Some(name)), left, &right))
        })
        .collect()
}
