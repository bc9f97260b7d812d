//! Zip archives, as learning platforms and file managers make them.
//!
//! Their index stands at the end, so entries are not read in the order in which they lie, and what is left
//! out is not read at all.

use std::io::{self, BufReader, Seek, SeekFrom};
use std::path::PathBuf;

use zip::result::ZipError;
use zip::{CompressionMethod, ZipArchive};

use super::{Kind, OnDisk, Unpacking};
use crate::submission::error::SubmissionError;

/// The bits of a mode that say what kind of file it is, and what they are for ordinary files.
const KIND: u32 = 0o170_000;
const ORDINARY: u32 = 0o100_000;

/// Unpacks one.
pub(super) fn unpack(file: OnDisk<'_>, unpacking: &Unpacking<'_>) -> Result<(), SubmissionError> {
    let unreadable = |error: ZipError| match error {
        ZipError::Io(error) => unpacking.unreadable(error),
        other => unpacking.unreadable(io::Error::other(other)),
    };
    let mut file = BufReader::new(file);
    // The whole index is kept in memory, so it must not be longer than what all files may take.
    let size = file.seek(SeekFrom::End(0)).map_err(|error| unpacking.unreadable(error))?;
    unpacking.intake.check_size(size)?;
    let mut archive = ZipArchive::new(file).map_err(unreadable)?;
    unpacking.check_count(archive.len())?;
    for index in 0..archive.len() {
        // Raw: whether it can be decompressed is asked last.
        let entry = archive.by_index_raw(index).map_err(unreadable)?;
        // Some programs of Windows part folders by what is no separator elsewhere.
        let name = entry.name().map_err(unreadable)?.replace('\\', "/");
        let is_folder = name.ends_with('/');
        let name = PathBuf::from(name);
        let kind = match entry.unix_mode().map(|mode| mode & KIND) {
            _ if is_folder => Kind::Folder,
            _ if entry.is_symlink() => Kind::Link,
            None | Some(0 | ORDINARY) => Kind::File,
            Some(_) => Kind::Special,
        };
        let Some(target) = unpacking.target(&name, kind)? else { continue };
        let refuse = |problem| Err(unpacking.intake.refuse(&name, problem));
        if entry.encrypted() {
            return refuse("is encrypted: pack it without a password");
        }
        if !matches!(entry.compression(), CompressionMethod::Stored | CompressionMethod::Deflated) {
            return refuse(
                "is compressed in a rare way: pack it again as an ordinary zip (deflate)",
            );
        }
        drop(entry);
        let content = archive.by_index(index).map_err(unreadable)?;
        unpacking.intake.take(content, &target, &|error| unpacking.unreadable(error))?;
    }
    Ok(())
}
