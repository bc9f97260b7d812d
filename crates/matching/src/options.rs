//! What to match with: one struct for every preset.

use std::fmt;
use std::str::FromStr;

use raster::DisparityRange;

use crate::{Ingredient, MatchError, ingredient};

/// A string of stages for one purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Preset {
    /// Fixed square window, sum of absolute differences, winner takes all.
    Fast,
    /// Semi-global matching in real time.
    Balanced,
    /// Accuracy first.
    Best,
}

impl Preset {
    /// Every preset, from the quickest to the most accurate.
    pub const ALL: [Preset; 3] = [Preset::Fast, Preset::Balanced, Preset::Best];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Balanced => "balanced",
            Self::Best => "best",
        }
    }

    /// The algorithm in a few short lines with its sources (Markdown).
    pub fn explanation(self) -> &'static str {
        crate::presets::explanation(self)
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Preset {
    type Err = MatchError;

    fn from_str(text: &str) -> Result<Self, MatchError> {
        Self::ALL.into_iter().find(|p| p.name() == text).ok_or_else(|| MatchError::Option {
            field: "matcher",
            value: format!("`{text}`"),
            allowed: "it must be one of fast, balanced, best".into(),
        })
    }
}

/// What becomes of pixels without a trustworthy match.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Holes {
    /// Every pixel in the box gets a value; its reason says how.
    #[default]
    Fill,
    /// They stay without a value; their reason says why.
    Keep,
}

/// What to match with. Built by [`Options::new`], then changed field by field.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// Which stages.
    pub preset: Preset,
    /// The disparities to search, in pixels. Of two `balanced` and `best` are never sure, and of three
    /// seldom, since there are hardly others to compare a winner with but its neighbours; of a single one nothing is
    /// matched.
    pub range: DisparityRange,
    /// Fill pixels without a match, or leave them.
    pub holes: Holes,
    /// Threads to use, at least 1. The answer does not depend on it. Where there is one for every
    /// processor that the process may use, each keeps to its own (Linux).
    pub threads: usize,
    /// The most bytes that the matcher may take for its stages and its answer; frames that need more
    /// are refused. `balanced` and `best` take more time where they have less memory, the answer
    /// does not depend on it. Without a limit they take up to 200 MB, or what they need beside the
    /// sums of semi-global matching and 100 MB for these, as far as that will do; where there is
    /// less, on the machine or by a control group (a container, a service) or `ulimit`, no more than that; frames
    /// that need more are refused (Linux).
    ///
    /// A matcher without a limit that is fed frames of several sizes keeps what each of them has taken.
    pub memory: Option<usize>,
    /// What the preset is to do without, to see what it gives: nothing unless stated.
    pub without: Vec<Ingredient>,
}

impl Options {
    /// The farthest disparity from 0 that can be looked for, in pixels. A disparity's place in the range is a
    /// number of 16 bits inside: the longest range between these limits has fewer places than such numbers
    /// can tell apart.
    pub const FARTHEST: i32 = i16::MAX as i32 / 2;

    /// The preset's own parameters, holes filled, one thread per core, no limit to the memory.
    pub fn new(preset: Preset, range: DisparityRange) -> Self {
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
        Self { preset, range, holes: Holes::Fill, threads, memory: None, without: Vec::new() }
    }

    /// Errors, with the field's name, when no matcher can be built from them: threads must be from 1 to
    /// 1024, disparities from -16383 to 16383 pixels, and what is left out must be of the preset.
    pub fn check(&self) -> Result<(), MatchError> {
        if self.threads == 0 || self.threads > 1024 {
            return Err(MatchError::Option {
                field: "threads",
                value: self.threads.to_string(),
                allowed: "it must be from 1 to 1024".into(),
            });
        }
        let limit = Self::FARTHEST;
        for (field, value) in
            [("min-disparity", self.range.min()), ("max-disparity", self.range.max())]
        {
            if !(-limit..=limit).contains(&value) {
                return Err(MatchError::Option {
                    field,
                    value: value.to_string(),
                    allowed: format!("it must be from -{limit} to {limit} pixels"),
                });
            }
        }
        ingredient::check(self.preset, &self.without)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_that_reaches_beyond_the_limits_is_refused_at_either_end() {
        let check =
            |min, max| Options::new(Preset::Fast, DisparityRange::new(min, max).unwrap()).check();
        assert_eq!(check(-16_383, 16_383), Ok(()));
        for (min, max, field, value) in [
            (-16_384, 0, "min-disparity", -16_384),
            (i32::MIN, 0, "min-disparity", i32::MIN),
            (i32::MAX, i32::MAX, "min-disparity", i32::MAX),
            (0, 16_384, "max-disparity", 16_384),
            (0, i32::MAX, "max-disparity", i32::MAX),
        ] {
            let error = check(min, max).unwrap_err();
            let expected = MatchError::Option {
                field,
                value: value.to_string(),
                allowed: "it must be from -16383 to 16383 pixels".into(),
            };
            assert_eq!(error, expected);
        }
    }
}
