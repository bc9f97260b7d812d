//! What a rectified stereo camera knows about the world: disparity to depth and back.
//!
//! The model is two pinhole cameras with the same focal length, their image planes in one plane
//! and their rows aligned; the right camera stands `baseline_m` to the right of the left one. All
//! coordinates are those of the left camera: X to the right, Y down, Z forward, in metres; pixel
//! centres lie at whole numbers.
#![forbid(unsafe_code)]

mod doubt;
mod stereo;

pub use doubt::{too_large, widest};
pub use stereo::{CameraError, DISPARITY_ERROR, StereoCamera, middle};
