//! TIFF and BigTIFF by the crate `tiff`: grey and RGB of 8 and 16 bit, and floats of 16 to 64 bit for
//! disparities; plain, LZW, Deflate or PackBits. A file has one picture, beside which smaller copies of it and
//! masks may lie; alpha is dropped (the colour samples stay as stored).

mod directory;

use std::io::{self, Cursor, Write};

use raster::{Image, Plane};
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::encoder::{Compression, DeflateLevel, TiffEncoder, colortype::Gray32Float};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use crate::FormatError;
use crate::image::{Decoded, Stored};
use crate::source::{Container, Source};

const FORMAT: Container = Container::Tiff;

/// LZW's longest string is 3840 bytes for 12 bits; Deflate and PackBits shrink less.
const LARGEST_RATIO: u64 = 2560;

/// What a TIFF file holds.
pub(crate) enum Content {
    /// Grey or colour of 8 or 16 bit.
    Picture(Decoded),
    /// One float a pixel, which had so many bits; what is not finite as a float of 32 becomes NaN.
    Floats(Plane<f32>, u8),
}

/// The sample format of floats.
const FLOATS: u16 = 3;
/// The fill order of bytes whose first bit is the lowest.
const BACKWARDS: u32 = 2;
/// The compression LZW.
const LZW: u16 = 5;
/// Grey with alpha, as the decoder calls it.
const GREY_WITH_ALPHA_8: ColorType = ColorType::Multiband { bit_depth: 8, num_samples: 2 };
const GREY_WITH_ALPHA_16: ColorType = ColorType::Multiband { bit_depth: 16, num_samples: 2 };
/// What is read.
const SAMPLES: &str = "unsigned grey or RGB of 8 or 16 bit, or one float a pixel for disparities, is needed: save it so";

/// Decodes the picture of a TIFF file.
pub(crate) fn decode(source: &Source) -> Result<Content, FormatError> {
    let failed = |error: TiffError| explain(source, error);
    directory::check(source)?;
    let mut decoder = Decoder::new(Cursor::new(&source.bytes[..])).map_err(failed)?;
    let (columns, rows) = decoder.dimensions().map_err(failed)?;
    let color = decoder.colortype().map_err(failed)?;
    // Several samples in a byte: the decoder would not know how many there are.
    if color.bit_depth() < 8 {
        return Err(source.wrong_kind(format!("a TIFF of {color:?} samples"), SAMPLES));
    }
    // The decoder would turn floats into 1 - v.
    let white: Option<u16> =
        decoder.find_tag_unsigned(Tag::PhotometricInterpretation).map_err(failed)?;
    // One of each sample.
    let kinds = decoder.find_tag_unsigned_vec::<u16>(Tag::SampleFormat).map_err(failed)?;
    let is_floats = kinds.is_some_and(|kinds| kinds.contains(&FLOATS));
    if color.num_samples() == 1 && is_floats && white == Some(0) {
        return Err(source.wrong_kind(
            "a TIFF of floats in which 0 is white",
            "save it with 0 as black (photometric `minisblack`)",
        ));
    }
    let bits = u64::from(color.bit_depth()) * u64::from(color.num_samples());
    let (columns, rows) =
        source.check_size(FORMAT, u64::from(columns), u64::from(rows), |pixels| {
            pixels * bits / 8 / LARGEST_RATIO
        })?;
    refuse_misread(source, &mut decoder, color)?;
    let planar: Option<u16> =
        decoder.find_tag_unsigned(Tag::PlanarConfiguration).map_err(failed)?;
    if planar == Some(2) && color.num_samples() > 1 {
        return Err(source.wrong_kind(
            "a TIFF whose colours are stored plane by plane",
            "interleaved colours are needed: save it again as such",
        ));
    }
    let mut limits = Limits::default();
    limits.decoding_buffer_size = (columns * rows).saturating_mul(bits as usize).div_ceil(8);
    limits.intermediate_buffer_size = source.bytes.len();
    let mut decoder = decoder.with_limits(limits);
    let mut samples = DecodingResult::U8(Vec::new());
    let is_tiled_lzw = is_tiled_lzw(&mut decoder).map_err(failed)?;
    decoder.read_image_to_buffer(&mut samples).map_err(|error| match error {
        TiffError::IoError(e) if is_tiled_lzw && e.kind() == io::ErrorKind::UnexpectedEof => source
            .wrong_kind(
                "a TIFF whose tiles of LZW cannot be read to their end",
                "a whole file is needed; if it was copied whole, save it in strips or with Deflate",
            ),
        error => failed(error),
    })?;
    content(source, columns, rows, color, samples)
}

/// Refuses what the decoder would make other samples of, or take memory for, without a word.
fn refuse_misread(
    source: &Source,
    decoder: &mut Decoder<Cursor<&[u8]>>,
    color: ColorType,
) -> Result<(), FormatError> {
    let mut tag = |tag| {
        let value = decoder.find_tag_unsigned::<u32>(tag);
        value.map_err(|error| explain(source, error))
    };
    if tag(Tag::FillOrder)? == Some(BACKWARDS) {
        return Err(source.wrong_kind(
            "a TIFF whose bytes have their bits the other way round",
            "the usual order (FillOrder 1) is needed: `tiffcp -f msb2lsb`",
        ));
    }
    let (samples, tile) = (tag(Tag::SamplesPerPixel)?.unwrap_or(1), tag(Tag::TileWidth)?);
    // A tile may be larger than the picture; memory is taken for a row of it.
    if let Some(across) = tile {
        let row = u64::from(across) * u64::from(color.bit_depth()) * u64::from(samples) / 8;
        if row / LARGEST_RATIO > source.bytes.len() as u64 {
            return Err(source.malformed(
                FORMAT,
                source.bytes.len() as u64,
                format!("it claims tiles of {across} columns, more than it has bytes for"),
            ));
        }
    }
    // Of samples that it does not know the decoder makes room for the others after it has undone what was done to
    // all, or of tiles that overhang the picture.
    let undoes = tag(Tag::Predictor)?.unwrap_or(1) != 1 || tile.is_some();
    let known = color.num_samples();
    if samples > u32::from(known) && undoes {
        return Err(source.wrong_kind(
            format!("a TIFF of {samples} samples a pixel, of which {known} have a known meaning"),
            "grey or RGB is needed, with alpha at most, marked as such: save it without the others",
        ));
    }
    Ok(())
}

/// Whether it is of the kind of which the decoder cannot read all: some of LZW's tiles that overhang the picture.
fn is_tiled_lzw(decoder: &mut Decoder<Cursor<&[u8]>>) -> Result<bool, TiffError> {
    let compression: Option<u16> = decoder.find_tag_unsigned(Tag::Compression)?;
    Ok(compression == Some(LZW) && decoder.find_tag(Tag::TileWidth)?.is_some())
}

fn content(
    source: &Source,
    columns: usize,
    rows: usize,
    color: ColorType,
    samples: DecodingResult,
) -> Result<Content, FormatError> {
    let wrong_size = |e: raster::SizeError| source.malformed(FORMAT, None, e.to_string());
    let stored = |samples, bits, exact| Stored { samples, bits, exact };
    let floats = |mut values: Vec<f32>, bits| {
        for value in values.iter_mut().filter(|value| !value.is_finite()) {
            *value = f32::NAN;
        }
        let plane = Plane::new(columns, rows, values).map_err(wrong_size)?;
        Ok(Content::Floats(plane, bits))
    };
    let (image, stored) = match (color, samples) {
        (ColorType::Gray(_), DecodingResult::F16(v)) => {
            return floats(v.into_iter().map(f32::from).collect(), 16);
        }
        (ColorType::Gray(_), DecodingResult::F32(v)) => return floats(v, 32),
        (ColorType::Gray(_), DecodingResult::F64(v)) => {
            return floats(v.into_iter().map(|v| v as f32).collect(), 64);
        }
        (ColorType::Gray(8), DecodingResult::U8(v)) => {
            (Plane::new(columns, rows, v).map(Image::Grey8), stored("grey", 8, true))
        }
        (ColorType::Gray(16), DecodingResult::U16(v)) => {
            (Plane::new(columns, rows, v).map(Image::Grey16), stored("grey", 16, true))
        }
        (GREY_WITH_ALPHA_8, DecodingResult::U8(v)) => {
            let v = v.as_chunks().0.iter().map(|&[v, _]| v).collect();
            (Plane::new(columns, rows, v).map(Image::Grey8), stored("grey with alpha", 8, false))
        }
        (GREY_WITH_ALPHA_16, DecodingResult::U16(v)) => {
            let v = v.as_chunks().0.iter().map(|&[v, _]| v).collect();
            (Plane::new(columns, rows, v).map(Image::Grey16), stored("grey with alpha", 16, false))
        }
        (ColorType::RGB(8), DecodingResult::U8(v)) => {
            let v = v.as_chunks().0.to_vec();
            (Plane::new(columns, rows, v).map(Image::Rgb8), stored("colour", 8, true))
        }
        (ColorType::RGB(16), DecodingResult::U16(v)) => {
            let v = v.as_chunks().0.to_vec();
            (Plane::new(columns, rows, v).map(Image::Rgb16), stored("colour", 16, true))
        }
        (ColorType::RGBA(8), DecodingResult::U8(v)) => {
            let v = v.as_chunks().0.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
            (Plane::new(columns, rows, v).map(Image::Rgb8), stored("colour with alpha", 8, false))
        }
        (ColorType::RGBA(16), DecodingResult::U16(v)) => {
            let v = v.as_chunks().0.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
            (Plane::new(columns, rows, v).map(Image::Rgb16), stored("colour with alpha", 16, false))
        }
        (color, samples) => {
            let numbers = match samples {
                DecodingResult::I8(_)
                | DecodingResult::I16(_)
                | DecodingResult::I32(_)
                | DecodingResult::I64(_) => "signed ",
                DecodingResult::F16(_) | DecodingResult::F32(_) | DecodingResult::F64(_) => {
                    "float "
                }
                _ => "",
            };
            return Err(source.wrong_kind(format!("a TIFF of {numbers}{color:?} samples"), SAMPLES));
        }
    };
    Ok(Content::Picture(Decoded { image: image.map_err(wrong_size)?, stored }))
}

fn explain(source: &Source, error: TiffError) -> FormatError {
    match error {
        // Some list what all samples have, of which a file may claim thousands.
        TiffError::UnsupportedError(what) => source.wrong_kind(
            format!("a TIFF of a kind that is not read ({:.100})", what.to_string()),
            "save it uncompressed or with LZW or Deflate, 8 or 16 bit grey or RGB, or floats",
        ),
        TiffError::IoError(e) if e.kind() == io::ErrorKind::UnexpectedEof => source.malformed(
            FORMAT,
            source.bytes.len() as u64,
            "the file ends early: was it copied whole?",
        ),
        // The memory for pixels is limited to what the size takes, that for a part to the file's length.
        TiffError::LimitsExceeded => source.malformed(
            FORMAT,
            source.bytes.len() as u64,
            "a strip or tile claims more bytes than the file has: was it copied whole?",
        ),
        error => source.malformed(FORMAT, None, error.to_string()),
    }
}

/// Writes one float a pixel, deflated, NaN as NaN. (The encoder names a predictor even where it has
/// none, which libtiff warns about in a file that is not compressed.)
pub(crate) fn encode(values: &Plane<f32>, writer: &mut dyn Write) -> io::Result<()> {
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let (columns, rows) = (side(values.columns())?, side(values.rows())?);
    // The encoder seeks back and forth, which a pipe cannot.
    let mut file = Cursor::new(Vec::new());
    TiffEncoder::new(&mut file)
        .map(|tiff| tiff.with_compression(Compression::Deflate(DeflateLevel::Fast)))
        .and_then(|mut tiff| tiff.write_image::<Gray32Float>(columns, rows, values.samples()))
        .map_err(io::Error::other)?;
    writer.write_all(file.get_ref())
}
