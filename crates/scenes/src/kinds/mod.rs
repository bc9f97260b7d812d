//! The kinds of scenes, one file each. A kind turns settings into a world and a pair of cameras.

mod builder;
mod cards;
mod clutter;
mod mars;
mod plane;
mod street;

use std::fmt;
use std::str::FromStr;

use crate::rig::Rig;
use crate::settings::{Settings, SettingsError};
use crate::world::World;

/// Which kind of scene. Its name, by [`Display`](fmt::Display) and [`FromStr`], is the variant's in
/// lower case; a plane's is followed by its numbers, as in `plane:12.5` or `plane:12.5,0.1,-0.05`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Kind {
    /// One plane with fine texture whose disparity is known in closed form:
    /// `d(x, y) = offset + per_column * x + per_row * y` at left pixel `(x, y)`.
    Plane {
        /// Disparity of the top-left pixel, in pixels.
        offset: f64,
        /// Growth of the disparity from column to column, -0.9 to 0.9.
        per_column: f64,
        /// Growth of the disparity from row to row, -0.9 to 0.9.
        per_row: f64,
    },
    /// Fronto-parallel cards with fine texture, each at a multiple of a quarter of a pixel.
    Cards,
    /// A room full of things at all depths: thin, blank, repeated, slanted, shining.
    Clutter,
    /// Martian ground with rocks to the horizon, over the deck of a rover.
    Mars,
    /// A street: slanted road and facades, cars, poles, trees, and a sky at infinity.
    Street,
}

/// A world and the cameras in it.
pub(crate) struct Stage {
    pub world: World,
    pub rig: Rig,
}

impl Kind {
    /// The kinds without numbers of their own: those to choose from when a seed is all there is.
    pub const NAMED: [Kind; 4] = [Kind::Cards, Kind::Clutter, Kind::Mars, Kind::Street];

    /// The name without numbers.
    fn word(&self) -> &'static str {
        match self {
            Self::Plane { .. } => "plane",
            Self::Cards => "cards",
            Self::Clutter => "clutter",
            Self::Mars => "mars",
            Self::Street => "street",
        }
    }

    pub(crate) fn check(&self, settings: &Settings) -> Result<(), SettingsError> {
        match *self {
            Self::Plane { offset, per_column, per_row } => {
                plane::check(settings, offset, per_column, per_row)
            }
            _ => Ok(()),
        }
    }

    /// The scene of settings that were checked.
    pub(crate) fn build(&self, settings: &Settings) -> Stage {
        match *self {
            Self::Plane { offset, per_column, per_row } => {
                plane::build(settings, offset, per_column, per_row)
            }
            Self::Cards => cards::build(settings),
            Self::Clutter => clutter::build(settings),
            Self::Mars => mars::build(settings),
            Self::Street => street::build(settings),
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Plane { offset, per_column, per_row } if per_column == 0.0 && per_row == 0.0 => {
                write!(f, "plane:{offset}")
            }
            Self::Plane { offset, per_column, per_row } => {
                write!(f, "plane:{offset},{per_column},{per_row}")
            }
            _ => f.write_str(self.word()),
        }
    }
}

impl FromStr for Kind {
    type Err = SettingsError;

    fn from_str(text: &str) -> Result<Self, SettingsError> {
        if let Some(kind) = Self::NAMED.into_iter().find(|kind| kind.word() == text) {
            return Ok(kind);
        }
        let numbers: Option<Vec<f64>> = text
            .strip_prefix("plane:")
            .and_then(|list| list.split(',').map(|number| number.parse().ok()).collect());
        match numbers.as_deref() {
            Some(&[offset]) => Ok(Self::Plane { offset, per_column: 0.0, per_row: 0.0 }),
            Some(&[offset, per_column, per_row]) => Ok(Self::Plane { offset, per_column, per_row }),
            _ => {
                let named: Vec<_> = Self::NAMED.iter().map(Self::word).collect();
                Err(SettingsError::new(
                    "kind",
                    format!("`{text}`"),
                    format!(
                        "it must be one of {}, or plane:OFFSET or plane:OFFSET,PER_COLUMN,PER_ROW",
                        named.join(", ")
                    ),
                ))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back() {
        let planes = [(12.0, 0.0, 0.0), (12.25, 0.1, -0.05), (-3.5, 0.0, 0.3)];
        let planes =
            planes.map(|(offset, per_column, per_row)| Kind::Plane { offset, per_column, per_row });
        for kind in Kind::NAMED.into_iter().chain(planes) {
            assert_eq!(kind.to_string().parse::<Kind>(), Ok(kind));
        }
    }

    #[test]
    fn wrong_names_list_the_right_ones() {
        for text in ["", "Cards", "plane", "plane:", "plane:1,2", "plane:x"] {
            let message = text.parse::<Kind>().unwrap_err().to_string();
            assert!(message.contains(&format!("`{text}`")), "{message}");
            assert!(message.contains("cards, "), "{message}");
        }
    }
}
