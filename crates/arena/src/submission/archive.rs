//! Tar archives, plain or compressed by gzip, unpacked without trusting a single entry.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::{Component, Path, PathBuf};

use flate2::read::MultiGzDecoder;
use tar::EntryType;

use super::budget::{Bounded, Budget};
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
    let disk_failed = Cell::new(false);
    let file = BufReader::new(OnDisk { file, failed: &disk_failed });
    let reader: Box<dyn Read> = match first[..] {
        [0x1f, 0x8b, ..] => Box::new(MultiGzDecoder::new(file)),
        _ if is_tar(&first) => Box::new(file),
        _ => {
            let found = describe(&first);
            return Err(SubmissionError::WrongKind { path: path.to_owned(), found });
        }
    };
    let budget = Budget::new();
    let unreadable = |error: io::Error| match budget.excess() {
        Some(problem) => SubmissionError::TooLarge { path: path.to_owned(), problem },
        None if disk_failed.get() => failed(error),
        None => SubmissionError::Damaged { path: path.to_owned(), problem: error.to_string() },
    };
    let mut intake = Intake::new(path);
    let mut archive = tar::Archive::new(Bounded::new(reader, &budget));
    let mut entries = archive.entries().map_err(unreadable)?;
    for count in 1.. {
        budget.begin_headers();
        let Some(entry) = entries.next() else { break };
        let mut entry = entry.map_err(unreadable)?;
        budget.begin_content();
        if count > MAX_ENTRIES {
            return Err(SubmissionError::TooLarge {
                path: path.to_owned(),
                problem: format!(
                    "it holds more than {MAX_ENTRIES} entries; hand in the Python files alone"
                ),
            });
        }
        let name = entry.path().map_err(unreadable)?.into_owned();
        let relative = checked(&intake, &name)?;
        let is_file = match entry.header().entry_type() {
            EntryType::Directory | EntryType::XGlobalHeader => false,
            EntryType::Symlink | EntryType::Link => {
                return Err(intake.refuse(&name, "is a link: pack the file itself (tar -h)"));
            }
            EntryType::Regular | EntryType::Continuous => true,
            _ => return Err(intake.refuse(&name, "is no ordinary file: remove it")),
        };
        let clutter = |part: Component<'_>| is_clutter(&part.as_os_str().to_string_lossy());
        if !is_file || relative.components().any(clutter) {
            // Read here, not by the library on its way to the next headers.
            io::copy(&mut entry, &mut io::sink()).map_err(unreadable)?;
            continue;
        }
        let target = staging.join(&relative);
        let is_below_a_file = relative.ancestors().skip(1).any(|a| staging.join(a).is_file());
        if relative.as_os_str().is_empty() || target.is_dir() || is_below_a_file {
            return Err(intake.refuse(&name, "is a file and a folder at once: pack it again"));
        }
        intake.take(entry, &target, &unreadable)?;
    }
    Ok(())
}

/// The file of an archive. It remembers when the system fails to read it: then the archive is not
/// damaged, whatever the layers above make of the error.
struct OnDisk<'a> {
    file: File,
    failed: &'a Cell<bool>,
}

impl Read for OnDisk<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read(buffer);
        let interrupted = |error: &io::Error| error.kind() == io::ErrorKind::Interrupted;
        self.failed.set(read.as_ref().is_err_and(|error| !interrupted(error)));
        read
    }
}

/// The entry's path below the folder that it is unpacked into.
fn checked(intake: &Intake<'_>, name: &Path) -> Result<PathBuf, SubmissionError> {
    let mut relative = PathBuf::new();
    intake.check_length(name)?;
    if name.as_os_str().as_encoded_bytes().contains(&0) {
        return Err(intake.refuse(name, "has a name with a NUL byte in it: rename it"));
    }
    for part in name.components() {
        match part {
            Component::Normal(part) => relative.push(part),
            Component::CurDir => {}
            Component::ParentDir => {
                return Err(intake.refuse(name, "leads out of the archive by `..`: pack it again"));
            }
            Component::RootDir | Component::Prefix(_) => {
                return Err(intake.refuse(
                    name,
                    "is an absolute path: pack it from within the folder (tar -C FOLDER -cf ...)",
                ));
            }
        }
    }
    Ok(relative)
}

/// Whether this first block of 512 bytes is a tar header, whose checksum fits, or the end of an
/// archive without entries, which is all zero.
fn is_tar(block: &[u8]) -> bool {
    match <&[u8; 512]>::try_from(block) {
        Ok(block) => {
            let header = tar::Header::from_byte_slice(block);
            let sum: u32 = block
                .iter()
                .enumerate()
                // The checksum itself counts as blanks.
                .map(|(at, &byte)| u32::from(if (148..156).contains(&at) { b' ' } else { byte }))
                .sum();
            block.iter().all(|&byte| byte == 0)
                || header.cksum().is_ok_and(|claimed| claimed == sum)
        }
        Err(_) => false,
    }
}

/// What a file that is no tar archive looks like.
fn describe(first: &[u8]) -> &'static str {
    match first {
        [] => "an empty file",
        [b'P', b'K', 3 | 5, ..] => "a zip archive",
        [b'R', b'a', b'r', b'!', ..] => "a rar archive",
        [b'7', b'z', 0xbc, 0xaf, ..] => "a 7z archive",
        [b'B', b'Z', b'h', ..] => "compressed by bzip2",
        [0xfd, b'7', b'z', b'X', b'Z', ..] => "compressed by xz",
        [0x28, 0xb5, 0x2f, 0xfd, ..] => "compressed by zstd",
        _ if std::str::from_utf8(first).is_ok() => "a single text file",
        _ => "no tar archive",
    }
}
