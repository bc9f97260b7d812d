//! The median of 3 x 3 pixels: lone outliers out, edges kept.
//!
//! In: finite values, borders repeated. Out: one row of medians.

use raster::Plane;

/// The medians of row `y` of `values`.
pub(crate) fn median_row(values: &Plane<f32>, y: usize, out: &mut [f32]) {
    let (columns, rows) = values.size();
    let near = [y.saturating_sub(1), y, (y + 1).min(rows - 1)].map(|y| values.row(y));
    for (x, median) in out.iter_mut().enumerate() {
        let places = [x.saturating_sub(1), x, (x + 1).min(columns - 1)];
        let mut window: [f32; 9] = std::array::from_fn(|i| near[i / 3][places[i % 3]]);
        *median = *window.select_nth_unstable_by(4, f32::total_cmp).1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_worked_by_hand() {
        #[rustfmt::skip]
        let values = [
            1.0, 9.0, 2.0,
            3.0, 4.0, 5.0,
            8.0, 7.0, 6.0,
        ];
        let mut out = [0.0; 3];
        median_row(&Plane::new(3, 3, values.to_vec()).unwrap(), 1, &mut out);
        // Column 0 repeated: 1 1 9 3 3 4 8 8 7 -> 4; all nine -> 5; 9 2 2 4 5 5 7 6 6 -> 5.
        assert_eq!(out, [4.0, 5.0, 5.0]);
    }
}
