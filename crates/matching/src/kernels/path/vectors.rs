//! Bytes of disparities side by side, one vector of them: what the paths need beyond arithmetic.

use fearless_simd::{
    Simd, SimdBase, SimdCombine, SimdInt, SimdIntWiden, SimdSplit, SimdWiden, u8x16, u8x32, u8x64,
};

/// A vector of bytes, one per disparity.
pub trait Disparities<S: Simd>: SimdInt<S, Element = u8> {
    /// Bytes as whole vectors.
    fn vectors_mut(bytes: &mut [u8]) -> &mut [Self::Array];

    /// What stands `rise + 1`, `rise` and `rise - 1` disparities lower, `earlier` and `later` being the
    /// vectors beside this one.
    fn around(self, earlier: Self, later: Self, rise: i8) -> [Self; 3];

    /// The first bytes, or only half as many and 255 for all others.
    fn load(simd: S, bytes: &[u8], whole: bool) -> Self;

    /// Stores all or only the lower half.
    fn store(self, bytes: &mut [u8], whole: bool);

    /// Stores eight times each of these and the two others of its lane, all or only the lower half.
    fn total(self, one: Self, other: Self, sums: &mut [u16], whole: bool);
}

/// For vectors of so many bytes: how half of one is loaded and stored, where counts of disparities are not
/// always whole vectors.
macro_rules! disparities {
    ($vector:ident, $count:literal $(, $load_half:ident, $store_half:ident)?) => {
        impl<S: Simd> Disparities<S> for $vector<S> {
            #[inline(always)]
            fn vectors_mut(bytes: &mut [u8]) -> &mut [Self::Array] {
                bytes.as_chunks_mut().0
            }

            #[inline(always)]
            fn around(self, earlier: Self, later: Self, rise: i8) -> [Self; 3] {
                let (lower, upper) = (earlier.slide::<{ $count - 1 }>(self), self.slide::<1>(later));
                let (lower2, upper2) = (earlier.slide::<{ $count - 2 }>(self), self.slide::<2>(later));
                match rise {
                    ..=-2 => [upper, upper2, self.slide::<3>(later)],
                    -1 => [self, upper, upper2],
                    0 => [lower, self, upper],
                    1 => [lower2, lower, self],
                    2.. => [earlier.slide::<{ $count - 3 }>(self), lower2, lower],
                }
            }

            #[inline(always)]
            fn load(simd: S, bytes: &[u8], _whole: bool) -> Self {
                $(if !_whole {
                    return $load_half(simd, bytes);
                })?
                Self::from_slice(simd, &bytes[..$count])
            }

            #[inline(always)]
            fn store(self, bytes: &mut [u8], _whole: bool) {
                $(if !_whole {
                    return $store_half(self, bytes);
                })?
                self.store_slice(&mut bytes[..$count]);
            }

            #[inline(always)]
            fn total(self, one: Self, other: Self, sums: &mut [u16], whole: bool) {
                let (costs, others) = (self.widen(), one.widening_add(other));
                ((costs.0 << 3) + others.0).store_slice(&mut sums[..$count / 2]);
                if whole {
                    ((costs.1 << 3) + others.1).store_slice(&mut sums[$count / 2..$count]);
                }
            }
        }
    };
}

disparities!(u8x16, 16);
disparities!(u8x32, 32);
disparities!(u8x64, 64, load_32, store_32);

#[inline(always)]
fn load_32<S: Simd>(simd: S, bytes: &[u8]) -> u8x64<S> {
    u8x32::from_slice(simd, &bytes[..32]).combine(u8x32::splat(simd, 255))
}

#[inline(always)]
fn store_32<S: Simd>(vector: u8x64<S>, bytes: &mut [u8]) {
    vector.split().0.store_slice(&mut bytes[..32]);
}
