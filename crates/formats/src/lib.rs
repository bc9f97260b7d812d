//! The files of the stereo community, read strictly and written whole.
#![forbid(unsafe_code)]

mod atomic;
mod bounding_box;
mod calibration;
mod disparity;
mod encoding;
mod error;
mod image;
mod inspect;
mod jpeg;
mod mask;
mod netpbm;
pub mod npy;
mod pfm;
pub mod picture;
mod png;
mod pnm;
mod source;
mod tiff;

pub use atomic::write_atomically;
pub use bounding_box::{parse_bounding_box, read_bounding_box};
pub use calibration::{Calibration, CalibrationLayout, read_calibration};
pub use disparity::{ReadDisparity, implausible_scale, read_disparity, write_disparity};
pub use encoding::Encoding;
pub use error::FormatError;
pub use image::{read_image, write_image};
pub use inspect::{DisparityReading, FileContent, FileInfo, Statistics, inspect, inspect_bytes};
pub use mask::read_mask;
pub use source::{Container, MAX_FILE_BYTES, MAX_PIXELS};
