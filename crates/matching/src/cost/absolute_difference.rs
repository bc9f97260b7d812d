//! Absolute differences, summed down the columns of a window.
//!
//! `A(x, y, d) = |L(x, y) - R(x - d, y)|`, and
//! `V(x, y, d) = A(x, y - r, d) + ... + A(x, y + r, d)` over the rows that lie in the image.
//!
//! From one row to the next only the row that enters and the row that leaves are touched, so the
//! work does not grow with the window. Right columns beyond the image repeat its border; they
//! only ever support a match whose centre lies inside.
//!
//! In: rows of bytes, the right one reversed (so that disparities follow each other in memory).
//! Out: `u16` sums, all disparities of one column together. The caller keeps
//! `window^2 * largest difference` below 65535.

/// Writes `right[top], right[top - 1], ...` to `out`; columns beyond the row repeat its border.
pub(crate) fn reverse_row(right: &[u8], top: i64, out: &mut [u8]) {
    let last = right.len() as i64 - 1;
    for (j, sample) in out.iter_mut().enumerate() {
        *sample = right[(top - j as i64).clamp(0, last) as usize];
    }
}

/// Adds the differences of one row to the column sums. `reversed` holds, for the last column of
/// `left`, its right sample at the smallest disparity first.
pub(crate) fn add_row(left: &[u8], reversed: &[u8], lanes: usize, sums: &mut [u16]) {
    let last = left.len() - 1;
    for (c, (sums, &l)) in sums.chunks_exact_mut(lanes).zip(left).enumerate() {
        for (sum, &r) in sums.iter_mut().zip(&reversed[last - c..][..lanes]) {
            *sum += u16::from(l.abs_diff(r));
        }
    }
}

/// Takes the differences of one row out of the column sums again.
pub(crate) fn subtract_row(left: &[u8], reversed: &[u8], lanes: usize, sums: &mut [u16]) {
    let last = left.len() - 1;
    for (c, (sums, &l)) in sums.chunks_exact_mut(lanes).zip(left).enumerate() {
        for (sum, &r) in sums.iter_mut().zip(&reversed[last - c..][..lanes]) {
            *sum -= u16::from(l.abs_diff(r));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_worked_by_hand() {
        // Left columns 0..3, disparities 0..2: right columns 2, 1, 0, then the border again.
        let mut reversed = [0; 4];
        reverse_row(&[10, 20, 40], 2, &mut reversed);
        assert_eq!(reversed, [40, 20, 10, 10]);
        let mut sums = [1; 6];
        add_row(&[11, 25, 5], &reversed, 2, &mut sums);
        assert_eq!(sums, [1 + 1, 1 + 1, 1 + 5, 1 + 15, 1 + 35, 1 + 15]);
        subtract_row(&[11, 25, 5], &reversed, 2, &mut sums);
        assert_eq!(sums, [1; 6]);
    }
}
