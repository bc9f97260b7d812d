//! Colours for numbers from 0 to 1.

use std::fmt;
use std::str::FromStr;

use crate::FormatError;

/// A way from 0 to 1 in colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColourMap {
    /// Dark blue over green to dark red, smooth to the eye: A. Mikhailov, *Turbo, An Improved
    /// Rainbow Colormap for Visualization*, Google AI Blog 2019, in R. Du's polynomial form.
    #[default]
    Turbo,
    /// KITTI's table for disparities: black, blue, red, magenta, green, cyan, yellow, white.
    Kitti,
    /// Almost black to white.
    Grey,
}

impl ColourMap {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Turbo, Self::Kitti, Self::Grey];

    /// The colour of a number; below 0 and above 1 it is that of the end, NaN counts as 0.
    pub fn colour(self, value: f32) -> [u8; 3] {
        let t = if value > 0.0 { value.min(1.0) } else { 0.0 };
        match self {
            Self::Turbo => TURBO.map(|curve| byte(polynomial(&curve, t))),
            Self::Kitti => kitti(t),
            // Black is for pixels without a value.
            Self::Grey => [(1.0 + t * 254.0).round() as u8; 3],
        }
    }
}

/// Coefficients for red, green, blue, the constant one first.
const TURBO: [[f32; 6]; 3] = [
    [0.13572138, 4.6153926, -42.660324, 132.13109, -152.94239, 59.28638],
    [0.09140261, 2.1941884, 4.8429666, -14.185033, 4.2772985, 2.829566],
    [0.1066733, 12.641946, -60.582047, 110.36277, -89.9031, 27.34825],
];

fn polynomial(coefficients: &[f32], t: f32) -> f32 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * t + c)
}

fn byte(value: f32) -> u8 {
    (value * 255.0).round().clamp(0.0, 255.0) as u8
}

/// Corners of the colour cube and, in thousandths, where each is reached.
const KITTI: [(f32, [f32; 3]); 8] = [
    (0.0, [0.0, 0.0, 0.0]),
    (114.0, [0.0, 0.0, 1.0]),
    (299.0, [1.0, 0.0, 0.0]),
    (413.0, [1.0, 0.0, 1.0]),
    (587.0, [0.0, 1.0, 0.0]),
    (701.0, [0.0, 1.0, 1.0]),
    (886.0, [1.0, 1.0, 0.0]),
    (1000.0, [1.0, 1.0, 1.0]),
];

/// Straight lines between the corners.
fn kitti(t: f32) -> [u8; 3] {
    let at = t * 1000.0;
    let next = KITTI.iter().position(|knot| at < knot.0).unwrap_or(KITTI.len() - 1);
    let ((start, from), (end, to)) = (KITTI[next - 1], KITTI[next]);
    let part = (at - start) / (end - start);
    [0, 1, 2].map(|c| byte(from[c] + part * (to[c] - from[c])))
}

impl fmt::Display for ColourMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Turbo => "turbo",
            Self::Kitti => "kitti",
            Self::Grey => "grey",
        })
    }
}

impl FromStr for ColourMap {
    type Err = FormatError;

    fn from_str(text: &str) -> Result<Self, FormatError> {
        Self::ALL.into_iter().find(|map| map.to_string() == text).ok_or_else(|| FormatError::Text {
            text: text.to_owned(),
            what: "a colour map",
            allowed: "give turbo, kitti or grey".to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turbo_is_near_its_table() {
        // Entries of Mikhailov's table. The polynomial strays by up to 20 of 255, and by 32 at
        // the dark start.
        for (entry, expected, stray) in [
            (0, [48, 18, 59], 32),
            (16, [64, 64, 162], 20),
            (64, [40, 188, 235], 20),
            (128, [164, 252, 60], 20),
            (192, [251, 126, 33], 20),
            (240, [169, 22, 1], 20),
            (255, [122, 4, 3], 22),
        ] {
            let colour = ColourMap::Turbo.colour(entry as f32 / 255.0);
            for c in 0..3 {
                let distance = (i32::from(colour[c]) - expected[c]).abs();
                assert!(distance <= stray, "entry {entry}: {colour:?}");
            }
        }
    }

    #[test]
    fn kitti_runs_through_the_corners_of_the_colour_cube() {
        let colour = |t| ColourMap::Kitti.colour(t);
        assert_eq!(colour(0.0), [0, 0, 0]);
        assert_eq!(colour(0.114), [0, 0, 255]);
        assert_eq!(colour(0.299), [255, 0, 0]);
        assert_eq!(colour(0.5), [128, 128, 128]);
        assert_eq!(colour(1.0), [255, 255, 255]);
    }

    #[test]
    fn no_number_leaves_the_map() {
        for map in ColourMap::ALL {
            assert_eq!(map.colour(-3.0), map.colour(0.0));
            assert_eq!(map.colour(7.0), map.colour(1.0));
            assert_eq!(map.colour(f32::NAN), map.colour(0.0));
            assert_eq!(map.to_string().parse::<ColourMap>().unwrap(), map);
        }
        assert_eq!(ColourMap::Grey.colour(0.0), [1; 3]);
        assert!("jet".parse::<ColourMap>().unwrap_err().to_string().contains("turbo"));
    }
}
