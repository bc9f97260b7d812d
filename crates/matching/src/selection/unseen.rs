//! Where the right camera saw nothing: rows that were mended by much come from beyond the first or the last one of its
//! image, and show what stands there, again and again.

use raster::Plane;

use crate::cost::MatchedRows;
use crate::prepare::alignment::VerticalDisparity;

/// A row that comes from so many rows beyond the image is not one of it: of the windows of nearer ones half and more is
/// true.
const BEYOND: f32 = 2.0;

/// Takes out what a right view, in a mirror, has found where it shows nothing, so that it confirms nothing there.
pub(crate) fn reject(vertical: &VerticalDisparity, rows: MatchedRows, right: &mut Plane<f32>) {
    let (columns, height) = (right.columns(), vertical.rows());
    let seen = -BEYOND..=(height - 1) as f32 + BEYOND;
    for row in 0..rows.count {
        let y = rows.in_image(row);
        let along = vertical.along_row(y);
        if along.extremes(columns).iter().all(|down| seen.contains(&(y as f32 + down))) {
            continue;
        }
        let from = |column: usize| y as f32 + along.at(column);
        for (column, value) in right.row_mut(row).iter_mut().rev().enumerate() {
            if !seen.contains(&from(column)) {
                *value = f32::NAN;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::BoundingBox;

    #[test]
    fn what_comes_from_beyond_the_image_is_taken_out() {
        // Of 40 rows, 20 columns: rolled by a quarter of a row a column, the last of them lower.
        let vertical = VerticalDisparity::of_shapes((20, 40), [0.0, 5.0, 0.0, 0.0, 0.0, 4.0]);
        for apart in [1, 2] {
            let rows = MatchedRows::of(BoundingBox::new(0, 1, 19, 39).unwrap(), apart);
            let mut right = Plane::filled(20, rows.count, 7.0);
            reject(&vertical, rows, &mut right);
            for row in 0..rows.count {
                for (x, value) in right.row(row).iter().rev().enumerate() {
                    let from = rows.in_image(row) as f64 + vertical.at(x as f64, 0.0);
                    let expected = (-2.0..=41.0).contains(&from);
                    assert_eq!(!value.is_nan(), expected, "column {x}, row {row}");
                }
            }
            let kept = right.samples().iter().filter(|value| !value.is_nan()).count();
            assert!(kept < right.samples().len() && kept > right.samples().len() * 9 / 10);
        }
    }
}
