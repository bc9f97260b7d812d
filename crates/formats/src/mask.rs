//! Middlebury's and ETH3D's masks (`mask0nocc.png`): which pixels both cameras see.

use std::path::Path;

use raster::{Image, Plane};

use crate::source::Source;
use crate::{FormatError, image};

/// Reads a mask: `true` where the sample is 255 (seen by both cameras), `false` where it is 128
/// (seen by the left camera only) or 0 (no truth).
///
/// Errors as [`read_image`](crate::read_image), and [`FormatError::WrongKind`] when the picture is
/// not 8-bit grey or holds another sample: a mask of 0 and 1, say, would otherwise hide everything.
pub fn read_mask(path: impl AsRef<Path>) -> Result<Plane<bool>, FormatError> {
    let source = Source::open(path.as_ref())?;
    let container = source.container()?;
    let image::Decoded { image, stored } = image::decode(&source, container)?;
    let needed = "a mask of 8-bit grey is needed: 255 = seen by both cameras, 128 = by the left \
                  one only, 0 = no truth";
    let Image::Grey8(samples) = image else {
        let found = format!("a {} of {}-bit {}", container.name(), stored.bits, stored.samples);
        return Err(source.wrong_kind(found, needed));
    };
    match samples.samples().iter().position(|sample| !matches!(sample, 0 | 128 | 255)) {
        None => Ok(samples.map(|&sample| sample == 255)),
        Some(at) => {
            let (x, y) = (at % samples.columns(), at / samples.columns());
            let sample = samples.samples()[at];
            let found = format!("no mask (the pixel at column {x}, row {y} is {sample})");
            Err(source.wrong_kind(found, needed))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::write_image;

    #[test]
    fn only_255_is_seen_by_both() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mask0nocc.png");
        write_image(&path, &Image::Grey8(Plane::new(3, 1, vec![0, 128, 255]).unwrap())).unwrap();
        assert_eq!(read_mask(&path).unwrap().samples(), [false, false, true]);
    }

    #[test]
    fn other_samples_and_kinds_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mask.png");
        write_image(&path, &Image::Grey8(Plane::new(2, 2, vec![0, 0, 0, 1]).unwrap())).unwrap();
        let error = read_mask(&path).unwrap_err().to_string();
        assert!(error.contains("column 1, row 1 is 1"), "{error}");
        write_image(&path, &Image::Rgb8(Plane::filled(2, 2, [255; 3]))).unwrap();
        assert!(read_mask(&path).unwrap_err().to_string().contains("8-bit colour"));
    }
}
