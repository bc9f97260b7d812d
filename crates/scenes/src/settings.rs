//! What to render: the kind of scene, its seed, and the two cameras.

use raster::DisparityRange;

use crate::kinds::Kind;

/// Largest width and height in pixels.
pub(crate) const LARGEST_SIDE: usize = 16_384;
/// Largest number of pixels per image, so that a pair with its masks stays within a few gigabytes.
pub(crate) const LARGEST_AREA: usize = 64 << 20;
/// Largest absolute disparity in pixels.
pub(crate) const LARGEST_DISPARITY: i32 = 8_192;

/// Grey or red, green, blue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Channels {
    /// One channel: ITU-R BT.601 luma of what a colour camera would see.
    Grey,
    /// Red, green, blue.
    Colour,
}

/// Bits per sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Depth {
    /// 0 to 255.
    Eight,
    /// 0 to 65535.
    Sixteen,
}

/// What to render. Built by [`Settings::new`], then changed field by field.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// Which kind of scene.
    pub kind: Kind,
    /// Where everything random comes from; every seed is another scene.
    pub seed: u64,
    /// Width of both images in pixels, 1 to 16384.
    pub columns: usize,
    /// Height of both images in pixels, 1 to 16384; at most 64 Mi pixels in all.
    pub rows: usize,
    /// Disparity of points at infinity, in pixels, -8192 to 8192: the right camera's principal
    /// point is shifted by as much. For a [`Kind::Plane`], which has cameras of its own, only a bound.
    pub min_disparity: i32,
    /// No visible point has a larger disparity, in pixels; from `min_disparity` to 8192. The
    /// baseline follows from it. With both equal, the two cameras stand at one place.
    pub max_disparity: i32,
    /// Grey or colour.
    pub channels: Channels,
    /// 8 or 16 bits per sample.
    pub depth: Depth,
    /// Factor on the light that reaches both cameras, 0 to 64; 1 is a well exposed picture, 4 and
    /// more saturate.
    pub exposure: f64,
    /// Contrast of all textures, 0 (every surface has one colour, only shading is left) to 1.
    pub contrast: f64,
    /// Standard deviation of the sensor noise in both images, in grey levels of 255, 0 to 128.
    pub noise: f64,
    /// Factor on the light that reaches the right camera on top of `exposure`, 0 to 64.
    pub right_exposure: f64,
    /// Exponent on the right camera's grey values (on the scale 0 to 1), 0.1 to 10.
    pub right_gamma: f64,
    /// Factor on the right camera's grey values after `right_gamma`, 0 to 64.
    pub right_gain: f64,
    /// How many rows lower than in the left image things stand in the right one, in pixels, -64
    /// to 64. A rectified pair has 0.
    pub vertical_offset: f64,
}

/// A setting that cannot be rendered.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the scene's `{field}` is {value}, but {allowed}")]
pub struct SettingsError {
    /// The setting's name.
    pub field: &'static str,
    /// What it was given.
    pub value: String,
    /// What is allowed.
    pub allowed: String,
}

impl SettingsError {
    pub(crate) fn new(
        field: &'static str,
        value: impl ToString,
        allowed: impl Into<String>,
    ) -> Self {
        Self { field, value: value.to_string(), allowed: allowed.into() }
    }
}

impl Settings {
    /// A colour pair of 450 x 375 pixels at 8 bit, disparities 0 to 64, noise of one grey level,
    /// two equal and well aligned cameras.
    pub fn new(kind: Kind, seed: u64) -> Self {
        Self {
            kind,
            seed,
            columns: 450,
            rows: 375,
            min_disparity: 0,
            max_disparity: 64,
            channels: Channels::Colour,
            depth: Depth::Eight,
            exposure: 1.0,
            contrast: 1.0,
            noise: 1.0,
            right_exposure: 1.0,
            right_gamma: 1.0,
            right_gain: 1.0,
            vertical_offset: 0.0,
        }
    }

    /// The name of the scene: its kind and seed, good for a folder's name.
    pub fn name(&self) -> String {
        let kind = self.kind.to_string().replace(':', "-").replace(',', "_");
        format!("{kind}-{}", self.seed)
    }

    /// The disparities that the scene may hold. Errors when it is empty.
    pub fn range(&self) -> Result<DisparityRange, SettingsError> {
        DisparityRange::new(self.min_disparity, self.max_disparity).map_err(|_| {
            SettingsError::new(
                "max_disparity",
                self.max_disparity,
                format!("it must be at least min_disparity, which is {}", self.min_disparity),
            )
        })
    }

    /// Errors at the first setting that cannot be rendered.
    pub fn check(&self) -> Result<(), SettingsError> {
        for (field, value) in [("columns", self.columns), ("rows", self.rows)] {
            if value == 0 || value > LARGEST_SIDE {
                let allowed = format!("it must be from 1 to {LARGEST_SIDE} pixels");
                return Err(SettingsError::new(field, value, allowed));
            }
        }
        if self.columns * self.rows > LARGEST_AREA {
            return Err(SettingsError::new(
                "rows",
                self.rows,
                format!(
                    "at {} columns it must be at most {}, since an image has at most \
                     {LARGEST_AREA} pixels",
                    self.columns,
                    LARGEST_AREA / self.columns
                ),
            ));
        }
        for (field, value) in
            [("min_disparity", self.min_disparity), ("max_disparity", self.max_disparity)]
        {
            if !(-LARGEST_DISPARITY..=LARGEST_DISPARITY).contains(&value) {
                let allowed =
                    format!("it must be from -{LARGEST_DISPARITY} to {LARGEST_DISPARITY} pixels");
                return Err(SettingsError::new(field, value, allowed));
            }
        }
        self.range()?;
        for (field, value, low, high) in [
            ("exposure", self.exposure, 0.0, 64.0),
            ("contrast", self.contrast, 0.0, 1.0),
            ("noise", self.noise, 0.0, 128.0),
            ("right_exposure", self.right_exposure, 0.0, 64.0),
            ("right_gamma", self.right_gamma, 0.1, 10.0),
            ("right_gain", self.right_gain, 0.0, 64.0),
            ("vertical_offset", self.vertical_offset, -64.0, 64.0),
        ] {
            // A NaN is in no range.
            if !(low..=high).contains(&value) {
                let allowed = format!("it must be from {low} to {high}");
                return Err(SettingsError::new(field, value, allowed));
            }
        }
        self.kind.check(self)
    }
}
