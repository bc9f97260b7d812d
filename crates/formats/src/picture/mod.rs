//! Pictures of disparity maps for people to look at. They cannot be read back as numbers; reasons
//! alone can, by [`read_reasons`](crate::read_reasons).
//!
//! Every picture is 8-bit RGB of the size of its map. Black is "nothing to show": no value, no
//! truth, outside the box.

mod colour_map;
mod error;
mod image;
mod maps;

use std::io;
use std::path::Path;

use raster::Plane;

pub use colour_map::ColourMap;
pub use error::{HOLE, LOG_ERROR_COLOURS, LOG_ERROR_STEPS, log_error, log_error_legend};
pub use image::image;
pub use maps::{confidence, disparity, reason_colour, reasons, value_range};

use crate::{FormatError, png, write_atomically};

/// Where there is nothing to show.
pub const BLACK: [u8; 3] = [0; 3];

/// Two maps that should lie over each other differ in size.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "the {first} is {} x {} but the {second} is {} x {}: they must have one size",
    first_size.0, first_size.1, second_size.0, second_size.1
)]
pub struct SizesDiffer {
    /// What the first map is.
    pub first: &'static str,
    /// What the second map is.
    pub second: &'static str,
    /// `(columns, rows)` of the first.
    pub first_size: (usize, usize),
    /// `(columns, rows)` of the second.
    pub second_size: (usize, usize),
}

/// Writes a picture as PNG, whatever the extension, whole or not at all.
///
/// Errors: [`FormatError::Write`].
pub fn write_png_rgb(path: impl AsRef<Path>, picture: &Plane<[u8; 3]>) -> Result<(), FormatError> {
    write_atomically(path, |writer| png::encode_rgb(picture, writer))
}

/// The bytes of a picture as PNG, for a data URI. Errors when the picture has no pixels.
pub fn png_rgb(picture: &Plane<[u8; 3]>) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    png::encode_rgb(picture, &mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_image;
    use raster::Image;

    #[test]
    fn a_picture_survives_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let picture = Plane::from_fn(5, 3, |x, y| [x as u8, y as u8, 200]);
        let path = folder.path().join("picture");
        write_png_rgb(&path, &picture).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), png_rgb(&picture).unwrap());
        assert_eq!(read_image(&path).unwrap(), Image::Rgb8(picture));
        assert!(write_png_rgb(folder.path().join("none"), &Plane::default()).is_err());
        assert!(!folder.path().join("none").exists());
    }
}
