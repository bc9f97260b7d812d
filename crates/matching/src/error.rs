//! What can go wrong, grouped by who must act: the options, the images, the memory.

use raster::BoundsError;

/// A matcher cannot be built, or cannot answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MatchError {
    /// An option has a value that is not allowed.
    #[error("option `{field}` is {value}, but {allowed}")]
    Option {
        /// The option's name, as in the command line and in TOML.
        field: &'static str,
        /// What it was given.
        value: String,
        /// What is allowed, and the remedy.
        allowed: String,
    },
    /// The two images differ in size.
    #[error(
        "the left image is {left_columns} x {left_rows} but the right one is {right_columns} x \
         {right_rows}: a rectified pair has one size; crop or rectify first"
    )]
    SizesDiffer {
        /// Columns of the left image.
        left_columns: usize,
        /// Rows of the left image.
        left_rows: usize,
        /// Columns of the right image.
        right_columns: usize,
        /// Rows of the right image.
        right_rows: usize,
    },
    /// The images have no pixels.
    #[error("the images have no pixels: at least 1 x 1 is needed")]
    NoPixels,
    /// The box or the range makes no sense for these images.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// The work does not fit the memory that is allowed.
    #[error(
        "this needs {needed} bytes of memory but the limit is {limit}: narrow the disparity \
         range, give a box, or raise the limit"
    )]
    Memory {
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        limit: u64,
    },
}
