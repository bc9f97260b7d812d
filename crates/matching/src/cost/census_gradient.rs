//! Census and gradient together: robust where exposures differ, sharp where objects end.
//!
//! ```text
//! C(x, y, d) = 75 H / 64 + min(|G_L(x, y) - G_R(x - d, y)|, 20)
//! ```
//!
//! `H` is the Hamming distance of two census words (0 to 32), `G` the grey step along the row
//! ([`crate::prepare::gradient`]). A census word does not know how large a step is, only its sign; a
//! difference of gradients does, and looks at three columns only, so it keeps edges where a window
//! smears them. Truncated, it cannot outvote the census where gain differs (Mei et al., ICCV
//! Workshops 2011, mix census and absolute differences in this way).

use raster::Plane;
use rayon::prelude::*;

use super::SearchSpace;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::path::LANES;
use crate::optimization::semi_global::CostRows;
use crate::prepare::census::{self, BITS, CensusRows};
use crate::prepare::gradient::steps_along_row;
use crate::prepare::grey::GreyView;
use crate::profile::Work;

/// A difference of grey steps counts at most this.
const LARGEST_STEP: u8 = 20;
/// What a census bit counts, in 1/64.
const BIT: u8 = 75;
/// The largest cost.
const LARGEST: u16 = (BITS as u16 * BIT as u16) / 64 + LARGEST_STEP as u16;
const _: () = assert!(LARGEST < 128, "a path's state must fit a byte");

/// An image as census words see it, in all its bits, and as everything else does, in the upper 8.
pub(crate) type Seen<'a> = (GreyView<'a>, &'a Plane<u8>);

/// What the costs of one image are computed from, of the rows of a box.
#[derive(Default)]
struct Features {
    words: Plane<u32>,
    steps: Plane<u8>,
    /// Of each band of rows.
    scratch: Vec<Scratch>,
}

/// A row of the whole image, before its columns are put in their place.
#[derive(Default)]
struct Scratch {
    census: CensusRows,
    words: Vec<u32>,
    steps: Vec<u8>,
}

/// The features of both images.
#[derive(Default)]
pub(crate) struct FeaturePair {
    left: Features,
    /// In a mirror, so that larger disparities stand at larger columns, and its ends repeated: a
    /// disparity whose match lies outside the image is compared with the nearest column inside, so
    /// that paths can cross.
    right: Features,
}

/// A row from right to left between two margins that repeat its ends.
fn mirror<T: Copy>(row: &[T], out: &mut [T]) {
    let margin = (out.len() - row.len()) / 2;
    let (first, last) = (row[0], row[row.len() - 1]);
    out[..margin].fill(last);
    out[margin + row.len()..].fill(first);
    out[margin..].iter_mut().zip(row.iter().rev()).for_each(|(to, &from)| *to = from);
}

impl Features {
    /// Computes features of `rows` rows of an image from row `first` on: `take(words, steps, ..)`
    /// puts those of a row in their place. Both views of the image are read, words and steps written.
    fn compute(
        &mut self,
        level: Level,
        (image, grey): Seen<'_>,
        (first, rows): (usize, usize),
        columns: usize,
        take: impl Fn(&[u32], &[u8], &mut [u32], &mut [u8]) + Sync,
    ) -> Work {
        let width = image.size().0;
        self.words.reset(columns, rows, 0);
        self.steps.reset(columns, rows, 0);
        let height = rows.div_ceil(rayon::current_num_threads());
        self.scratch.resize_with(rows.div_ceil(height), Scratch::default);
        let words = self.words.samples_mut().par_chunks_mut(columns * height);
        let steps = self.steps.samples_mut().par_chunks_mut(columns * height);
        let bands = words.zip(steps).zip(&mut self.scratch);
        bands.enumerate().for_each(|(i, ((words, steps), scratch))| {
            scratch.words.resize(width, 0);
            scratch.steps.resize(width, 0);
            let rows = words.chunks_mut(columns).zip(steps.chunks_mut(columns));
            for (y, (words, steps)) in (first + i * height..).zip(rows) {
                scratch.census.words(level, image, y, &mut scratch.words);
                steps_along_row(grey.row(y), &mut scratch.steps);
                take(&scratch.words, &scratch.steps, words, steps);
            }
        });
        let read = image.bytes(rows) + width * rows;
        Work::bytes(read + self.bytes()) + Work::operations(census::OPERATIONS) * (width * rows)
    }

    /// Bytes of all words and steps.
    fn bytes(&self) -> usize {
        size_of_val(self.words.samples()) + size_of_val(self.steps.samples())
    }
}

impl FeaturePair {
    /// Computes the features of the columns of a search space and of `rows` rows from row `first`
    /// on.
    pub fn compute(
        &mut self,
        level: Level,
        [left, right]: [Seen<'_>; 2],
        space: &SearchSpace,
        rows: (usize, usize),
    ) -> Work {
        let answered = space.first..=space.last;
        let columns = space.columns();
        let left = self.left.compute(level, left, rows, columns, |words, steps, to, to_steps| {
            to.copy_from_slice(&words[answered.clone()]);
            to_steps.copy_from_slice(&steps[answered.clone()]);
        });
        let columns = space.width + 2 * space.lanes;
        let right =
            self.right.compute(level, right, rows, columns, |words, steps, to, to_steps| {
                mirror(words, to);
                mirror(steps, to_steps);
            });
        left + right
    }

    /// The costs over the search space that the features were computed for.
    pub fn costs<'a>(&'a self, level: Level, space: &'a SearchSpace) -> CensusGradientRows<'a> {
        CensusGradientRows { level, features: self, space }
    }
}

/// The costs of the rows of a box.
pub(crate) struct CensusGradientRows<'a> {
    level: Level,
    features: &'a FeaturePair,
    space: &'a SearchSpace,
}

at_every_level! {
    /// The costs of a row.
    fn row_costs(features: &FeaturePair, space: &SearchSpace, y: usize, costs: &mut [u8]) {
        let FeaturePair { left, right } = features;
        let (left_words, left_steps) = (left.words.row(y), left.steps.row(y));
        let (words, steps) = (right.words.row(y), right.steps.row(y));
        let farthest = (space.width + space.lanes) as i64;
        for (x, costs) in costs.chunks_exact_mut(space.lanes).enumerate() {
            let place = space.mirrored(space.first + x) + space.lanes as i64;
            let place = place.clamp(0, farthest) as usize;
            let (word, step) = (left_words[x], left_steps[x]);
            let words = words[place..place + space.lanes].as_chunks::<LANES>().0;
            let steps = steps[place..place + space.lanes].as_chunks::<LANES>().0;
            let groups = costs.as_chunks_mut::<LANES>().0.iter_mut().zip(words).zip(steps);
            for ((costs, words), steps) in groups {
                // One loop per width of number, so that each fills its vectors.
                let mut bits = [0u8; LANES];
                for i in 0..LANES {
                    bits[i] = (word ^ words[i]).count_ones() as u8;
                }
                for i in 0..LANES {
                    let census = (u16::from(bits[i]) * u16::from(BIT) / 64) as u8;
                    // `abs_diff` would go through 32 bits.
                    let difference = step.max(steps[i]) - step.min(steps[i]);
                    costs[i] = census + difference.min(LARGEST_STEP);
                }
            }
            if space.count < space.lanes {
                costs[space.count..].fill(255);
            }
        }
    }
}

impl CostRows for CensusGradientRows<'_> {
    /// Words are compared and their bits counted (of 32 bits), weighed by a product and a shift (of
    /// 16); a difference of steps is three operations, bounding and adding it two.
    const OPERATIONS: usize = 2 * 4 + 2 * 2 + 3 + 2;

    fn columns(&self) -> usize {
        self.space.columns()
    }

    fn rows(&self) -> usize {
        self.features.left.words.rows()
    }

    fn count(&self) -> usize {
        self.space.count
    }

    fn bytes(&self) -> usize {
        self.features.left.bytes() + self.features.right.bytes()
    }

    fn fill_row(&self, y: usize, costs: &mut [u8]) {
        row_costs(self.level, self.features, self.space, y, costs);
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
        let views = [&left, &right].map(|image| (GreyView::Depth8(image.view()), image));
        let word = |(view, _): Seen<'_>, x: usize, y: usize| {
            let mut words = [0; 40];
            CensusRows::default().words(Level::detect(), view, y, &mut words);
            words[x]
        };
        let step = |(_, grey): Seen<'_>, x: usize, y: usize| {
            let mut steps = [0; 40];
            steps_along_row(grey.row(y), &mut steps);
            steps[x]
        };
        // The second range begins where no match lies inside.
        for (range, columns) in [((-4, 37), (5, 38)), ((10, 30), (0, 39)), ((-60, -31), (3, 12))] {
            let range = DisparityRange::new(range.0, range.1).unwrap();
            let bounds = BoundingBox::new(columns.0, 1, columns.1, 4).unwrap();
            let space = SearchSpace::new(40, bounds, range);
            for level in Level::available() {
                eprintln!("level {}", level.name());
                let mut pair = FeaturePair::default();
                pair.compute(level, views, &space, (1, 4));
                let rows = pair.costs(level, &space);
                let mut costs = vec![0; space.columns() * space.lanes];
                for y in 0..4 {
                    rows.fill_row(y, &mut costs);
                    for (x, costs) in costs.chunks_exact(space.lanes).enumerate() {
                        let x = x + space.first;
                        for (k, &cost) in costs[..space.count].iter().enumerate() {
                            let at = x as i64 - i64::from(space.min) - k as i64;
                            let at = at.clamp(0, 39) as usize;
                            let bits =
                                (word(views[0], x, y + 1) ^ word(views[1], at, y + 1)).count_ones();
                            let (a, b) = (step(views[0], x, y + 1), step(views[1], at, y + 1));
                            let expected = bits * 75 / 64 + u32::from(a.abs_diff(b).min(20));
                            assert_eq!(u32::from(cost), expected, "({x}, {y}), {k}");
                        }
                        assert!(costs[space.count..].iter().all(|&c| c == 255));
                    }
                }
            }
        }
    }
}
