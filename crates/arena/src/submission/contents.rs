//! Names and sizes: what is copied, and what is refused.

use std::cell::Cell;
use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::error::SubmissionError;
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
pub(super) fn shortened(name: &str) -> String {
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

/// All files below a folder but those of one that is left out, in order.
pub(super) fn files_below(root: &Path, left_out: Option<&Path>) -> Vec<PathBuf> {
    let (mut files, mut folders) = (Vec::new(), vec![root.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if left_out == Some(&path) {
                continue;
            }
            (if path.is_dir() { &mut folders } else { &mut files }).push(path);
        }
    }
    files.sort();
    files
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
