//! `scenes.json`: a list of scenes with everything that their files do not say.
//!
//! ```json
//! [{"id": "course/cones", "use": "test", "left": "cones/im2.png", "right": "cones/im6.png",
//!   "truth": "cones/disp2.png", "truth_encoding": "png8/4", "max_disparity": 55,
//!   "box": "cones/bounds.npy", "source": "...", "terms": "..."}]
//! ```
//! `id`, `use`, `left` and `right` are needed; `truth` (with `truth_encoding`), `truth_noc`,
//! `truth_right`, `mask_nocc`, `box`, `calib`, `min_disparity` (0 unless stated), `max_disparity`,
//! `source` and `terms` may be there. A true disparity of 0 or infinity is none, however it is encoded.
//! Paths are relative to the catalogue's folder.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use formats::Encoding;
use raster::DisparityRange;
use serde::Deserialize;

use super::case::{Case, Files, Purpose, TruthFile};
use super::error::DatasetError;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    id: String,
    #[serde(rename = "use")]
    purpose: Purpose,
    left: PathBuf,
    right: PathBuf,
    truth: Option<PathBuf>,
    truth_encoding: Option<String>,
    truth_noc: Option<PathBuf>,
    truth_right: Option<PathBuf>,
    mask_nocc: Option<PathBuf>,
    #[serde(rename = "box")]
    bounds: Option<PathBuf>,
    calib: Option<PathBuf>,
    min_disparity: Option<i32>,
    max_disparity: Option<i32>,
    /// For people: where it comes from.
    #[serde(default, rename = "source")]
    _source: String,
    /// For people: under which terms it may be used.
    #[serde(default, rename = "terms")]
    _terms: String,
}

/// Reads a catalogue.
pub(super) fn read(path: &Path) -> Result<Vec<Case>, DatasetError> {
    let text = fs::read_to_string(path)
        .map_err(|source| DatasetError::Read { path: path.to_owned(), source })?;
    let wrong = |problem: String| DatasetError::Catalogue { path: path.to_owned(), problem };
    let entries: Vec<Entry> =
        serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    if entries.is_empty() {
        return Err(wrong("it lists no scene".into()));
    }
    let root = path.parent().unwrap_or(Path::new(""));
    let mut ids = HashSet::new();
    entries
        .into_iter()
        .map(|entry| {
            let id = entry.id.clone();
            if !ids.insert(id.clone()) {
                return Err(wrong(format!("the id `{id}` is there twice")));
            }
            case(root, entry).map_err(|problem| wrong(format!("scene `{id}`: {problem}")))
        })
        .collect()
}

fn case(root: &Path, entry: Entry) -> Result<Case, String> {
    let plain = |part: &str| !matches!(part, "" | "." | "..");
    if !entry.id.split('/').all(plain) || entry.id.contains(|c: char| c == '\\' || c.is_control()) {
        return Err(
            "an id has the form FAMILY/SCENE or SCENE, without empty parts, `.`, `..` or control characters"
                .into(),
        );
    }
    let of_truth = [
        ("truth_encoding", entry.truth_encoding.is_some()),
        ("truth_noc", entry.truth_noc.is_some()),
        ("truth_right", entry.truth_right.is_some()),
    ];
    if let Some((field, _)) =
        of_truth.iter().find(|(_, is_there)| *is_there && entry.truth.is_none())
    {
        return Err(format!("{field} is there, but no truth: name that too, or leave {field} out"));
    }
    let encoding = match &entry.truth_encoding {
        Some(text) => text.parse().map_err(|error: formats::FormatError| error.to_string())?,
        None => Encoding::Auto,
    };
    let truth_file =
        |path: PathBuf| TruthFile { path: root.join(path), encoding, zero_is_none: true };
    let truth = entry.truth.map(truth_file);
    let right_of = |file: &TruthFile| right_view_of(&file.path).map(truth_file);
    let truth_right = match entry.truth_right {
        Some(path) => Some(truth_file(path)),
        None => truth.as_ref().and_then(right_of),
    };
    let truth_noc = match entry.truth_noc {
        Some(path) => Some(truth_file(path)),
        // KITTI's folder names say what the files hold.
        None => truth.clone().filter(|file| lies_in(&file.path, "disp_noc")),
    };
    let range = match (entry.min_disparity, entry.max_disparity) {
        (min, Some(max)) => {
            Some(DisparityRange::new(min.unwrap_or(0), max).map_err(|error| error.to_string())?)
        }
        (Some(_), None) => return Err("min_disparity needs a max_disparity".into()),
        (None, None) => None,
    };
    let files = Files {
        left: root.join(entry.left),
        right: root.join(entry.right),
        truth,
        truth_right,
        truth_noc,
        unscaled: None,
        mask_nocc: entry.mask_nocc.map(|path| root.join(path)),
        bounds: entry.bounds.map(|path| root.join(path)),
        calibration: entry.calib.map(|path| root.join(path)),
    };
    let mut case = Case::new(entry.id, entry.purpose, files);
    case.range = range;
    Ok(case)
}

/// Whether the name of the folder that the file is in begins with `prefix`.
fn lies_in(path: &Path, prefix: &str) -> bool {
    let folder = path.parent().and_then(Path::file_name);
    folder.is_some_and(|name| name.to_string_lossy().starts_with(prefix))
}

/// The truth of the right view beside that of the left one, as Middlebury 2005 and 2006 name them.
pub(super) fn right_view_of(left: &Path) -> Option<PathBuf> {
    let right = left.with_file_name("disp5.png");
    (left.file_name()? == "disp1.png" && right.is_file()).then_some(right)
}
