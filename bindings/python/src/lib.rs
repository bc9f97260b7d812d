//! The part of the Python package `hazcam` that is not Python: arrays in, the crates' work without the
//! interpreter's lock, arrays out.
//!
//! What Python programmers meet, with its types and documentation, is in `python/hazcam`; it hands its
//! arguments on as they come. They are checked here, each by its name in Python, so that every wrong one
//! is answered by an exception of `hazcam.errors` that says what it is, what is allowed, and the remedy.

mod arguments;
mod arrays;
mod detached;
mod doubts;
mod errors;
mod files;
mod images;
mod matcher;
mod planes;
mod scores;
mod stereo_camera;

#[pyo3::pymodule]
mod _hazcam {
    use pyo3::prelude::*;
    use pyo3::types::PyDict;

    #[pymodule_export]
    use crate::files::{read_calibration, read_disparity, read_image, write_disparity};
    #[pymodule_export]
    use crate::matcher::Matcher;
    #[pymodule_export]
    use crate::scores::score_map;
    #[pymodule_export]
    use crate::stereo_camera::{check_camera, depth, depth_uncertainty, points, scaled};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("FARTHEST", matching::Options::FARTHEST)?;
        module.add("MOST_PIXELS", matching::MOST_PIXELS)?;
        // For the test that `hazcam.Reason` has them all.
        let reasons = PyDict::new(module.py());
        for reason in raster::Reason::ALL {
            reasons.set_item(reason.name(), reason as u8)?;
        }
        module.add("REASONS", reasons)
    }
}
