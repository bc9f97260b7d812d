//! JPEG, read by the crate `zune-jpeg`: baseline and progressive, grey and colour, 8 bit.
//!
//! The decoder runs without vector instructions, so that a file gives the same samples on every
//! machine. An orientation in the file's EXIF data is not applied: a matcher needs the pixels as
//! the camera laid them out. Colour comes out as RGB; CMYK is refused.

use raster::{Image, Plane};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::FormatError;
use crate::image::{Decoded, Stored};
use crate::source::{Container, Source};

const FORMAT: Container = Container::Jpeg;

/// Decodes the picture of a JPEG file.
pub(crate) fn decode(source: &Source) -> Result<Decoded, FormatError> {
    check_end(source)?;
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_use_unsafe(false)
        .set_max_width(usize::from(u16::MAX))
        .set_max_height(usize::from(u16::MAX));
    let failed = |e: zune_jpeg::errors::DecodeErrors| source.malformed(FORMAT, None, e.to_string());
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(&source.bytes), options);
    decoder.decode_headers().map_err(failed)?;
    let info = decoder.info().ok_or_else(|| source.malformed(FORMAT, None, "it has no header"))?;
    // A block of 8 x 8 pixels takes at least one bit, even in a progressive file.
    let (columns, rows) =
        source.check_size(FORMAT, u64::from(info.width), u64::from(info.height), |p| p / 512)?;

    let (output, samples) = match decoder.input_colorspace() {
        Some(ColorSpace::Luma) => (ColorSpace::Luma, "grey"),
        Some(ColorSpace::YCbCr | ColorSpace::RGB) => (ColorSpace::RGB, "colour"),
        other => {
            let name = other.map_or("no known colours".to_owned(), |c| format!("{c:?} colours"));
            return Err(source.wrong_kind(
                format!("a JPEG of {name}"),
                "grey or RGB is needed: convert it first",
            ));
        }
    };
    decoder.set_options(options.jpeg_set_out_colorspace(output));
    let bytes = decoder.decode().map_err(failed)?;
    let image = match output {
        ColorSpace::Luma => Plane::new(columns, rows, bytes).map(Image::Grey8),
        _ => Plane::new(columns, rows, bytes.as_chunks().0.to_vec()).map(Image::Rgb8),
    };
    let image = image.map_err(|e| source.malformed(FORMAT, None, e.to_string()))?;
    Ok(Decoded { image, stored: Stored { samples, bits: 8, exact: true } })
}

/// Errors where the end of the image is missing: decoders make up what is not there.
fn check_end(source: &Source) -> Result<(), FormatError> {
    let bytes = &source.bytes;
    let problem = "the file ends before the picture does: was it copied whole?";
    let cut = || source.malformed(FORMAT, bytes.len() as u64, problem);
    end(bytes).map(drop).ok_or_else(cut)
}

/// Whether a file that begins with a picture holds another one behind it.
pub(crate) fn goes_on(bytes: &[u8]) -> bool {
    const BEGINNING: [u8; 3] = [0xff, 0xd8, 0xff];
    let end = if bytes.starts_with(&BEGINNING) { end(bytes) } else { None };
    end.is_some_and(|end| bytes[end..].array_windows().any(|bytes| *bytes == BEGINNING))
}

/// Where the first picture ends, by its markers; `None` where the file ends before it.
fn end(bytes: &[u8]) -> Option<usize> {
    let mut at = 2;
    loop {
        // To the next marker: in compressed data 0xff is followed by 0 or a restart marker.
        while let Some(&[first, second]) = bytes.get(at..at + 2).and_then(|b| b.as_array()) {
            if first == 0xff && !matches!(second, 0 | 0xd0..=0xd7 | 0xff) {
                break;
            }
            at += 1;
        }
        match bytes.get(at + 1)? {
            0xd9 => return Some(at + 2),
            _ => {
                let length = bytes.get(at + 2..at + 4)?;
                at += 2 + usize::from(u16::from_be_bytes([length[0], length[1]]));
            }
        }
    }
}
