//! Images between numpy arrays and [`Image`].

use matching::{MOST_PIXELS, MatchError};
use numpy::{
    Element, PyArrayDescrMethods, PyArrayDyn, PyUntypedArray, PyUntypedArrayMethods, ToPyArray,
    ndarray,
};
use pyo3::prelude::*;
use raster::{Image, Plane};

use crate::arrays::{array, described, from_plane, kind, owned, to_vec, with_samples};
use crate::errors::{of_matching, wrong_type, wrong_value};

const NEEDED: &str = "an image is a numpy array of uint8 or uint16";
const SHAPE: &str = "an image has shape (rows, columns) for grey, or (rows, columns, 3) for red, green \
                     and blue";

/// An image from Python, copied once.
pub fn image(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Image> {
    let array = array(name, value, NEEDED)?;
    let (rows, columns, coloured) = match *array.shape() {
        [rows, columns] => (rows, columns, false),
        [rows, columns, 3] => (rows, columns, true),
        _ => return Err(wrong_value(name, described(array), wrong_shape(name, array.shape()))),
    };
    // A view may show few samples many times: before it is copied, its size is looked at.
    if columns.checked_mul(rows).is_none_or(|pixels| pixels > MOST_PIXELS) {
        let error = MatchError::TooLarge { columns, rows, limit: MOST_PIXELS };
        return Err(of_matching(error));
    }
    if let Ok(samples) = array.cast::<PyArrayDyn<u8>>() {
        return match coloured {
            false => Ok(Image::Grey8(grey(name, samples, columns, rows)?)),
            true => Ok(Image::Rgb8(colour(name, samples, columns, rows)?)),
        };
    }
    if let Ok(samples) = array.cast::<PyArrayDyn<u16>>() {
        return match coloured {
            false => Ok(Image::Grey16(grey(name, samples, columns, rows)?)),
            true => Ok(Image::Rgb16(colour(name, samples, columns, rows)?)),
        };
    }
    Err(wrong_type(name, described(array), wrong_samples(name, array)))
}

fn grey<T: Element + Copy>(
    name: &str,
    samples: &Bound<'_, PyArrayDyn<T>>,
    columns: usize,
    rows: usize,
) -> PyResult<Plane<T>> {
    let samples = to_vec(name, samples)?;
    Ok(Plane::new(columns, rows, samples).expect("the shape has been looked at"))
}

fn colour<T: Element + Copy>(
    name: &str,
    samples: &Bound<'_, PyArrayDyn<T>>,
    columns: usize,
    rows: usize,
) -> PyResult<Plane<[T; 3]>> {
    let samples =
        with_samples(name, samples, |samples| owned(name, samples.as_chunks().0, |sample| sample))?;
    Ok(Plane::new(columns, rows, samples).expect("the shape has been looked at"))
}

/// What is needed instead of a shape that is none of an image, with a remedy for the usual ones.
fn wrong_shape(name: &str, shape: &[usize]) -> String {
    let remedy = match shape {
        [_, _, 1] => format!("{name}[..., 0] is the grey image"),
        [_, _, 2] => format!("without its alpha it is {name}[..., 0]"),
        [_, _, 4] => format!("without its alpha it is {name}[..., :3]"),
        [1, _, _] => format!("{name}[0] is the grey image"),
        [3, _, _] => format!("numpy.moveaxis({name}, 0, -1) puts the colours last"),
        [_, _, _, _] => "give the images of a batch one after another".into(),
        _ => return SHAPE.into(),
    };
    format!("{SHAPE}: {remedy}")
}

/// What is needed instead of samples that are not an image's, with a remedy.
fn wrong_samples(name: &str, array: &Bound<'_, PyUntypedArray>) -> String {
    let remedy = match kind(array) {
        'f' => format!(
            "numpy.rint({name}).astype(numpy.uint8) makes one where white is 255, \
             numpy.rint(255 * {name}).astype(numpy.uint8) where white is 1"
        ),
        'b' => format!("255 * {name}.astype(numpy.uint8) makes one where True is white"),
        // The other order of bytes: the machine's own has been taken.
        'u' if array.dtype().itemsize() == 2 => {
            format!("{name}.astype(numpy.uint16) has the machine's own order of bytes")
        }
        'i' | 'u' => format!(
            "{name}.astype(numpy.uint8) makes one where white is 255, {name}.astype(numpy.uint16) \
             where white is 65535"
        ),
        _ => return NEEDED.into(),
    };
    format!("{NEEDED}: {remedy}")
}

/// An image for Python.
pub fn from_image<'py>(py: Python<'py>, image: Image) -> Bound<'py, PyAny> {
    match image {
        Image::Grey8(plane) => from_plane(py, plane).into_any(),
        Image::Grey16(plane) => from_plane(py, plane).into_any(),
        Image::Rgb8(plane) => from_colours(py, &plane),
        Image::Rgb16(plane) => from_colours(py, &plane),
    }
}

fn from_colours<'py, T: Element + Copy>(
    py: Python<'py>,
    plane: &Plane<[T; 3]>,
) -> Bound<'py, PyAny> {
    let (columns, rows) = plane.size();
    let samples = plane.samples().as_flattened();
    let view = ndarray::ArrayView3::from_shape((rows, columns, 3), samples);
    view.expect("a plane has columns x rows samples").to_pyarray(py).into_any()
}
