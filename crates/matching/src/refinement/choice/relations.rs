//! How the candidates of pixels lie to each other, in numbers of 16 bits: every one is compared with every
//! other one, twice, so that is where the time of a choice goes.
//!
//! A vector holds two candidates of 16 pixels, in turns pixel by pixel, as sums of products take them.

use super::block::LANES;
use super::reach::MOST;
use crate::kernels::aligned::Line;
use crate::kernels::nearness::Nearness;
use crate::kernels::products::{Lanes, Numbers, Sums};
use crate::kernels::rounding::nearest;

/// Parts of a pixel of disparity.
pub(super) const PARTS: f32 = 64.0;
/// Candidates that lie farther than so many pixels from what a pixel has are as good as there. Differences of
/// any two then have 16 bits.
const FARTHEST: f32 = 255.0;
/// Candidates within so many parts say the same: a pixel.
pub(super) const SAME: i16 = PARTS as i16;

pub(super) const NO_NUMBERS: Numbers = Line([0; 2 * LANES]);

/// Where the candidates lie from what the pixels have, two after the other.
#[derive(Debug)]
#[repr(C, align(64))]
pub(super) struct Relations {
    pairs: [Numbers; MOST / 2],
    count: usize,
}

impl Default for Relations {
    fn default() -> Self {
        Self { pairs: [NO_NUMBERS; MOST / 2], count: 0 }
    }
}

impl Relations {
    /// Of candidates with these disparities, an even number of them.
    #[inline(always)]
    pub fn find(&mut self, disparities: &[Lanes], here: &Lanes) {
        let candidates = disparities.as_chunks::<2>().0;
        for (pair, [one, other]) in self.pairs.iter_mut().zip(candidates) {
            *pair = in_turns(&relative(one, here), &relative(other, here));
        }
        self.count = candidates.len();
    }

    pub fn pairs(&self) -> &[Numbers] {
        &self.pairs[..self.count]
    }

    /// The two candidates of a pair, each in the places of both.
    #[inline(always)]
    pub fn of(&self, nearness: impl Nearness, pair: usize) -> [Numbers; 2] {
        nearness.of_each(&self.pairs[pair])
    }
}

#[inline(always)]
fn relative(disparity: &Lanes, here: &Lanes) -> Sums {
    let mut relative = Line([0; LANES]);
    for l in 0..LANES {
        let away = disparity[l] - here[l];
        let away = if away < FARTHEST { away } else { FARTHEST };
        relative[l] = nearest(PARTS * if away > -FARTHEST { away } else { -FARTHEST });
    }
    relative
}

/// Numbers of two candidates, which 16 bits can hold, in turns.
#[inline(always)]
pub(super) fn in_turns(one: &Sums, other: &Sums) -> Numbers {
    let mut numbers = NO_NUMBERS;
    for (numbers, (&one, &other)) in
        numbers.as_chunks_mut().0.iter_mut().zip(one.iter().zip(&**other))
    {
        *numbers = [one as i16, other as i16];
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::products::Plain;

    #[test]
    fn candidates_are_compared_in_parts_of_a_pixel() {
        let mut relations = Relations::default();
        let disparities = [3.0, 3.5, 3.99, 4.01, 3.0 - 1e6, 1e9].map(|d| Line([d; LANES]));
        relations.find(&disparities, &Line([3.0; LANES]));
        assert_eq!(relations.pairs().len(), 3);
        let [first, second] = relations.of(Plain, 0);
        let pairs = relations.pairs();
        assert_eq!([first, second].map(|of| of[..2].to_vec()), [[0, 0], [32, 32]]);
        // Of either of a pair, told apart by their weights.
        let weights = Line(std::array::from_fn(|i| if i % 2 == 0 { 1 } else { 100 }));
        let apart = |one: &Numbers, pair: usize, most: i16| {
            Plain.apart([one], most, &pairs[pair..=pair], &[weights])[0]
        };
        let same = |one: &Numbers, pair: usize| {
            Plain.near([one], SAME, &pairs[pair..=pair], &[[weights]])[0][0]
        };
        assert_eq!(*apart(&first, 0, 192), [100 * 32; LANES]);
        assert_eq!(*apart(&second, 2, 192), [192 + 100 * 192; LANES]);
        assert_eq!(*same(&first, 1), [1; LANES]);
        // The farthest ones are not near to each other.
        let [low, high] = relations.of(Plain, 2);
        let apart: [i32; 2 * LANES] =
            std::array::from_fn(|i| i32::from(high[i]) - i32::from(low[i]));
        assert_eq!(apart, [32_640; 2 * LANES]);
        assert_eq!(*same(&low, 2), [1; LANES]);
    }
}
