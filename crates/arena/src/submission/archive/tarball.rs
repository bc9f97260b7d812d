//! Tar archives, plain or compressed by gzip.

use std::io::{self, BufReader, Read};

use flate2::read::MultiGzDecoder;
use tar::EntryType;

use super::{Kind, OnDisk, Unpacking};
use crate::submission::budget::{Bounded, Budget};
use crate::submission::error::SubmissionError;

/// Whether this first block of 512 bytes is a tar header, whose checksum fits, or the end of an
/// archive without entries, which is all zero.
pub(super) fn is_one(block: &[u8]) -> bool {
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

/// Unpacks one that is compressed by gzip.
pub(super) fn unpack_compressed(
    file: OnDisk<'_>,
    unpacking: &Unpacking<'_>,
) -> Result<(), SubmissionError> {
    unpack(MultiGzDecoder::new(BufReader::new(file)), unpacking)
}

/// Unpacks a plain one.
pub(super) fn unpack(reader: impl Read, unpacking: &Unpacking<'_>) -> Result<(), SubmissionError> {
    let budget = Budget::new();
    let mut archive = tar::Archive::new(Bounded::new(BufReader::new(reader), &budget));
    let unreadable = |error: io::Error| match budget.excess() {
        Some(problem) => unpacking.intake.too_large(problem),
        None => unpacking.unreadable(error),
    };
    let mut entries = archive.entries().map_err(unreadable)?;
    for count in 1.. {
        budget.begin_headers();
        let Some(entry) = entries.next() else { break };
        let mut entry = entry.map_err(unreadable)?;
        budget.begin_content();
        unpacking.check_count(count)?;
        let name = entry.path().map_err(unreadable)?.into_owned();
        let kind = match entry.header().entry_type() {
            // As tar marked them before there was a type for them.
            EntryType::Regular if entry.path_bytes().ends_with(b"/") => Kind::Folder,
            EntryType::Directory | EntryType::XGlobalHeader => Kind::Folder,
            EntryType::Symlink | EntryType::Link => Kind::Link,
            EntryType::Regular | EntryType::Continuous => Kind::File,
            _ => Kind::Special,
        };
        match unpacking.target(&name, kind)? {
            Some(target) => unpacking.intake.take(entry, &target, &unreadable)?,
            // Read here, not by the library on its way to the next headers.
            None => {
                io::copy(&mut entry, &mut io::sink()).map_err(unreadable)?;
            }
        }
    }
    Ok(())
}
