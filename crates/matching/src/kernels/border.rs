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

/// `N` samples of a row, of which so many lie before column `start`; beyond the row there is `nothing`.
#[inline(always)]
pub(crate) fn around<T: Copy, const N: usize>(
    row: &[T],
    start: usize,
    before: usize,
    nothing: T,
) -> [T; N] {
    let inside = start.checked_sub(before).and_then(|first| row.get(first..)?.first_chunk());
    if let Some(around) = inside {
        return *around;
    }
    let mut around = [nothing; N];
    let first = start.saturating_sub(before);
    let samples = row.get(first..).unwrap_or_default();
    let place = first + before - start;
    let count = samples.len().min(N - place);
    around[place..][..count].copy_from_slice(&samples[..count]);
    around
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

    #[test]
    fn beyond_a_row_there_is_nothing() {
        let row: Vec<u32> = (1..=9).collect();
        for (end, start, before) in (0..=9)
            .flat_map(|end| (0..=9).flat_map(move |start| (0..4).map(move |b| (end, start, b))))
        {
            let found: [u32; 6] = around(&row[..end], start, before, 0);
            let expected: [u32; 6] = std::array::from_fn(|i| {
                let column = (start + i).checked_sub(before);
                column.and_then(|column| row[..end].get(column)).copied().unwrap_or(0)
            });
            assert_eq!(found, expected, "{end} samples, {before} before {start}");
        }
    }
}
