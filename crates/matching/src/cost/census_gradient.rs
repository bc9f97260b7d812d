//! Census and gradient together, robust where exposures differ, sharp where objects end; and learned
//! descriptors beside them, which tell more places apart.
//!
//! ```text
//! C(x, y, d) = w H / 64 + min(|G_L(x, y) - G_R(x - d, y)|, 20) + v L / 64
//! ```
//!
//! `H` is the Hamming distance of two census words (0 to 32), `G` the grey step along the row
//! ([`crate::prepare::gradient`]), `L` the Hamming distance of two descriptors (0 to 64,
//! [`crate::prepare::descriptor`]). A census word does not know how large a step is, only its sign; a
//! difference of gradients does, and looks at three columns only, so it keeps edges where a window
//! smears them. Truncated, it cannot outvote the census where gain differs (Mei et al., ICCV
//! Workshops 2011, mix census and absolute differences in this way). Descriptors count nearly as
//! much as both together, and more where there was no match ([`Weights`]).
//!
//! Where a pixel stands for itself and its neighbours in the next row and column, its word sees all four
//! ([`crate::prepare::census`]), and steps are those of the mean of both rows.

use raster::{Plane, View};
use rayon::prelude::*;

use super::{MatchedRows, SearchSpace};
use crate::kernels::bits::{Bits, Weight};
use crate::kernels::every::take_every;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::path::{LANES, LARGEST_COST};
use crate::optimization::semi_global::CostRows;
use crate::prepare::census::{self, BITS, CensusRows};
use crate::prepare::descriptor::Descriptors;
use crate::prepare::gradient::{mean_of_rows, steps_along_row};
use crate::prepare::grey::GreyView;
use crate::profile::Work;

/// A difference of grey steps counts at most this.
pub(crate) const LARGEST_STEP: u8 = 20;

/// What a bit counts.
#[derive(Debug)]
struct Weights {
    /// Of census words.
    census: Weight,
    /// Of descriptors, in 64ths.
    descriptor: u16,
}

/// Without descriptors, with them, and with them where a pixel is in doubt.
static CENSUS: Weights = Weights::new(75, 0);
static CERTAIN: Weights = Weights::new(45, 35);
static DOUBTFUL: Weights = Weights::new(20, 45);

impl Weights {
    const fn new(census: u16, descriptor: u16) -> Self {
        let largest = (BITS as u16 * census + 64 * descriptor) / 64 + LARGEST_STEP as u16;
        assert!(largest <= LARGEST_COST as u16, "paths and their sums have no room for more");
        Self { census: Weight::new(census), descriptor }
    }
}

/// An image as census words see it, in all its bits, and as everything else does, in the upper 8.
pub(crate) type Seen<'a> = (GreyView<'a>, View<'a, u8>);

/// What the costs of one image are computed from, of the rows of a box.
#[derive(Default)]
struct Features {
    words: Plane<u32>,
    steps: Plane<u8>,
    /// Empty where none are asked for.
    descriptors: Plane<u64>,
    /// Of each band of rows.
    scratch: Vec<Scratch>,
}

/// A row of the whole image, before its columns are put in their place.
#[derive(Default)]
struct Scratch {
    census: CensusRows,
    words: Vec<u32>,
    /// Of a row and the next.
    mean: Vec<u8>,
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
    network: Descriptors,
}

/// How a row of the whole image comes to stand in its features.
enum Place {
    /// From a column on every so many-th.
    Every { first: usize, apart: usize },
    /// From right to left between two margins that repeat its ends.
    Mirror,
}

impl Place {
    fn put<T: Copy>(&self, row: &[T], out: &mut [T]) {
        match self {
            Place::Every { first, apart } => take_every(*apart, &row[*first..], out),
            Place::Mirror => {
                let margin = (out.len() - row.len()) / 2;
                let (first, last) = (row[0], row[row.len() - 1]);
                out[..margin].fill(last);
                out[margin + row.len()..].fill(first);
                out[margin..].iter_mut().zip(row.iter().rev()).for_each(|(to, &from)| *to = from);
            }
        }
    }
}

impl Features {
    /// Computes features of some rows of an image, `columns` in each. Both views of the image are read, words
    /// and steps written.
    fn compute(
        &mut self,
        level: Level,
        (image, grey): Seen<'_>,
        rows: MatchedRows,
        columns: usize,
        place: Place,
    ) -> Work {
        let (width, image_rows) = image.size();
        let pair = rows.apart > 1;
        self.words.reshape(columns, rows.count, 0);
        self.steps.reshape(columns, rows.count, 0);
        let height = rows.count.div_ceil(rayon::current_num_threads());
        self.scratch.resize_with(rayon::current_num_threads(), Scratch::default);
        let words = self.words.samples_mut().par_chunks_mut(columns * height);
        let steps = self.steps.samples_mut().par_chunks_mut(columns * height);
        let bands = words.zip(steps).zip(&mut self.scratch);
        bands.enumerate().for_each(|(i, ((words, steps), scratch))| {
            scratch.words.resize(width, 0);
            scratch.steps.resize(width, 0);
            let out = words.chunks_mut(columns).zip(steps.chunks_mut(columns));
            for (row, (words, steps)) in (i * height..).zip(out) {
                let y = rows.in_image(row);
                scratch.census.words(level, image, y, pair, &mut scratch.words);
                let mut seen = grey.row(y);
                if pair {
                    scratch.mean.resize(width, 0);
                    mean_of_rows(seen, grey.row((y + 1).min(image_rows - 1)), &mut scratch.mean);
                    seen = &scratch.mean;
                }
                steps_along_row(seen, &mut scratch.steps);
                place.put(&scratch.words, words);
                place.put(&scratch.steps, steps);
            }
        });
        let read = rows.apart * (image.bytes(rows.count) + width * rows.count);
        Work::bytes(read + self.bytes())
            + Work::operations(census::OPERATIONS) * (width * rows.count)
    }

    /// Computes the descriptors of the same rows. The whole image is read once for its mean, then its
    /// rows, and descriptors are written.
    fn describe(
        &mut self,
        level: Level,
        image: GreyView<'_>,
        first: usize,
        place: Place,
        network: &mut Descriptors,
    ) -> Work {
        let (columns, rows) = self.words.size();
        self.descriptors.reshape(columns, rows, 0);
        let put = |words: &[u64], out: &mut [u64]| place.put(words, out);
        network.compute(level, image, first, &mut self.descriptors, put)
            + Work::bytes(size_of_val(self.descriptors.samples()))
    }

    /// Bytes of all words and steps.
    fn bytes(&self) -> usize {
        size_of_val(self.words.samples()) + size_of_val(self.steps.samples())
    }
}

impl FeaturePair {
    /// Computes the features of the columns of a search space and of some rows.
    pub fn compute(
        &mut self,
        level: Level,
        [left, right]: [Seen<'_>; 2],
        space: &SearchSpace,
        rows: MatchedRows,
    ) -> Work {
        let place = Place::Every { first: space.first, apart: space.apart };
        let left = self.left.compute(level, left, rows, space.columns(), place);
        let columns = space.width + 2 * space.lanes;
        left + self.right.compute(level, right, rows, columns, Place::Mirror)
    }

    /// Computes the descriptors of the same rows from row `first` on.
    pub fn describe(
        &mut self,
        level: Level,
        [left, right]: [GreyView<'_>; 2],
        space: &SearchSpace,
        first: usize,
    ) -> Work {
        let Self { left: left_features, right: right_features, network } = self;
        let place = Place::Every { first: space.first, apart: space.apart };
        left_features.describe(level, left, first, place, network)
            + right_features.describe(level, right, first, Place::Mirror, network)
    }

    /// The costs over the search space that the features were computed for; with descriptors where it
    /// is told for which pixels they count.
    pub fn costs<'a>(
        &'a self,
        level: Level,
        space: &'a SearchSpace,
        described: Option<Described<'a>>,
    ) -> CensusGradientRows<'a> {
        CensusGradientRows { level, features: self, space, described }
    }
}

/// For which pixels descriptors count.
#[derive(Clone, Copy)]
pub(crate) struct Described<'a> {
    /// For these they do not.
    pub plain: &'a Plane<bool>,
    /// For these they count the more, the plain ones excepted.
    pub doubtful: &'a Plane<bool>,
}

/// The costs of the rows of a box.
pub(crate) struct CensusGradientRows<'a> {
    level: Level,
    features: &'a FeaturePair,
    space: &'a SearchSpace,
    described: Option<Described<'a>>,
}

at_every_level! {
    /// The costs of a row.
    fn row_costs[instructions](
        features: &FeaturePair,
        space: &SearchSpace,
        y: usize,
        described: Option<[&[bool]; 2]>,
        costs: &mut [u8],
    ) {
        let FeaturePair { left, right, .. } = features;
        let (left_words, left_steps) = (left.words.row(y), left.steps.row(y));
        let (words, steps) = (right.words.row(y), right.steps.row(y));
        let farthest = (space.width + space.lanes) as i64;
        // What lies beyond the disparities costs 255, in fewer lanes than one vector has.
        let last = space.lanes - LANES;
        let beyond: [u8; LANES] =
            std::array::from_fn(|i| if last + i < space.count { 0 } else { 255 });
        for (x, costs) in costs.chunks_exact_mut(space.lanes).enumerate() {
            let place = space.mirrored(space.in_image(x)) + space.lanes as i64;
            let place = place.clamp(0, farthest) as usize;
            let words = &words[place..place + space.lanes];
            let steps = &steps[place..place + space.lanes];
            let (word, step) = (left_words[x], left_steps[x]);
            let weights = match described {
                None => &CENSUS,
                Some([plain, _]) if plain[x] => &CENSUS,
                Some([_, doubtful]) if doubtful[x] => &DOUBTFUL,
                Some(_) => &CERTAIN,
            };
            add_up(instructions, &weights.census, (word, words), (step, steps), costs);
            if weights.descriptor > 0 {
                let descriptors = &right.descriptors.row(y)[place..place + space.lanes];
                add_descriptors(weights.descriptor, left.descriptors.row(y)[x], descriptors, costs);
            }
            for (cost, beyond) in costs[last..].iter_mut().zip(&beyond) {
                *cost |= beyond;
            }
        }
    }
}

/// The costs of a pixel by census words and grey steps, its own and those that it is compared with.
#[inline(always)]
fn add_up(
    instructions: impl Bits,
    weight: &Weight,
    (word, words): (u32, &[u32]),
    (step, steps): (u8, &[u8]),
    costs: &mut [u8],
) {
    let (words, last_words) = words.as_chunks::<LANES>().0.as_chunks::<2>();
    let (costs, last_costs) = costs.as_chunks_mut::<{ 2 * LANES }>();
    let (steps, last_steps) = steps.as_chunks::<{ 2 * LANES }>();
    for ((costs, words), steps) in costs.iter_mut().zip(words).zip(steps) {
        *costs = with_steps(instructions.weighed_in_two(word, words, weight), step, steps);
    }
    let (costs, steps) = (last_costs.as_chunks_mut::<LANES>().0, last_steps.as_chunks().0);
    for ((costs, words), steps) in costs.iter_mut().zip(last_words).zip(steps) {
        *costs = with_steps(instructions.weighed(word, words, weight), step, steps);
    }
}

/// Adds what grey steps differ by. Costs are given back rather than written, so that the compiler need not ask whether
/// what it reads changes meanwhile.
#[inline(always)]
fn with_steps<const N: usize>(mut costs: [u8; N], step: u8, steps: &[u8; N]) -> [u8; N] {
    for i in 0..N {
        // `abs_diff` would go through 32 bits.
        let difference = step.max(steps[i]) - step.min(steps[i]);
        costs[i] += difference.min(LARGEST_STEP);
    }
    costs
}

/// What descriptors add to the costs of a pixel.
#[inline(always)]
fn add_descriptors(weight: u16, descriptor: u64, descriptors: &[u64], costs: &mut [u8]) {
    let descriptors = descriptors.as_chunks::<LANES>().0;
    for (costs, descriptors) in costs.as_chunks_mut::<LANES>().0.iter_mut().zip(descriptors) {
        let mut bits = [0u8; LANES];
        for i in 0..LANES {
            bits[i] = (descriptor ^ descriptors[i]).count_ones() as u8;
        }
        for i in 0..LANES {
            costs[i] += (u16::from(bits[i]) * weight / 64) as u8;
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
        let described =
            self.described.map(|Described { plain, doubtful }| [plain.row(y), doubtful.row(y)]);
        row_costs(self.level, self.features, self.space, y, described, costs);
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
        let views = [left.view(), right.view()].map(|image| (GreyView::Depth8(image), image));
        let word = |(view, _): Seen<'_>, x: usize, y: usize, pairs: bool| {
            let mut words = [0; 40];
            CensusRows::default().words(Level::detect(), view, y, pairs, &mut words);
            words[x]
        };
        let step = |(_, grey): Seen<'_>, x: usize, y: usize, pairs: bool| {
            let (mut steps, mut mean) = ([0; 40], [0; 40]);
            let next = if pairs { (y + 1).min(5) } else { y };
            mean_of_rows(grey.row(y), grey.row(next), &mut mean);
            steps_along_row(&mean, &mut steps);
            steps[x]
        };
        let descriptors = views.map(|(view, _)| {
            let mut words = Plane::filled(40, 6, 0);
            let put = |from: &[u64], to: &mut [u64]| to.copy_from_slice(from);
            Descriptors::default().compute(Level::detect(), view, 0, &mut words, put);
            words
        });
        // The second range begins where no match lies inside.
        for (range, columns) in [((-4, 67), (5, 38)), ((10, 30), (0, 39)), ((-60, -31), (3, 12))] {
            let range = DisparityRange::new(range.0, range.1).unwrap();
            let bounds = BoundingBox::new(columns.0, 1, columns.1, 5).unwrap();
            let doubtful = Plane::from_fn(bounds.columns(), 5, |x, y| (x + y) % 3 == 0);
            let plain = Plane::from_fn(bounds.columns(), 5, |x, y| (x + y) % 4 == 0);
            // Descriptors are of all columns and rows.
            let described = Described { plain: &plain, doubtful: &doubtful };
            let kinds = [(1, None), (1, Some(described)), (2, None)];
            for (level, (apart, described)) in
                Level::available().into_iter().flat_map(|l| kinds.map(|kind| (l, kind)))
            {
                eprintln!("level {}", level.name());
                let (rows, pairs) = (MatchedRows::of(bounds, apart), apart > 1);
                let space = SearchSpace::of_every(apart, 40, bounds, range);
                let mut pair = FeaturePair::default();
                pair.compute(level, views, &space, rows);
                if !pairs {
                    pair.describe(level, views.map(|(view, _)| view), &space, 1);
                }
                let costs_of_rows = pair.costs(level, &space, described);
                let mut costs = vec![0; space.columns() * space.lanes];
                for y in 0..rows.count {
                    let image_row = rows.in_image(y);
                    costs_of_rows.fill_row(y, &mut costs);
                    for (x, costs) in costs.chunks_exact(space.lanes).enumerate() {
                        let states =
                            described.map(|of| (of.plain.row(y)[x], of.doubtful.row(y)[x]));
                        let weights = match states {
                            None | Some((true, _)) => &CENSUS,
                            Some((false, false)) => &CERTAIN,
                            Some((false, true)) => &DOUBTFUL,
                        };
                        let x = space.in_image(x);
                        for (k, &cost) in costs[..space.count].iter().enumerate() {
                            let at = x as i64 - i64::from(space.min) - k as i64;
                            let at = at.clamp(0, 39) as usize;
                            let [a, b] = [(views[0], x), (views[1], at)]
                                .map(|(view, x)| word(view, x, image_row, pairs));
                            let bits = (a ^ b).count_ones();
                            let [a, b] = [(views[0], x), (views[1], at)]
                                .map(|(view, x)| step(view, x, image_row, pairs));
                            let unlike = descriptors[0].row(image_row)[x]
                                ^ descriptors[1].row(image_row)[at];
                            let expected = bits * u32::from(weights.census.each) / 64
                                + u32::from(a.abs_diff(b).min(20))
                                + unlike.count_ones() * u32::from(weights.descriptor) / 64;
                            assert_eq!(u32::from(cost), expected, "({x}, {y}), {k}");
                        }
                        assert!(costs[space.count..].iter().all(|&c| c == 255));
                    }
                }
            }
        }
    }
}
