//! Every so many-th sample of a row.

/// Takes every so many-th sample of a row, 1 or 2, the first among them: as many as `out` has room for.
pub(crate) fn take_every<T: Copy>(every: usize, row: &[T], out: &mut [T]) {
    match every {
        // In one go.
        1 => out.copy_from_slice(&row[..out.len()]),
        // Whole pairs become vectors; the last one may lack its second sample.
        2 => {
            let (pairs, rest) = row.as_chunks::<2>();
            out.iter_mut().zip(pairs).for_each(|(out, pair)| *out = pair[0]);
            if let Some(last) = out.get_mut(pairs.len()) {
                *last = rest[0];
            }
        }
        _ => unreachable!("every sample is taken, or every second one"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_taken_from_the_first_on() {
        let row = [2, 3, 4, 5, 6, 7, 8];
        let taken = |every, count| {
            let mut out = vec![0; count];
            take_every(every, &row, &mut out);
            out
        };
        assert_eq!(taken(1, 3), [2, 3, 4]);
        assert_eq!(taken(2, 4), [2, 4, 6, 8]);
        assert_eq!(taken(2, 3), [2, 4, 6]);
        assert_eq!(taken(2, 0), []);
    }
}
