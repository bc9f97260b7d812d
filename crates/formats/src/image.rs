//! Pictures in, pictures out: which decoder reads a file is decided by its content.

use std::path::Path;

use raster::Image;

use crate::source::{Container, Source};
use crate::{FormatError, atomic, png};

/// A decoded picture, and how its file stores it.
pub(crate) struct Decoded {
    pub image: Image,
    pub stored: Stored,
}

/// How a file stores its samples.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stored {
    /// Grey, colour, with alpha and so on, in words.
    pub samples: &'static str,
    /// Bits a sample.
    pub bits: u8,
    /// Whether the decoded samples are the stored ones, nothing scaled, dropped or looked up.
    pub exact: bool,
}

/// Reads a picture: PNG, PGM/PPM, JPEG or TIFF, by content, whatever its extension.
pub fn read_image(path: impl AsRef<Path>) -> Result<Image, FormatError> {
    let source = Source::open(path.as_ref())?;
    decode(&source, source.container()?).map(|decoded| decoded.image)
}

/// Decodes a picture of a known container.
pub(crate) fn decode(source: &Source, container: Container) -> Result<Decoded, FormatError> {
    match container {
        Container::Png => png::decode(source),
        Container::Pnm | Container::Jpeg | Container::Tiff | Container::Pfm | Container::Npy => {
            Err(source.wrong_kind(
                format!("a {} file", container.name()),
                "a picture is needed: PNG, PGM/PPM, JPEG or TIFF",
            ))
        }
    }
}

/// Writes a picture as 8 or 16-bit PNG, whole or not at all.
pub fn write_image(path: impl AsRef<Path>, image: &Image) -> Result<(), FormatError> {
    atomic::write_atomically(path, |writer| png::encode(image, writer))
}
