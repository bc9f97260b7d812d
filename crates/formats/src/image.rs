//! Pictures in, pictures out: which decoder reads a file is decided by its content.

use std::path::Path;

use raster::Image;

use crate::source::{Container, Source};
use crate::{FormatError, jpeg, png, pnm, tiff, write_atomically};

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
///
/// Samples come out as stored, 8 or 16 bit, with these exceptions: alpha is dropped (the colour
/// samples stay as stored, nothing is blended), a palette becomes colour, PNG grey of less than 8
/// bit and PGM/PPM with a maxval other than 255 or 65535 are scaled so that white is 255 or 65535,
/// JPEG colour becomes RGB. No gamma, colour profile or EXIF orientation is applied.
///
/// Errors: [`FormatError::Read`], [`FormatError::Malformed`] for damaged files,
/// [`FormatError::TooLarge`] past [`MAX_PIXELS`](crate::MAX_PIXELS), [`FormatError::WrongKind`] for
/// anything that is no picture of these kinds.
pub fn read_image(path: impl AsRef<Path>) -> Result<Image, FormatError> {
    read_image_and_bytes(path).map(|(image, _)| image)
}

/// The same, with the bytes of the file that it was decoded from: read again, the file may be another one.
///
/// Errors: those of [`read_image`].
pub fn read_image_and_bytes(path: impl AsRef<Path>) -> Result<(Image, Vec<u8>), FormatError> {
    let source = Source::open(path.as_ref())?;
    let image = decode(&source, source.container()?)?.image;
    Ok((image, source.bytes))
}

/// Decodes a picture of a known container.
pub(crate) fn decode(source: &Source, container: Container) -> Result<Decoded, FormatError> {
    let wrong = |what: &str| {
        source.wrong_kind(
            format!("a {} file of {what}", container.name()),
            "a picture is needed: PNG, PGM/PPM, JPEG or TIFF of 8 or 16 bit",
        )
    };
    match container {
        Container::Png => png::decode(source),
        Container::Pnm => pnm::decode(source),
        Container::Jpeg => jpeg::decode(source),
        Container::Tiff => match tiff::decode(source)? {
            tiff::Content::Picture(decoded) => Ok(decoded),
            tiff::Content::Floats(..) => Err(wrong("floats")),
        },
        Container::Pfm => Err(wrong("floats")),
        Container::Npy => Err(wrong("numbers")),
    }
}

/// Writes a picture whole or not at all, its format by extension: `.png`, or `.pgm` (grey) and
/// `.ppm` (colour), all 8 or 16 bit as the picture is.
///
/// Errors: [`FormatError::UnknownExtension`], and [`FormatError::Write`], also for a picture without pixels and for
/// colour in a `.pgm` or grey in a `.ppm`.
pub fn write_image(path: impl AsRef<Path>, image: &Image) -> Result<(), FormatError> {
    let path = path.as_ref();
    if image.columns() == 0 || image.rows() == 0 {
        return Err(FormatError::no_pixels(path, "the picture has"));
    }
    let grey = !image.is_coloured();
    match extension(path).as_deref() {
        Some("png") => write_atomically(path, |writer| png::encode(image, writer)),
        Some("pgm") if grey => write_atomically(path, |writer| pnm::encode(image, writer)),
        Some("ppm") if !grey => write_atomically(path, |writer| pnm::encode(image, writer)),
        Some("pgm") => Err(unfit(path, "a .pgm holds grey and this is colour: write .ppm or .png")),
        Some("ppm") => Err(unfit(path, "a .ppm holds colour and this is grey: write .pgm or .png")),
        _ => Err(FormatError::UnknownExtension {
            path: path.to_owned(),
            known: ".png, .pgm (grey), .ppm (colour)",
        }),
    }
}

fn unfit(path: &Path, problem: &str) -> FormatError {
    let (path, problem) = (path.to_owned(), problem.to_owned());
    FormatError::Write { path, problem, os_error: None, source: None }
}

/// The extension in lower case.
pub(crate) fn extension(path: &Path) -> Option<String> {
    path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase)
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::Plane;

    #[test]
    fn pictures_survive_their_files() {
        let folder = tempfile::tempdir().unwrap();
        let grey8 = Plane::from_fn(7, 5, |x, y| (x * 30 + y) as u8);
        let grey16 = Plane::from_fn(7, 5, |x, y| (x * 9000 + y) as u16);
        for (image, extensions) in [
            (Image::Grey8(grey8.clone()), ["png", "pgm"]),
            (Image::Grey16(grey16.clone()), ["PNG", "pgm"]),
            (Image::Rgb8(grey8.map(|&v| [v, !v, 3])), ["png", "ppm"]),
            (Image::Rgb16(grey16.map(|&v| [v, !v, 3])), ["png", "ppm"]),
        ] {
            for extension in extensions {
                let path = folder.path().join("picture").with_extension(extension);
                write_image(&path, &image).unwrap();
                assert_eq!(read_image(&path).unwrap(), image, "{extension}");
                // The content counts, not the extension.
                let renamed = folder.path().join("picture.jpg");
                std::fs::rename(&path, &renamed).unwrap();
                assert_eq!(read_image(&renamed).unwrap(), image);
            }
        }
    }

    #[test]
    fn what_does_not_fit_the_extension_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let grey = Image::Grey8(Plane::filled(2, 2, 1));
        let colour = Image::Rgb8(Plane::filled(2, 2, [1; 3]));
        for (name, image, word) in [
            ("a.ppm", &grey, "write .pgm or .png"),
            ("a.pgm", &colour, "write .ppm or .png"),
            ("a.jpg", &grey, "`.jpg`: use one of .png"),
            ("a.png", &Image::Grey8(Plane::default()), "no pixels"),
        ] {
            let error = write_image(folder.path().join(name), image).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
