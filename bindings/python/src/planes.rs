//! Maps of disparities and depths, and masks, from numpy arrays.

use numpy::PyArrayDyn;
use pyo3::prelude::*;
use raster::Plane;

use crate::arrays::{array, copied, described, kind, owned, size, to_vec, with_samples};
use crate::errors::{wrong_type, wrong_value};

/// What a map holds.
#[derive(Clone, Copy)]
pub struct Contents {
    numbers: &'static str,
    /// What it must be.
    map: &'static str,
}

pub const DISPARITIES: Contents = Contents {
    numbers: "disparities",
    map: "a map of disparities is a numpy array of numbers with shape (rows, columns), in pixels, NaN where there is \
          none",
};
pub const DEPTHS: Contents = Contents {
    numbers: "depths",
    map: "a map of depths is a numpy array of numbers with shape (rows, columns), in metres, NaN where there is none",
};
const MASK: &str =
    "a mask is a numpy array of bool with shape (rows, columns), True where to score";

/// A map from Python: floats and integers of any size.
pub fn map(name: &str, value: &Bound<'_, PyAny>, contents: Contents) -> PyResult<Plane<f32>> {
    let array = array(name, value, contents.map)?;
    if !matches!(kind(array), 'f' | 'i' | 'u') {
        return Err(wrong_type(name, described(array), contents.map));
    }
    let (rows, columns) = size(name, array, contents.map)?;
    let samples = match array.cast::<PyArrayDyn<f32>>() {
        Ok(samples) => to_vec(name, samples)?,
        Err(_) => {
            let wide = copied(name, array, "astype", "float64")?;
            with_samples(name, wide.cast::<PyArrayDyn<f64>>()?, |samples| {
                narrow(name, columns, samples, contents)
            })?
        }
    };
    Ok(Plane::new(columns, rows, samples).expect("the shape has been looked at"))
}

/// The same in 32 bits.
fn narrow(name: &str, columns: usize, samples: &[f64], contents: Contents) -> PyResult<Vec<f32>> {
    let too_large = |value: &f64| value.is_finite() && value.abs() > f64::from(f32::MAX);
    if let Some(at) = samples.iter().position(too_large) {
        let (x, y, value) = (at % columns, at / columns, samples[at]);
        let what = format!("{value:?} at column {x}, row {y}");
        return Err(wrong_value(name, what, format!("{} must fit float32", contents.numbers)));
    }
    owned(name, samples, |value| value as f32)
}

/// A mask from Python.
pub fn mask(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Plane<bool>> {
    let array = array(name, value, MASK)?;
    let Ok(samples) = array.cast::<PyArrayDyn<bool>>() else {
        let remedy = format!("{MASK}: {name} == 255 makes one of a picture");
        return Err(wrong_type(name, described(array), remedy));
    };
    let (rows, columns) = size(name, array, MASK)?;
    let samples = to_vec(name, samples)?;
    Ok(Plane::new(columns, rows, samples).expect("the shape has been looked at"))
}
