//! Archives, unpacked without trusting a single entry.

mod tarball;
mod zipped;

use std::cell::Cell;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Component, Path, PathBuf};

use super::contents::{Intake, is_clutter};
use super::error::SubmissionError;

/// Entries of an archive, folders and what is left out among them.
const MAX_ENTRIES: usize = 10_000;

/// Unpacks the archive at `path` into the empty folder `staging`.
pub(super) fn unpack(path: &Path, staging: &Path) -> Result<(), SubmissionError> {
    let failed = |source| SubmissionError::Read { path: path.to_owned(), source };
    let mut file = File::open(path).map_err(failed)?;
    let mut first = Vec::new();
    file.by_ref().take(512).read_to_end(&mut first).map_err(failed)?;
    file.rewind().map_err(failed)?;
    let disk = Disk::default();
    let file = OnDisk { file, disk: &disk };
    let unpacking = Unpacking { path, staging, disk: &disk, intake: Intake::new(path) };
    match first[..] {
        [0x1f, 0x8b, ..] => tarball::unpack_compressed(file, &unpacking),
        // Of an entry, of an archive without any, of one that was split.
        [b'P', b'K', 3, 4, ..]
        | [b'P', b'K', 5, 6, ..]
        | [b'P', b'K', 7, 8, ..]
        | [b'P', b'K', b'0', b'0', ..] => zipped::unpack(file, &unpacking),
        _ if tarball::is_one(&first) => tarball::unpack(file, &unpacking),
        _ => {
            let found = describe(&first);
            Err(SubmissionError::WrongKind { path: path.to_owned(), found })
        }
    }
}

/// Whether the system failed to read an archive: then it is not damaged, whatever the layers above make of
/// the error.
#[derive(Default)]
struct Disk {
    failed: Cell<bool>,
}

impl Disk {
    fn note<T>(&self, result: io::Result<T>) -> io::Result<T> {
        let interrupted = |error: &io::Error| error.kind() == io::ErrorKind::Interrupted;
        self.failed.set(result.as_ref().is_err_and(|error| !interrupted(error)));
        result
    }
}

/// The file of an archive.
struct OnDisk<'a> {
    file: File,
    disk: &'a Disk,
}

impl Read for OnDisk<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.disk.note(self.file.read(buffer))
    }
}

impl Seek for OnDisk<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        // To where no file has a place is what an archive asked for, not the disk's failure.
        self.file.seek(to)
    }
}

/// What an entry is, beside its name.
enum Kind {
    Folder,
    File,
    Link,
    Special,
}

/// An archive on its way into a folder.
struct Unpacking<'a> {
    path: &'a Path,
    staging: &'a Path,
    disk: &'a Disk,
    intake: Intake<'a>,
}

impl Unpacking<'_> {
    /// What it means that the archive cannot be read.
    fn unreadable(&self, error: io::Error) -> SubmissionError {
        let path = self.path.to_owned();
        match self.disk.failed.get() {
            true => SubmissionError::Read { path, source: error },
            false => SubmissionError::Damaged { path, problem: error.to_string() },
        }
    }

    /// Errors where there are more entries than anybody needs.
    fn check_count(&self, entries: usize) -> Result<(), SubmissionError> {
        if entries <= MAX_ENTRIES {
            return Ok(());
        }
        let problem =
            format!("it holds more than {MAX_ENTRIES} entries; hand in the Python files alone");
        Err(self.intake.too_large(problem))
    }

    /// Where an entry is to be written; nowhere if it is a folder or left out.
    fn target(&self, name: &Path, kind: Kind) -> Result<Option<PathBuf>, SubmissionError> {
        let relative = self.checked(name)?;
        match kind {
            Kind::Folder => return Ok(None),
            Kind::File => {}
            Kind::Link => {
                let problem = "is a link: pack the file itself (tar -h --hard-dereference, or zip without -y)";
                return Err(self.intake.refuse(name, problem));
            }
            Kind::Special => {
                return Err(self.intake.refuse(name, "is no ordinary file: remove it"));
            }
        }
        let clutter = |part: Component<'_>| is_clutter(&part.as_os_str().to_string_lossy());
        if relative.components().any(clutter) {
            return Ok(None);
        }
        let target = self.staging.join(&relative);
        let is_below_a_file = relative.ancestors().skip(1).any(|a| self.staging.join(a).is_file());
        if relative.as_os_str().is_empty() || target.is_dir() || is_below_a_file {
            let problem = "is a file and a folder at once: pack it again";
            return Err(self.intake.refuse(name, problem));
        }
        Ok(Some(target))
    }

    /// The entry's path below the folder that it is unpacked into.
    fn checked(&self, name: &Path) -> Result<PathBuf, SubmissionError> {
        let refuse = |problem| Err(self.intake.refuse(name, problem));
        let mut relative = PathBuf::new();
        self.intake.check_length(name)?;
        if name.as_os_str().as_encoded_bytes().contains(&0) {
            return refuse("has a name with a NUL byte in it: rename it");
        }
        for part in name.components() {
            match part {
                Component::Normal(part) => relative.push(part),
                Component::CurDir => {}
                Component::ParentDir => {
                    return refuse("leads out of the archive by `..`: pack it again");
                }
                Component::RootDir | Component::Prefix(_) => {
                    return refuse("is an absolute path: pack it from within the folder");
                }
            }
        }
        Ok(relative)
    }
}

/// What a file that is no archive looks like.
fn describe(first: &[u8]) -> &'static str {
    match first {
        [] => "an empty file",
        [b'R', b'a', b'r', b'!', ..] => "a rar archive",
        [b'7', b'z', 0xbc, 0xaf, ..] => "a 7z archive",
        [b'B', b'Z', b'h', ..] => "compressed by bzip2",
        [0xfd, b'7', b'z', b'X', b'Z', ..] => "compressed by xz",
        [0x28, 0xb5, 0x2f, 0xfd, ..] => "compressed by zstd",
        _ if std::str::from_utf8(first).is_ok() => "a single text file",
        _ => "no archive",
    }
}
