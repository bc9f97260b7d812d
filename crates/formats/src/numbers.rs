//! Maps of numbers out: one a pixel, NaN for none, as floats or as whole numbers of 16 bits.

use std::path::Path;

use raster::{Image, Plane};

use crate::atomic::write_atomically;
use crate::{FormatError, image, npy, pfm, png, tiff};

/// What the numbers are, in the words of errors, and how they stand in 16 bits.
pub(crate) struct Numbers {
    /// The extensions, each with its format.
    pub known: &'static str,
    /// That none may be infinite.
    pub finite: &'static str,
    /// Whole numbers of 16 bits to one.
    pub scale: f32,
    /// From here on they do not fit 16 bits.
    pub below: f32,
    /// The same in words, with the remedy.
    pub png: &'static str,
}

impl Numbers {
    /// Writes a map, its format by extension, whole or not at all.
    pub fn write(&self, path: &Path, values: &Plane<f32>) -> Result<(), FormatError> {
        if values.samples().is_empty() {
            return Err(FormatError::no_pixels(path, "the map has"));
        }
        refuse(path, values, |v| v.is_infinite(), self.finite)?;
        match image::extension(path).as_deref() {
            Some("pfm") => write_atomically(path, |writer| pfm::encode(values, writer)),
            Some("npy") => npy::write(path, values),
            Some("tif" | "tiff") => write_atomically(path, |writer| tiff::encode(values, writer)),
            Some("png") => {
                let fits = |v: f32| (0.0..self.below).contains(&v) || v.is_nan();
                refuse(path, values, |v| !fits(v), self.png)?;
                let image = Image::Grey16(values.map(|&v| self.sample(v)));
                write_atomically(path, |writer| png::encode(&image, writer))
            }
            _ => Err(FormatError::UnknownExtension { path: path.to_owned(), known: self.known }),
        }
    }

    /// What is nearest in 16 bits, but at least 1, because 0 means none.
    fn sample(&self, value: f32) -> u16 {
        if value.is_nan() { 0 } else { ((value * self.scale).round() as u16).max(1) }
    }
}

/// Errors at the first pixel whose value is `bad`.
fn refuse(
    path: &Path,
    values: &Plane<f32>,
    bad: impl Fn(f32) -> bool,
    allowed: &'static str,
) -> Result<(), FormatError> {
    match values.samples().iter().position(|&v| bad(v)) {
        None => Ok(()),
        Some(at) => Err(FormatError::Unrepresentable {
            path: path.to_owned(),
            x: at % values.columns(),
            y: at / values.columns(),
            value: f64::from(values.samples()[at]),
            allowed,
        }),
    }
}
