//! The files of the stereo community, read strictly and written whole.
#![forbid(unsafe_code)]

mod atomic;
mod disparity;
mod encoding;
mod error;
mod image;
mod jpeg;
mod netpbm;
pub mod npy;
mod pfm;
mod png;
mod pnm;
mod source;
mod tiff;

pub use atomic::write_atomically;
pub use disparity::{ReadDisparity, implausible_scale, read_disparity, write_disparity};
pub use encoding::Encoding;
pub use error::FormatError;
pub use image::{read_image, write_image};
pub use source::{Container, MAX_FILE_BYTES, MAX_PIXELS};
