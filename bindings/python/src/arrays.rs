//! The samples of numpy arrays, in the order of rows.

use numpy::{
    Element, PyArray2, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyUntypedArray,
    PyUntypedArrayMethods, ndarray,
};
use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyString;
use raster::Plane;

use crate::arguments::shown;
use crate::errors::{FrameMemoryError, wrong_type, wrong_value};

/// `value` as an array, whatever is in it. `needed` says what would be right.
pub fn array<'a, 'py>(
    name: &str,
    value: &'a Bound<'py, PyAny>,
    needed: &str,
) -> PyResult<&'a Bound<'py, PyUntypedArray>> {
    let Ok(array) = value.cast::<PyUntypedArray>() else {
        let remedy = if value.is_none() {
            format!(
                "{needed}: cv2.imread gives None for a file that it cannot read, hazcam.read_image says why"
            )
        } else if value.is_instance_of::<PyString>() || value.hasattr("__fspath__")? {
            format!("{needed}: hazcam.read_image({name}) or another reader of hazcam's gives one")
        } else {
            format!("{needed}: numpy.asarray({name}) may be one")
        };
        return Err(wrong_type(name, shown(value), remedy));
    };
    // Its copies and views would forget what is masked.
    if value.is_instance(&value.py().import("numpy.ma")?.getattr("MaskedArray")?)? {
        let remedy = format!("{needed}: {name}.filled(...) says what stands where it is masked");
        return Err(wrong_type(name, "a masked array", remedy));
    }
    Ok(array)
}

/// What an array is, in messages: "an array of float32 with shape (3, 4)".
pub fn described(array: &Bound<'_, PyUntypedArray>) -> String {
    let sides: Vec<String> = array.shape().iter().map(usize::to_string).collect();
    let comma = if sides.len() == 1 { "," } else { "" };
    format!("an array of {} with shape ({}{comma})", array.dtype(), sides.join(", "))
}

/// `(rows, columns)` of an array that must have these two dimensions.
pub fn size(
    name: &str,
    array: &Bound<'_, PyUntypedArray>,
    needed: &str,
) -> PyResult<(usize, usize)> {
    match array.shape() {
        &[rows, columns] => Ok((rows, columns)),
        _ => Err(wrong_value(name, described(array), needed)),
    }
}

/// The letter for what kind of samples an array has: `f` floats, `i` and `u` integers, `b` truth values.
pub fn kind(array: &Bound<'_, PyUntypedArray>) -> char {
    char::from(array.dtype().kind())
}

/// Hands all samples on in the order of rows. They are copied before where they do not lie so: strided,
/// in Fortran's order, or off their alignment.
pub fn with_samples<T: Element, U>(
    name: &str,
    array: &Bound<'_, PyArrayDyn<T>>,
    take: impl FnOnce(&[T]) -> PyResult<U>,
) -> PyResult<U> {
    if array.is_c_contiguous()
        && let Ok(samples) = array.try_readonly()?.as_slice()
    {
        return take(samples);
    }
    let copy = copied(name, array.as_untyped(), "copy", "C")?.cast_into::<PyArrayDyn<T>>()?;
    let copy = copy.try_readonly()?;
    take(copy.as_slice()?)
}

/// All samples as our own.
pub fn to_vec<T: Element + Copy>(name: &str, array: &Bound<'_, PyArrayDyn<T>>) -> PyResult<Vec<T>> {
    with_samples(name, array, |samples| owned(name, samples, |sample| sample))
}

/// `samples` as our own, each changed on the way, if there is memory for them.
pub fn owned<T: Copy, U>(
    name: &str,
    samples: &[T],
    change: impl FnMut(T) -> U,
) -> PyResult<Vec<U>> {
    let mut own = Vec::new();
    own.try_reserve_exact(samples.len()).map_err(|_| {
        let bytes = size_of::<U>() as u128 * samples.len() as u128;
        let what = format!("a copy of `{name}` takes {bytes} bytes, for which there is no memory");
        FrameMemoryError::new_err(what)
    })?;
    own.extend(samples.iter().copied().map(change));
    Ok(own)
}

/// A copy that numpy makes, by one of its methods: of a view, which may show few samples many times, it
/// may need more memory than there is.
pub fn copied<'py>(
    name: &str,
    array: &Bound<'py, PyUntypedArray>,
    method: &str,
    argument: &str,
) -> PyResult<Bound<'py, PyAny>> {
    array.call_method1(method, (argument,)).map_err(|error| {
        // The second for more bytes than there are addresses.
        let py = array.py();
        let too_large =
            error.is_instance_of::<PyMemoryError>(py) || error.is_instance_of::<PyValueError>(py);
        if !too_large {
            return error;
        }
        let what = described(array);
        FrameMemoryError::new_err(format!("`{name}` is {what}, for whose copy there is no memory"))
    })
}

/// A plane as an array of rows and columns, which keeps its memory.
pub fn from_plane<'py, T: Element>(py: Python<'py>, plane: Plane<T>) -> Bound<'py, PyArray2<T>> {
    let (columns, rows) = plane.size();
    let array = ndarray::Array2::from_shape_vec((rows, columns), plane.into_samples());
    PyArray2::from_owned_array(py, array.expect("a plane has columns x rows samples"))
}
