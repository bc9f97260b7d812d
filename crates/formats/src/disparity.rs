//! Disparity maps in and out. In memory a disparity is in pixels and NaN means "no value".

use std::path::Path;

use raster::{Image, Plane};

use crate::numbers::Numbers;
use crate::source::{Container, Source};
use crate::{Encoding, FormatError, image, npy, pfm, tiff};

/// A disparity map as read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadDisparity {
    /// Disparity in pixels, `x_right = x_left - d`, NaN = no value.
    pub values: Plane<f32>,
    /// How the file was understood; never [`Encoding::Auto`].
    pub encoding: Encoding,
    /// What had to be assumed and may be wrong, as a sentence for the user.
    pub note: Option<String>,
}

/// Reads a disparity map.
///
/// With [`Encoding::Auto`] the content decides. Integers do not say their scale: 16-bit grey is
/// taken for KITTI's (/ 256), 8-bit grey and arrays of int16, uint16 and uint8 for whole disparities (/ 1), and the
/// note says so, because a map read at the wrong scale looks right and scores as almost all wrong. A disparity of 0 comes
/// back from KITTI's PNG as 1/256, since 0 says there that there is none ([`write_disparity`]): before depth is made of it,
/// make that 0 again. Any other
/// encoding is a demand: a file of another kind is an error.
///
/// Errors: [`FormatError::Read`], [`FormatError::WrongKind`] for a file that holds no disparities or not so encoded,
/// [`FormatError::Malformed`] and [`FormatError::TooLarge`] as the readers of its format, [`FormatError::Text`] for a
/// divisor that makes no pixels.
pub fn read_disparity(
    path: impl AsRef<Path>,
    encoding: Encoding,
) -> Result<ReadDisparity, FormatError> {
    let encoding = encoding.check()?;
    let source = Source::open(path.as_ref())?;
    let container = source.container()?;
    let read = understood(&source, container, encoding)?;
    let note = read.note.or_else(|| marked(&read.values));
    Ok(ReadDisparity { note, ..read })
}

fn understood(
    source: &Source,
    container: Container,
    encoding: Encoding,
) -> Result<ReadDisparity, FormatError> {
    match container {
        Container::Pfm => {
            demand(source, container, encoding, Encoding::Pfm)?;
            Ok(floats(pfm::decode(source)?, Encoding::Pfm))
        }
        Container::Npy => {
            demand(source, container, encoding, Encoding::Npy)?;
            let (values, dtype) = from_npy(source)?;
            let scaled = match dtype {
                npy::Dtype::Int16 => {
                    "OpenCV's matchers give sixteenths, which must be divided by 16 before"
                }
                npy::Dtype::Uint16 => {
                    "KITTI's are 256ths, which must be divided by 256 before, with NaN instead of 0"
                }
                npy::Dtype::Uint8 => {
                    "Middlebury's are halves, thirds or quarters, which must be divided before, with NaN \
                     instead of 0"
                }
                _ => "",
            };
            let note = (encoding == Encoding::Auto && !scaled.is_empty()).then(|| {
                format!("{dtype} does not say its scale: pixels were assumed (npy); {scaled}")
            });
            Ok(ReadDisparity { note, ..floats(values, Encoding::Npy) })
        }
        Container::Tiff => match tiff::decode(source)? {
            tiff::Content::Floats(values, _) => {
                demand(source, container, encoding, Encoding::Tiff)?;
                Ok(floats(values, Encoding::Tiff))
            }
            tiff::Content::Picture(_) => Err(source.wrong_kind(
                "a TIFF of integers",
                "a disparity map as TIFF holds floats; integers do not say their scale",
            )),
        },
        _ => from_grey(source, container, encoding),
    }
}

/// Says that many pixels have one value that looks as if it stood for none, if so: the smallest, below zero, whole, and
/// by itself, as OpenCV's matchers leave it.
fn marked(values: &Plane<f32>) -> Option<String> {
    const MANY: f64 = 0.01;
    const APART: f32 = 0.5;
    let known = || values.samples().iter().copied().filter(|value| !value.is_nan());
    let least = known().fold(f32::INFINITY, f32::min);
    if !(least < 0.0 && least.is_finite() && least.fract() == 0.0) {
        return None;
    }
    let count = known().filter(|&value| value == least).count();
    let share = count as f64 / values.samples().len() as f64;
    let is_alone = known().all(|value| value == least || value > least + APART);
    (share >= MANY && is_alone).then(|| {
        format!(
            "{:.1} % of the pixels are exactly {least}, below all others, and count as disparities; where that stands \
             for no match, store NaN instead",
            100.0 * share
        )
    })
}

fn floats(values: Plane<f32>, encoding: Encoding) -> ReadDisparity {
    ReadDisparity { values, encoding, note: None }
}

/// Errors when another encoding was asked for than the content has.
fn demand(
    source: &Source,
    container: Container,
    asked: Encoding,
    found: Encoding,
) -> Result<(), FormatError> {
    if asked == Encoding::Auto || asked == found {
        return Ok(());
    }
    Err(source.wrong_kind(
        format!("a {} file", container.name()),
        format!("the encoding {asked} was asked for: ask for {found} or auto"),
    ))
}

/// Any array of numbers with two dimensions; the values that are not finite become NaN.
fn from_npy(source: &Source) -> Result<(Plane<f32>, npy::Dtype), FormatError> {
    let npy::Array { shape, samples } = npy::decode(source)?;
    let dtype = samples.dtype();
    let needed = "an array of numbers with shape (rows, columns) is needed";
    if shape.len() != 2 || dtype == npy::Dtype::Bool {
        let shape = npy::shape_text(&shape);
        let found = format!("a .npy array of {dtype} with shape {shape}");
        return Err(source.wrong_kind(found, needed));
    }
    let (columns, rows) = npy::plane_size(source, &shape)?;
    let values = samples.to_f64();
    if let Some(at) = values.iter().position(|v| v.is_finite() && v.abs() > f64::from(f32::MAX)) {
        let (x, y, value) = (at % columns, at / columns, values[at]);
        let found = format!("a .npy array whose value at column {x}, row {y} is {value:e}");
        return Err(source.wrong_kind(found, "disparities must fit float32"));
    }
    let keep = |v: f64| if v.is_finite() { v as f32 } else { f32::NAN };
    let values = values.into_iter().map(keep).collect();
    let plane = Plane::new(columns, rows, values).expect("the length has been checked");
    Ok((plane, dtype))
}

/// Grey integers with a scale, 0 = none.
fn from_grey(
    source: &Source,
    container: Container,
    encoding: Encoding,
) -> Result<ReadDisparity, FormatError> {
    let image::Decoded { image, stored } = image::decode(source, container)?;
    let found = format!("a {} of {}-bit {}", container.name(), stored.bits, stored.samples);
    if !stored.exact || container == Container::Jpeg {
        return Err(source.wrong_kind(
            found,
            "disparities must be stored as they are: 8 or 16-bit grey PNG without alpha or \
             palette, PFM, NPY or float TIFF",
        ));
    }
    let wrong = |needed: &str| Err(source.wrong_kind(found.clone(), needed));
    match (&image, encoding) {
        (Image::Grey8(samples), Encoding::Auto) => Ok(ReadDisparity {
            values: scaled(samples, 1.0),
            encoding: Encoding::Png8 { divisor: 1.0 },
            note: Some(
                "8-bit grey does not say its scale: whole disparities (png8/1) were assumed; \
                 Cones and Teddy need png8/4, Middlebury 2005 and 2006 png8/3 at third size and \
                 png8/2 at half size"
                    .to_owned(),
            ),
        }),
        (Image::Grey8(samples), Encoding::Png8 { divisor }) => {
            Ok(ReadDisparity { values: scaled(samples, divisor), encoding, note: None })
        }
        (Image::Grey16(samples), Encoding::Auto) => Ok(ReadDisparity {
            values: scaled(samples, 256.0),
            encoding: Encoding::Png16 { divisor: 256.0 },
            note: Some(
                "16-bit grey does not say its scale: KITTI's (png16/256) was assumed".to_owned(),
            ),
        }),
        (Image::Grey16(samples), Encoding::Png16 { divisor }) => {
            Ok(ReadDisparity { values: scaled(samples, divisor), encoding, note: None })
        }
        (Image::Grey8(_) | Image::Grey16(_), asked) => {
            let kind = if image.depth() == u8::BITS { "png8" } else { "png16" };
            wrong(&format!("the encoding {asked} was asked for: ask for {kind}/K or auto"))
        }
        (Image::Rgb8(_) | Image::Rgb16(_), _) => wrong(
            "a disparity map has one number a pixel: a coloured picture of one cannot be read \
             back, save grey PNG, PFM, NPY or float TIFF",
        ),
    }
}

/// Samples over the divisor, 0 as no value.
fn scaled<T: Copy + Into<f32>>(samples: &Plane<T>, divisor: f32) -> Plane<f32> {
    samples.map(|&sample| match sample.into() {
        0.0 => f32::NAN,
        value => value / divisor,
    })
}

/// How disparities stand in files.
const DISPARITIES: Numbers = Numbers {
    known: ".pfm, .npy (float32), .png (KITTI, 16 bit), .tiff (float32)",
    finite: "a disparity is finite, or NaN for no value",
    scale: 256.0,
    below: 256.0,
    png: "KITTI's 16-bit PNG holds 0 up to, not including, 256 pixels: write .pfm, .npy or .tiff instead",
};

/// Writes a disparity map, its format by extension, whole or not at all.
///
/// | extension | what is written | no value |
/// | --- | --- | --- |
/// | `.pfm` | little-endian float32, bottom-up | `+INF` |
/// | `.npy` | float32, `rows x columns` | NaN |
/// | `.png` | KITTI: 16-bit grey, `round(256 d)` | 0 |
/// | `.tiff`, `.tif` | float32 | NaN |
///
/// In a `.png` a disparity below 1/512 would round to 0 and so vanish; it is stored as 1, that is
/// 1/256 pixel, as KITTI's own tools do. Any other is off by at most 1/512 pixel (above 255.998 by
/// less than 1/256, since 65535 is the last sample).
///
/// Errors: [`FormatError::UnknownExtension`], [`FormatError::Unrepresentable`], which names the pixel, for disparities
/// outside `[0, 256)` in a `.png` and for infinite ones in every format, since these are neither disparities nor "no
/// value", and [`FormatError::Write`], also for a map without pixels.
pub fn write_disparity(path: impl AsRef<Path>, values: &Plane<f32>) -> Result<(), FormatError> {
    DISPARITIES.write(path.as_ref(), values)
}
