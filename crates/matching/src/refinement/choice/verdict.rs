//! What the scores of a pixel's candidates come to.
//!
//! Scores become probabilities (softmax), and the candidate is taken that is expected to be off by the least, where
//! being off by more than [`FAR`] pixels is as bad as being off by that: of several that say nearly the same the one in
//! the middle wins, and one that stands alone must be likely.

use super::block::{Block, LANES, NONE};
use super::reach::{GROUP, MOST};
use super::relations::{NO_NUMBERS, PARTS, in_turns};
use crate::kernels::aligned::Line;
use crate::kernels::products::{Lanes, Numbers, Products, Sums};
use crate::kernels::rounding::nearest;

/// Errors beyond this, in pixels, are as bad as this.
pub(super) const FAR: f32 = 3.0;
const FAR_IN_PARTS: i16 = (FAR * PARTS) as i16;
/// The share of a candidate that is certain, in numbers of 16 bits.
const ALL: f32 = 32767.0;

/// What a judge says of pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Verdict {
    pub disparity: Lanes,
    /// In `[0, 1]`.
    pub certainty: Lanes,
}

/// What candidates are weighed with; vectors begin where cache lines do.
#[repr(C, align(64))]
pub(super) struct Odds {
    /// How likely each is, in parts of [`ALL`], of two after the other.
    shares: [Numbers; MOST / 2],
    /// How far each is expected to be off.
    expected: [Sums; MOST],
}

impl Default for Odds {
    fn default() -> Self {
        Self { shares: [NO_NUMBERS; MOST / 2], expected: [Line([0; LANES]); MOST] }
    }
}

/// The candidate that is expected to be off by the least, by the scores of all; these become how likely each is.
#[inline(always)]
pub(super) fn verdict(
    products: impl Products,
    block: &Block,
    scores: &mut [Lanes; MOST],
    odds: &mut Odds,
) -> Verdict {
    let Odds { shares, expected } = odds;
    let n = block.candidates();
    let mut best = Line([f32::NEG_INFINITY; LANES]);
    for k in 0..n {
        for l in 0..LANES {
            let counts = (block.inside[k][l] > 0.0) & (scores[k][l] > best[l]);
            best[l] = if counts { scores[k][l] } else { best[l] };
        }
    }
    let mut all = NONE;
    for k in 0..n {
        for l in 0..LANES {
            let share = exp(scores[k][l] - best[l]);
            let share = if block.inside[k][l] > 0.0 { share } else { 0.0 };
            scores[k][l] = share;
            all[l] += share;
        }
    }
    let mut scale = NONE;
    for l in 0..LANES {
        scale[l] = ALL / all[l];
    }
    for (shares, [one, other]) in shares.iter_mut().zip(scores[..n].as_chunks().0) {
        *shares = in_turns(&scaled(one, &scale), &scaled(other, &scale));
    }
    // Some that grow together: what the others say is read once for all of these.
    for (i, expected) in expected[..n].as_chunks_mut::<GROUP>().0.iter_mut().enumerate() {
        let [one, two] = block.relations.of(products, 2 * i);
        let [three, four] = block.relations.of(products, 2 * i + 1);
        let candidates = [&one, &two, &three, &four];
        *expected = products.apart(candidates, FAR_IN_PARTS, block.relations.pairs(), shares);
    }
    let mut least = Line([i32::MAX; LANES]);
    for (k, (expected, inside)) in expected[..n].iter().zip(&block.inside).enumerate() {
        least = winner(&least, expected, inside, k);
    }
    let mut disparity = NONE;
    for l in 0..LANES {
        disparity[l] = block.disparities[least[l] as usize % MOST][l];
        least[l] /= MOST as i32;
    }
    let mut certainty = NONE;
    for l in 0..LANES {
        // Shares are rounded.
        let sure = 1.0 - least[l] as f32 * (1.0 / (FAR * PARTS * ALL));
        certainty[l] = if sure > 0.0 { sure } else { 0.0 };
    }
    Verdict { disparity, certainty }
}

/// The least so far or that of a candidate inside the map.
#[inline(always)]
fn winner(least: &Sums, expected: &Sums, inside: &Lanes, candidate: usize) -> Sums {
    let mut winner = Line([0; LANES]);
    for l in 0..LANES {
        let key = expected[l] * MOST as i32 + candidate as i32;
        let key = if inside[l] > 0.0 { key } else { i32::MAX };
        winner[l] = if key < least[l] { key } else { least[l] };
    }
    winner
}

#[inline(always)]
fn scaled(numbers: &Lanes, scale: &Lanes) -> Sums {
    let mut scaled = Line([0; LANES]);
    for l in 0..LANES {
        scaled[l] = nearest(numbers[l] * scale[l]);
    }
    scaled
}

/// `e^x` of what is not positive, by powers of two and a polynomial of what is left (its Taylor
/// series): the same on every machine, off by less than 3e-6. What is positive counts as 0.
#[inline(always)]
fn exp(x: f32) -> f32 {
    let x = if x < -60.0 { -60.0 } else { x };
    let x = if x < 0.0 { x } else { 0.0 };
    let power = x * std::f32::consts::LOG2_E;
    let whole = nearest(power);
    let rest = (power - whole as f32) * std::f32::consts::LN_2;
    let series = 1.0
        + rest
            * (1.0
                + rest * (0.5 + rest * (1.0 / 6.0 + rest * (1.0 / 24.0 + rest * (1.0 / 120.0)))));
    series * f32::from_bits(((whole + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::products::Plain;
    use crate::refinement::choice::reach::WIDE;

    #[test]
    fn of_many_that_say_nearly_the_same_the_middle_wins_and_one_alone_does_not() {
        let disparity = |k: usize| if k == 0 { 30.0 } else { k as f32 / PARTS };
        let block = Block::of(&WIDE, std::array::from_fn(|k| Line([disparity(k); LANES])));
        let Verdict { disparity, certainty } =
            verdict(Plain, &block, &mut [NONE; MOST], &mut Odds::default());
        assert_eq!(*disparity, [16.0 / PARTS; LANES]);
        // One of 32 is as bad as can be, the others are off by a little.
        let sure = certainty[3];
        assert!(sure > 0.9 && sure < 31.0 / 32.0, "{sure}");
    }

    #[test]
    fn powers_of_e() {
        for x in [0.0, -1e-3, -0.3, -0.5, -1.0, -7.7, -30.0] {
            let (ours, exact) = (f64::from(exp(x)), f64::from(x).exp());
            assert!((ours / exact - 1.0).abs() < 3e-6, "{x}: {ours} {exact}");
        }
        assert!(exp(-1000.0) < 1e-25 && exp(f32::MIN) >= 0.0);
        assert_eq!([exp(1.0), exp(f32::INFINITY), exp(f32::NAN)], [1.0; 3]);
    }
}
