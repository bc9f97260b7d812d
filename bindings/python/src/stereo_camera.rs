//! `hazcam.StereoCamera`: depth and points of all pixels.

use camera::{StereoCamera, middle, too_large};
use numpy::{PyArray2, PyArray3, ndarray};
use pyo3::prelude::*;
use raster::Plane;

use crate::arguments::{count, real, shown};
use crate::arrays::from_plane;
use crate::detached::detached;
use crate::errors::{of_camera, wrong_value};
use crate::planes::{DEPTHS, DISPARITIES, map};

/// `(focal_px, baseline_m, doffs, cx, cy)`.
pub type Numbers = (f64, f64, f64, f64, f64);

/// Those of a camera.
pub fn numbers(camera: &StereoCamera) -> Numbers {
    let StereoCamera { focal_px, baseline_m, doffs, cx, cy, .. } = *camera;
    (focal_px, baseline_m, doffs, cx, cy)
}

/// A camera from Python.
pub struct Camera {
    /// With 0 where its principal point is not known.
    camera: StereoCamera,
    cx: Option<f64>,
    cy: Option<f64>,
    /// Columns and rows of its images.
    size: Option<(usize, usize)>,
}

impl Camera {
    /// The camera of a map of `(columns, rows)`, which it looks at the middle of unless told otherwise.
    fn of_map(&self, size: (usize, usize)) -> PyResult<StereoCamera> {
        if let Some((columns, rows)) = self.size
            && size != (columns, rows)
        {
            let what = format!("a map of {} rows x {} columns", size.1, size.0);
            let allowed = format!(
                "the camera's images have {rows} rows x {columns} columns: camera.scaled({}) is that of images as wide \
                 as the map, and of a part of an image say cx, cy and size",
                size.0 as f64 / columns as f64
            );
            return Err(wrong_value("disparity", what, allowed));
        }
        let ([x, y], mut camera) = (middle(size), self.camera);
        (camera.cx, camera.cy) = (self.cx.unwrap_or(x), self.cy.unwrap_or(y));
        Ok(camera)
    }
}

impl<'py> FromPyObject<'_, 'py> for Camera {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let number = |field: &str| real(field, &value.getattr(field)?);
        let (focal_px, baseline_m) = (number("focal_px")?, number("baseline_m")?);
        let known = |field: &str| {
            let absent = value.getattr(field)?.is_none();
            (!absent).then(|| number(field)).transpose()
        };
        let (doffs, cx, cy) = (number("doffs")?, known("cx")?, known("cy")?);
        let [x, y] = [cx, cy].map(Option::unwrap_or_default);
        let camera = StereoCamera::new(focal_px, baseline_m, doffs, x, y).map_err(of_camera)?;
        let size = size(&value.getattr("size")?)?;
        Ok(Self { camera, cx, cy, size })
    }
}

/// `(columns, rows)` of images, or `None`.
fn size(value: &Bound<'_, PyAny>) -> PyResult<Option<(usize, usize)>> {
    if value.is_none() {
        return Ok(None);
    }
    let allowed = "it must be (columns, rows) of the camera's images, each at least 1";
    let wrong = || wrong_value("size", shown(value), allowed);
    let [columns, rows]: [Bound<'_, PyAny>; 2] = value.extract().map_err(|_| wrong())?;
    let [columns, rows] = [columns, rows].map(|side| count("size", &side, allowed));
    match (columns?, rows?) {
        (Some(columns), Some(rows)) if columns > 0 && rows > 0 => Ok(Some((columns, rows))),
        _ => Err(wrong()),
    }
}

/// Raises where the fields make no camera; says what is unusual about them.
#[pyfunction]
pub fn check_camera(camera: Camera) -> Option<String> {
    camera.camera.doubt()
}

/// The numbers of the camera at another scale.
#[pyfunction]
pub fn scaled(camera: Camera, times: &Bound<'_, PyAny>) -> PyResult<Numbers> {
    let times = real("times", times)?;
    if !(times.is_finite() && times > 0.0) {
        return Err(wrong_value("times", times, "it must be finite and positive"));
    }
    camera.camera.scaled(times).map(|camera| numbers(&camera)).map_err(of_camera)
}

/// By how much depths in metres are off where disparities are off by so many pixels.
#[pyfunction]
pub fn depth_uncertainty<'py>(
    py: Python<'py>,
    camera: Camera,
    depth: &Bound<'py, PyAny>,
    disparity_error: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let error = real("disparity_error", disparity_error)?;
    if !(error.is_finite() && error > 0.0) {
        return Err(wrong_value(
            "disparity_error",
            error,
            "it must be finite and positive, in pixels",
        ));
    }
    let depths = map("depth", depth, DEPTHS)?;
    let off = detached(py, || camera.camera.depth_uncertainty_map(&depths, error))?;
    Ok(from_plane(py, off))
}

fn doubts(camera: &StereoCamera, disparities: &Plane<f32>) -> Vec<String> {
    [too_large(disparities), camera.doubt_of(disparities)].into_iter().flatten().collect()
}

/// Depth in metres of each disparity, and what is doubtful about these.
#[pyfunction]
pub fn depth<'py>(
    py: Python<'py>,
    camera: Camera,
    disparity: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyArray2<f32>>, Vec<String>)> {
    let disparities = map("disparity", disparity, DISPARITIES)?;
    let of_map = camera.of_map(disparities.size())?;
    let (depths, doubts) =
        detached(py, || (of_map.depth_map(&disparities), doubts(&of_map, &disparities)))?;
    Ok((from_plane(py, depths), doubts))
}

/// The point that each pixel shows, X, Y, Z in metres, and what is doubtful about its disparities.
#[pyfunction]
pub fn points<'py>(
    py: Python<'py>,
    camera: Camera,
    disparity: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyArray3<f32>>, Vec<String>)> {
    let disparities = map("disparity", disparity, DISPARITIES)?;
    let of_map = camera.of_map(disparities.size())?;
    let (points, doubts) =
        detached(py, || (of_pixels(&of_map, &disparities), doubts(&of_map, &disparities)))?;
    Ok((PyArray3::from_owned_array(py, points), doubts))
}

/// NaN three times where a pixel has no depth ([`StereoCamera::depth_map`]).
fn of_pixels(camera: &StereoCamera, disparities: &Plane<f32>) -> ndarray::Array3<f32> {
    let depths = camera.depth_map(disparities);
    let (columns, rows) = depths.size();
    let mut points = Vec::with_capacity(columns * rows);
    let pixels = camera.points(disparities, &depths);
    points.extend(pixels.map(|point| point.unwrap_or([f32::NAN; 3])));
    let shape = (rows, columns, 3);
    ndarray::Array3::from_shape_vec(shape, points.into_flattened()).expect("three for each pixel")
}
