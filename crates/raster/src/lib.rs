//! The arrays that flow between the stages of stereo matching.
//!
//! A [`Plane`] is a rectangle of samples in row order. Its columns grow to the right and its rows
//! downwards, so `(x, y) = (0, 0)` is the top-left pixel. An [`Image`] is what a file holds, a
//! [`Grey`] what a matcher looks at, and a [`DisparityMap`] what it answers. All geometry is in
//! pixels of the left image: a disparity `d` says that left `(x, y)` shows what right `(x - d, y)`
//! shows.
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
pub use plane::{Plane, SizeError, View};
