//! `hazcam.StereoCamera`: depth and points of all pixels.

use camera::{StereoCamera, middle};
use numpy::{PyArray2, PyArray3, ndarray};
use pyo3::prelude::*;
use raster::Plane;

use crate::arguments::real;
use crate::arrays::from_plane;
use crate::detached::detached;
use crate::errors::of_camera;
use crate::planes::map;

/// A camera from Python.
pub struct Camera {
    /// With 0 where its principal point is not known.
    camera: StereoCamera,
    cx: Option<f64>,
    cy: Option<f64>,
}

impl Camera {
    /// The camera of a map of `(columns, rows)`, which it looks at the middle of unless told otherwise.
    fn of_map(self, size: (usize, usize)) -> StereoCamera {
        let ([x, y], mut camera) = (middle(size), self.camera);
        (camera.cx, camera.cy) = (self.cx.unwrap_or(x), self.cy.unwrap_or(y));
        camera
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
        Ok(Self { camera, cx, cy })
    }
}

/// Raises where the fields make no camera.
#[pyfunction]
pub fn check_camera(camera: Camera) {
    let Camera { .. } = camera;
}

/// Depth in metres of each disparity.
#[pyfunction]
pub fn depth<'py>(
    py: Python<'py>,
    camera: Camera,
    disparity: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let (Camera { camera, .. }, disparities) = (camera, map("disparity", disparity)?);
    let depths = detached(py, || camera.depth_map(&disparities))?;
    Ok(from_plane(py, depths))
}

/// The point that each pixel shows: X, Y, Z in metres.
#[pyfunction]
pub fn points<'py>(
    py: Python<'py>,
    camera: Camera,
    disparity: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let disparities = map("disparity", disparity)?;
    let camera = camera.of_map(disparities.size());
    let points = detached(py, || of_pixels(&camera, &disparities))?;
    Ok(PyArray3::from_owned_array(py, points))
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
