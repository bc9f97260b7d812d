//! A file's bytes with its path, and what its first bytes say it is.
//!
//! Files are read whole before they are decoded: every decoder then works on a slice, so that a
//! claimed size can be held against the bytes that are really there before memory is taken for it.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use crate::FormatError;

/// The most pixels that are read from one file: 2^28, for example 16384 x 16384.
pub const MAX_PIXELS: u64 = 1 << 28;

/// The most bytes that are read from one file: those of [`MAX_PIXELS`] of eight bytes each, and a header.
pub const MAX_FILE_BYTES: u64 = 8 * MAX_PIXELS + (1 << 20);

/// So many bytes tell what a file is.
const BEGINNING: u64 = 512;

/// Calibrations are short; a text that is longer is something else.
pub(crate) const LONGEST_TEXT: u64 = 1 << 20;

/// What a file is, by its first bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Container {
    /// Portable Network Graphics.
    Png,
    /// Netpbm grey or colour, P2, P3, P5 or P6.
    Pnm,
    /// JPEG.
    Jpeg,
    /// TIFF or BigTIFF.
    Tiff,
    /// Portable float map, grey (`Pf`) or colour (`PF`).
    Pfm,
    /// NumPy's single-array file.
    Npy,
}

impl Container {
    /// What the first bytes say, or `None`.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => Some(Self::Png),
            [b'P', b'2' | b'3' | b'5' | b'6', space, ..] if is_blank(*space) => Some(Self::Pnm),
            [b'P', b'f' | b'F', space, ..] if is_blank(*space) => Some(Self::Pfm),
            [0xff, 0xd8, 0xff, ..] => Some(Self::Jpeg),
            [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Some(Self::Tiff),
            [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => Some(Self::Npy),
            _ => None,
        }
    }

    /// The format's name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Pnm => "PGM/PPM",
            Self::Jpeg => "JPEG",
            Self::Tiff => "TIFF",
            Self::Pfm => "PFM",
            Self::Npy => "NPY",
        }
    }
}

impl From<Container> for &'static str {
    fn from(container: Container) -> Self {
        container.name()
    }
}

/// White space as Netpbm defines it; a comment may begin right after the magic number as well.
fn is_blank(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == 0x0b || byte == b'#'
}

/// A file in memory, with its path for messages.
pub(crate) struct Source {
    pub path: PathBuf,
    pub bytes: Vec<u8>,
}

impl Source {
    /// Reads all of a file, at most [`MAX_FILE_BYTES`]; of one that is of no known kind no more than shows that it is
    /// no calibration.
    pub fn open(path: &Path) -> Result<Self, FormatError> {
        let failed = |source| FormatError::Read { path: path.to_owned(), source };
        let file = File::open(path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        let too_large = |claim: String| FormatError::TooLarge {
            path: path.to_owned(),
            format: "any",
            claim,
            limit: format!("{MAX_FILE_BYTES} bytes a file"),
        };
        if length > MAX_FILE_BYTES {
            return Err(too_large(format!("it has {length} bytes")));
        }
        let mut bytes = Vec::new();
        // What is none of ours is told by its beginning, and need not be read to its end; short texts may be
        // calibrations.
        (&file).take(BEGINNING).read_to_end(&mut bytes).map_err(failed)?;
        let most = match Container::of(&bytes) {
            Some(_) => MAX_FILE_BYTES,
            // With one byte more, so that whoever asked for it sees that it is longer.
            None => LONGEST_TEXT,
        };
        let rest = (length.min(most + 1) as usize).saturating_sub(bytes.len());
        bytes.try_reserve_exact(rest).map_err(|_| failed(io::ErrorKind::OutOfMemory.into()))?;
        // A pipe or device has no length: its end is looked for, but not without end.
        let rest = most + 1 - bytes.len() as u64;
        (&file).take(rest).read_to_end(&mut bytes).map_err(failed)?;
        if bytes.len() as u64 > MAX_FILE_BYTES {
            return Err(too_large("it has no end in sight".to_owned()));
        }
        Ok(Self { path: path.to_owned(), bytes })
    }

    /// Bytes that come from a test.
    #[cfg(test)]
    pub fn of(path: &str, bytes: &[u8]) -> Self {
        Self { path: path.into(), bytes: bytes.to_vec() }
    }

    /// What the file is, or an error that says what it looks like instead.
    pub fn container(&self) -> Result<Container, FormatError> {
        Container::of(&self.bytes).ok_or_else(|| {
            self.wrong_kind(
                self.describe(),
                "a PNG, PGM/PPM, JPEG, TIFF, PFM or NPY file is needed (the content counts, not \
                 the extension)",
            )
        })
    }

    pub fn malformed(
        &self,
        format: impl Into<&'static str>,
        offset: impl Into<Option<u64>>,
        problem: impl Into<String>,
    ) -> FormatError {
        FormatError::Malformed {
            path: self.path.clone(),
            format: format.into(),
            offset: offset.into(),
            problem: problem.into(),
        }
    }

    pub fn wrong_kind(&self, found: impl Into<String>, needed: impl Into<String>) -> FormatError {
        FormatError::WrongKind {
            path: self.path.clone(),
            found: found.into(),
            needed: needed.into(),
        }
    }

    /// Refuses a size that is zero, larger than [`MAX_PIXELS`], or more than the file can hold:
    /// `least_bytes` is the smallest number of bytes that could encode that many pixels.
    pub fn check_size(
        &self,
        format: Container,
        columns: u64,
        rows: u64,
        least_bytes: impl FnOnce(u64) -> u64,
    ) -> Result<(usize, usize), FormatError> {
        let pixels = match columns.checked_mul(rows) {
            Some(0) => {
                return Err(self.malformed(
                    format,
                    None,
                    format!("it has no pixels ({columns} x {rows}): at least 1 x 1 is needed"),
                ));
            }
            Some(pixels) if pixels <= MAX_PIXELS => pixels,
            _ => {
                return Err(FormatError::TooLarge {
                    path: self.path.clone(),
                    format: format.name(),
                    claim: format!("it claims {columns} x {rows} pixels"),
                    limit: format!("{MAX_PIXELS} pixels (for example 16384 x 16384)"),
                });
            }
        };
        let (needed, there) = (least_bytes(pixels), self.bytes.len() as u64);
        if needed > there {
            return Err(self.malformed(
                format,
                there,
                format!(
                    "it claims {columns} x {rows} pixels, which takes at least {needed} bytes, \
                     but it has {there}: was it copied whole?"
                ),
            ));
        }
        Ok((columns as usize, rows as usize))
    }

    /// What a file that is none of ours looks like, for messages.
    pub fn describe(&self) -> &'static str {
        match &self.bytes[..] {
            [] => "empty",
            [b'P', b'1' | b'4', ..] => "a black-and-white PBM picture",
            [b'P', b'7', ..] => "a PAM picture",
            [b'P', b'K', 3 | 5, ..] => "a zip archive (.npz is one: save the array alone as .npy)",
            [b'G', b'I', b'F', b'8', ..] => "a GIF picture",
            [b'B', b'M', ..] => "a BMP picture",
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => "a WebP picture",
            [0x76, 0x2f, 0x31, 0x01, ..] => "an OpenEXR picture",
            [0x1f, 0x8b, ..] => "gzip-compressed",
            [b'%', b'P', b'D', b'F', ..] => "a PDF document",
            [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "text in UTF-16 (save it as UTF-8)",
            bytes if bytes.len() < 8 => "cut off after a few bytes",
            bytes
                if bytes[..bytes.len().min(512)]
                    .iter()
                    .all(|b| b.is_ascii_graphic() || is_blank(*b)) =>
            {
                "text"
            }
            _ => "of an unknown kind",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_is_read_to_the_most_pixels() {
        let source = Source::of("a.png", b"");
        let size = |columns, rows| source.check_size(Container::Png, columns, rows, |_| 0);
        assert_eq!(size(1 << 14, 1 << 14).unwrap(), (1 << 14, 1 << 14));
        for (columns, rows) in [(MAX_PIXELS + 1, 1), (1 << 14, (1 << 14) + 1), (1 << 33, 1 << 33)] {
            let error = size(columns, rows).unwrap_err();
            assert!(matches!(error, FormatError::TooLarge { .. }), "{error}");
        }
    }
}
