//! Names and sizes: what is copied, what is refused, which files are missing.

use std::cell::Cell;
use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::error::SubmissionError;
use super::finding::Finding;
use crate::hexadecimal;

/// What a submission may hold.
const MAX_FILES: usize = 1000;
/// What a submission may hold, in bytes.
const MAX_BYTES: u64 = 64 << 20;

/// Bytes of a name, as file systems have it.
const LONGEST_NAME: usize = 255;

/// Bytes of a name with its folders: a quarter of what Linux takes, whose paths begin elsewhere.
const LONGEST_PATH: usize = 1024;

/// Characters of an entry's name that messages show.
const LONGEST_SHOWN: usize = 120;

/// The files of the course's assignment.
const FILES: [&str; 3] = ["secret_id.py", "stereo_disparity_fast.py", "stereo_disparity_best.py"];

/// Counts what is taken against what a submission may hold.
pub(super) struct Intake<'a> {
    submission: &'a Path,
    files: Cell<usize>,
    bytes: Cell<u64>,
}

impl<'a> Intake<'a> {
    pub fn new(submission: &'a Path) -> Self {
        Self { submission, files: Cell::new(0), bytes: Cell::new(0) }
    }

    pub fn refuse(&self, entry: &Path, problem: impl Into<String>) -> SubmissionError {
        SubmissionError::Entry {
            path: self.submission.to_owned(),
            entry: shortened(&entry.display().to_string()),
            problem: problem.into(),
        }
    }

    /// Errors when a path is longer than what the grader can write.
    pub fn check_length(&self, name: &Path) -> Result<(), SubmissionError> {
        let longest = name.components().map(|part| part.as_os_str().len()).max().unwrap_or(0);
        if name.as_os_str().len() <= LONGEST_PATH && longest <= LONGEST_NAME {
            return Ok(());
        }
        Err(self.refuse(
            name,
            format!(
                "has too long a name: at most {LONGEST_NAME} bytes each, {LONGEST_PATH} with all \
                 folders; rename it"
            ),
        ))
    }

    /// Takes one file: copies `reader`, whatever size was claimed for it, to `target`. `unreadable`
    /// tells what it means when `reader` fails.
    pub fn take(
        &self,
        mut reader: impl Read,
        target: &Path,
        unreadable: &dyn Fn(io::Error) -> SubmissionError,
    ) -> Result<(), SubmissionError> {
        self.files.set(self.files.get() + 1);
        if self.files.get() > MAX_FILES {
            return Err(self.too_large(format!(
                "it holds more than {MAX_FILES} files; hand in the Python files alone"
            )));
        }
        let failed = |source| SubmissionError::Write { path: target.to_owned(), source };
        if let Some(folder) = target.parent() {
            fs::create_dir_all(folder).map_err(failed)?;
        }
        let mut file = fs::File::create(target).map_err(failed)?;
        let left = MAX_BYTES - self.bytes.get();
        let copied = copy(reader.by_ref().take(left + 1), &mut file, unreadable, &failed)?;
        self.bytes.set(self.bytes.get() + copied);
        self.check_size(self.bytes.get())
    }

    /// Errors when so many bytes are more than a submission may hold.
    pub fn check_size(&self, bytes: u64) -> Result<(), SubmissionError> {
        if bytes <= MAX_BYTES {
            return Ok(());
        }
        Err(self.too_large(format!(
            "it holds more than {} MiB; hand in the Python files alone",
            MAX_BYTES >> 20
        )))
    }

    pub fn too_large(&self, problem: String) -> SubmissionError {
        SubmissionError::TooLarge { path: self.submission.to_owned(), problem }
    }
}

/// As [`io::copy`], but it tells reading from writing: the one may be the entrant's fault, the other
/// never is.
fn copy(
    mut reader: impl Read,
    writer: &mut impl Write,
    unreadable: &dyn Fn(io::Error) -> SubmissionError,
    unwritable: &dyn Fn(io::Error) -> SubmissionError,
) -> Result<u64, SubmissionError> {
    let mut buffer = vec![0; 64 << 10];
    let mut copied = 0;
    loop {
        let read = match reader.read(&mut buffer) {
            Ok(0) => return Ok(copied),
            Ok(read) => read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(unreadable(error)),
        };
        writer.write_all(&buffer[..read]).map_err(unwritable)?;
        copied += read as u64;
    }
}

/// A name for messages: what a hostile one of many kilobytes would bury stays readable.
fn shortened(name: &str) -> String {
    let count = name.chars().count();
    if count <= LONGEST_SHOWN {
        return name.to_owned();
    }
    let end = LONGEST_SHOWN / 3;
    let (first, last) = (name.chars().take(LONGEST_SHOWN - end), name.chars().skip(count - end));
    first.chain(['…']).chain(last).collect()
}

/// Whether an entry is left out without a word: caches, version control, what editors and
/// operating systems leave behind.
pub(super) fn is_clutter(name: &str) -> bool {
    name.starts_with('.') || name == "__pycache__" || name == "__MACOSX"
}

/// Copies a folder; links and special files are refused.
pub(super) fn copy_folder(from: &Path, to: &Path) -> Result<(), SubmissionError> {
    let intake = Intake::new(from);
    let mut folders = vec![PathBuf::new()];
    while let Some(folder) = folders.pop() {
        let full = from.join(&folder);
        let failed = |source| SubmissionError::Read { path: full.clone(), source };
        for entry in fs::read_dir(&full).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            let relative = folder.join(entry.file_name());
            if is_clutter(&entry.file_name().to_string_lossy()) {
                continue;
            }
            intake.check_length(&relative)?;
            let kind = entry.file_type().map_err(failed)?;
            if kind.is_dir() {
                folders.push(relative);
            } else if kind.is_symlink() {
                let problem = "is a link: hand in the file itself";
                return Err(intake.refuse(&relative, problem));
            } else if kind.is_file() {
                let path = entry.path();
                let unreadable = |source| SubmissionError::Read { path: path.clone(), source };
                let file = fs::File::open(&path).map_err(unreadable)?;
                intake.take(file, &to.join(relative), &unreadable)?;
            } else {
                return Err(intake.refuse(&relative, "is no ordinary file: remove it"));
            }
        }
    }
    Ok(())
}

/// The SHA-256 of all files below a folder, with their names.
pub(super) fn digest(root: &Path) -> io::Result<String> {
    let mut hash = Sha256::new();
    let mut left = vec![root.to_owned()];
    while let Some(path) = left.pop() {
        let name = path.strip_prefix(root).unwrap_or(&path).as_os_str().as_encoded_bytes();
        let content = if path.is_dir() {
            let entries = fs::read_dir(&path)?.map(|entry| Ok(entry?.path()));
            let mut entries = entries.collect::<io::Result<Vec<PathBuf>>>()?;
            entries.sort();
            left.extend(entries);
            Vec::new()
        } else {
            fs::read(&path)?
        };
        for part in [name, &content] {
            hash.update((part.len() as u64).to_le_bytes());
            hash.update(part);
        }
    }
    Ok(hexadecimal(&hash.finalize()))
}

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
    let mut found = Vec::new();
    let mut folders = vec![staging.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path == root {
                continue;
            } else if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "py") {
                let name = path.strip_prefix(staging).unwrap_or(&path);
                found.push(shortened(&name.display().to_string()));
            }
        }
    }
    found.sort();
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

/// Bytes of files that together hold more than a few pages of text or a few numbers, and of sources that nobody wrote by
/// hand.
const LARGE: u64 = 20_000;
const LARGE_SOURCE: u64 = 200_000;
/// Files that [`besides_its_source`] names.
const SHOWN: usize = 5;

/// A finding for what may do more than the source tells: compiled code, which could be somebody else's matcher, and data,
/// which could be the truth.
pub(super) fn besides_its_source(root: &Path) -> Option<Finding> {
    let (mut sources, mut others, mut any_compiled) = (Vec::new(), Vec::new(), false);
    let mut left = vec![root.to_owned()];
    while let Some(path) = left.pop() {
        if path.is_dir() {
            left.extend(fs::read_dir(&path).into_iter().flatten().flatten().map(|e| e.path()));
            continue;
        }
        let bytes = path.metadata().map_or(0, |found| found.len());
        let name = shortened(&path.strip_prefix(root).unwrap_or(&path).display().to_string());
        let is_compiled = is_compiled(&path);
        any_compiled |= is_compiled;
        let kind = if is_compiled { " of compiled code" } else { "" };
        let is_source = !is_compiled && path.extension().is_some_and(|end| end == "py");
        (if is_source { &mut sources } else { &mut others }).push((bytes, name, kind));
    }
    let sum = |files: &[(u64, String, &str)]| files.iter().map(|(bytes, ..)| bytes).sum::<u64>();
    if sum(&sources) < LARGE_SOURCE {
        sources.clear();
    }
    if !any_compiled && sum(&others) < LARGE {
        others.clear();
    }
    let mut found = [sources, others].concat();
    // The largest first; of the same size by name, since folders are listed in any order.
    found.sort_by(|a, b| b.0.cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
    let file = found.first()?.1.clone();
    let told: Vec<String> = (found.iter().take(SHOWN))
        .map(|(bytes, name, kind)| format!("{name} ({} KB{kind})", bytes.div_ceil(1000)))
        .collect();
    let more = match found.len().saturating_sub(SHOWN) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let text = format!(
        "much comes with it that nobody reads: {}{more}; whoever grades may ask what for",
        told.join(", ")
    );
    Some(Finding { doubtful: true, ..Finding::about(file, text) })
}

/// Whether a file begins as programs and libraries do on Linux, Windows or macOS, or is called as Python's byte code is.
fn is_compiled(path: &Path) -> bool {
    const BEGINNINGS: [&[u8]; 5] =
        [b"\x7fELF", b"\xca\xfe\xba\xbe", b"\xcf\xfa\xed\xfe", b"\xce\xfa\xed\xfe", b"!<arch>\n"];
    let mut beginning = Vec::new();
    let read = fs::File::open(path).and_then(|file| file.take(64).read_to_end(&mut beginning));
    let ends_in =
        |ends: &[&str]| path.extension().is_some_and(|end| ends.iter().any(|e| end == *e));
    // A text may begin with the letters of Windows.
    let is_of_windows = beginning.starts_with(b"MZ") && beginning.contains(&0);
    ends_in(&["pyc", "pyd", "so", "dll", "dylib"])
        || read.is_ok() && (is_of_windows || BEGINNINGS.iter().any(|b| beginning.starts_with(b)))
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
