//! The judge: a small network that scores each candidate of a pixel with the same weights, some in the light of all.
//!
//! ```text
//! c   = max(0, C (context, of_pixel) + a)
//! s_k = w3 . max(0, W2 max(0, W1 of_each_k + V c + u_k) + b)
//! ```
//!
//! The context is the first few things that are known of each candidate, from the first to the last: which of them
//! belong together. A judge without it has `V of_pixel` in place of `V c`. `u_k` belongs to the place that candidate
//! `k` comes from. What scores come to says the [`verdict`](super::verdict).
//!
//! Pixels of a few rows are worked on side by side, in whole numbers of 16 bits
//! ([`crate::kernels::products`]): all levels give the same bits. Only the score is a floating-point
//! number; it is summed in the same order everywhere and without fused multiply-adds.

use super::block::{LANES, NONE, OF_PIXEL};
use super::hint::{Hints, IN_CONTEXT, OF_EACH};
use super::reach::{MOST, Reach};
use super::verdict::Odds;
use crate::kernels::aligned::Line;
use crate::kernels::neurons::TOGETHER;
use crate::kernels::products::{Lanes, Pair, Products, Sums, Weighing};
use crate::profile::Work;

/// The most numbers that a layer has.
const LARGEST: usize = 32;

/// The numbers of the context, none where there is no context, and of the two layers between; each a multiple of
/// [`TOGETHER`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Layers {
    pub context: usize,
    pub first: usize,
    pub second: usize,
}

impl Layers {
    /// How many numbers all candidates of a pixel have in common.
    fn common(self) -> usize {
        if self.context > 0 { self.context } else { OF_PIXEL }
    }
}

/// Two numbers of each pixel, [`packed`](crate::kernels::products::packed).
type Pairs = Sums;

/// The weights of a judge, those of [`TOGETHER`] sums for one pair of numbers after the other.
#[derive(PartialEq)]
pub(crate) struct Judge {
    layers: Layers,
    /// What goes into the context.
    of_all: Vec<[Pair; TOGETHER]>,
    context_offsets: [i32; LARGEST],
    context: Weighing,
    of_context: Vec<[Pair; TOGETHER]>,
    /// What a place adds to each sum of the first layer.
    places: Vec<[i32; LARGEST]>,
    of_each: Vec<[Pair; TOGETHER]>,
    first: Weighing,
    weights: Vec<[Pair; TOGETHER]>,
    offsets: [i32; LARGEST],
    /// What a sum of the second layer adds to the score.
    last: [f32; LARGEST],
}

/// What a judge keeps in mind of pixels while it looks at their candidates; vectors begin where cache lines do.
#[repr(C, align(64))]
pub(super) struct Mind {
    /// What all candidates have in common adds so much to the first layer.
    own: [Sums; LARGEST],
    /// What is known of a candidate.
    pub hints: Hints,
    /// The first layer of two candidates.
    numbers: [[Pairs; LARGEST / 2]; 2],
    /// Of each candidate.
    pub scores: [Lanes; MOST],
    pub odds: Odds,
    /// What is known of candidates as layers take it: of two, or where there is a context of all.
    heard: [[Pairs; OF_EACH / 2]; MOST],
    /// What of that goes into the context, and that.
    all: [Pairs; (MOST * IN_CONTEXT + OF_PIXEL) / 2],
    context: [Pairs; LARGEST / 2],
}

impl Default for Mind {
    fn default() -> Self {
        Self {
            hints: [NONE; OF_EACH],
            heard: [[Line([0; LANES]); OF_EACH / 2]; MOST],
            all: [Line([0; LANES]); (MOST * IN_CONTEXT + OF_PIXEL) / 2],
            context: [Line([0; LANES]); LARGEST / 2],
            own: [Line([0; LANES]); LARGEST],
            numbers: [[Line([0; LANES]); LARGEST / 2]; 2],
            scores: [NONE; MOST],
            odds: Odds::default(),
        }
    }
}

impl Mind {
    /// Remembers the hints, so many others before them.
    #[inline(always)]
    pub fn hear(&mut self, products: impl Products, others: usize) {
        self.heard[others] = told(products, &self.hints);
    }
}

/// What is known of a candidate, as layers take it.
#[inline(always)]
fn told(products: impl Products, hints: &Hints) -> [Pairs; OF_EACH / 2] {
    let [a, b, c, d, e, f, g, h, i, j] = hints.as_chunks().0 else {
        unreachable!("candidates have twenty numbers")
    };
    // Written out: a loop would be taken for the one to work on together.
    [
        products.pairs(a),
        products.pairs(b),
        products.pairs(c),
        products.pairs(d),
        products.pairs(e),
        products.pairs(f),
        products.pairs(g),
        products.pairs(h),
        products.pairs(i),
        products.pairs(j),
    ]
}

impl Judge {
    /// How many numbers it is made of.
    pub fn numbers(reach: &Reach, layers: Layers) -> usize {
        let (Layers { context, first, second }, candidates) = (layers, reach.places.len());
        context * (candidates * IN_CONTEXT + OF_PIXEL + 1)
            + first * (layers.common() + candidates + OF_EACH + second)
            + 2 * second
    }

    /// What a pixel takes at the least: a product for every weight, and each candidate compared with each other one,
    /// in three operations on two bytes, once for the products that are four votes, once for that which says what it
    /// costs to be wrong.
    pub fn work(&self) -> Work {
        let Layers { context, first, second } = self.layers;
        let candidates = self.places.len();
        let of_all = context * (candidates * IN_CONTEXT + OF_PIXEL) + first * self.layers.common();
        let of_each = first * OF_EACH + second * first + second;
        let pairs = candidates * candidates;
        Work::operations(2 * (3 * 2) * pairs)
            + Work::products(of_all + candidates * of_each + (4 + 1) * pairs)
    }

    /// From its numbers: of each number of the context the weights of what is known of the first candidate, of the
    /// next, then of the pixel; its offsets. Of each number of the first layer the weights of the context, or else of
    /// what is known of the pixel; the places; the weights of what is known of each candidate. The weights of the
    /// second layer, its offsets, the weights of the score. Those of a layer row by row.
    pub fn new(reach: &Reach, layers: Layers, numbers: impl IntoIterator<Item = f32>) -> Self {
        let Layers { context, first, second } = layers;
        assert!(
            [context, first, second].iter().all(|n| n.is_multiple_of(TOGETHER) && *n <= LARGEST)
        );
        let mut numbers = numbers.into_iter();
        let mut rows = |rows: usize, columns: usize| -> Vec<Vec<f32>> {
            let mut next = || numbers.next().expect("there is a number for every weight");
            (0..rows).map(|_| (0..columns).map(|_| next()).collect()).collect()
        };
        let of_all = rows(context, reach.places.len() * IN_CONTEXT + OF_PIXEL);
        let context_offsets = rows(1, context).concat();
        let of_context = rows(first, layers.common());
        let of_places = rows(first, reach.places.len());
        let of_each = rows(first, OF_EACH);
        let weights = rows(second, first);
        let (offsets, last) = (rows(1, second).concat(), rows(1, second).concat());

        let of_rows = |rows: &[Vec<f32>], offsets: &[f32]| {
            Weighing::of(rows.iter().map(|row| row.iter().copied()).zip(offsets.iter().copied()))
        };
        let known = of_each.iter().zip(&of_context).map(|(each, all)| each.iter().chain(all));
        let largest =
            |row: &Vec<f32>| row.iter().fold(0.0f32, |most, number| most.max(number.abs()));
        let places = of_places.iter().map(largest);
        let weighing = Weighing::of(known.map(Iterator::copied).zip(places));
        let second = of_rows(&weights, &offsets);
        let in_context = of_rows(&of_all, &context_offsets);
        Self {
            layers,
            of_all: together(&of_all, in_context).concat(),
            context_offsets: filled_up(context_offsets.iter().map(|&a| in_context.offset(a))),
            context: in_context,
            of_context: together(&of_context, weighing).concat(),
            places: (0..reach.places.len())
                .map(|k| filled_up(of_places.iter().map(|row| weighing.offset(row[k]))))
                .collect(),
            of_each: together(&of_each, weighing).concat(),
            first: weighing,
            weights: together(&weights, second).concat(),
            offsets: filled_up(offsets.iter().map(|&offset| second.part(offset))),
            last: filled_up(last.iter().map(|weight| weight * second.unit())),
        }
    }

    /// Whether it hears all candidates before it scores any.
    pub(super) fn has_context(&self) -> bool {
        self.layers.context > 0
    }

    /// Looks at pixels, all of whose candidates were heard if there is a context.
    #[inline(always)]
    pub(super) fn look(
        &self,
        products: impl Products,
        of_pixel: &[Lanes; OF_PIXEL],
        mind: &mut Mind,
    ) {
        let Mind { heard, all, context, own, .. } = mind;
        let [a, b, c] = of_pixel.as_chunks().0 else { unreachable!("pixels have six numbers") };
        let pairs = [products.pairs(a), products.pairs(b), products.pairs(c)];
        let context = match self.layers.context {
            0 => &pairs[..],
            numbers => {
                let of_candidates = all.as_chunks_mut::<{ IN_CONTEXT / 2 }>().0.iter_mut();
                for (all, [a, b, c, ..]) in of_candidates.zip(&heard[..self.places.len()]) {
                    *all = [*a, *b, *c];
                }
                self.of_all(products, &pairs, all, context);
                &context[..numbers / 2]
            }
        };
        let groups = self.of_context.chunks_exact(context.len());
        for (own, weights) in own.as_chunks_mut().0.iter_mut().zip(groups) {
            *own = [Line([0; LANES]); TOGETHER];
            products.add_all(own, weights, context);
        }
    }

    /// The context of pixels, from what is known of them and of their candidates.
    #[inline(always)]
    fn of_all(
        &self,
        products: impl Products,
        pairs: &[Pairs],
        all: &mut [Pairs],
        context: &mut [Pairs],
    ) {
        let known = self.places.len() * IN_CONTEXT / 2;
        all[known..][..pairs.len()].copy_from_slice(pairs);
        let all = &all[..known + pairs.len()];
        let offsets = self.context_offsets.as_chunks().0;
        let groups = context.as_chunks_mut().0.iter_mut().zip(offsets);
        for ((out, offsets), weights) in groups.zip(self.of_all.chunks_exact(all.len())) {
            let begin = [Line([0; LANES]); TOGETHER];
            products.layer(&begin, weights, [all], [offsets], self.context, [out]);
        }
    }

    /// Scores candidate `k` and the one after it, of which the mind has heard after so many others.
    #[inline(always)]
    pub(super) fn score(&self, products: impl Products, k: usize, others: usize, mind: &mut Mind) {
        let Mind { heard, own, numbers, scores, .. } = mind;
        let hints: [&[Pairs]; 2] = [&heard[others], &heard[others + 1]];
        let places = [self.places[k].as_chunks().0, self.places[k + 1].as_chunks().0];
        let own = own.as_chunks::<TOGETHER>().0;
        // Of a length that the compiler does not know: unrolled, the loop over them takes longer.
        let of_each =
            self.of_each.chunks_exact(self.of_each.len() / (self.layers.first / TOGETHER));
        for (group, (weights, own)) in of_each.zip(own).enumerate() {
            let numbers = numbers.each_mut().map(|of_one| &mut of_one.as_chunks_mut().0[group]);
            let places = places.map(|of_one| &of_one[group]);
            products.layer(own, weights, hints, places, self.first, numbers);
        }
        let used = self.layers.first / 2;
        let numbers = [&numbers[0][..used], &numbers[1][..used]];
        let mut both = [NONE; 2];
        let ends = self.offsets.as_chunks().0.iter().zip(self.last.as_chunks().0);
        for (weights, (offsets, last)) in self.weights.chunks_exact(numbers[0].len()).zip(ends) {
            products.score(&mut both, weights, numbers, offsets, last);
        }
        scores[k..][..2].copy_from_slice(&both);
    }
}

/// The weights of rows, those of [`TOGETHER`] rows for one pair of columns after the other.
fn together(rows: &[Vec<f32>], weighing: Weighing) -> Vec<Vec<[Pair; TOGETHER]>> {
    let group = |rows: &[Vec<f32>]| -> Vec<[Pair; TOGETHER]> {
        let pair = |i: usize| {
            std::array::from_fn(|t| {
                [2 * i, 2 * i + 1].map(|column| weighing.weight(rows[t][column]) as i16)
            })
        };
        (0..rows[0].len() / 2).map(pair).collect()
    };
    rows.chunks_exact(TOGETHER).map(group).collect()
}

/// The first of an array, and nothing after them.
fn filled_up<T: Default + Copy>(first: impl Iterator<Item = T>) -> [T; LARGEST] {
    let mut all = [T::default(); LARGEST];
    all.iter_mut().zip(first).for_each(|(to, from)| *to = from);
    all
}

#[cfg(test)]
mod tests {
    use super::super::block::Block;
    use super::super::reach::{NARROW, WIDE};
    use super::super::verdict::{FAR, Verdict, verdict};
    use super::*;
    use crate::chance::Chance;
    use crate::kernels::level::{Level, at_every_level};

    const SHAPES: [(&Reach, Layers); 2] = [
        (&NARROW, Layers { context: 0, first: 16, second: 8 }),
        (&WIDE, Layers { context: 32, first: 32, second: 16 }),
    ];

    at_every_level! {
        fn judge_block[products](judge: &Judge, block: &Block, hints: &[Hints]) -> Verdict {
            let mut mind = Mind::default();
            for (k, hints) in hints.iter().enumerate() {
                mind.hints = *hints;
                mind.hear(products, k);
            }
            judge.look(products, &block.of_pixel, &mut mind);
            for (i, hints) in hints.as_chunks::<2>().0.iter().enumerate() {
                judge.score(products, 2 * i, 2 * i, &mut mind);
                let scores = mind.scores;
                for (others, hints) in hints.iter().enumerate() {
                    mind.hints = *hints;
                    mind.hear(products, others);
                }
                judge.score(products, 2 * i, 0, &mut mind);
                assert_eq!(scores, mind.scores, "where they were heard does not matter");
            }
            verdict(products, block, &mut mind.scores, &mut mind.odds)
        }
    }

    /// A number between -1 and 1.
    fn noise(chance: &mut Chance) -> f32 {
        2.0 * chance.share() - 1.0
    }

    fn noises<const N: usize>(chance: &mut Chance) -> [Lanes; N] {
        std::array::from_fn(|_| Line(std::array::from_fn(|_| noise(chance))))
    }

    /// The expected errors of a pixel's candidates by the formula, in 64 bits.
    fn definition(
        numbers: &[f32],
        (reach, Layers { context, first, second }): (&Reach, Layers),
        block: &Block,
        hints: &[Hints],
        l: usize,
    ) -> Vec<f64> {
        let n = reach.places.len();
        let wide = |number: f32| f64::from(number);
        let of_all = n * IN_CONTEXT + OF_PIXEL;
        let (all, rest) = numbers.split_at(context * of_all);
        let (in_context, rest) = rest.split_at(context);
        let common = if context > 0 { context } else { OF_PIXEL };
        let (of_context, rest) = rest.split_at(first * common);
        let (places, rest) = rest.split_at(first * n);
        let (of_each, rest) = rest.split_at(first * OF_EACH);
        let (weights, rest) = rest.split_at(second * first);
        let (offsets, last) = rest.split_at(second);
        let known: Vec<f64> = hints
            .iter()
            .flat_map(|hints| &hints[..IN_CONTEXT])
            .chain(&block.of_pixel)
            .map(|of| wide(of[l]))
            .collect();
        let numbers: Vec<f64> = (0..context)
            .map(|c| {
                let weights = &all[c * of_all..][..of_all];
                let sum: f64 = weights.iter().zip(&known).map(|(&w, known)| wide(w) * known).sum();
                (sum + wide(in_context[c])).max(0.0)
            })
            .collect();
        let context = if context > 0 { &numbers[..] } else { &known[n * IN_CONTEXT..] };
        let score = |k: usize| -> f64 {
            let layer = |h: usize| {
                let each =
                    (0..OF_EACH).map(|i| wide(of_each[h * OF_EACH + i]) * wide(hints[k][i][l]));
                let all = context.iter().enumerate();
                let all = all.map(|(c, number)| wide(of_context[h * context.len() + c]) * number);
                (wide(places[h * n + k]) + each.sum::<f64>() + all.sum::<f64>()).max(0.0)
            };
            let numbers: Vec<f64> = (0..first).map(layer).collect();
            let second = (0..second).map(|g| {
                let sum =
                    (0..first).map(|h| wide(weights[g * first + h]) * numbers[h]).sum::<f64>();
                wide(last[g]) * (sum + wide(offsets[g])).max(0.0)
            });
            second.sum()
        };
        let inside = |k: usize| block.inside[k][l] > 0.0;
        let chances: Vec<f64> =
            (0..n).map(|k| if inside(k) { score(k).exp() } else { 0.0 }).collect();
        let all: f64 = chances.iter().sum();
        let expected = (0..n).map(|k| {
            let off = |i: usize| {
                wide(block.disparities[k][l] - block.disparities[i][l]).abs().min(wide(FAR))
            };
            (0..n).map(|i| chances[i] / all * off(i)).sum()
        });
        expected.collect()
    }

    #[test]
    fn the_least_expected_error_wins_at_every_level() {
        let mut chance = Chance(5);
        for shape in SHAPES.into_iter().cycle().take(6) {
            let (reach, layers) = shape;
            let numbers: Vec<f32> =
                (0..Judge::numbers(reach, layers)).map(|_| 0.4 * noise(&mut chance)).collect();
            let judge = Judge::new(reach, layers, numbers.iter().copied());
            let mut block =
                Block::of(reach, noises::<MOST>(&mut chance).map(|d| Line(d.map(|d| 8.0 * d))));
            for inside in &mut block.inside[1..] {
                **inside = std::array::from_fn(|_| f32::from(noise(&mut chance) > -0.5));
            }
            block.of_pixel = noises(&mut chance);
            let hints: Vec<Hints> = reach.places.iter().map(|_| noises(&mut chance)).collect();
            let first = judge_block(Level::available()[0], &judge, &block, &hints);
            for l in 0..LANES {
                let expected = definition(&numbers, shape, &block, &hints, l);
                let inside = (0..expected.len()).filter(|&k| block.inside[k][l] > 0.0);
                let least = inside.map(|k| expected[k]).fold(f64::INFINITY, f64::min);
                let chosen = |k: &usize| block.disparities[*k][l] == first.disparity[l];
                let chosen = (0..expected.len()).find(chosen).unwrap();
                assert!(block.inside[chosen][l] > 0.0 && expected[chosen] < least + 0.02);
                let sure = 1.0 - least / f64::from(FAR);
                assert!((f64::from(first.certainty[l]) - sure).abs() < 0.02);
            }
            for level in Level::available() {
                eprintln!("level {}", level.name());
                assert_eq!(judge_block(level, &judge, &block, &hints), first);
            }
        }
    }
}
