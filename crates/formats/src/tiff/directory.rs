//! A look at a TIFF's directories before the decoder sees them: every list that the first one names must
//! lie within the file, since the decoder takes memory for a list on the word of its entry; and there must
//! be no second picture, of which the decoder would say nothing.

use std::collections::HashSet;

use crate::FormatError;
use crate::source::{Container, Source};

/// The tag that says what a directory's picture is to the others, and its bits for a smaller copy and for a mask.
const SUBFILE: u64 = 254;
const COPY_OR_MASK: u64 = 0b101;

/// Errors when the first directory, or a list of values that one of its entries names, is not
/// within the file, or another directory has a picture of its own. (TIFF 6.0, section 2, and BigTIFF,
/// whose numbers are wider.)
pub(super) fn check(source: &Source) -> Result<(), FormatError> {
    let bytes = &source.bytes;
    let reader = Reader { bytes, big_endian: bytes.starts_with(b"MM") };
    let header = || cut(source, "the header");
    let wide = reader.number(2, 2).ok_or_else(header)? == 43;
    // Where the first directory's offset stands, and the sizes of counts, entries and offsets.
    let (at, sizes) = if wide { (8, [8, 20, 8]) } else { (4, [2, 12, 4]) };
    let [.., offset_size] = sizes;
    let first = reader.number(at, offset_size).ok_or_else(header)?;
    let directory = Directory::at(source, reader, first, sizes)?;
    for entry in directory.entries() {
        let tag = entry.tag;
        let list = || cut(source, &format!("the list of tag {tag} ({} values)", entry.values));
        let length = entry.values.checked_mul(value_size(entry.kind)).ok_or_else(list)?;
        if length > offset_size {
            let place = directory.reader.number(entry.value_at, offset_size).ok_or_else(list)?;
            if !directory.reader.holds(place, length) {
                return Err(list());
            }
        }
    }
    one_picture(source, &directory, first, sizes)
}

/// Errors when a directory after the first one has a picture that is no smaller copy of it and no mask.
fn one_picture(
    source: &Source,
    first: &Directory<'_>,
    start: u64,
    sizes: [u64; 3],
) -> Result<(), FormatError> {
    let mut seen = HashSet::from([start]);
    let mut next = first.next();
    // Where there is none is 0; a directory that comes again has been looked at.
    while next != 0 && seen.insert(next) {
        let directory = Directory::at(source, first.reader, next, sizes)?;
        let mut entries = directory.entries();
        let kind = entries.find(|entry| entry.tag == SUBFILE);
        let kind =
            kind.and_then(|entry| directory.reader.number(entry.value_at, value_size(entry.kind)));
        if kind.unwrap_or(0) & COPY_OR_MASK == 0 {
            return Err(source.wrong_kind(
                "a TIFF of several pictures",
                "one picture in a file is needed: split it, as with `tiffsplit`",
            ));
        }
        next = directory.next();
    }
    Ok(())
}

fn cut(source: &Source, what: &str) -> FormatError {
    let problem = format!("{what} lies outside the file: was it copied whole?");
    source.malformed(Container::Tiff, source.bytes.len() as u64, problem)
}

/// A list of entries that lies within the file.
struct Directory<'a> {
    reader: Reader<'a>,
    /// Where its entries begin and end.
    begin: u64,
    end: u64,
    entry_size: u64,
    offset_size: u64,
}

/// One of them.
struct Entry {
    tag: u64,
    kind: u64,
    values: u64,
    /// Where its value stands, or what is said of the place of its list.
    value_at: u64,
}

impl<'a> Directory<'a> {
    fn at(
        source: &Source,
        reader: Reader<'a>,
        start: u64,
        [count_size, entry_size, offset_size]: [u64; 3],
    ) -> Result<Self, FormatError> {
        let outside = || cut(source, &format!("the directory at byte {start}"));
        let count = reader.number(start, count_size).ok_or_else(outside)?;
        let length = count.checked_mul(entry_size).ok_or_else(outside)?;
        let begin = start + count_size;
        if !reader.holds(begin, length) {
            return Err(outside());
        }
        Ok(Self { reader, begin, end: begin + length, entry_size, offset_size })
    }

    fn entries(&self) -> impl Iterator<Item = Entry> {
        let number = |at, size| self.reader.number(at, size).unwrap_or(0);
        (self.begin..self.end).step_by(self.entry_size as usize).map(move |at| Entry {
            tag: number(at, 2),
            kind: number(at + 2, 2),
            values: number(at + 4, self.offset_size),
            value_at: at + 4 + self.offset_size,
        })
    }

    /// Where the next directory begins: 0 where there is none, or the file ends.
    fn next(&self) -> u64 {
        self.reader.number(self.end, self.offset_size).unwrap_or(0)
    }
}

/// Bytes of a value by its type; the decoder skips types that it does not know.
fn value_size(kind: u64) -> u64 {
    match kind {
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16..=18 => 8,
        _ => 1,
    }
}

#[derive(Clone, Copy)]
struct Reader<'a> {
    bytes: &'a [u8],
    big_endian: bool,
}

impl Reader<'_> {
    fn holds(&self, at: u64, length: u64) -> bool {
        at.checked_add(length).is_some_and(|end| end <= self.bytes.len() as u64)
    }

    /// The whole number of up to 8 bytes at a place, or `None` outside the file.
    fn number(&self, at: u64, size: u64) -> Option<u64> {
        if !self.holds(at, size) {
            return None;
        }
        let bytes = &self.bytes[at as usize..][..size as usize];
        let append = |number, &byte: &u8| number << 8 | u64::from(byte);
        Some(match self.big_endian {
            true => bytes.iter().fold(0, append),
            false => bytes.iter().rev().fold(0, append),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A directory at byte 8 with one entry: tag 273, type 4 (32 bit), so many values at a place.
    fn file(big_endian: bool, values: u32, place: u32) -> Vec<u8> {
        let four = |n: u32| if big_endian { n.to_be_bytes() } else { n.to_le_bytes() };
        let two = |n: u16| if big_endian { n.to_be_bytes() } else { n.to_le_bytes() };
        let mut bytes = if big_endian { b"MM".to_vec() } else { b"II".to_vec() };
        bytes.extend(two(42));
        bytes.extend(four(8));
        bytes.extend([two(1), two(273), two(4)].concat());
        bytes.extend([four(values), four(place), four(0)].concat());
        bytes
    }

    fn checked(bytes: &[u8]) -> Result<(), String> {
        check(&Source::of("a.tif", bytes)).map_err(|e| e.to_string())
    }

    #[test]
    fn lists_must_lie_within_the_file() {
        for big_endian in [false, true] {
            assert_eq!(checked(&file(big_endian, 1, u32::MAX)), Ok(()), "the value itself");
            assert_eq!(checked(&file(big_endian, 2, 18)), Ok(()));
            for (values, place) in [(2, 19), (3, 18), (u32::MAX, 0), (2, u32::MAX)] {
                let error = checked(&file(big_endian, values, place)).unwrap_err();
                assert!(error.contains("the list of tag 273"), "{error}");
            }
        }
    }

    #[test]
    fn a_second_picture_is_refused_but_a_smaller_copy_or_a_mask_is_none() {
        for (kind, refused) in [(0, true), (2, true), (1, false), (4, false), (5, false)] {
            let mut bytes = file(false, 1, 0);
            // The next directory begins where this one ends: tag 254, type 4.
            bytes[22..26].copy_from_slice(&26_u32.to_le_bytes());
            bytes.extend([1, 0, 254, 0, 4, 0, 1, 0, 0, 0, kind, 0, 0, 0, 0, 0, 0, 0]);
            let found = checked(&bytes);
            assert_eq!(found.is_err(), refused, "{kind}");
            assert!(found.err().is_none_or(|error| error.contains("several pictures")));
            // After itself.
            bytes[40..44].copy_from_slice(&26_u32.to_le_bytes());
            assert_eq!(checked(&bytes).is_err(), refused, "{kind}");
            bytes[22..26].copy_from_slice(&4000_u32.to_le_bytes());
            let error = checked(&bytes).unwrap_err();
            assert!(error.contains("the directory at byte 4000"), "{error}");
        }
    }

    #[test]
    fn the_directory_must_lie_within_the_file() {
        let whole = file(false, 1, 0);
        for length in 4..22 {
            assert!(checked(&whole[..length]).is_err(), "{length}");
        }
        assert!(checked(b"II\x2b\0\x08\0\0\0\xff\xff\xff\xff\xff\xff\xff\xff").is_err());
    }
}
