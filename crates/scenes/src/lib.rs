//! Rendered stereo pairs with exact ground truth.
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
    DISCONTINUITY_GAP, DISCONTINUITY_WINDOW, TEXTURELESS_THRESHOLD, TEXTURELESS_WINDOW,
};
pub use render::{OCCLUSION_TOLERANCE, Scene, render};
pub use settings::{Channels, Depth, Settings, SettingsError};
