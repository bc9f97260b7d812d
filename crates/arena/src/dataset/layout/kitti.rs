//! KITTI 2012 (`image_0`, `image_1`, or `colored_0`, `colored_1`) and 2015 (`image_2`, `image_3`).

use formats::Encoding;

use super::{Case, Folder, course};
use crate::dataset::case::{Files, Purpose, TruthFile};

/// What folders of a year are called. Frames of the two are others by the same numbers.
struct Year {
    name: &'static str,
    /// Left and right images, in the order of preference.
    views: &'static [(&'static str, &'static str)],
    /// Truths of all pixels and of those that both cameras see.
    truths: (&'static str, &'static str),
}

const YEARS: [Year; 2] = [
    Year {
        name: "2012",
        views: &[("image_0", "image_1"), ("colored_0", "colored_1")],
        truths: ("disp_occ", "disp_noc"),
    },
    Year { name: "2015", views: &[("image_2", "image_3")], truths: ("disp_occ_0", "disp_noc_0") },
];

/// Every frame at time 10, the only one that has truth.
pub(super) fn cases(folder: &Folder) -> Vec<Case> {
    let has = |views: &&(&str, &str)| folder.has_folder(views.0) && folder.has_folder(views.1);
    // Where all right images of frames with truth are not there loading them tells so.
    let half = |year: &'static Year| {
        let has_truth = [year.truths.0, year.truths.1].iter().any(|name| folder.has_folder(name));
        year.views.iter().find(|views| has_truth && folder.has_folder(views.0))
    };
    let views = |year: &'static Year| year.views.iter().find(has).or_else(|| half(year));
    let years = YEARS.iter().filter_map(|year| Some((year, *views(year)?)));
    let years: Vec<_> = years.collect();
    let are_both = years.len() > 1;
    years.into_iter().flat_map(|(year, views)| of_year(folder, year, views, are_both)).collect()
}

/// The frames of a year. Where both lie in one folder their numbers alone would not tell them apart; where one does, its
/// truth may be called as the other's.
fn of_year(folder: &Folder, year: &Year, (left, right): (&str, &str), are_both: bool) -> Vec<Case> {
    let Ok(images) = super::read(&folder.path.join(left), String::new()) else {
        return Vec::new();
    };
    let truth = |name: &str, frame: &str| {
        let path = folder.path.join(name).join(frame);
        path.is_file().then_some(TruthFile::new(path, Encoding::Png16 { divisor: 256.0 }))
    };
    let own = |of: &&Year| !are_both || of.name == year.name;
    let frames = images.files.iter().filter(|name| name.ends_with("_10.png"));
    frames
        .filter_map(|frame| {
            let occ = YEARS.iter().filter(own).find_map(|of| truth(of.truths.0, frame));
            let noc = YEARS.iter().filter(own).find_map(|of| truth(of.truths.1, frame));
            // Where the right image of a frame with truth is not there loading it tells so.
            let is_scene = || folder.path.join(right).join(frame).is_file();
            if occ.is_none() && noc.is_none() && !is_scene() {
                return None;
            }
            let files = Files {
                left: folder.path.join(left).join(frame),
                right: folder.path.join(right).join(frame),
                truth: occ.or_else(|| noc.clone()),
                truth_noc: noc,
                ..Files::default()
            };
            let number = frame.trim_end_matches("_10.png");
            let purpose = match year.name {
                "2012" => course::purpose(number),
                _ => Purpose::Tuning,
            };
            let scene =
                if are_both { format!("{}/{number}", year.name) } else { number.to_owned() };
            Some(Case::new(folder.id(Some(&scene)), purpose, files))
        })
        .collect()
}
