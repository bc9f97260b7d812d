//! PNG, read and written by the crate `png`.
//!
//! Grey and colour of 8 and 16 bit come out as they are stored. Grey of 1, 2 and 4 bit is scaled
//! to 8 bit (exactly: times 255, 85, 17), a palette becomes colour. **Alpha is dropped**: the
//! colour samples stay as stored, they are neither multiplied by alpha nor laid over a background,
//! so a transparent pixel keeps the colour that hides behind it. Gamma and colour profiles are
//! not applied, of an animation the first frame is read.

use std::io::{self, Cursor, Write};

use png::{BitDepth, ColorType, DecodingError, Transformations};
use raster::{Image, Plane};

use crate::FormatError;
use crate::image::{Decoded, Stored};
use crate::source::{Container, MAX_FILE_BYTES, Source};

/// Deflate never shrinks by more than this, so a file bounds the pixels that it can hold.
const LARGEST_DEFLATE_RATIO: u64 = 1032;

/// Whether a file is an animation of more than one frame.
pub(crate) fn is_animated(bytes: &[u8]) -> bool {
    const BEGINNING: &[u8] = b"\x89PNG\r\n\x1a\n";
    let mut rest = bytes.strip_prefix(BEGINNING).unwrap_or_default();
    // The length of what a chunk holds, its name, that, and a checksum.
    while let Some((head, behind)) = rest.split_first_chunk::<8>() {
        let [length, name] =
            [0, 4].map(|i| <[u8; 4]>::try_from(&head[i..i + 4]).expect("four bytes"));
        let length = u32::from_be_bytes(length) as usize;
        if name == *b"acTL" {
            let frames = behind.first_chunk().map_or(0, |frames| u32::from_be_bytes(*frames));
            return frames > 1;
        }
        rest = behind.get(length.saturating_add(4)..).unwrap_or_default();
        // It stands before the picture.
        if name == *b"IDAT" {
            return false;
        }
    }
    false
}

/// Decodes the picture of a PNG file.
pub(crate) fn decode(source: &Source) -> Result<Decoded, FormatError> {
    let failed = |error: DecodingError| explain(source, error);
    let limits = png::Limits { bytes: MAX_FILE_BYTES as usize };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(&source.bytes[..]), limits);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(Transformations::EXPAND);

    let header = decoder.read_header_info().map_err(failed)?;
    let bits = header.color_type.samples() as u64 * header.bit_depth as u64;
    let stored = describe(header.color_type, header.bit_depth);
    let (columns, rows) = source.check_size(
        Container::Png,
        u64::from(header.width),
        u64::from(header.height),
        |pixels| pixels * bits / 8 / LARGEST_DEFLATE_RATIO,
    )?;

    let mut reader = decoder.read_info().map_err(failed)?;
    let length = reader.output_buffer_size().expect("the size has been checked");
    let mut bytes = vec![0; length];
    reader.next_frame(&mut bytes).map_err(failed)?;
    let (color, depth) = reader.output_color_type();
    reader.finish().map_err(failed)?;

    let image = match (color, depth) {
        (ColorType::Grayscale, BitDepth::Eight) => Image::Grey8(plane(columns, rows, bytes)),
        (ColorType::GrayscaleAlpha, BitDepth::Eight) => {
            Image::Grey8(gather(columns, rows, &bytes, |[v, _]: [u8; 2]| v))
        }
        (ColorType::Rgb, BitDepth::Eight) => {
            Image::Rgb8(gather(columns, rows, &bytes, |rgb: [u8; 3]| rgb))
        }
        (ColorType::Rgba, BitDepth::Eight) => {
            Image::Rgb8(gather(columns, rows, &bytes, |[r, g, b, _]: [u8; 4]| [r, g, b]))
        }
        (ColorType::Grayscale, BitDepth::Sixteen) => {
            Image::Grey16(gather(columns, rows, &bytes, u16::from_be_bytes))
        }
        (ColorType::GrayscaleAlpha, BitDepth::Sixteen) => {
            Image::Grey16(gather(columns, rows, &bytes, |[h, l, _, _]: [u8; 4]| {
                u16::from_be_bytes([h, l])
            }))
        }
        (ColorType::Rgb, BitDepth::Sixteen) => {
            Image::Rgb16(gather(columns, rows, &bytes, |b: [u8; 6]| sixteen(b)))
        }
        (ColorType::Rgba, BitDepth::Sixteen) => {
            Image::Rgb16(gather(columns, rows, &bytes, |[a, b, c, d, e, f, _, _]: [u8; 8]| {
                sixteen([a, b, c, d, e, f])
            }))
        }
        (color, depth) => {
            return Err(source.wrong_kind(
                format!("a PNG of {color:?} with {depth:?} bits"),
                "8 or 16 bits a sample are needed",
            ));
        }
    };
    Ok(Decoded { image, stored })
}

/// What the header says about the samples.
fn describe(color: ColorType, depth: BitDepth) -> Stored {
    let (samples, plain) = match color {
        ColorType::Grayscale => ("grey", true),
        ColorType::GrayscaleAlpha => ("grey with alpha", false),
        ColorType::Rgb => ("colour", true),
        ColorType::Rgba => ("colour with alpha", false),
        ColorType::Indexed => ("colour from a palette", false),
    };
    let bits = depth as u8;
    Stored { samples, bits, exact: plain && bits >= 8 }
}

fn sixteen([a, b, c, d, e, f]: [u8; 6]) -> [u16; 3] {
    [[a, b], [c, d], [e, f]].map(u16::from_be_bytes)
}

fn plane<T>(columns: usize, rows: usize, samples: Vec<T>) -> Plane<T> {
    Plane::new(columns, rows, samples).expect("the decoder fills columns x rows pixels")
}

/// Makes a pixel of every `N` bytes.
fn gather<const N: usize, T>(
    columns: usize,
    rows: usize,
    bytes: &[u8],
    pixel: impl Fn([u8; N]) -> T,
) -> Plane<T> {
    plane(columns, rows, bytes.as_chunks::<N>().0.iter().map(|&chunk| pixel(chunk)).collect())
}

fn explain(source: &Source, error: DecodingError) -> FormatError {
    let there = source.bytes.len() as u64;
    match error {
        DecodingError::IoError(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
            source.malformed(Container::Png, there, "the file ends early: was it copied whole?")
        }
        error => source.malformed(Container::Png, None, in_words(&error)),
    }
}

/// What the decoder says; of bytes that were changed it tells what it was about to do with them.
fn in_words(error: &DecodingError) -> String {
    let text = error.to_string();
    match text.starts_with("CRC error") || text.starts_with("Corrupt deflate stream") {
        true => {
            "its bytes were changed, as checksums or packed data tell: copy the file again".into()
        }
        false => text,
    }
}

/// Encodes a picture as PNG, without alpha, colour profile or gamma.
pub(crate) fn encode(image: &Image, writer: &mut dyn Write) -> io::Result<()> {
    let (columns, rows) = image.size();
    match image {
        Image::Grey8(p) => {
            encode_bytes(writer, columns, rows, ColorType::Grayscale, BitDepth::Eight, p.samples())
        }
        Image::Rgb8(p) => encode_rgb(p, writer),
        Image::Grey16(p) => {
            let bytes: Vec<u8> = p.samples().iter().flat_map(|v| v.to_be_bytes()).collect();
            encode_bytes(writer, columns, rows, ColorType::Grayscale, BitDepth::Sixteen, &bytes)
        }
        Image::Rgb16(p) => {
            let samples = p.samples().as_flattened();
            let bytes: Vec<u8> = samples.iter().flat_map(|v| v.to_be_bytes()).collect();
            encode_bytes(writer, columns, rows, ColorType::Rgb, BitDepth::Sixteen, &bytes)
        }
    }
}

/// Encodes 8-bit colour.
pub(crate) fn encode_rgb(picture: &Plane<[u8; 3]>, writer: &mut dyn Write) -> io::Result<()> {
    let (columns, rows) = picture.size();
    let bytes = picture.samples().as_flattened();
    encode_bytes(writer, columns, rows, ColorType::Rgb, BitDepth::Eight, bytes)
}

fn encode_bytes(
    writer: &mut dyn Write,
    columns: usize,
    rows: usize,
    color: ColorType,
    depth: BitDepth,
    bytes: &[u8],
) -> io::Result<()> {
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let mut encoder = png::Encoder::new(writer, side(columns)?, side(rows)?);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().map_err(io::Error::from)?;
    writer.write_image_data(bytes).map_err(io::Error::from)?;
    writer.finish().map_err(io::Error::from)
}
