//! Numbers that stand in a table, by their places.
//!
//! ```text
//! v_i = table[place_i]
//! ```
//!
//! One after the other they take two loads and a store each, and what was stored number by number is waited for when it
//! is read as a vector. With AVX-512 a table of 64 numbers fits two registers, and 32 places of it are looked up at
//! once; of longer tables it is part after part, whose numbers count where a place lies in it. Confirming the winners of
//! `fast` takes .75 times as long so. Below, places are checked together, and numbers go from memory into registers.
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

    impl LookUp for Baseline {
        #[inline(always)]
        fn look_up(self, table: &[u16], places: &[u16; LANES]) -> [u16; LANES] {
            one_by_one(table, places)
        }
    }

    impl LookUp for Avx2 {
        #[inline(always)]
        fn look_up(self, table: &[u16], places: &[u16; LANES]) -> [u16; LANES] {
            one_by_one(table, places)
        }
    }

    /// With what every x86 of 64 bits has.
    #[inline(always)]
    fn one_by_one(table: &[u16], places: &[u16; LANES]) -> [u16; LANES] {
        const PARTS: usize = size_of::<[u16; LANES]>() / size_of::<__m128i>();
        let last = table.len().checked_sub(1).expect("a table has a number");
        let last = u16::try_from(last).unwrap_or(u16::MAX);
        // SAFETY: these instructions are always there, both sides of a transmutation are plain numbers of the same size,
        // and no place lies beyond the last of the table.
        unsafe {
            // Written out: a closure is not always inlined.
            let parts = transmute::<[u16; LANES], [__m128i; PARTS]>(*places);
            let mut beyond = _mm_setzero_si128();
            for part in parts {
                let of_part = _mm_subs_epu16(part, _mm_set1_epi16(last as i16));
                beyond = _mm_or_si128(beyond, of_part);
            }
            let is_there = _mm_cmpeq_epi16(beyond, _mm_setzero_si128());
            assert!(_mm_movemask_epi8(is_there) == 0xFFFF, "the last is {last}: {places:?}");
            let mut found = [_mm_setzero_si128(); PARTS];
            for (found, places) in found.iter_mut().zip(places.as_chunks::<8>().0) {
                let mut eight = [0; 8];
                for (number, &place) in eight.iter_mut().zip(places) {
                    *number = i32::from(*table.get_unchecked(usize::from(place)));
                }
                let [a, b, c, d, e, f, g, h] = eight;
                let numbers = _mm_insert_epi16::<1>(_mm_cvtsi32_si128(a), b);
                let numbers = _mm_insert_epi16::<3>(_mm_insert_epi16::<2>(numbers, c), d);
                let numbers = _mm_insert_epi16::<5>(_mm_insert_epi16::<4>(numbers, e), f);
                *found = _mm_insert_epi16::<7>(_mm_insert_epi16::<6>(numbers, g), h);
            }
            transmute::<[__m128i; PARTS], [u16; LANES]>(found)
        }
    }

    impl LookUp for Avx512 {
        #[inline(always)]
        fn look_up(self, table: &[u16], places: &[u16; LANES]) -> [u16; LANES] {
            // SAFETY: whoever made `self` vouched for the instructions, and both sides of a transmutation are
            // plain numbers of the same size.
            unsafe {
                let last = table.len().checked_sub(1).expect("a table has a number");
                let last = _mm512_set1_epi16(u16::try_from(last).unwrap_or(u16::MAX) as i16);
                let all = places;
                let places = transmute::<[u16; LANES], __m512i>(*places);
                assert!(_mm512_cmpgt_epu16_mask(places, last) == 0, "beyond the last: {all:?}");
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
    use crate::kernels::products::Plain;
    use std::panic::AssertUnwindSafe;

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
            let expected = Plain.look_up(&table, &places);
            assert_eq!((expected[5], expected[31]), (table[0], table[table.len() - 1]));
            for level in Level::available() {
                eprintln!("level {}", level.name());
                assert_eq!(numbers(level, &table, &places), expected, "of {length}");
            }
        }
    }

    #[test]
    fn a_place_beyond_the_end_panics_at_every_level() {
        let table = [7; 40];
        let refused = |level, table: &[u16], places: &[u16; LANES]| {
            let look_up = AssertUnwindSafe(|| _ = numbers(level, table, places));
            std::panic::catch_unwind(look_up).is_err()
        };
        for level in Level::available() {
            assert!(!refused(level, &table, &[39; LANES]));
            assert!(refused(level, &[], &[0; LANES]), "there are none");
            for l in 0..LANES {
                for beyond in [40, 63, 64, 0x7FFF, 0x8000, u16::MAX] {
                    let mut places = [39; LANES];
                    places[l] = beyond;
                    assert!(refused(level, &table, &places), "{beyond}, {}", level.name());
                }
            }
        }
    }
}
