//! The median of a small square window: lone outliers out, edges kept.
//!
//! In: finite values, borders repeated. Out: one row of medians.

/// The medians of row `y` of `values` (`columns` wide) over `2 radius + 1` squared pixels.
pub(crate) fn median_row(values: &[f32], columns: usize, y: usize, radius: usize, out: &mut [f32]) {
    let rows = values.len() / columns;
    let mut window = Vec::with_capacity((2 * radius + 1) * (2 * radius + 1));
    for (x, median) in out.iter_mut().enumerate() {
        window.clear();
        for dy in 0..=2 * radius {
            let row = (y + dy).saturating_sub(radius).min(rows - 1) * columns;
            for dx in 0..=2 * radius {
                window.push(values[row + (x + dx).saturating_sub(radius).min(columns - 1)]);
            }
        }
        let middle = window.len() / 2;
        *median = *window.select_nth_unstable_by(middle, f32::total_cmp).1;
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
        median_row(&values, 3, 1, 1, &mut out);
        // Column 0 repeated: 1 1 9 3 3 4 8 8 7 -> 4; all nine -> 5; 9 2 2 4 5 5 7 6 6 -> 5.
        assert_eq!(out, [4.0, 5.0, 5.0]);
    }
}
