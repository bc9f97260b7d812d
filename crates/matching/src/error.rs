//! What can go wrong, grouped by who must act: the options, the images, the memory.

use raster::BoundsError;

/// A matcher cannot be built, or cannot answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MatchError {
    /// An option has a value that is not allowed.
    #[error("option `{field}` is {value}, but {allowed}")]
    Option {
        /// Its name on the command line, or that of an environment variable (`HAZCAM_CPU`).
        field: &'static str,
        /// What it was given.
        value: String,
        /// What is allowed, and the remedy.
        allowed: String,
    },
    /// The two images differ in size.
    #[error(
        "the left image is {left_columns} x {left_rows} but the right one is {right_columns} x \
         {right_rows}: a rectified pair has one size; rectify first, crop, or take both at one resolution"
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
    /// The two images are not both grey or both colour, or not as deep.
    #[error(
        "the left image is {left}, but the right one is {right}: a pair is of one kind; read both alike, or make \
         both grey"
    )]
    KindsDiffer {
        /// What the left image is ([`raster::Image::kind`]).
        left: &'static str,
        /// What the right one is.
        right: &'static str,
    },
    /// The images have no pixels.
    #[error("the images have no pixels: at least 1 x 1 is needed")]
    NoPixels,
    /// The box or the range makes no sense for these images.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// Whatever the pixel, its match would lie outside the images.
    #[error(
        "disparities {min} to {max} lie outside images of {columns} columns: nothing could be matched; give a smallest \
         and a largest one {}",
        match columns - 1 {
            0 => "of 0".to_owned(),
            last => format!("within -{last} to {last}"),
        }
    )]
    RangeOutside {
        /// The smallest disparity.
        min: i32,
        /// The largest.
        max: i32,
        /// Columns of either image, at least 1.
        columns: usize,
    },
    /// The images have more pixels than can be counted.
    #[error(
        "the images have {columns} x {rows} pixels, but at most {limit} can be matched at a time: \
         cut them into tiles"
    )]
    TooLarge {
        /// Columns of either image.
        columns: usize,
        /// Rows of either image.
        rows: usize,
        /// Pixels allowed.
        limit: usize,
    },
    /// The images are wider than places in them can be told to fractions of a pixel.
    #[error(
        "the images are {columns} columns wide, but at most {limit} can be matched: cut them into tiles"
    )]
    TooWide {
        /// Columns of either image.
        columns: usize,
        /// Columns allowed.
        limit: usize,
    },
    /// The work does not fit the memory that is allowed.
    #[error(
        "`memory` is {} MB, but {columns} x {rows} pixels and {disparities} disparities need \
         at least {} MB: allow that much, narrow the range, or match a box",
        *limit as f64 / 1e6,
        needed.div_ceil(1_000_000)
    )]
    Memory {
        /// Columns of either image.
        columns: usize,
        /// Rows of either image.
        rows: usize,
        /// Disparities asked for.
        disparities: usize,
        /// Bytes needed.
        needed: usize,
        /// Bytes allowed.
        limit: usize,
    },
    /// The work does not fit the memory that the machine has, or that is left of what a process may
    /// take.
    #[error(
        "{columns} x {rows} pixels and {disparities} disparities need at least {} MB, but {}",
        needed.div_ceil(1_000_000),
        too_little(*there, *bound)
    )]
    MachineMemory {
        /// Columns of either image.
        columns: usize,
        /// Rows of either image.
        rows: usize,
        /// Disparities asked for.
        disparities: usize,
        /// Bytes needed.
        needed: usize,
        /// Bytes that there are for it: of the machine with swap, or what is left of the bound.
        there: usize,
        /// Bytes that the process is bounded to, if it is: by a control group (a container, a service), or
        /// by `ulimit`.
        bound: Option<usize>,
    },
}

/// What there is instead of what a frame needs, and what can be done.
fn too_little(there: usize, bound: Option<usize>) -> String {
    let there = there / 1_000_000;
    match bound {
        None => format!("this machine has {there} MB: narrow the range, or match a box"),
        Some(bound) => format!(
            "of the {} MB that this process may take {there} MB are left for that: raise the limit of \
             its container, service or shell (ulimit), use fewer threads, narrow the range, or match a box",
            bound / 1_000_000
        ),
    }
}
