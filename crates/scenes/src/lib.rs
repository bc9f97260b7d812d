//! Rendered stereo pairs with exact ground truth.
//!
//! ```
//! use scenes::{Kind, Settings, render};
//!
//! let mut settings = Settings::new(Kind::Mars, 7); // any seed is a scene of its own
//! (settings.columns, settings.rows) = (120, 90);
//! settings.right_exposure = 0.8;
//! let scene = render(&settings)?;
//! assert_eq!(scene.truth_left.size(), scene.left.size());
//! # Ok::<(), scenes::SettingsError>(())
//! ```
//!
//! A [`Scene`] holds both pictures, the disparity of every pixel of both views, and where matching
//! is hard: occluded, near a depth discontinuity, without texture, thin, of repeated texture. What
//! is random comes from the seed, by whole numbers and by arithmetic that IEEE 754 fixes to the
//! last bit, so that a seed gives the same scene on every machine.
//!
//! | module | question |
//! | --- | --- |
//! | `settings` | what can be asked for |
//! | `kinds` | what stands where: planes, cards, clutter, Mars, a street |
//! | `geometry`, `terrain`, `world` | where a ray meets something first |
//! | `texture`, `noise`, `light` | what it looks like there |
//! | `rig`, `render` | the two cameras; pictures, truth and occlusion |
//! | `masks` | where matching is hard |
//! | `sensor` | from light to numbers: exposure, response, noise, bits |
//! | `catalogue` | the scenes that measurements share |
#![forbid(unsafe_code)]

mod catalogue;
mod geometry;
mod kinds;
mod light;
mod masks;
mod noise;
mod number;
mod random;
mod render;
mod rig;
mod sensor;
mod settings;
mod terrain;
mod texture;
mod vector;
mod world;

pub use catalogue::{demo_scenes, stress_scenes};
pub use kinds::Kind;
pub use masks::{
    DISCONTINUITY_GAP, DISCONTINUITY_WINDOW, TEXTURELESS_THRESHOLD, TEXTURELESS_WINDOW, THIN_WIDTH,
};
pub use random::Random;
pub use render::{OCCLUSION_TOLERANCE, Scene, render};
pub use settings::{Channels, Depth, Settings, SettingsError};
