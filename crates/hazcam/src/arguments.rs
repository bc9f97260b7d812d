//! Arguments that several commands take, read the same way everywhere.

use std::fmt::Display;
use std::num::NonZeroUsize;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use bytesize::ByteSize;
use formats::FormatError;
use matching::Options;
use raster::BoundingBox;

/// A box, and the file that it was read from if it was.
#[derive(Debug, Clone)]
pub struct GivenBox {
    pub bounds: BoundingBox,
    pub file: Option<PathBuf>,
}

/// A box: `x0,y0,x1,y1`, or the course's file `*_bounds.npy`.
pub fn bounding_box(text: &str) -> Result<GivenBox, FormatError> {
    let is_file = Path::new(text).extension().is_some_and(|e| e.eq_ignore_ascii_case("npy"));
    let bounds = match is_file {
        true => formats::read_bounding_box(text)?,
        false => formats::parse_bounding_box(text)?,
    };
    Ok(GivenBox { bounds, file: is_file.then(|| text.into()) })
}

/// How many work at once.
pub fn jobs(text: &str) -> Result<NonZeroUsize, String> {
    text.parse().map_err(|_| "give a whole number from 1 on".into())
}

/// A whole number of a range.
pub fn whole<T: FromStr + PartialOrd + Display>(
    text: &str,
    range: RangeInclusive<T>,
) -> Result<T, String> {
    let number = text.parse().ok().filter(|number| range.contains(number));
    let (least, most) = (range.start(), range.end());
    number.ok_or_else(|| format!("give a whole number from {least} to {most}"))
}

/// A count of threads.
pub fn threads(text: &str) -> Result<usize, String> {
    whole(text, 1..=1024)
}

/// What can be a length or an error.
pub fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "give a number above 0".into())
}

/// A part of a whole.
pub fn share(text: &str) -> Result<f32, String> {
    let number = text.parse().ok().filter(|number| (0.0..=1.0).contains(number));
    number.ok_or_else(|| "give a number from 0 to 1".into())
}

/// What the option names, else what the variable does; an empty variable names nothing.
///
/// Not clap's `env`, to which a variable that is set is an option that was given: it would be at odds
/// with options that stand alone.
pub fn or_variable(option: Option<&Path>, variable: &str) -> Option<PathBuf> {
    let set = || std::env::var_os(variable).filter(|value| !value.is_empty());
    option.map(Path::to_owned).or_else(|| set().map(PathBuf::from))
}

const FARTHEST: i32 = Options::FARTHEST;

/// An end of a range of disparities.
pub fn disparity(text: &str) -> Result<i32, String> {
    whole(text, -FARTHEST..=FARTHEST)
}

/// An amount of memory, in bytes. A number alone is none: some mean megabytes by it.
pub fn memory(text: &str) -> Result<usize, String> {
    let has_unit = text.ends_with(|end: char| end.is_alphabetic());
    let bytes: Option<ByteSize> = text.parse().ok().filter(|_| has_unit);
    let bytes = bytes.and_then(|bytes| bytes.as_u64().try_into().ok());
    bytes.ok_or_else(|| "give a number and a unit from B to TiB, such as 200MB or 1.5GiB".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disparities_are_read_up_to_where_matchers_take_them() {
        use matching::Preset;
        use raster::DisparityRange;
        for end in [FARTHEST, -FARTHEST] {
            assert_eq!(disparity(&end.to_string()), Ok(end));
            let takes = |end| {
                Options::new(Preset::Fast, DisparityRange::new(end, end).unwrap()).check().is_ok()
            };
            let beyond = end + end.signum();
            assert!(takes(end) && !takes(beyond), "{end}");
            assert!(disparity(&beyond.to_string()).is_err(), "{beyond}");
        }
        for text in ["", "many", "64.5", "99999999999", "100000"] {
            let error = disparity(text).unwrap_err();
            assert_eq!(error, "give a whole number from -16383 to 16383", "{text}");
        }
    }

    #[test]
    fn memory_is_read_in_powers_of_ten_and_two() {
        for (text, bytes) in [
            ("200MB", 200_000_000),
            ("200 mb", 200_000_000),
            ("1.5GiB", 3 << 29),
            ("64KiB", 1 << 16),
            ("1kB", 1000),
            ("12B", 12),
        ] {
            assert_eq!(memory(text), Ok(bytes), "{text}");
        }
        for text in ["", "MB", "-1MB", "4096", "200 apples", "1,5GB"] {
            assert!(memory(text).is_err(), "{text}");
        }
    }
}
