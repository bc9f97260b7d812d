//! The arrays that flow between the stages of stereo matching.
//!
//! A [`Plane`] is a rectangle of samples in row order. Its columns grow to the right and its rows
//! downwards, so `(x, y) = (0, 0)` is the top-left pixel. An [`Image`] is what a file holds, a
//! [`Grey`] what a matcher looks at, and a [`DisparityMap`] what it answers. All geometry is in
//! pixels of the left image: a disparity `d` says that left `(x, y)` shows what right `(x - d, y)`
//! shows.
//!
//! ```
//! use raster::{BoundingBox, Plane, Reason};
//!
//! let plane = Plane::from_fn(4, 3, |x, y| 10 * y + x);
//! assert_eq!((plane.size(), plane.row(2)[1]), ((4, 3), 21));
//! // Columns 1 to 2 and rows 0 to 2: boxes have both ends in them.
//! let bounds = BoundingBox::new(1, 0, 2, 2)?;
//! assert_eq!((bounds.columns(), bounds.rows()), (2, 3));
//! assert!(Reason::OccludedFilled.has_value() && !Reason::OccludedHole.has_value());
//! # Ok::<(), raster::BoundsError>(())
//! ```
//!
//! The crate depends on nothing, holds no algorithm, and contains no `unsafe`.
#![forbid(unsafe_code)]

mod bounds;
mod disparity;
mod image;
mod plane;

pub use bounds::{BoundingBox, BoundsError, DisparityRange};
pub use disparity::{DisparityMap, Reason};
pub use image::{Grey, Image, LUMA};
pub use plane::{Plane, SizeError, StrideError, View};
