//! PGM and PPM, plain (P2, P3) and raw (P5, P6), maxval 1 to 65535.
//!
//! With maxval 255 or 65535 the samples come out as stored. Any other maxval is scaled so that it
//! becomes white: to 0..255 when it is below 255, to 0..65535 when it is above,
//! `(sample * white + maxval / 2) / maxval` in whole numbers, that is, rounded to nearest.

use std::io::{self, Write};

use raster::{Image, Plane};

use crate::FormatError;
use crate::image::{Decoded, Stored};
use crate::netpbm::Words;
use crate::source::{Container, Source};

const FORMAT: Container = Container::Pnm;

/// Decodes the one picture of the file.
pub(crate) fn decode(source: &Source) -> Result<Decoded, FormatError> {
    let kind = source.bytes[1];
    let plain = matches!(kind, b'2' | b'3');
    let channels = if matches!(kind, b'3' | b'6') { 3 } else { 1 };
    let mut words = Words::after_magic(&source.bytes);
    let columns = number(source, &mut words, "columns")?;
    let rows = number(source, &mut words, "rows")?;
    let at = words.at() as u64;
    let maxval = match number(source, &mut words, "the largest sample (maxval)")? {
        maxval @ 1..=65535 => maxval as u32,
        other => {
            let problem = format!("maxval is {other}, but 1 to 65535 is allowed");
            return Err(source.malformed(FORMAT, at, problem));
        }
    };
    let sample_bytes = if maxval > 255 { 2 } else { 1 };
    let (columns, rows) = source.check_size(FORMAT, columns, rows, |pixels| {
        // Plain samples are at least one digit and, but for the last, one blank.
        pixels * channels as u64 * if plain { 2 } else { sample_bytes } - u64::from(plain)
    })?;
    let count = columns * rows * channels;
    let samples = if plain {
        plain_samples(source, &mut words, count, maxval)?
    } else {
        raw_samples(source, &words, count, maxval)?
    };
    let image = picture(columns, rows, channels, maxval, samples);
    let stored = Stored {
        samples: if channels == 3 { "colour" } else { "grey" },
        bits: if maxval > 255 { 16 } else { 8 },
        exact: matches!(maxval, 255 | 65535),
    };
    Ok(Decoded { image, stored })
}

fn number(source: &Source, words: &mut Words<'_>, name: &str) -> Result<u64, FormatError> {
    let at = words.at() as u64;
    words.next().and_then(|word| word.parse().ok()).ok_or_else(|| {
        source.malformed(FORMAT, at, format!("the header must give {name} as a whole number"))
    })
}

fn plain_samples(
    source: &Source,
    words: &mut Words<'_>,
    count: usize,
    maxval: u32,
) -> Result<Vec<u16>, FormatError> {
    let mut samples = Vec::with_capacity(count);
    for n in 0..count {
        let at = words.at() as u64;
        let word = words.next().ok_or_else(|| {
            let problem = format!("the picture takes {count} samples, but it ends after {n}");
            source.malformed(FORMAT, source.bytes.len() as u64, problem)
        })?;
        match word.parse::<u32>() {
            Ok(sample) if sample <= maxval => samples.push(sample as u16),
            _ => {
                let problem = format!("a sample is `{word}`, but 0 to {maxval} is allowed");
                return Err(source.malformed(FORMAT, at, problem));
            }
        }
    }
    match words.next() {
        None if words.at() == source.bytes.len() => Ok(samples),
        _ => Err(source.malformed(
            FORMAT,
            words.at() as u64,
            format!("there is more behind the {count} samples of the picture"),
        )),
    }
}

fn raw_samples(
    source: &Source,
    words: &Words<'_>,
    count: usize,
    maxval: u32,
) -> Result<Vec<u16>, FormatError> {
    let data = words.data().unwrap_or_default();
    let length = if maxval > 255 { 2 * count } else { count };
    if data.len() != length {
        let problem = format!(
            "the picture takes {length} bytes behind its header, but there are {}",
            data.len()
        );
        return Err(source.malformed(FORMAT, source.bytes.len() as u64, problem));
    }
    let samples: Vec<u16> = if maxval > 255 {
        data.as_chunks().0.iter().map(|&pair| u16::from_be_bytes(pair)).collect()
    } else {
        data.iter().map(|&byte| u16::from(byte)).collect()
    };
    match samples.iter().position(|&sample| u32::from(sample) > maxval) {
        None => Ok(samples),
        Some(n) => {
            let at = source.bytes.len() - length + n * length / count;
            let problem = format!("a sample is {}, but 0 to {maxval} is allowed", samples[n]);
            Err(source.malformed(FORMAT, at as u64, problem))
        }
    }
}

/// Scales the samples to 8 or 16 bit and groups them into pixels.
fn picture(columns: usize, rows: usize, channels: usize, maxval: u32, samples: Vec<u16>) -> Image {
    let white: u32 = if maxval > 255 { 65535 } else { 255 };
    let scale = |sample: u16| ((u32::from(sample) * white + maxval / 2) / maxval) as u16;
    let colours = || samples.as_chunks::<3>().0.iter();
    match (white, channels) {
        (255, 1) => Image::Grey8(plane(columns, rows, samples.iter().map(|&s| scale(s) as u8))),
        (255, _) => Image::Rgb8(plane(columns, rows, colours().map(|c| c.map(|s| scale(s) as u8)))),
        (_, 1) => Image::Grey16(plane(columns, rows, samples.iter().map(|&s| scale(s)))),
        _ => Image::Rgb16(plane(columns, rows, colours().map(|c| c.map(scale)))),
    }
}

fn plane<T>(columns: usize, rows: usize, pixels: impl Iterator<Item = T>) -> Plane<T> {
    Plane::new(columns, rows, pixels.collect()).expect("the samples have been counted")
}

/// Writes raw PGM (grey) or PPM (colour) with maxval 255 or 65535.
pub(crate) fn encode(image: &Image, writer: &mut dyn Write) -> io::Result<()> {
    let (columns, rows) = image.size();
    let (kind, maxval) = match image {
        Image::Grey8(_) => (5, 255),
        Image::Grey16(_) => (5, 65535),
        Image::Rgb8(_) => (6, 255),
        Image::Rgb16(_) => (6, 65535),
    };
    write!(writer, "P{kind}\n{columns} {rows}\n{maxval}\n")?;
    let wide =
        |samples: &[u16]| -> Vec<u8> { samples.iter().flat_map(|s| s.to_be_bytes()).collect() };
    match image {
        Image::Grey8(p) => writer.write_all(p.samples()),
        Image::Rgb8(p) => writer.write_all(p.samples().as_flattened()),
        Image::Grey16(p) => writer.write_all(&wide(p.samples())),
        Image::Rgb16(p) => writer.write_all(&wide(p.samples().as_flattened())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> Result<Image, String> {
        decode(&Source::of("a.pgm", bytes)).map(|d| d.image).map_err(|e| e.to_string())
    }

    fn grey8(samples: &[u8]) -> Image {
        Image::Grey8(Plane::new(samples.len(), 1, samples.to_vec()).unwrap())
    }

    fn grey16(samples: &[u16]) -> Image {
        Image::Grey16(Plane::new(samples.len(), 1, samples.to_vec()).unwrap())
    }

    #[test]
    fn all_four_kinds_are_read() {
        assert_eq!(
            read(b"P2 # grey\n3 1\n255\n0 128 # half\n255\n").unwrap(),
            grey8(&[0, 128, 255])
        );
        assert_eq!(read(b"P5 2 1 255\n\x07\xff").unwrap(), grey8(&[7, 255]));
        assert_eq!(read(b"P5 2 1 65535\n\x01\x02\xff\xff").unwrap(), grey16(&[258, 65535]));
        let colour = Image::Rgb8(Plane::new(1, 1, vec![[1, 2, 3]]).unwrap());
        assert_eq!(read(b"P3 1 1 255 1 2 3").unwrap(), colour);
        assert_eq!(read(b"P6 1 1 255 \x01\x02\x03").unwrap(), colour);
    }

    #[test]
    fn another_maxval_becomes_white() {
        // 255 * 1 / 2 = 127.5 is rounded up.
        assert_eq!(read(b"P2 3 1 2 0 1 2").unwrap(), grey8(&[0, 128, 255]));
        // 65535 * 512 / 1023 = 32799.53
        assert_eq!(read(b"P2 3 1 1023 0 512 1023").unwrap(), grey16(&[0, 32800, 65535]));
    }

    #[test]
    fn broken_rules_are_named() {
        for (bytes, word) in [
            (&b"P5 2 1 255\n\x07"[..], "there are 1"),
            (b"P5 2 1 255\n\x07\x08\x09", "there are 3"),
            (b"P5 1 1 10\n\x0b", "0 to 10"),
            (b"P5 1 1 70000\n\0\0", "1 to 65535"),
            (b"P5 1 1 0\n\0", "1 to 65535"),
            (b"P2 2 1 255 1 ", "near byte 13"),
            (b"P2 2 1 255 1 2 3", "more behind"),
            (b"P2 2 1 255 1 -2", "`-2`"),
            (b"P5 0 1 255\n", "no pixels"),
            (b"P5 x 1 255\n", "columns"),
            (b"P5 100000 100000 255\n", "100000 x 100000"),
            (b"P5 18446744073709551615 3 255\n", "too large"),
        ] {
            let error = read(bytes).unwrap_err();
            assert!(error.contains(word), "{error}");
        }
    }
}
