//! Between whole numbers and others, in a way that every level does alike and in few operations.

/// The whole number nearest to one that is smaller than 2^22.
#[inline(always)]
pub(crate) fn nearest(number: f32) -> i32 {
    /// Adding it leaves no room for a fraction.
    const ROUNDING: f32 = 12_582_912.0;
    (number + ROUNDING).to_bits() as i32 - ROUNDING.to_bits() as i32
}

/// The number that a column is, of which an image has at most 2^22: by way of 32 bits, since of 64 no level below
/// AVX-512 makes vectors.
#[inline(always)]
pub(crate) fn as_number(column: usize) -> f32 {
    debug_assert!(column < 1 << 24, "{column} is no number of 32 bits");
    column as i32 as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_the_numbers_that_they_are() {
        for column in [0, 1, 4_194_304, (1 << 24) - 1] {
            assert_eq!(as_number(column), column as f32);
        }
    }

    #[test]
    fn halves_go_to_even_numbers_and_all_else_to_the_nearest() {
        for number in [0.0, -0.2, 0.49, 0.5, 1.5, 2.5, -1.5, 7.51, -63.7, 65_535.4, -4_000_000.3] {
            assert_eq!(nearest(number), number.round_ties_even() as i32, "{number}");
        }
    }
}
