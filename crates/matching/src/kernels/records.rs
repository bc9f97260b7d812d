//! Samples from anywhere in a row of them, sixteen at a time; and records of sixteen bytes, taken apart: all first
//! words in one vector, all second ones in the next.
//!
//! ```text
//! w_jl = record[place_l]_j
//! ```
//!
//! Loops take the places out of a vector one by one, ask of each whether it is there, and write what they found to
//! memory in parts, which cannot be read as a whole for a while. Here all places are looked at together, records go
//! to a register, and shuffles put their words in order.
//!
//! A kernel asks for it in brackets, see [`at_every_level!`](super::level::at_every_level).

use super::aligned::Line;
use super::products::{LANES, Lanes};

/// Sixteen bytes: two words, or four of half the size of which the lower half comes first. It begins where vectors of
/// that size may be read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[repr(C, align(16))]
pub(crate) struct Record(pub [u64; 2]);

/// Where records lie.
pub(crate) type Places = Line<[u32; LANES]>;

/// What takes records at one level.
pub(crate) trait Records: Copy {
    /// The four words of 32 bits of records, all of which there are.
    #[inline(always)]
    fn fourths(self, records: &[Record], places: &Places) -> [Line<[u32; LANES]>; 4] {
        let mut words = [Line([0; LANES]); 4];
        for (l, &place) in places.iter().enumerate() {
            for (i, word) in words.iter_mut().enumerate() {
                word[l] = (records[place as usize].0[i / 2] >> (32 * (i % 2))) as u32;
            }
        }
        words
    }

    /// Their two words of 64 bits.
    #[inline(always)]
    fn halves(self, records: &[Record], places: &Places) -> [Line<[u64; LANES]>; 2] {
        let mut words = [Line([0; LANES]); 2];
        for (l, &place) in places.iter().enumerate() {
            for (i, word) in words.iter_mut().enumerate() {
                word[l] = records[place as usize].0[i];
            }
        }
        words
    }

    /// Numbers from anywhere in a row of them.
    #[inline(always)]
    fn numbers(self, numbers: &[f32], places: &Places) -> Lanes {
        Line(places.map(|place| numbers[place as usize]))
    }

    /// The same of other samples.
    #[inline(always)]
    fn samples<T: Copy>(self, samples: &[T], places: &Places) -> Line<[T; LANES]> {
        Line(places.map(|place| samples[place as usize]))
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl Records for super::products::Baseline {}

#[cfg(all(test, target_arch = "x86_64"))]
impl Records for super::products::Plain {}

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod x86 {
    use std::arch::x86_64::*;

    use super::{LANES, Lanes, Line, Places, Record, Records};
    use crate::kernels::products::{Avx2, Avx512, Baseline};

    macro_rules! records {
        (
            $level:ident, $part:ident, $same:ident, |$place:ident, $end:ident| $all_before:expr,
            |$quarters:ident| $side_by_side:expr,
            $low_32:ident, $high_32:ident, $low_64:ident, $high_64:ident
        ) => {
            impl $level {
                /// How many records a vector holds.
                const WIDE: usize = size_of::<$part>() / size_of::<Record>();

                /// Panics where a place lies beyond the end.
                #[inline(always)]
                fn check<T>(self, samples: &[T], places: &Places) {
                    let end = u32::try_from(samples.len()).unwrap_or(u32::MAX);
                    for part in 0..Self::PARTS {
                        let $place = self.read(places, part);
                        // SAFETY: whoever made `self` vouched for the instructions.
                        let all_before = unsafe {
                            let $end = $same(end as i32);
                            $all_before
                        };
                        assert!(all_before, "there are {end}, but asked for are {places:?}");
                    }
                }

                /// The records at every so many-th place from a first one on, side by side.
                ///
                /// # Safety
                ///
                /// They must be there.
                #[inline(always)]
                unsafe fn side_by_side(
                    self,
                    records: &[Record],
                    places: &Places,
                    first: usize,
                    every: usize,
                ) -> $part {
                    // SAFETY: whoever called vouched for the places, and whoever made `self` for the
                    // instructions; records begin where such vectors may.
                    unsafe {
                        let mut quarters = [_mm_setzero_si128(); Self::WIDE];
                        for (i, quarter) in quarters.iter_mut().enumerate() {
                            let place = places[first + every * i] as usize;
                            *quarter = _mm_load_si128(records.as_ptr().add(place).cast());
                        }
                        let $quarters = quarters;
                        $side_by_side
                    }
                }
            }

            impl Records for $level {
                #[inline(always)]
                fn fourths(self, records: &[Record], places: &Places) -> [Line<[u32; LANES]>; 4] {
                    self.check(records, places);
                    let mut words = [Line([0; LANES]); 4];
                    for part in 0..Self::PARTS {
                        let first = 4 * Self::WIDE * part;
                        // SAFETY: all places were checked; the instructions as above.
                        let of_part = unsafe {
                            let a = self.side_by_side(records, places, first, 4);
                            let b = self.side_by_side(records, places, first + 1, 4);
                            let c = self.side_by_side(records, places, first + 2, 4);
                            let d = self.side_by_side(records, places, first + 3, 4);
                            let (ab, cd) = ($low_32(a, b), $low_32(c, d));
                            let (ab_high, cd_high) = ($high_32(a, b), $high_32(c, d));
                            [
                                $low_64(ab, cd),
                                $high_64(ab, cd),
                                $low_64(ab_high, cd_high),
                                $high_64(ab_high, cd_high),
                            ]
                        };
                        for (words, of_part) in words.iter_mut().zip(of_part) {
                            self.write(words, part, of_part);
                        }
                    }
                    words
                }

                #[inline(always)]
                fn halves(self, records: &[Record], places: &Places) -> [Line<[u64; LANES]>; 2] {
                    self.check(records, places);
                    let mut words = [Line([0; LANES]); 2];
                    for part in 0..2 * Self::PARTS {
                        let first = 2 * Self::WIDE * part;
                        // SAFETY: as above; the words of all records are as many parts, and lines begin
                        // where any vector may.
                        unsafe {
                            let a = self.side_by_side(records, places, first, 2);
                            let b = self.side_by_side(records, places, first + 1, 2);
                            let [low, high] = &mut words;
                            std::ptr::from_mut(low).cast::<$part>().add(part).write($low_64(a, b));
                            std::ptr::from_mut(high)
                                .cast::<$part>()
                                .add(part)
                                .write($high_64(a, b));
                        }
                    }
                    words
                }

                #[inline(always)]
                fn numbers(self, numbers: &[f32], places: &Places) -> Lanes {
                    self.check(numbers, places);
                    let mut taken = Line([0.0; LANES]);
                    for part in 0..Self::PARTS {
                        // SAFETY: all places were checked, and as in `check`.
                        let of_part = unsafe {
                            let mut quarters = [_mm_setzero_si128(); Self::WIDE];
                            for (i, quarter) in quarters.iter_mut().enumerate() {
                                *quarter = four(numbers, places, 4 * (Self::WIDE * part + i));
                            }
                            let $quarters = quarters;
                            $side_by_side
                        };
                        self.write(&mut taken, part, of_part);
                    }
                    taken
                }

                #[inline(always)]
                fn samples<T: Copy>(self, samples: &[T], places: &Places) -> Line<[T; LANES]> {
                    self.check(samples, places);
                    let mut taken = Line([samples[places[0] as usize]; LANES]);
                    // Written out: a closure is not always inlined, and then none of it is in registers.
                    for (taken, &place) in taken.iter_mut().zip(places.iter()) {
                        // SAFETY: all places were checked.
                        *taken = unsafe { *samples.get_unchecked(place as usize) };
                    }
                    taken
                }
            }
        };
    }

    /// The numbers at four places from a first one on: what is written one by one is waited for when it is read
    /// together.
    ///
    /// # Safety
    ///
    /// They must be there.
    #[inline(always)]
    unsafe fn four(numbers: &[f32], places: &Places, first: usize) -> __m128i {
        // SAFETY: whoever called vouched for the places; the instructions are always there.
        unsafe {
            let a = _mm_load_ss(numbers.as_ptr().add(places[first] as usize));
            let b = _mm_load_ss(numbers.as_ptr().add(places[first + 1] as usize));
            let c = _mm_load_ss(numbers.as_ptr().add(places[first + 2] as usize));
            let d = _mm_load_ss(numbers.as_ptr().add(places[first + 3] as usize));
            let (ab, cd) = (_mm_unpacklo_ps(a, b), _mm_unpacklo_ps(c, d));
            _mm_castps_si128(_mm_movelh_ps(ab, cd))
        }
    }

    records!(
        Baseline,
        __m128i,
        _mm_set1_epi32,
        |place, end| {
            let lowest = _mm_set1_epi32(i32::MIN);
            let before = _mm_cmplt_epi32(_mm_xor_si128(place, lowest), _mm_xor_si128(end, lowest));
            _mm_movemask_epi8(before) == 0xFFFF
        },
        |quarters| quarters[0],
        _mm_unpacklo_epi32,
        _mm_unpackhi_epi32,
        _mm_unpacklo_epi64,
        _mm_unpackhi_epi64
    );
    records!(
        Avx2,
        __m256i,
        _mm256_set1_epi32,
        |place, end| {
            let beyond = _mm256_cmpeq_epi32(_mm256_max_epu32(place, end), place);
            _mm256_testz_si256(beyond, beyond) == 1
        },
        |quarters| {
            let one = _mm256_castsi128_si256(quarters[0]);
            _mm256_inserti128_si256::<1>(one, quarters[1])
        },
        _mm256_unpacklo_epi32,
        _mm256_unpackhi_epi32,
        _mm256_unpacklo_epi64,
        _mm256_unpackhi_epi64
    );
    records!(
        Avx512,
        __m512i,
        _mm512_set1_epi32,
        |place, end| _mm512_cmpge_epu32_mask(place, end) == 0,
        |quarters| {
            let one = _mm512_castsi128_si512(quarters[0]);
            let two = _mm512_inserti32x4::<1>(one, quarters[1]);
            let three = _mm512_inserti32x4::<2>(two, quarters[2]);
            _mm512_inserti32x4::<3>(three, quarters[3])
        },
        _mm512_unpacklo_epi32,
        _mm512_unpackhi_epi32,
        _mm512_unpacklo_epi64,
        _mm512_unpackhi_epi64
    );
}

#[cfg(test)]
mod tests {
    use std::panic::AssertUnwindSafe;

    use super::*;
    use crate::chance::Chance;
    use crate::kernels::level::{Level, at_every_level};
    use crate::kernels::products::Plain;

    at_every_level! {
        fn fourths[products](records: &[Record], places: &Places) -> [Line<[u32; LANES]>; 4] {
            products.fourths(records, places)
        }

        fn halves[products](records: &[Record], places: &Places) -> [Line<[u64; LANES]>; 2] {
            products.halves(records, places)
        }

        fn samples[products](records: &[Record], places: &Places) -> Line<[Record; LANES]> {
            products.samples(records, places)
        }

        fn numbers[products](numbers: &[f32], places: &Places) -> Lanes {
            products.numbers(numbers, places)
        }
    }

    fn some(chance: &mut Chance, length: u32) -> (Vec<Record>, Places) {
        let mut word = || u64::from(chance.bits(32)) << 32 | u64::from(chance.bits(32));
        let records = (0..length).map(|_| Record([word(), word()])).collect();
        let mut places = Line([0; LANES].map(|_: u32| chance.below(length)));
        // Its ends are asked for too.
        (places[5], places[12]) = (0, length - 1);
        (records, places)
    }

    #[test]
    fn words_are_those_of_their_records_at_every_level() {
        let mut chance = Chance(3);
        for length in [1, 7, 400] {
            let (records, places) = some(&mut chance, length);
            let words = Plain.fourths(&records, &places);
            let wide = Plain.halves(&records, &places);
            let [low, high] = records[places[3] as usize].0;
            assert_eq!(wide.map(|words| words[3]), [low, high]);
            let parts = [low, low >> 32, high, high >> 32].map(|word| word as u32);
            assert_eq!(words.map(|words| words[3]), parts);
            for level in Level::available() {
                eprintln!("level {}", level.name());
                assert_eq!(fourths(level, &records, &places), words, "of {length}");
                assert_eq!(halves(level, &records, &places), wide, "of {length}");
                let of_all = Plain.samples(&records, &places);
                assert_eq!(samples(level, &records, &places), of_all, "of {length}");
                let low = |record: &Record| record.0[0] as u16 as f32;
                let floats: Vec<f32> = records.iter().map(low).collect();
                let of_all = Plain.numbers(&floats, &places);
                assert_eq!(numbers(level, &floats, &places), of_all, "of {length}");
            }
        }
    }

    #[test]
    fn a_place_beyond_the_end_panics_at_every_level() {
        let (records, mut places) = some(&mut Chance(4), 40);
        let refused = |level, records: &[Record], places: &Places| {
            let floats = vec![0.0; records.len()];
            let takes: [&dyn Fn(); 4] = [
                &|| _ = fourths(level, records, places),
                &|| _ = halves(level, records, places),
                &|| _ = samples(level, records, places),
                &|| _ = numbers(level, &floats, places),
            ];
            takes.map(|take| std::panic::catch_unwind(AssertUnwindSafe(take)).is_err())
        };
        for level in Level::available() {
            assert_eq!(refused(level, &records, &places), [false; 4], "all of them are there");
            for l in 0..LANES {
                // The largest one is what a place before the beginning becomes.
                for beyond in [40, i32::MAX as u32, 1 << 31, u32::MAX] {
                    let before = std::mem::replace(&mut places[l], beyond);
                    assert_eq!(refused(level, &records, &places), [true; 4], "{beyond}");
                    places[l] = before;
                }
            }
            assert_eq!(refused(level, &[], &Line([0; LANES])), [true; 4], "there are none");
        }
    }
}
