//! Dense stereo matching, arranged by the taxonomy of Scharstein & Szeliski (IJCV 2002).
//!
//! A pair of rectified images goes through the stages in this order; each folder is one stage and
//! each file in it one method:
//!
//! | stage | what it does |
//! | --- | --- |
//! | `prepare` | grey images and their noise, vertical disparity taken out, census words, descriptors: what costs are computed from |
//! | `cost` | how badly left `(x, y)` and right `(x - d, y)` fit, per disparity `d` |
//! | `aggregation` | costs summed over a support region |
//! | `optimization` | a disparity per pixel that is also smooth: paths, planes |
//! | `selection` | the winner, its fraction of a pixel, and the check against the right view |
//! | `refinement` | outliers out, occlusions filled, edges sharpened, confidence |
//!
//! The taxonomy has four stages: `prepare` comes before its first one, and `selection` is the end of its third
//! (winner takes all) and the beginning of its fourth (fractions of a pixel, cross-checking).
//!
//! A *preset* strings stages together for one purpose: [`Preset::Fast`], [`Preset::Balanced`],
//! [`Preset::Best`]. `kernels` holds what must be quick. What looks wrong about images and answers, though no rule was
//! broken, [`image_doubts`] and [`doubts`] tell.
//!
//! ```
//! use matching::{Matcher, Options, Preset};
//! use raster::{DisparityRange, Image, Plane};
//!
//! // A ramp that the right camera sees 2 pixels further left.
//! let texture = |x: usize| ((x * x * 7 + x * 13) % 251) as u8;
//! let left = Image::Grey8(Plane::from_fn(40, 20, |x, _| texture(x)));
//! let right = Image::Grey8(Plane::from_fn(40, 20, |x, _| texture(x + 2)));
//!
//! let range = DisparityRange::new(0, 8)?;
//! let mut matcher = Matcher::new(Options::new(Preset::Fast, range))?;
//! let map = matcher.compute(&left, &right, None)?;
//! assert!((map.values.row(10)[20] - 2.0).abs() < 0.5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// What a frame takes is reckoned in bytes, which may be more than 32 bits count: it would be admitted by mistake.
#[cfg(not(target_pointer_width = "64"))]
compile_error!("hazcam needs a processor and a system of 64 bits");

mod aggregation;
mod allowance;
#[cfg(test)]
mod chance;
mod cost;
mod doubt;
mod error;
mod ingredient;
mod kernels;
mod limits;
mod machine;
mod matcher;
mod optimization;
mod options;
mod prepare;
mod presets;
mod profile;
mod refinement;
mod selection;
mod threads;
#[doc(hidden)]
pub mod training;

pub use doubt::{Doubt, ImageDoubt, doubts, few_bits, image_doubts};
pub use error::MatchError;
pub use ingredient::Ingredient;
pub use kernels::level::Level;
pub use limits::Limits;
pub use machine::memory_bound;
pub use matcher::Matcher;
pub use options::{Holes, Options, Preset};
pub use prepare::alignment::VerticalDisparity;
pub use profile::Stage;

/// The most pixels that an image may have: more are answered by [`MatchError::TooLarge`].
pub const MOST_PIXELS: usize = refinement::groups::LARGEST;
/// The most columns that an image may have: more are answered by [`MatchError::TooWide`]. Fractions of a column
/// are told in 32 bits.
pub const MOST_COLUMNS: usize = 1 << 22;
