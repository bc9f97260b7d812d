//! The grey step along the row: the derivative that a disparity does not change.

/// `I(x + 1) - I(x - 1)`, clamped to plus and minus 127, as `128 + step`. The row's ends are
/// repeated.
pub(crate) fn steps_along_row(row: &[u8], steps: &mut [u8]) {
    let step = |before: u8, after: u8| {
        (i16::from(after) - i16::from(before)).clamp(-127, 127).wrapping_add(128) as u8
    };
    let last = row.len() - 1;
    steps[0] = step(row[0], row[last.min(1)]);
    steps[last] = step(row[last.saturating_sub(1)], row[last]);
    for ((to, &before), &after) in steps[1..].iter_mut().zip(row).zip(&row[last.min(2)..]) {
        *to = step(before, after);
    }
}

/// The mean of two rows; halves are rounded up.
pub(crate) fn mean_of_rows(row: &[u8], next: &[u8], mean: &mut [u8]) {
    for ((mean, &one), &other) in mean.iter_mut().zip(row).zip(next) {
        *mean = (u16::from(one) + u16::from(other)).div_ceil(2) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_rounded_up() {
        let mut mean = [0; 4];
        mean_of_rows(&[10, 11, 255, 0], &[10, 12, 255, 255], &mut mean);
        assert_eq!(mean, [10, 12, 255, 128]);
    }

    #[test]
    fn a_case_worked_by_hand() {
        let mut steps = [0; 5];
        steps_along_row(&[10, 20, 15, 255, 0], &mut steps);
        assert_eq!(steps, [138, 133, 255, 113, 1]);
        steps_along_row(&[9], &mut steps[..1]);
        assert_eq!(steps[0], 128);
    }
}
