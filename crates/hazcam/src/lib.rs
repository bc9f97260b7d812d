//! Dense stereo matching on a CPU: two rectified images in, a disparity map out, scored honestly.
//!
//! This crate only names the parts; each has its own first page:
//!
//! | module | what it is |
//! | --- | --- |
//! | [`raster`] | the arrays that flow between the stages: planes, images, boxes, ranges, maps |
//! | [`matching`] | the matchers `fast`, `balanced` and `best`, arranged by the standard taxonomy |
//! | [`camera`] | disparity to depth and points, and how uncertain they are |
//! | [`formats`] | the files of the stereo community, calibrations too, read strictly and written whole |
//! | [`score`] | a disparity map against ground truth |
//!
//! A disparity `d` says that left `(x, y)` shows what right `(x - d, y)` shows. It is in pixels,
//! and NaN where there is none.
//!
//! ```
//! use hazcam::matching::{Matcher, Options, Preset};
//! use hazcam::raster::{DisparityRange, Image, Plane};
//!
//! // A wall that the right camera sees 3 pixels further left.
//! let texture = |x: usize, y: usize| ((x * x * 7 + x * 13 + y * 31) % 251) as u8;
//! let left = Image::Grey8(Plane::from_fn(64, 32, texture));
//! let right = Image::Grey8(Plane::from_fn(64, 32, |x, y| texture(x + 3, y)));
//!
//! let options = Options::new(Preset::Fast, DisparityRange::new(0, 15)?);
//! let mut matcher = Matcher::new(options)?;
//! let map = matcher.compute(&left, &right, None)?;
//! assert!((map.values.row(16)[32] - 3.0).abs() < 0.5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub use camera;
pub use formats;
pub use matching;
pub use raster;
pub use score;
