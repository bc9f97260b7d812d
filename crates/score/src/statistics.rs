//! Means and medians, of numbers of which there may be none.

/// The mean, or `None` of nothing.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let add = |(sum, count), value| (sum + value, count + 1_u64);
    let (sum, count) = values.into_iter().fold((0.0, 0), add);
    (count > 0).then(|| sum / count as f64)
}

/// The value in the middle or, of an even number of them, the mean of the two there; `None` of nothing.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_unstable_by(f64::total_cmp);
    let upper = *values.get(values.len() / 2)?;
    let lower = values[(values.len() - 1) / 2];
    Some((lower + upper) / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        assert_eq!((mean([]), median([])), (None, None));
        assert_eq!((mean([3.0, 1.0, 2.5]), median([3.0, 1.0, 2.5])), (Some(6.5 / 3.0), Some(2.5)));
        assert_eq!(median([4.0, 1.0, 2.0, 8.0]), Some(3.0));
    }
}
