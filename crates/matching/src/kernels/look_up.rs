//! Numbers that stand in a table, by their places.
//!
//! ```text
//! v_i = table[place_i]
//! ```
//!
//! One after the other they take two loads and a store each. With AVX-512 a table of 64 numbers fits two registers, and
//! 32 places of it are looked up at once; of longer tables it is part after part, whose numbers count where a place
//! lies in it. Confirming the winners of `fast` takes .75 times as long so.
//!
//! A kernel asks for it in brackets, see [`at_every_level!`](super::level::at_every_level).

/// Places that are looked up together.
pub(crate) const LANES: usize = 32;

/// What looks numbers up at one level.
pub(crate) trait LookUp: Copy {
    /// The number at each place, all of which the table has.
    #[inline(always)]
    fn look_up(self, table: &[u16], places: &[u16; LANES]) -> [u16; LANES] {
        let mut numbers = [0; LANES];
        for (number, &place) in numbers.iter_mut().zip(places) {
            *number = table[usize::from(place)];
        }
        numbers
    }
}

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod x86 {
    use std::arch::x86_64::*;
    use std::mem::transmute;

    use super::{LANES, LookUp};
    use crate::kernels::products::{Avx2, Avx512, Baseline};

    impl LookUp for Baseline {}

    impl LookUp for Avx2 {}

    impl LookUp for Avx512 {
        #[inline(always)]
        fn look_up(self, table: &[u16], places: &[u16; LANES]) -> [u16; LANES] {
            // SAFETY: whoever made `self` vouched for the instructions, and both sides of a transmutation are
            // plain numbers of the same size.
            unsafe {
                let places = transmute::<[u16; LANES], __m512i>(*places);
                let part_of = _mm512_srli_epi16::<6>(places);
                let mut numbers = _mm512_setzero_si512();
                for (part, table) in (0..).zip(table.chunks(2 * LANES)) {
                    let [low, high] = self.both(table);
                    let found = _mm512_permutex2var_epi16(low, places, high);
                    let is_here = _mm512_cmpeq_epi16_mask(part_of, _mm512_set1_epi16(part));
                    numbers = _mm512_mask_mov_epi16(numbers, is_here, found);
                }
                transmute::<__m512i, [u16; LANES]>(numbers)
            }
        }
    }

    impl Avx512 {
        /// Up to as many numbers as two vectors hold, and zeros.
        #[inline(always)]
        fn both(self, numbers: &[u16]) -> [__m512i; 2] {
            let (low, high) = numbers.split_at(numbers.len().min(LANES));
            [low, high].map(|half| {
                let there = u32::MAX.checked_shr((LANES - half.len()) as u32).unwrap_or(0);
                // SAFETY: as above; what is read is there, and a half has no more than a vector.
                unsafe { _mm512_maskz_loadu_epi16(there, half.as_ptr().cast()) }
            })
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl LookUp for super::products::Baseline {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::kernels::level::{Level, at_every_level};

    at_every_level! {
        fn numbers[tables](table: &[u16], places: &[u16; LANES]) -> [u16; LANES] {
            tables.look_up(table, places)
        }
    }

    #[test]
    fn numbers_are_those_of_their_places_at_every_level() {
        let mut chance = Chance(3);
        for length in [1, 2, 31, 32, 33, 63, 64, 65, 96, 127, 128, 200, 543] {
            let table: Vec<u16> = (0..length).map(|_| chance.below(1 << 16) as u16).collect();
            let mut places = [0; LANES].map(|_: u16| chance.below(length) as u16);
            // Its ends are asked for too.
            (places[5], places[31]) = (0, (length - 1) as u16);
            let expected = places.map(|place| table[usize::from(place)]);
            for level in Level::available() {
                eprintln!("level {}", level.name());
                assert_eq!(numbers(level, &table, &places), expected, "of {length}");
            }
        }
    }
}
