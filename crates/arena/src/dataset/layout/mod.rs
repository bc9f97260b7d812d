//! Finds scenes by the layouts in which data sets are distributed.

mod course;
mod kitti;
mod middeval;
mod middlebury;
mod pair;

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::case::Case;
use super::error::DatasetError;

/// Folders deeper than this are not looked into.
const DEPTH: usize = 7;

/// A folder with the names of what it holds.
pub(super) struct Folder {
    pub path: PathBuf,
    /// Path from the root, with `/`.
    pub name: String,
    pub files: Vec<String>,
    pub folders: Vec<String>,
}

impl Folder {
    fn has(&self, file: &str) -> bool {
        self.files.binary_search_by(|name| name.as_str().cmp(file)).is_ok()
    }

    fn has_folder(&self, folder: &str) -> bool {
        self.folders.binary_search_by(|name| name.as_str().cmp(folder)).is_ok()
    }

    /// A file, if the folder holds it.
    fn file(&self, file: &str) -> Option<PathBuf> {
        self.has(file).then(|| self.path.join(file))
    }

    /// The name of the folder itself.
    fn last(&self) -> &str {
        self.name.rsplit('/').next().unwrap_or_default()
    }

    /// The name of the folder above it.
    fn above(&self) -> &str {
        self.name.rsplit('/').nth(1).unwrap_or_default()
    }

    /// An id: the folder's name, without the parts that only say what lies below.
    fn id(&self, scene: Option<&str>) -> String {
        let parts = self.name.split('/').chain(scene);
        let telling = |part: &&str| !matches!(*part, "" | "training" | "two_view_training");
        let parts: Vec<_> = parts.filter(telling).collect();
        match parts[..] {
            [] => "scene".into(),
            _ => parts.join("/"),
        }
    }
}

/// Every scene below `root`, in the order of the folders' names. Errors where two would have one id.
pub(super) fn discover(root: &Path) -> Result<Vec<Case>, DatasetError> {
    let mut cases = Vec::new();
    visit(root, String::new(), DEPTH, &mut cases)?;
    let mut seen: HashMap<&str, &Case> = HashMap::new();
    for case in &cases {
        if let Some(other) = seen.insert(&case.id, case) {
            let [one, other] =
                [other, case].map(|case| case.files().map(|files| files.left.clone()));
            let [one, other] = [one, other].map(Option::unwrap_or_default);
            return Err(DatasetError::SameId { id: case.id.clone(), one, other });
        }
    }
    Ok(cases)
}

fn visit(
    path: &Path,
    name: String,
    depth: usize,
    cases: &mut Vec<Case>,
) -> Result<(), DatasetError> {
    let folder = read(path, name)?;
    // A folder belongs to the first layout that recognises it; the pairs come last because every
    // layout would look like a pair to them.
    let finders = [course::cases, kitti::cases, middlebury::cases, middeval::cases, pair::cases];
    let found = finders.iter().map(|find| find(&folder)).find(|found| !found.is_empty());
    let whole_tree = found.is_some() && course::is_root(&folder);
    cases.extend(found.into_iter().flatten());
    if depth == 0 || whole_tree {
        return Ok(());
    }
    for sub in &folder.folders {
        let name = match folder.name.as_str() {
            "" => sub.clone(),
            above => format!("{above}/{sub}"),
        };
        visit(&folder.path.join(sub), name, depth - 1, cases)?;
    }
    Ok(())
}

/// What a file system keeps for itself at its root: nobody else may look into it.
const OF_THE_SYSTEM: [&str; 2] = ["lost+found", "System Volume Information"];

/// The names in a folder, sorted; hidden ones, the system's own and links to folders are left out.
fn read(path: &Path, name: String) -> Result<Folder, DatasetError> {
    let failed = |source| DatasetError::Read { path: path.to_owned(), source };
    let (mut files, mut folders) = (Vec::new(), Vec::new());
    for entry in fs::read_dir(path).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let Ok(name) = entry.file_name().into_string() else { continue };
        let kind = entry.file_type().map_err(failed)?;
        let is_link_to_folder = || kind.is_symlink() && entry.path().is_dir();
        if name.starts_with('.') || OF_THE_SYSTEM.contains(&&*name) || is_link_to_folder() {
            continue;
        } else if kind.is_dir() {
            folders.push(name);
        } else {
            files.push(name);
        }
    }
    files.sort();
    folders.sort();
    Ok(Folder { path: path.to_owned(), name, files, folders })
}
