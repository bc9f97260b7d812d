//! Census and gradient together: robust where exposures differ, sharp where objects end.
//!
//! ```text
//! C(x, y, d) = 75 H / 64 + min(|G_L(x, y) - G_R(x - d, y)|, 20)
//! ```
//!
//! `H` is the Hamming distance of two census words (0 to 34), `G` the grey step along the row
//! ([`crate::prepare::gradient`]). A census word does not know how large a step is, only its sign; a
//! difference of gradients does, and looks at three columns only, so it keeps edges where a window
//! smears them. Truncated, it cannot outvote the census where gain differs (Mei et al., ICCV
//! Workshops 2011, mix census and absolute differences in this way).

use raster::Plane;

use super::SearchSpace;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::path::padded;
use crate::optimization::semi_global::CostRows;
use crate::prepare::census::{BITS, census_row};
use crate::prepare::gradient::steps_along_row;

/// A difference of grey steps counts at most this.
const LARGEST_STEP: u8 = 20;
/// What a census bit counts, in 1/64.
const BIT: u8 = 75;
/// The largest cost.
const LARGEST: u16 = (BITS as u16 * BIT as u16) / 64 + LARGEST_STEP as u16;
const _: () = assert!(LARGEST < 128, "a path's state must fit a byte");

/// What the costs of one image are computed from, of the rows of a box.
#[derive(Default)]
struct Features {
    words: Plane<u64>,
    steps: Plane<u8>,
}

/// The features of both images.
#[derive(Default)]
pub(crate) struct FeaturePair {
    left: Features,
    right: Features,
    scratch: Vec<u16>,
}

impl FeaturePair {
    /// Computes the features of rows `first..first + rows` of both images, given at both depths.
    pub fn compute(
        &mut self,
        level: Level,
        images: [&Plane<u16>; 2],
        grey: [&Plane<u8>; 2],
        first: usize,
        rows: usize,
    ) {
        let columns = images[0].columns();
        let both = [&mut self.left, &mut self.right];
        for ((features, image), grey) in both.into_iter().zip(images).zip(grey) {
            features.words.reset(columns, rows, 0);
            features.steps.reset(columns, rows, 0);
            for y in 0..rows {
                let words = features.words.row_mut(y);
                census_row(level, image, first + y, &mut self.scratch, words);
                steps_along_row(grey.row(first + y), features.steps.row_mut(y));
            }
        }
    }

    /// The costs over a search space.
    pub fn costs<'a>(&'a self, level: Level, space: &'a SearchSpace) -> CensusGradientRows<'a> {
        CensusGradientRows { level, features: self, space }
    }
}

/// The costs of the rows of a box. A disparity whose match lies outside the right image is compared
/// with the nearest column inside, so that paths can cross.
pub(crate) struct CensusGradientRows<'a> {
    level: Level,
    features: &'a FeaturePair,
    space: &'a SearchSpace,
}

/// Right row samples in the order in which disparities meet them: place `i` holds column
/// `last - min - i`, the border repeated.
fn reverse<T: Copy>(row: &[T], space: &SearchSpace, length: usize) -> Vec<T> {
    let start = space.last as i64 - i64::from(space.min);
    let end = row.len() as i64 - 1;
    (0..length as i64).map(|i| row[(start - i).clamp(0, end) as usize]).collect()
}

at_every_level! {
    /// Costs of one pixel over `costs.len()` disparities.
    fn pixel_costs(word: u64, step: u8, words: &[u64], steps: &[u8], costs: &mut [u8]) {
        for ((cost, &other), &other_step) in costs.iter_mut().zip(words).zip(steps) {
            let bits = (word ^ other).count_ones() as u16;
            let census = (bits * u16::from(BIT) / 64) as u8;
            *cost = census + step.abs_diff(other_step).min(LARGEST_STEP);
        }
    }
}

impl CostRows for CensusGradientRows<'_> {
    fn columns(&self) -> usize {
        self.space.columns()
    }

    fn rows(&self) -> usize {
        self.features.left.words.rows()
    }

    fn count(&self) -> usize {
        self.space.count
    }

    fn fill_row(&self, y: usize, costs: &mut [u8]) {
        let (space, FeaturePair { left, right, .. }) = (self.space, self.features);
        let (count, columns) = (space.count, space.columns());
        let length = columns + count;
        let words = reverse(right.words.row(y), space, length);
        let steps = reverse(right.steps.row(y), space, length);
        let pixels = costs.chunks_exact_mut(padded(count)).enumerate();
        for (x, costs) in pixels {
            // Disparity `k` of this column is compared with place `columns - 1 - x + k`.
            let from = columns - 1 - x;
            let column = space.first + x;
            pixel_costs(
                self.level,
                left.words.row(y)[column],
                left.steps.row(y)[column],
                &words[from..from + count],
                &steps[from..from + count],
                &mut costs[..count],
            );
            costs[count..].fill(255);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::{BoundingBox, DisparityRange};

    #[test]
    fn rows_are_their_definition_at_every_level() {
        let scramble = |x: usize, y: usize, seed: usize| {
            ((x * 7919 + y * 104_729 + seed * 31).wrapping_mul(2_654_435_761) >> 7) as u8
        };
        let left = Plane::from_fn(40, 6, |x, y| scramble(x, y, 1));
        let right = Plane::from_fn(40, 6, |x, y| scramble(x + 3, y, 1));
        let wide = |p: &Plane<u8>| p.map(|&v| u16::from(v) * 257);
        let range = DisparityRange::new(-4, 37).unwrap();
        let space = SearchSpace::new(40, BoundingBox::new(5, 1, 38, 4).unwrap(), range);
        for level in Level::available() {
            eprintln!("level {}", level.name());
            let mut pair = FeaturePair::default();
            pair.compute(level, [&wide(&left), &wide(&right)], [&left, &right], 1, 4);
            let rows = pair.costs(level, &space);
            let mut costs = vec![0; space.columns() * padded(space.count)];
            for y in 0..4 {
                rows.fill_row(y, &mut costs);
                for (x, costs) in costs.chunks_exact(padded(space.count)).enumerate() {
                    let x = x + space.first;
                    for (k, &cost) in costs[..space.count].iter().enumerate() {
                        let at = (x as i64 - i64::from(space.min) - k as i64).clamp(0, 39) as usize;
                        let word = pair.left.words.row(y)[x] ^ pair.right.words.row(y)[at];
                        let (a, b) = (pair.left.steps.row(y)[x], pair.right.steps.row(y)[at]);
                        let expected =
                            word.count_ones() * 75 / 64 + u32::from(a.abs_diff(b).min(20));
                        assert_eq!(u32::from(cost), expected, "({x}, {y}), {k}");
                    }
                    assert!(costs[space.count..].iter().all(|&c| c == 255));
                }
            }
        }
    }
}
