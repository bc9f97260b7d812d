//! Where the course's files are in a submission, which of them are missing, and what lies elsewhere.

use std::fs;
use std::path::{Path, PathBuf};

use super::contents::{files_below, shortened};
use super::error::SubmissionError;
use super::finding::Finding;

/// The files of the course's assignment.
const FILES: [&str; 3] = ["secret_id.py", "stereo_disparity_fast.py", "stereo_disparity_best.py"];

/// The folder in which the course's files are: the copy itself, or one below it when the
/// submission was packed with its folder. Of several that hold as many it is nobody's to choose one.
pub(super) fn find_root(path: &Path, staging: &Path) -> Result<PathBuf, SubmissionError> {
    let mut level = vec![staging.to_owned()];
    let (mut python_files, mut packed) = (Vec::new(), Vec::new());
    while !level.is_empty() {
        let holding = |folder: &PathBuf| FILES.iter().filter(|f| folder.join(f).is_file()).count();
        // Of folders at the same depth the one that holds most.
        level.sort();
        let most = level.iter().map(holding).max().unwrap_or(0);
        let holders: Vec<&PathBuf> =
            level.iter().filter(|f| most > 0 && holding(f) == most).collect();
        match holders[..] {
            [] => (),
            [one] => return Ok(one.clone()),
            [one, other, ..] => {
                let [one, other] = [one, other]
                    .map(|folder| folder.strip_prefix(staging).unwrap_or(folder).to_owned());
                return Err(SubmissionError::Several { path: path.to_owned(), one, other });
            }
        }
        let mut below = Vec::new();
        for folder in level {
            let failed = |source| SubmissionError::Read { path: folder.clone(), source };
            for entry in fs::read_dir(&folder).map_err(failed)?.flatten() {
                let path = entry.path();
                if path.is_dir() {
                    below.push(path);
                } else if path.extension().is_some_and(|e| e == "py" || e == "ipynb") {
                    python_files.push(entry.file_name().to_string_lossy().into_owned());
                } else if path
                    .extension()
                    .is_some_and(|e| PACKED.iter().any(|end| e.eq_ignore_ascii_case(end)))
                {
                    packed.push(shortened(&entry.file_name().to_string_lossy()));
                }
            }
        }
        level = below;
    }
    python_files.sort();
    python_files.truncate(6);
    let hint = match python_files.is_empty() {
        true if let Some(packed) = packed.iter().min() => {
            format!(", but `{packed}`: unpack that, and hand in what is in it")
        }
        true => ", and no Python file at all".to_owned(),
        false if python_files.iter().all(|name| name.ends_with(NOTEBOOK)) => {
            format!("; it has {}: {EXPORT} under these names", python_files.join(", "))
        }
        false => format!("; it has {}: rename them", python_files.join(", ")),
    };
    Err(SubmissionError::NoModules { path: path.to_owned(), hint })
}

/// What archives end with.
const PACKED: [&str; 7] = ["zip", "tar", "gz", "tgz", "7z", "rar", "xz"];

/// A finding for what lies outside of the folder that was chosen: another one with files of the course, or other files
/// of Python.
pub(super) fn left_out(staging: &Path, root: &Path) -> Option<Finding> {
    let Some(other) = elsewhere(staging, &FILES, Some(root)) else { return beside(staging, root) };
    let other = other.display().to_string();
    let chosen = root.strip_prefix(staging).unwrap_or(root).display().to_string();
    let text = format!(
        "it holds files of the course too, and nobody looks at them: those in `{}` are graded",
        shortened(&chosen)
    );
    Some(Finding::about(shortened(&other), text))
}

/// A finding for files of Python, none of them the course's, that lie outside of the folder that was chosen.
fn beside(staging: &Path, root: &Path) -> Option<Finding> {
    if staging == root {
        return None;
    }
    let files = files_below(staging, Some(root)).into_iter();
    let sources = files.filter(|path| path.extension().is_some_and(|end| end == "py"));
    let found: Vec<String> = sources
        .map(|path| shortened(&path.strip_prefix(staging).unwrap_or(&path).display().to_string()))
        .collect();
    let file = found.first()?.clone();
    let chosen = root.strip_prefix(staging).unwrap_or(root).display().to_string();
    let lie = match found.len() - 1 {
        0 => "it lies".into(),
        others => format!("it and {others} more of Python lie"),
    };
    let text = format!(
        "{lie} outside of `{}`, whose files are graded, and out of their reach: if they need it, put all into one folder",
        shortened(&chosen)
    );
    Some(Finding::about(file, text))
}

/// What a notebook's name ends with, and what is to be done with it.
const NOTEBOOK: &str = ".ipynb";
const EXPORT: &str = "a notebook is no Python file, export it (`jupyter nbconvert --to script`, or File > Save as .py)";

/// The first folder from `root` on, and relative to it, which has one of these files. One is not looked into.
fn elsewhere(root: &Path, files: &[&str], besides: Option<&Path>) -> Option<PathBuf> {
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        if besides == Some(&folder) {
            continue;
        }
        if files.iter().any(|file| folder.join(file).is_file()) {
            return folder.strip_prefix(root).ok().map(Path::to_owned);
        }
        let entries = fs::read_dir(&folder).into_iter().flatten().flatten();
        let below = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
        let mut below: Vec<PathBuf> = below.map(|entry| entry.path()).collect();
        below.sort();
        folders.extend(below.into_iter().rev());
    }
    None
}

/// A finding for each of the course's files that is not there.
pub(super) fn missing_files(root: &Path) -> Vec<Finding> {
    let names: Vec<String> = fs::read_dir(root)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    let mut findings = Vec::new();
    for file in FILES {
        if root.join(file).is_file() {
            continue;
        }
        let stem = file.trim_end_matches(".py");
        let alike = names.iter().find(|name| name.to_lowercase().starts_with(stem));
        let instead = match alike {
            Some(name) if root.join(name).is_dir() => {
                format!(
                    "; `{name}` is a folder: hand in one file, with all that it needs beside it"
                )
            }
            Some(name) if name.ends_with(NOTEBOOK) => format!("; there is `{name}`: {EXPORT}"),
            Some(name) if name.ends_with(".pyc") => {
                format!("; there is `{name}`, which is compiled: hand in the source, {file}")
            }
            Some(name) => format!("; there is `{name}`: rename it"),
            None if let Some(place) = elsewhere(root, &[file], None) => {
                format!("; there is one in `{}`: put all files into one folder", place.display())
            }
            None if file == "secret_id.py" => {
                "; it defines secret_id(), which returns the name for the leaderboard, 4 to 32 \
                 printable characters with no space at an end"
                    .to_owned()
            }
            None => format!("; it defines {stem}(Il, Ir, bbox, maxd)"),
        };
        let text = format!("the file is missing{instead}");
        let fatal = file != "secret_id.py";
        findings.push(Finding { fatal, ..Finding::about(file, text) });
    }
    findings
}
