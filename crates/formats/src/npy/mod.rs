//! NumPy's `.npy`, versions 1 to 3: one array of numbers, either byte order, C or Fortran order.
//!
//! The reader is strict, because the file may come from a program that is not trusted: nothing is
//! evaluated, pickled objects are refused, the length must be exactly what the shape takes, and
//! nothing is converted silently. [`read_plane`] wants one element type and says what it found
//! instead; [`read`] takes any array of numbers. Writing is little-endian, C order, version 1.

mod element;
mod header;

use std::io::{self, Write};
use std::path::Path;

use raster::Plane;

pub use element::{Element, Samples};
pub use header::Dtype;

use crate::FormatError;
use crate::atomic::write_atomically;
use crate::source::{Container, Source};
use header::{Header, Refusal};

/// An array of numbers of any shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Length of each dimension, the slowest first.
    pub shape: Vec<usize>,
    /// The elements in C order (the last index runs fastest), whatever the order in the file.
    pub samples: Samples,
}

/// Reads an array of numbers of any shape and type.
///
/// Errors: [`FormatError::WrongKind`] when the file is no `.npy` or holds something else than
/// numbers, [`FormatError::Malformed`] when header or length are wrong.
pub fn read(path: impl AsRef<Path>) -> Result<Array, FormatError> {
    decode(&Source::open(path.as_ref())?)
}

/// Reads `rows x columns` elements (for a colour `T` such as `[u8; 3]`: `rows x columns x 3`).
///
/// Errors as [`read`], and [`FormatError::WrongKind`] when the element type or the shape is another
/// one, [`FormatError::TooLarge`] past [`MAX_PIXELS`](crate::MAX_PIXELS).
pub fn read_plane<T: Element>(path: impl AsRef<Path>) -> Result<Plane<T>, FormatError> {
    plane(&Source::open(path.as_ref())?)
}

/// As [`read_plane`], for a file that is in memory already; `path` only names it in errors.
pub fn plane_of_bytes<T: Element>(
    path: impl AsRef<Path>,
    bytes: Vec<u8>,
) -> Result<Plane<T>, FormatError> {
    plane(&Source { path: path.as_ref().to_owned(), bytes })
}

/// Writes a plane as `rows x columns` (a colour `T`: `rows x columns x 3`), whole or not at all.
///
/// Errors: [`FormatError::Write`], also for a plane without pixels.
pub fn write<T: Element>(path: impl AsRef<Path>, plane: &Plane<T>) -> Result<(), FormatError> {
    if plane.samples().is_empty() {
        return Err(FormatError::no_pixels(path.as_ref(), "the plane has"));
    }
    write_atomically(path, |writer| encode(plane, writer))
}

/// The array of a file in memory.
pub(crate) fn decode(source: &Source) -> Result<Array, FormatError> {
    let header = header(source)?;
    let data = &source.bytes[header.data_at..];
    let count = header.shape.iter().try_fold(1usize, |n, &side| n.checked_mul(side));
    let length = count.and_then(|n| n.checked_mul(header.dtype.size()));
    if length != Some(data.len()) {
        return Err(source.malformed(
            Container::Npy,
            source.bytes.len() as u64,
            format!(
                "an array of {} with shape {} does not take the {} bytes behind its header",
                header.dtype,
                shape_text(&header.shape),
                data.len()
            ),
        ));
    }
    let samples = Samples::from_bytes(header.dtype, header.big_endian, data);
    let samples = match header.fortran_order && header.shape.len() > 1 {
        true => samples.fortran_to_c(&header.shape),
        false => samples,
    };
    Ok(Array { shape: header.shape, samples })
}

/// The header of a file in memory, its refusals as errors.
fn header(source: &Source) -> Result<Header, FormatError> {
    if Container::of(&source.bytes) != Some(Container::Npy) {
        let found = match source.container() {
            Ok(container) => format!("a {} file", container.name()),
            Err(FormatError::WrongKind { found, .. }) => found,
            Err(other) => return Err(other),
        };
        return Err(source.wrong_kind(found, "a .npy file is needed: write one with `numpy.save`"));
    }
    Header::parse(&source.bytes).map_err(|refusal| match refusal {
        Refusal::Malformed(at, problem) => source.malformed(Container::Npy, at as u64, problem),
        Refusal::WrongKind(found) => source.wrong_kind(
            found,
            "numbers are needed: bool, int8 to int64, uint8 to uint64, float16 to float64",
        ),
    })
}

/// The plane of a file in memory.
pub(crate) fn plane<T: Element>(source: &Source) -> Result<Plane<T>, FormatError> {
    let Header { dtype, shape, .. } = header(source)?;
    let wanted_shape = if T::CHANNELS == 1 { "(rows, columns)" } else { "(rows, columns, 3)" };
    let fits = match shape[..] {
        [_, _] => T::CHANNELS == 1,
        [_, _, channels] => T::CHANNELS > 1 && channels == T::CHANNELS,
        _ => false,
    };
    if dtype != T::DTYPE || !fits {
        return Err(source.wrong_kind(
            format!("a .npy array of {dtype} with shape {}", shape_text(&shape)),
            format!("{} with shape {wanted_shape} is needed", T::DTYPE),
        ));
    }
    let (columns, rows) = plane_size(source, &shape)?;
    let samples = T::from_samples(decode(source)?.samples).expect("the type has been checked");
    Ok(Plane::new(columns, rows, samples).expect("the length has been checked"))
}

/// `(columns, rows)` of an array of two or more dimensions, within the limits.
pub(crate) fn plane_size(source: &Source, shape: &[usize]) -> Result<(usize, usize), FormatError> {
    source.check_size(Container::Npy, shape[1] as u64, shape[0] as u64, |pixels| pixels)
}

/// The shape as Python writes a tuple.
pub(crate) fn shape_text(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        many => {
            let sides: Vec<String> = many.iter().map(usize::to_string).collect();
            format!("({})", sides.join(", "))
        }
    }
}

/// Writes the header and the elements.
pub(crate) fn encode<T: Element>(plane: &Plane<T>, writer: &mut dyn Write) -> io::Result<()> {
    let mut shape = vec![plane.rows(), plane.columns()];
    if T::CHANNELS > 1 {
        shape.push(T::CHANNELS);
    }
    let mut header = format!(
        "{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}",
        T::DTYPE.descr(),
        shape_text(&shape)
    );
    // The elements begin at a multiple of 64 bytes, as the format asks for.
    let unpadded = 10 + header.len() + 1;
    header.push_str(&" ".repeat(unpadded.next_multiple_of(64) - unpadded));
    header.push('\n');
    writer.write_all(b"\x93NUMPY\x01\0")?;
    writer.write_all(&(header.len() as u16).to_le_bytes())?;
    writer.write_all(header.as_bytes())?;
    T::write_all(plane.samples(), writer)
}
