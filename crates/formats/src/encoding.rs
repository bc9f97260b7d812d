//! How a file stands for disparities: the names that data sets, options and records use.

use std::fmt;
use std::str::FromStr;

use crate::FormatError;

/// How the samples of a file become disparities in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Encoding {
    /// By content; what had to be assumed is told in [`ReadDisparity::note`].
    ///
    /// [`ReadDisparity::note`]: crate::ReadDisparity::note
    #[default]
    Auto,
    /// 8-bit grey, disparity = sample / divisor, 0 = none. Middlebury 2003 (Cones, Teddy): 4;
    /// 2005 and 2006: 3 at third, 2 at half, 1 at full size.
    Png8 {
        /// Positive.
        divisor: f32,
    },
    /// 16-bit grey, disparity = sample / divisor, 0 = none. KITTI: 256.
    Png16 {
        /// Positive.
        divisor: f32,
    },
    /// 32-bit floats, not finite = none.
    Pfm,
    /// A NumPy array of numbers, not finite = none.
    Npy,
    /// TIFF of 32-bit floats, not finite = none.
    Tiff,
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Png8 { divisor } => write!(f, "png8/{divisor}"),
            Self::Png16 { divisor } => write!(f, "png16/{divisor}"),
            Self::Pfm => f.write_str("pfm"),
            Self::Npy => f.write_str("npy"),
            Self::Tiff => f.write_str("tiff"),
        }
    }
}

impl FromStr for Encoding {
    type Err = FormatError;

    fn from_str(text: &str) -> Result<Self, FormatError> {
        let wrong = || none(text);
        let parse = |divisor: &str| divisor.parse().map_err(|_| wrong());
        let encoding = match text.split_once('/') {
            Some(("png8", divisor)) => Self::Png8 { divisor: parse(divisor)? },
            Some(("png16", divisor)) => Self::Png16 { divisor: parse(divisor)? },
            Some(_) => return Err(wrong()),
            None => match text {
                "auto" => Self::Auto,
                "pfm" => Self::Pfm,
                "npy" => Self::Npy,
                "tiff" => Self::Tiff,
                _ => return Err(wrong()),
            },
        };
        encoding.check().map_err(|_| wrong())
    }
}

impl Encoding {
    /// Errors when it has a divisor that makes no pixels.
    pub(crate) fn check(self) -> Result<Self, FormatError> {
        match self {
            // The largest sample must be a number of pixels too.
            Self::Png8 { divisor } | Self::Png16 { divisor }
                if !(divisor > 0.0 && (f32::from(u16::MAX) / divisor).is_normal()) =>
            {
                Err(none(&self.to_string()))
            }
            _ => Ok(self),
        }
    }
}

/// The error of what is no encoding.
fn none(text: &str) -> FormatError {
    FormatError::Text {
        text: text.to_owned(),
        what: "an encoding of disparities",
        allowed: "give auto, png8/DIVISOR (png8/4 for Cones and Teddy), png16/DIVISOR \
                  (png16/256 for KITTI), pfm, npy or tiff"
            .to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_survive_a_round_trip() {
        for name in ["auto", "png8/4", "png8/2.5", "png16/256", "pfm", "npy", "tiff"] {
            assert_eq!(name.parse::<Encoding>().unwrap().to_string(), name);
        }
    }

    #[test]
    fn a_divisor_that_makes_no_pixels_is_refused_before_anything_is_read() {
        for divisor in [0.0, -4.0, f32::NAN, f32::INFINITY, 1e-40] {
            for encoding in [Encoding::Png8 { divisor }, Encoding::Png16 { divisor }] {
                let error = crate::read_disparity("missing.png", encoding).unwrap_err();
                assert!(error.to_string().contains(&format!("{encoding}` is not an encoding")));
            }
        }
    }

    #[test]
    fn a_scale_must_be_said_and_be_positive() {
        for text in [
            "png8",
            "png16",
            "png8/0",
            "png8/-4",
            "png8/x",
            "png8/inf",
            "png8/1e-38",
            "PFM",
            "",
            "pfm/1",
        ] {
            let error = text.parse::<Encoding>().unwrap_err().to_string();
            assert!(error.contains(text) && error.contains("png8/4"), "{error}");
        }
    }
}
