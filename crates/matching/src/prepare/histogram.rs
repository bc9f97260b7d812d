//! Quantiles of whole numbers that were counted.

/// What a share of the numbers does not exceed, by how often each of 0, 1, 2, ... is there. A whole number stands
/// for all that are rounded to it. 0 where none is there.
pub(super) fn quantile(counts: &[u32], share: f32) -> f32 {
    let below = share * counts.iter().sum::<u32>() as f32;
    let mut smaller = 0.0;
    for (number, &count) in counts.iter().enumerate() {
        let count = count as f32;
        if count > 0.0 && smaller + count >= below {
            let (from, width) = if number == 0 { (0.0, 0.5) } else { (number as f32 - 0.5, 1.0) };
            return from + width * (below - smaller) / count;
        }
        smaller += count;
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_spread_over_what_is_rounded_to_them() {
        assert_eq!(quantile(&[0, 0, 8], 0.5), 2.0);
        assert_eq!(quantile(&[0, 0, 8], 0.25), 1.75);
        assert_eq!(quantile(&[8], 0.5), 0.25);
        assert_eq!(quantile(&[2, 0, 0, 6], 0.25), 0.5);
        assert_eq!(quantile(&[2, 0, 0, 6], 1.0), 3.5);
        assert_eq!([quantile(&[], 0.5), quantile(&[0, 0], 0.5)], [0.0; 2]);
    }
}
