//! Arguments that several commands take, read the same way everywhere.

use std::path::Path;

use formats::FormatError;
use raster::BoundingBox;

/// A box: `x0,y0,x1,y1`, or the course's file `*_bounds.npy`.
pub fn bounding_box(text: &str) -> Result<BoundingBox, FormatError> {
    let is_file = Path::new(text).extension().is_some_and(|e| e.eq_ignore_ascii_case("npy"));
    match is_file {
        true => formats::read_bounding_box(text),
        false => formats::parse_bounding_box(text),
    }
}

/// A count of threads.
pub fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 1..=1024) => Ok(count),
        _ => Err("give a whole number from 1 to 1024".into()),
    }
}
