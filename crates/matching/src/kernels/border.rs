//! Rows that go on beyond their ends.

/// Copies a row from column `from` on, which may lie outside; there its border is repeated.
pub(crate) fn repeat_border<T: Copy>(row: &[T], from: i64, out: &mut [T]) {
    let (columns, length) = (row.len() as i64, out.len() as i64);
    let start = (-from).clamp(0, length);
    let end = (columns - from).clamp(start, length);
    out[..start as usize].fill(row[0]);
    if start < end {
        let inside = &row[(from + start) as usize..(from + end) as usize];
        out[start as usize..end as usize].copy_from_slice(inside);
    }
    out[end as usize..].fill(row[row.len() - 1]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_border_of_a_row_is_repeated() {
        let row = [10, 20, 40];
        for from in -6..9 {
            for length in 0..12 {
                let mut copy = vec![0; length];
                repeat_border(&row, from, &mut copy);
                let expected: Vec<u8> =
                    (0..length as i64).map(|i| row[(from + i).clamp(0, 2) as usize]).collect();
                assert_eq!(copy, expected, "from {from}, {length} samples");
            }
        }
    }
}
