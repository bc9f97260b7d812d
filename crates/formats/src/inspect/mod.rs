//! What a file holds, in numbers: for a first look, and for finding out why two files do not fit.

mod display;

use std::path::{Path, PathBuf};

use raster::{Image, Plane};
use serde::Serialize;

use crate::image::{self, Decoded};
use crate::npy::{self, Array, Dtype};
use crate::source::{Container, Source};
use crate::{Calibration, Encoding, FormatError, bounding_box, calibration, pfm, tiff, unused};

/// What a file holds. Displays as a few lines of text.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FileInfo {
    /// The file.
    #[serde(serialize_with = "crate::path_as_text")]
    pub path: PathBuf,
    /// Its length.
    pub bytes: u64,
    /// What is in it.
    pub content: FileContent,
}

/// The kinds of files that are known.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[non_exhaustive]
pub enum FileContent {
    /// A picture of whole numbers.
    Picture {
        /// The format.
        format: Container,
        /// Width in pixels.
        columns: usize,
        /// Height in pixels.
        rows: usize,
        /// Channels as decoded: 1 for grey, 3 for colour.
        channels: usize,
        /// Bits a sample, as stored.
        bits: u8,
        /// How the samples are stored: `grey`, `colour with alpha` and so on.
        stored: &'static str,
        /// What else the file holds, of which nothing is made ([`unused`]).
        unused: Vec<String>,
        /// Over all channels, as decoded.
        samples: Statistics,
        /// For grey that may be a disparity map: the scales in use, and what they would make of it.
        as_disparities: Vec<DisparityReading>,
    },
    /// One float a pixel: a disparity map in pixels.
    Floats {
        /// The format.
        format: Container,
        /// Width in pixels.
        columns: usize,
        /// Height in pixels.
        rows: usize,
        /// Bits per float.
        bits: u8,
        /// Over the finite values.
        values: Statistics,
    },
    /// A NumPy array.
    Array {
        /// Type of the elements.
        dtype: Dtype,
        /// Length of each dimension.
        shape: Vec<usize>,
        /// Over the finite elements.
        values: Statistics,
        /// For 2 x 2 integers that may be the course's box: `x0,y0,x1,y1`.
        as_box: Option<String>,
    },
    /// The cameras of a pair.
    Calibration(Calibration),
}

/// Numbers about numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Statistics {
    /// The smallest finite value, `None` when there is none.
    pub min: Option<f64>,
    /// The largest finite value, `None` when there is none.
    pub max: Option<f64>,
    /// The mean of the finite values, `None` when there is none.
    pub mean: Option<f64>,
    /// Share of values that are infinite or NaN, 0 to 1.
    pub without_value: f64,
}

/// What grey samples would be as disparities at one scale.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DisparityReading {
    /// The scale, as in [`Encoding`]'s text form.
    pub encoding: String,
    /// The smallest disparity in pixels.
    pub min: f64,
    /// The largest disparity in pixels.
    pub max: f64,
    /// Share of pixels that are 0 and so have no value, 0 to 1.
    pub without_value: f64,
    /// Whether the largest disparity is below the image's width; otherwise it cannot be one.
    pub plausible: bool,
}

impl Statistics {
    /// Counts values; those that are not finite have no value.
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let (mut min, mut max, mut sum) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
        let (mut valid, mut all) = (0u64, 0u64);
        for value in values {
            all += 1;
            if value.is_finite() {
                valid += 1;
                min = min.min(value);
                max = max.max(value);
                sum += value;
            }
        }
        let some = |value| (valid > 0).then_some(value);
        Self {
            min: some(min),
            max: some(max),
            mean: some(sum / valid as f64),
            without_value: if all > 0 { (all - valid) as f64 / all as f64 } else { 0.0 },
        }
    }
}

/// Looks into a picture, a disparity map, a NumPy array or a calibration file.
///
/// Errors as the reader of that kind of file, and [`FormatError::WrongKind`] for any other.
pub fn inspect(path: impl AsRef<Path>) -> Result<FileInfo, FormatError> {
    look_into(Source::open(path.as_ref())?)
}

/// As [`inspect`], for a file that is in memory already; `path` only names it in the answer.
pub fn inspect_bytes(path: impl AsRef<Path>, bytes: Vec<u8>) -> Result<FileInfo, FormatError> {
    look_into(Source { path: path.as_ref().to_owned(), bytes })
}

fn look_into(source: Source) -> Result<FileInfo, FormatError> {
    let content = match Container::of(&source.bytes) {
        Some(Container::Npy) => array(&source)?,
        Some(Container::Pfm) => floats(Container::Pfm, &pfm::decode(&source)?, 32),
        Some(Container::Tiff) => match tiff::decode(&source)? {
            tiff::Content::Floats(values, bits) => floats(Container::Tiff, &values, bits),
            tiff::Content::Picture(decoded) => picture(Container::Tiff, &decoded, &source),
        },
        Some(container) => picture(container, &image::decode(&source, container)?, &source),
        None => match calibration::parse(&source) {
            Ok(calibration) => FileContent::Calibration(calibration),
            Err(error) if calibration::is_none(&error) => {
                let found = source.describe();
                let needed = "a picture (PNG, PGM/PPM, JPEG, TIFF), a disparity map (PNG, PFM, \
                              NPY, TIFF), a NumPy array or a calibration file is needed";
                return Err(source.wrong_kind(found, needed));
            }
            Err(error) => return Err(error),
        },
    };
    Ok(FileInfo { bytes: source.bytes.len() as u64, path: source.path, content })
}

fn floats(format: Container, values: &Plane<f32>, bits: u8) -> FileContent {
    let (columns, rows) = values.size();
    let values = Statistics::of(values.samples().iter().map(|&v| f64::from(v)));
    FileContent::Floats { format, columns, rows, bits, values }
}

fn array(source: &Source) -> Result<FileContent, FormatError> {
    let array = npy::decode(source)?;
    let as_box = bounding_box::of_array(source, &array).ok().map(|bounds| bounds.to_string());
    let Array { shape, samples } = array;
    let dtype = samples.dtype();
    let values = Statistics::of(samples.values());
    Ok(FileContent::Array { dtype, shape, values, as_box })
}

fn picture(format: Container, decoded: &Decoded, source: &Source) -> FileContent {
    let unused = unused(&source.bytes);
    let Decoded { image, stored } = decoded;
    let (columns, rows) = image.size();
    let eight = |samples: &[u8]| Statistics::of(samples.iter().map(|&v| f64::from(v)));
    let sixteen = |samples: &[u16]| Statistics::of(samples.iter().map(|&v| f64::from(v)));
    let (channels, samples) = match image {
        Image::Grey8(p) => (1, eight(p.samples())),
        Image::Grey16(p) => (1, sixteen(p.samples())),
        Image::Rgb8(p) => (3, eight(p.samples().as_flattened())),
        Image::Rgb16(p) => (3, sixteen(p.samples().as_flattened())),
    };
    let as_disparities = match image {
        // Those of JPEG are not exact, those of TIFF are floats.
        _ if matches!(format, Container::Jpeg | Container::Tiff) => Vec::new(),
        Image::Grey8(p) if stored.exact => {
            readings(p, [1.0, 2.0, 3.0, 4.0].map(|divisor| Encoding::Png8 { divisor }))
        }
        Image::Grey16(p) if stored.exact => readings(p, [Encoding::Png16 { divisor: 256.0 }]),
        _ => Vec::new(),
    };
    FileContent::Picture {
        format,
        columns,
        rows,
        channels,
        bits: stored.bits,
        stored: stored.samples,
        unused,
        samples,
        as_disparities,
    }
}

/// What the samples would be as disparities, for each of the encodings; none when all are 0.
fn readings<T: Copy + Into<f64>>(
    samples: &Plane<T>,
    encodings: impl IntoIterator<Item = Encoding>,
) -> Vec<DisparityReading> {
    let zero_as_none = |v: &T| match (*v).into() {
        0.0 => f64::NAN,
        value => value,
    };
    let Statistics { min: Some(min), max: Some(max), without_value, .. } =
        Statistics::of(samples.samples().iter().map(zero_as_none))
    else {
        return Vec::new();
    };
    let reading = |encoding: Encoding| {
        let divisor = match encoding {
            Encoding::Png8 { divisor } | Encoding::Png16 { divisor } => f64::from(divisor),
            _ => 1.0,
        };
        DisparityReading {
            encoding: encoding.to_string(),
            min: min / divisor,
            max: max / divisor,
            without_value,
            plausible: max / divisor < samples.columns() as f64,
        }
    };
    encodings.into_iter().map(reading).collect()
}
