//! Boxes of pixels: the course's `*_bounds.npy` and the text form `x0,y0,x1,y1`.

use std::path::Path;

use raster::BoundingBox;

use crate::FormatError;
use crate::npy::{self, Array};
use crate::source::Source;

/// Reads the course's box, a 2 x 2 integer array `[[x0, x1], [y0, y1]]`, inclusive, as `.npy`.
///
/// Errors as [`npy::read`], [`FormatError::WrongKind`] when the array has another shape or no
/// integers, [`FormatError::Malformed`] when the box ends before it begins or has negative sides.
pub fn read_bounding_box(path: impl AsRef<Path>) -> Result<BoundingBox, FormatError> {
    let source = Source::open(path.as_ref())?;
    of_array(&source, &npy::decode(&source)?)
}

/// The box in an array of the file `source`, if it is one.
pub(crate) fn of_array(source: &Source, array: &Array) -> Result<BoundingBox, FormatError> {
    let Array { shape, samples } = array;
    if *shape != [2, 2] || !samples.dtype().is_integer() {
        let shape = npy::shape_text(shape);
        return Err(source.wrong_kind(
            format!("a .npy array of {} with shape {shape}", samples.dtype()),
            "a box is 2 x 2 integers, [[x0, x1], [y0, y1]], inclusive",
        ));
    }
    let sides = samples.to_f64();
    let malformed = |problem: String| source.malformed("bounding box", None, problem);
    // Past 2^53 an integer is no longer exact, and past any image.
    if let Some(side) = sides.iter().find(|side| !(0.0..=9e15).contains(*side)) {
        let side = if *side < 0.0 { side.to_string() } else { format!("{side:e}") };
        return Err(malformed(format!("a side is {side}, but 0 to 9e15 is allowed")));
    }
    let [x0, x1, y0, y1] = [0, 1, 2, 3].map(|n| sides[n] as usize);
    BoundingBox::new(x0, y0, x1, y1).map_err(|error| malformed(error.to_string()))
}

/// Reads `x0,y0,x1,y1`, inclusive: the form in which a [`BoundingBox`] is displayed.
pub fn parse_bounding_box(text: &str) -> Result<BoundingBox, FormatError> {
    let wrong =
        |allowed: String| FormatError::Text { text: text.to_owned(), what: "a box", allowed };
    let sides: Option<Vec<usize>> = text.split(',').map(|side| side.trim().parse().ok()).collect();
    match sides.as_deref() {
        Some(&[x0, y0, x1, y1]) => {
            BoundingBox::new(x0, y0, x1, y1).map_err(|error| wrong(error.to_string()))
        }
        _ => Err(wrong(
            "give four whole numbers x0,y0,x1,y1: first column and row, last column and row"
                .to_owned(),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::Plane;

    fn read(samples: Vec<i32>, columns: usize) -> Result<BoundingBox, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a_bounds.npy");
        let rows = samples.len() / columns;
        npy::write(&path, &Plane::new(columns, rows, samples).unwrap()).unwrap();
        read_bounding_box(&path).map_err(|e| e.to_string())
    }

    #[test]
    fn the_course_gives_columns_first() {
        let expected = BoundingBox::new(52, 11, 440, 365).unwrap();
        assert_eq!(read(vec![52, 440, 11, 365], 2), Ok(expected));
    }

    #[test]
    fn other_arrays_are_refused() {
        assert!(read(vec![52, 440, 11, 365], 4).unwrap_err().contains("shape (1, 4)"));
        assert!(read(vec![52, 40, 11, 365], 2).unwrap_err().contains("52,11,40,365"));
        assert!(read(vec![-1, 40, 11, 365], 2).unwrap_err().contains("-1"));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a_bounds.npy");
        npy::write(&path, &Plane::filled(2, 2, 1.5f64)).unwrap();
        assert!(read_bounding_box(&path).unwrap_err().to_string().contains("float64"));
    }

    #[test]
    fn the_text_form_survives_a_round_trip() {
        let text = "52,11,440,365";
        assert_eq!(parse_bounding_box(text).unwrap().to_string(), text);
        assert_eq!(parse_bounding_box(" 1, 2, 3, 4").unwrap().to_string(), "1,2,3,4");
        for text in ["", "1,2,3", "1,2,3,4,5", "1,2,-3,4", "a,b,c,d", "3,0,2,0"] {
            let error = parse_bounding_box(text).unwrap_err().to_string();
            assert!(error.starts_with(&format!("`{text}` is not a box")), "{error}");
        }
    }
}
