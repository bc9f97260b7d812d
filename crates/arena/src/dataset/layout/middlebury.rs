//! Middlebury 2001 and 2003: `im2`, `im6`, `disp2`, `disp6`; 2005 and 2006: `view1.png`, `view5.png`, `disp1.png`,
//! `disp5.png`.
//!
//! The value of a truth pixel is the disparity times a number that nothing but a name tells: of the scene, or of a folder
//! above. Without it the scene is taken without its truth rather than with a wrong one.

use std::path::{Component, Path, PathBuf};

use formats::Encoding;

use super::{Case, Folder, course};
use crate::dataset::case::{Files, TruthFile};

/// What images and truth end in.
const PICTURES: [&str; 3] = ["png", "ppm", "pgm"];
/// The scenes of 2001 and 2003 in all their sizes, and what disparities were multiplied by.
const SCALES: [(&[&str], f32); 4] = [
    (&["barn1", "barn2", "bull", "poster", "sawtooth", "venus"], 8.0),
    (&["cones", "teddy", "conesq", "teddyq"], 4.0),
    (&["conesh", "teddyh"], 2.0),
    (&["conesf", "teddyf"], 1.0),
];
/// The same for folders of 2005 and 2006.
const SIZES: [(&str, f32); 3] = [("ThirdSize", 3.0), ("HalfSize", 2.0), ("FullSize", 1.0)];

/// The scene that a folder is, if it is one.
pub(super) fn cases(folder: &Folder) -> Vec<Case> {
    let found = of_2005(folder).or_else(|| of_2003(folder));
    // Of what the course measures with, all sizes are one scene.
    let purpose = course::purpose(folder.last().trim_end_matches(['Q', 'H', 'F', 'q', 'h', 'f']));
    let case = |files| Case::new(folder.id(None), purpose, files);
    found.map(case).into_iter().collect()
}

fn of_2005(folder: &Folder) -> Option<Files> {
    let (left, right) = (folder.file("view1.png")?, folder.file("view5.png")?);
    // All of the path: the root may lie in such a folder.
    let path = std::path::absolute(&folder.path).unwrap_or_default();
    let named = |part: Component<'_>| SIZES.iter().find(|(name, _)| part.as_os_str() == *name);
    let scale = path.components().rev().find_map(named).map(|(_, scale)| *scale);
    // Other exposures lie two folders below the truth.
    let is_exposure = folder.last().starts_with("Exp") && folder.above().starts_with("Illum");
    let place = if is_exposure { path.parent()?.parent()? } else { &path };
    let truth = |name: &str| Some(place.join(name)).filter(|file| file.is_file());
    Some(scaled(left, right, [truth("disp1.png"), truth("disp5.png")], scale))
}

fn of_2003(folder: &Folder) -> Option<Files> {
    let file = |name: &str| PICTURES.iter().find_map(|kind| folder.file(&format!("{name}.{kind}")));
    let (left, right) = (file("im2")?, file("im6")?);
    let scene = folder.last().to_ascii_lowercase();
    let scale =
        SCALES.iter().find(|(scenes, _)| scenes.contains(&&*scene)).map(|(_, scale)| *scale);
    Some(scaled(left, right, [file("disp2"), file("disp6")], scale))
}

/// A pair with its truths, if their scale is known.
fn scaled(
    left: PathBuf,
    right: PathBuf,
    truths: [Option<PathBuf>; 2],
    scale: Option<f32>,
) -> Files {
    let known = |path: &Path| {
        let divisor = scale?;
        Some(TruthFile::new(path.to_owned(), Encoding::Png8 { divisor }))
    };
    let [truth, truth_right] = truths.each_ref().map(|path| path.as_deref().and_then(known));
    let [unscaled, _] = truths;
    let unscaled = unscaled.filter(|_| truth.is_none());
    Files { left, right, truth, truth_right, unscaled, ..Files::default() }
}
