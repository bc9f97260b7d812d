//! PFM, the portable float map of Debevec, as Middlebury and ETH3D use it for disparities.
//!
//! A text header `Pf`, columns, rows, scale, then 32-bit floats, **bottom row first**. The sign of
//! the scale tells the byte order (negative: little endian); its size is ignored, as Middlebury's
//! own reader does (its files say 0.0039 there and mean nothing by it). Infinity or NaN stands for
//! "no value" on reading; `+INF` is written.

use std::io::{self, Write};

use raster::Plane;

use crate::FormatError;
use crate::netpbm::Words;
use crate::source::{Container, Source};

const FORMAT: Container = Container::Pfm;

/// The values of a grey PFM file, NaN where there is none.
pub(crate) fn decode(source: &Source) -> Result<Plane<f32>, FormatError> {
    if source.bytes.starts_with(b"PF") {
        return Err(source.wrong_kind(
            "a PFM file with three channels (`PF`)",
            "a disparity map has one (`Pf`): save a single channel",
        ));
    }
    let mut words = Words::after_magic(&source.bytes);
    let columns = side(source, &mut words, "columns")?;
    let rows = side(source, &mut words, "rows")?;
    let start = words.at();
    let scale: f32 = words.next().and_then(|word| word.parse().ok()).unwrap_or(f32::NAN);
    if scale == 0.0 || !scale.is_finite() {
        return Err(source.malformed(
            FORMAT,
            start as u64,
            "the third number of the header, the scale, must be positive (big endian) or \
             negative (little endian)",
        ));
    }
    let (columns, rows) = source.check_size(FORMAT, columns, rows, |pixels| pixels * 4)?;
    let length = columns * rows * 4;
    // One blank ends the header; some programs write several (`\r\n`, or a space and a line feed).
    // Which bytes are values is certain all the same, because their number is.
    let behind = &source.bytes[words.at()..];
    let blanks = behind.len().saturating_sub(length);
    let data = match (behind, &behind[..blanks]) {
        // Of a file that was cut off by a byte, `\n` would else be taken for the first value's.
        ([b'\r', b'\n', data @ ..], _) => data,
        (_, [space @ .., b'\n']) if space.iter().all(|b| matches!(b, b' ' | b'\t' | b'\r')) => {
            &behind[blanks..]
        }
        _ => words.data().unwrap_or_default(),
    };
    if data.len() != length {
        return Err(source.malformed(
            FORMAT,
            source.bytes.len() as u64,
            format!(
                "{columns} x {rows} floats take {length} bytes behind the header, but there are {}",
                data.len()
            ),
        ));
    }
    let from_bytes = if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let mut values = Vec::with_capacity(columns * rows);
    for row in data.chunks_exact(columns * 4).rev() {
        values.extend(row.as_chunks().0.iter().map(|&bytes| {
            let value = from_bytes(bytes);
            if value.is_finite() { value } else { f32::NAN }
        }));
    }
    Ok(Plane::new(columns, rows, values).expect("one value a pixel"))
}

fn side(source: &Source, words: &mut Words<'_>, name: &str) -> Result<u64, FormatError> {
    let start = words.at() as u64;
    words.next().and_then(|word| word.parse().ok()).ok_or_else(|| {
        source.malformed(FORMAT, start, format!("the header must give the number of {name}"))
    })
}

/// Writes little-endian PFM, `+INF` where the value is NaN.
pub(crate) fn encode(values: &Plane<f32>, writer: &mut dyn Write) -> io::Result<()> {
    write!(writer, "Pf\n{} {}\n-1\n", values.columns(), values.rows())?;
    let stored = |value: &f32| if value.is_nan() { f32::INFINITY } else { *value };
    let mut bytes = Vec::new();
    for y in (0..values.rows()).rev() {
        bytes.clear();
        bytes.extend(values.row(y).iter().flat_map(|value| stored(value).to_le_bytes()));
        writer.write_all(&bytes)?;
    }
    Ok(())
}
