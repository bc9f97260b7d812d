//! A look at a TIFF's first directory before the decoder sees it: every list that it names must lie
//! within the file. The decoder takes memory for a list on the word of its entry.

use crate::FormatError;
use crate::source::{Container, Source};

/// Errors when the first directory, or a list of values that one of its entries names, is not
/// within the file. (TIFF 6.0, section 2, and BigTIFF, whose numbers are wider.)
pub(super) fn check(source: &Source) -> Result<(), FormatError> {
    let bytes = &source.bytes;
    let reader = Reader { bytes, big_endian: bytes.starts_with(b"MM") };
    let cut = |what: String| {
        let problem = format!("{what} lies outside the file: was it copied whole?");
        source.malformed(Container::Tiff, bytes.len() as u64, problem)
    };
    let header = || cut("the header".to_owned());
    let wide = reader.number(2, 2).ok_or_else(header)? == 43;
    // Where the first directory's offset stands, and the sizes of counts, entries and offsets.
    let (at, count_size, entry_size, offset_size) =
        if wide { (8, 8, 20, 8) } else { (4, 2, 12, 4) };
    let start = reader.number(at, offset_size).ok_or_else(header)?;
    let directory = || cut(format!("the directory at byte {start}"));
    let count = reader.number(start, count_size).ok_or_else(directory)?;
    let entries = start + count_size;
    let length = count.checked_mul(entry_size).ok_or_else(directory)?;
    if !reader.holds(entries, length) {
        return Err(directory());
    }
    for entry in (entries..entries + length).step_by(entry_size as usize) {
        let tag = reader.number(entry, 2).ok_or_else(directory)?;
        let kind = reader.number(entry + 2, 2).ok_or_else(directory)?;
        let values = reader.number(entry + 4, offset_size).ok_or_else(directory)?;
        let list = || cut(format!("the list of tag {tag} ({values} values)"));
        let length = values.checked_mul(value_size(kind)).ok_or_else(list)?;
        if length > offset_size {
            let place = reader.number(entry + 4 + offset_size, offset_size).ok_or_else(list)?;
            if !reader.holds(place, length) {
                return Err(list());
            }
        }
    }
    Ok(())
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
    fn the_directory_must_lie_within_the_file() {
        let whole = file(false, 1, 0);
        for length in 4..22 {
            assert!(checked(&whole[..length]).is_err(), "{length}");
        }
        assert!(checked(b"II\x2b\0\x08\0\0\0\xff\xff\xff\xff\xff\xff\xff\xff").is_err());
    }
}
