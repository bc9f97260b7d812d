//! Numbers, names, boxes and paths from Python, each with an error that names it.

use std::path::PathBuf;

use matching::{Holes, Ingredient, Options};
use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFrozenSet, PySet, PyString};
use raster::{BoundingBox, DisparityRange};

use crate::errors::{about, of_matching, wrong_type, wrong_value};

/// The most characters of a value that stand in a message.
const SHOWN: usize = 60;

/// A value and its type in a message, on one line.
pub fn shown(value: &Bound<'_, PyAny>) -> String {
    let text = value.repr().map_or_else(|_| "something".into(), |text| text.to_string());
    let mut words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if let Some((end, _)) = words.char_indices().nth(SHOWN) {
        words.truncate(end);
        words.push_str("...");
    }
    format!("{words} ({})", type_name(value))
}

/// The name of a value's type.
pub fn type_name(value: &Bound<'_, PyAny>) -> String {
    value.get_type().name().map_or_else(|_| "of an unknown type".into(), |name| name.to_string())
}

/// Why a value is no whole number of 64 bits.
enum NoInteger {
    TooLarge,
    WrongType,
}

/// An `int`, or one of numpy's; truth values are none.
fn integer(value: &Bound<'_, PyAny>) -> Result<i64, NoInteger> {
    if value.is_instance_of::<PyBool>() {
        return Err(NoInteger::WrongType);
    }
    value.extract().map_err(|error: PyErr| {
        let is_too_large = error.is_instance_of::<PyOverflowError>(value.py());
        if is_too_large { NoInteger::TooLarge } else { NoInteger::WrongType }
    })
}

/// A whole number.
fn whole(name: &str, value: &Bound<'_, PyAny>, allowed: &str) -> PyResult<i64> {
    integer(value).map_err(|error| match error {
        NoInteger::TooLarge => wrong_value(name, shown(value), allowed),
        NoInteger::WrongType => {
            let is_finite = value.extract().is_ok_and(f64::is_finite);
            let is_number = is_finite && !value.is_instance_of::<PyBool>();
            let remedy = if is_number { format!("; int({name}) is one") } else { String::new() };
            wrong_type(name, shown(value), format!("a whole number is needed: {allowed}{remedy}"))
        }
    })
}

/// A disparity of the range that is searched.
pub fn disparity(name: &str, value: &Bound<'_, PyAny>) -> PyResult<i32> {
    let farthest = Options::FARTHEST;
    let allowed = format!("it must be from -{farthest} to {farthest} pixels");
    let number = whole(name, value, &allowed)?;
    i32::try_from(number).map_err(|_| wrong_value(name, number, allowed))
}

/// All disparities that are searched.
pub fn range(max: &Bound<'_, PyAny>, min: &Bound<'_, PyAny>) -> PyResult<DisparityRange> {
    let (max, min) = (disparity("max_disparity", max)?, disparity("min_disparity", min)?);
    DisparityRange::new(min, max).map_err(|_| {
        wrong_value("max_disparity", max, format!("it must not be below `min_disparity`, {min}"))
    })
}

/// How many there may be of something, `None` as it is.
pub fn count(name: &str, value: &Bound<'_, PyAny>, allowed: &str) -> PyResult<Option<usize>> {
    if value.is_none() {
        return Ok(None);
    }
    let number = whole(name, value, allowed)?;
    usize::try_from(number).map(Some).map_err(|_| wrong_value(name, number, allowed))
}

/// A number with its fraction; truth values are none.
pub fn real(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let needed = "a number is needed";
    if value.is_instance_of::<PyBool>() {
        return Err(wrong_type(name, shown(value), needed));
    }
    value.extract().map_err(|error: PyErr| {
        match error.is_instance_of::<PyOverflowError>(value.py()) {
            true => wrong_value(name, shown(value), "it must fit a float of 64 bits"),
            false => wrong_type(name, shown(value), needed),
        }
    })
}

/// A text.
pub fn text(name: &str, value: &Bound<'_, PyAny>, allowed: &str) -> PyResult<String> {
    let text = value.cast::<PyString>().map_err(|_| wrong_type(name, shown(value), allowed))?;
    // Half of a surrogate pair is no text, but a `str` holds it.
    text.extract().map_err(|_| wrong_value(name, shown(value), allowed))
}

/// What becomes of pixels without a trustworthy match.
pub fn holes(value: &Bound<'_, PyAny>) -> PyResult<Holes> {
    let allowed = "it must be 'fill' or 'keep'";
    match text("holes", value, allowed)?.as_str() {
        "fill" => Ok(Holes::Fill),
        "keep" => Ok(Holes::Keep),
        other => Err(wrong_value("holes", format!("`{other}`"), allowed)),
    }
}

/// What a preset is to do without.
pub fn without(value: &Bound<'_, PyAny>) -> PyResult<Vec<Ingredient>> {
    let allowed = "a sequence of names is needed: ('median',) for one";
    let wrong = || wrong_type("without", shown(value), allowed);
    if value.is_instance_of::<PyString>() {
        return Err(wrong());
    }
    let mut without = Vec::new();
    for name in value.try_iter().map_err(|_| wrong())? {
        let ingredient = text("without", &name?, allowed)?.parse().map_err(of_matching)?;
        if !without.contains(&ingredient) {
            without.push(ingredient);
        }
        // An iterator may go on for ever.
        value.py().check_signals()?;
    }
    Ok(without)
}

/// `(x0, y0, x1, y1)`, inclusive, or `None` for the whole image.
pub fn bounding_box(value: &Bound<'_, PyAny>) -> PyResult<Option<BoundingBox>> {
    if value.is_none() {
        return Ok(None);
    }
    let needed = "four whole numbers (x0, y0, x1, y1) are needed, first column and row, last column and \
                  row, all part of the box; the course's [[x0, x1], [y0, y1]] is for hazcam.course";
    let wrong = || wrong_type("box", shown(value), needed);
    if value.is_instance_of::<PySet>() || value.is_instance_of::<PyFrozenSet>() {
        // They have no order.
        return Err(wrong());
    }
    let mut sides = Vec::new();
    // One more than are needed: an iterator may go on for ever.
    for side in value.try_iter().map_err(|_| wrong())?.take(5) {
        sides.push(integer(&side?).map_err(|error| match error {
            NoInteger::TooLarge => {
                wrong_value("box", shown(value), "its sides must be columns and rows of the image")
            }
            NoInteger::WrongType => wrong(),
        })?);
    }
    let &[x0, y0, x1, y1] = &sides[..] else { return Err(wrong()) };
    let side = |side| {
        let allowed = "its sides must be 0 or more: they count columns and rows from the top left";
        usize::try_from(side).map_err(|_| wrong_value("box", shown(value), allowed))
    };
    let bounds = BoundingBox::new(side(x0)?, side(y0)?, side(x1)?, side(y1)?);
    bounds.map(Some).map_err(|error| about("box", error))
}

/// The path of a file: a `str` or an `os.PathLike`.
pub fn path(name: &str, value: &Bound<'_, PyAny>) -> PyResult<PathBuf> {
    let path = value.extract();
    path.map_err(|_| wrong_type(name, shown(value), "a path is needed: a str or a pathlib.Path"))
}
