//! How sure pixels are, in bytes: two maps of it are kept, and more than a byte says nothing more.

use crate::kernels::rounding::nearest;

/// What cannot be otherwise.
pub(super) const CERTAIN: u8 = u8::MAX;

/// The byte for a share from 0 to 1.
#[inline(always)]
pub(super) fn byte(share: f32) -> u8 {
    nearest(share * f32::from(CERTAIN)) as u8
}

/// From 0 to 1.
#[inline(always)]
pub(crate) fn share(byte: u8) -> f32 {
    f32::from(byte) * (1.0 / CERTAIN as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_kept_within_half_a_step() {
        for thousandths in 0..=1000 {
            let told = thousandths as f32 / 1000.0;
            assert!((share(byte(told)) - told).abs() <= 0.5 / 255.0 + 1e-6, "{told}");
        }
        assert_eq!([byte(0.0), byte(1.0)], [0, CERTAIN]);
        assert_eq!(share(CERTAIN), 1.0);
    }
}
