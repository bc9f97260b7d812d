//! How much of a truth estimates within a range can reach.

use std::ops::RangeInclusive;

/// The share of true disparities that lie outside a range; 0 of none.
pub fn share_outside(truths: impl Iterator<Item = f32>, range: RangeInclusive<f32>) -> f64 {
    let (mut all, mut outside) = (0usize, 0usize);
    for truth in truths {
        all += 1;
        outside += usize::from(!range.contains(&truth));
    }
    outside as f64 / all.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_are_within() {
        let share = |truths: &[f32]| share_outside(truths.iter().copied(), 0.0..=9.0);
        assert_eq!(share(&[0.0, 9.0, -0.5, 9.5]), 0.5);
        assert_eq!((share(&[-1.0]), share(&[4.0]), share(&[])), (1.0, 0.0, 0.0));
    }
}
