//! Files in, files out.

use formats::{Encoding, FormatError};
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::arguments::{path, text};
use crate::arrays::from_plane;
use crate::detached::detached;
use crate::errors::{about, of_file, wrong_value};
use crate::images::from_image;
use crate::planes::{DISPARITIES, map};
use crate::stereo_camera::{Numbers, numbers};

/// A picture as an array, and what else its file holds, of which nothing is made.
#[pyfunction]
pub fn read_image<'py>(
    py: Python<'py>,
    path: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyAny>, Vec<String>)> {
    let path = self::path("path", path)?;
    let read = detached(py, || formats::read_image_and_bytes(path))?;
    let (image, bytes) = read.map_err(of_file)?;
    Ok((from_image(py, image), formats::unused(&bytes)))
}

/// A map of disparities, and what had to be assumed.
#[pyfunction]
pub fn read_disparity<'py>(
    py: Python<'py>,
    path: &Bound<'py, PyAny>,
    encoding: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyArray2<f32>>, Option<String>)> {
    let path = self::path("path", path)?;
    let allowed = "give 'auto', 'png8/4', 'png16/256', 'pfm', 'npy' or 'tiff'";
    let encoding: Encoding = text("encoding", encoding, allowed)?
        .parse()
        .map_err(|error: FormatError| about("encoding", error))?;
    let read = detached(py, || formats::read_disparity(path, encoding))?.map_err(of_file)?;
    Ok((from_plane(py, read.values), read.note))
}

/// Writes a map of disparities, its format by extension, whole or not at all.
#[pyfunction]
pub fn write_disparity(
    py: Python<'_>,
    path: &Bound<'_, PyAny>,
    disparity: &Bound<'_, PyAny>,
) -> PyResult<()> {
    let (path, values) = (self::path("path", path)?, map("disparity", disparity, DISPARITIES)?);
    if values.samples().is_empty() {
        let (columns, rows) = values.size();
        let what = format!("a map of {rows} rows x {columns} columns");
        return Err(wrong_value("disparity", what, "at least 1 x 1 is needed"));
    }
    detached(py, || formats::write_disparity(path, &values))?.map_err(of_file)
}

/// A camera, `(columns, rows)` of its images if the file says it, and what is doubtful about it.
type Calibrated = (Numbers, Option<(usize, usize)>, Option<String>);

/// `(focal_px, baseline_m, doffs, cx, cy)` of the pair that a left image belongs to, and the columns and rows of its
/// images where the file says them.
#[pyfunction]
pub fn read_calibration(
    py: Python<'_>,
    path: &Bound<'_, PyAny>,
    left: &Bound<'_, PyAny>,
) -> PyResult<Calibrated> {
    let path = self::path("path", path)?;
    let left = (!left.is_none()).then(|| self::path("left", left)).transpose()?;
    let read = detached(py, || formats::read_calibration(path))?.map_err(of_file)?;
    let (camera, doubt) = left.map_or((read.camera, None), |left| read.camera_of(left));
    Ok((numbers(&camera), read.width.zip(read.height), doubt))
}
