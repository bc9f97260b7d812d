//! How fast this machine is at the moment.
//!
//! CPU seconds of two machines cannot be compared, nor those of one machine that is busy, hot or
//! shared. A fixed piece of work is timed before and after the tests; its time goes into every
//! record, and where the two differ by more than a tenth the times are marked as noisy.

use std::time::Instant;

use serde::{Deserialize, Serialize};

/// The time that a fixed piece of work took, in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MachineSpeed {
    /// Before the tests.
    pub before_seconds: f64,
    /// After the tests.
    pub after_seconds: f64,
}

impl MachineSpeed {
    /// Whether the two differ by more than a tenth of the smaller.
    pub fn is_noisy(&self) -> bool {
        let (low, high) = match self.before_seconds < self.after_seconds {
            true => (self.before_seconds, self.after_seconds),
            false => (self.after_seconds, self.before_seconds),
        };
        high > low * 1.1
    }
}

/// Times the fixed piece of work: the best of five, each absolute differences and sums over 6 Mi
/// samples, which is what matchers spend their time on.
pub fn measure() -> f64 {
    let row: Vec<u8> = (0..4096u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let started = Instant::now();
        let mut sum = 0u32;
        for shift in 0..2048 {
            let shifted = std::hint::black_box(&row[shift..]);
            for (a, b) in row.iter().zip(shifted) {
                sum = sum.wrapping_mul(31).wrapping_add(u32::from(a.abs_diff(*b)));
            }
        }
        std::hint::black_box(sum);
        best = best.min(started.elapsed().as_secs_f64());
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_apart_is_noisy() {
        let noisy = |before_seconds, after_seconds| {
            MachineSpeed { before_seconds, after_seconds }.is_noisy()
        };
        assert!(!noisy(1.0, 1.09) && !noisy(1.09, 1.0) && noisy(1.0, 1.11) && noisy(1.11, 1.0));
    }

    #[test]
    fn the_work_is_not_optimised_away() {
        assert!(measure() > 1e-5);
    }
}
