//! The judge: a small network that scores each candidate of a pixel alone, with the same weights.
//!
//! ```text
//! s_k = w3 . max(0, W2 max(0, W1 of_each_k + V of_pixel + u_k) + b)
//! ```
//!
//! `u_k` belongs to the place that candidate `k` comes from. Scores become probabilities (softmax), and
//! the candidate is taken that is expected to be off by the least, where being off by more than
//! [`FAR`] pixels is as bad as being off by that: of several that say nearly the same the one in the
//! middle wins, and one that stands alone must be likely.
//!
//! Sums are taken candidate beside candidate, in the same order at every level and without fused
//! multiply-adds: all levels give the same bits.

use super::candidates::{CANDIDATES, Known, OF_EACH, OF_PIXEL};

/// Numbers of the two layers between.
const FIRST: usize = 32;
const SECOND: usize = 16;
/// Errors beyond this, in pixels, are as bad as this.
const FAR: f32 = 3.0;

/// Sums that grow together: each number of the layer before is read once for all of these.
const TOGETHER: usize = 4;

/// One number for each candidate.
type Lanes = [f32; CANDIDATES];

/// The weights of a judge.
pub(crate) struct Judge {
    places: [Lanes; FIRST],
    of_each: [[f32; OF_EACH]; FIRST],
    /// Of each number of the pixel, so that all sums grow together.
    of_pixel: [[f32; FIRST]; OF_PIXEL],
    second: [[f32; FIRST]; SECOND],
    second_offsets: [f32; SECOND],
    last: [f32; SECOND],
}

/// What a judge says of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Verdict {
    pub disparity: f32,
    /// In `[0, 1]`.
    pub certainty: f32,
}

impl Judge {
    /// How many numbers it is made of.
    pub const NUMBERS: usize = FIRST * (CANDIDATES + OF_EACH + OF_PIXEL + SECOND) + 2 * SECOND;

    /// Operations on bytes for a pixel: products and sums of four bytes each, and each candidate
    /// compared with each other one, by disparity and by what it costs to be wrong.
    pub const OPERATIONS: usize =
        4 * CANDIDATES * (2 * (FIRST * OF_EACH + SECOND * FIRST + SECOND) + CANDIDATES * (4 + 4));

    /// From its numbers, in the order of the fields, those of the layers row by row.
    pub fn new(numbers: impl IntoIterator<Item = f32>) -> Self {
        let mut numbers = numbers.into_iter();
        let mut next = || numbers.next().expect("there is a number for every weight");
        let places = std::array::from_fn(|_| std::array::from_fn(|_| next()));
        let of_each = std::array::from_fn(|_| std::array::from_fn(|_| next()));
        let mut of_pixel = [[0.0; FIRST]; OF_PIXEL];
        for h in 0..FIRST {
            for i in 0..OF_PIXEL {
                of_pixel[i][h] = next();
            }
        }
        Self {
            places,
            of_each,
            of_pixel,
            second: std::array::from_fn(|_| std::array::from_fn(|_| next())),
            second_offsets: std::array::from_fn(|_| next()),
            last: std::array::from_fn(|_| next()),
        }
    }

    /// What it says of a pixel.
    #[inline(always)]
    pub fn decide(&self, known: &Known) -> Verdict {
        let scores = self.scores(known);
        let mut best = f32::NEG_INFINITY;
        for k in 0..CANDIDATES {
            best = if known.inside[k] & (scores[k] > best) { scores[k] } else { best };
        }
        let mut shares = [0.0; CANDIDATES];
        for k in 0..CANDIDATES {
            let share = exp(scores[k] - best);
            shares[k] = if known.inside[k] { share } else { 0.0 };
        }
        let mut all = 0.0;
        let mut expected = [0.0; CANDIDATES];
        for k in 0..CANDIDATES {
            let (share, there) = (shares[k], known.disparities[k]);
            all += share;
            for i in 0..CANDIDATES {
                let off = (known.disparities[i] - there).abs();
                expected[i] += share * if off < FAR { off } else { FAR };
            }
        }
        let (mut least, mut disparity) = (f32::INFINITY, known.disparities[0]);
        for k in 0..CANDIDATES {
            if known.inside[k] && expected[k] < least {
                (least, disparity) = (expected[k], known.disparities[k]);
            }
        }
        // Sums are rounded.
        Verdict { disparity, certainty: (1.0 - least / (FAR * all)).max(0.0) }
    }

    #[inline(always)]
    fn scores(&self, known: &Known) -> Lanes {
        let mut own = [0.0; FIRST];
        for (weights, of_pixel) in self.of_pixel.iter().zip(known.of_pixel) {
            for h in 0..FIRST {
                own[h] += weights[h] * of_pixel;
            }
        }
        let mut first = self.places;
        layer(&self.of_each, &known.of_each, &own, &mut first);
        let mut second = [[0.0; CANDIDATES]; SECOND];
        layer(&self.second, &first, &self.second_offsets, &mut second);
        let mut scores = [0.0; CANDIDATES];
        for h in 0..SECOND {
            for k in 0..CANDIDATES {
                scores[k] += self.last[h] * second[h][k];
            }
        }
        scores
    }
}

/// Adds offsets and weighted sums to `out`, and what is negative becomes zero.
#[inline(always)]
fn layer<const FROM: usize, const TO: usize>(
    weights: &[[f32; FROM]; TO],
    from: &[Lanes; FROM],
    offsets: &[f32; TO],
    out: &mut [Lanes; TO],
) {
    const { assert!(TO.is_multiple_of(TOGETHER)) };
    let rows = weights.as_chunks::<TOGETHER>().0.iter().zip(out.as_chunks_mut::<TOGETHER>().0);
    for ((weights, out), offsets) in rows.zip(offsets.as_chunks::<TOGETHER>().0) {
        let [mut a, mut b, mut c, mut d] = *out;
        for k in 0..CANDIDATES {
            a[k] += offsets[0];
            b[k] += offsets[1];
            c[k] += offsets[2];
            d[k] += offsets[3];
        }
        for i in 0..FROM {
            add_weighted(weights[0][i], &from[i], &mut a);
            add_weighted(weights[1][i], &from[i], &mut b);
            add_weighted(weights[2][i], &from[i], &mut c);
            add_weighted(weights[3][i], &from[i], &mut d);
        }
        *out = [positive(&a), positive(&b), positive(&c), positive(&d)];
    }
}

#[inline(always)]
fn add_weighted(weight: f32, from: &Lanes, sums: &mut Lanes) {
    for k in 0..CANDIDATES {
        sums[k] += weight * from[k];
    }
}

#[inline(always)]
fn positive(sums: &Lanes) -> Lanes {
    let mut out = [0.0; CANDIDATES];
    for k in 0..CANDIDATES {
        out[k] = if sums[k] > 0.0 { sums[k] } else { 0.0 };
    }
    out
}

/// `e^x` of what is not positive, by powers of two and a polynomial of what is left (its Taylor
/// series): the same on every machine, off by less than 3e-6.
#[inline(always)]
fn exp(x: f32) -> f32 {
    /// Adding it leaves no room for a fraction.
    const ROUNDING: f32 = 12_582_912.0;
    let x = if x < -60.0 { -60.0 } else { x };
    let power = x * std::f32::consts::LOG2_E;
    let whole = (power + ROUNDING) - ROUNDING;
    let rest = (power - whole) * std::f32::consts::LN_2;
    let series = 1.0
        + rest
            * (1.0
                + rest * (0.5 + rest * (1.0 / 6.0 + rest * (1.0 / 24.0 + rest * (1.0 / 120.0)))));
    series * f32::from_bits((((whole as i32) + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::kernels::level::{Level, at_every_level};

    at_every_level! {
        fn decide(judge: &Judge, known: &Known) -> Verdict {
            judge.decide(known)
        }
    }

    /// A number between -1 and 1.
    fn noise(chance: &mut Chance) -> f32 {
        2.0 * chance.share() - 1.0
    }

    fn judge(chance: &mut Chance) -> Judge {
        Judge::new((0..Judge::NUMBERS).map(|_| 0.4 * noise(chance)))
    }

    /// The same by its formula, candidate after candidate, in 64 bits.
    fn definition(judge: &Judge, known: &Known) -> Vec<f64> {
        let wide = f64::from;
        let score = |k: usize| -> f64 {
            let first = |h: usize| {
                let each = judge.of_each[h].iter().zip(&known.of_each);
                let pixel = (0..OF_PIXEL).map(|i| (&judge.of_pixel[i][h], &known.of_pixel[i]));
                let sum = wide(judge.places[h][k])
                    + each.map(|(w, f)| wide(*w) * wide(f[k])).sum::<f64>()
                    + pixel.map(|(w, f)| wide(*w) * wide(*f)).sum::<f64>();
                sum.max(0.0)
            };
            let second = |h: usize| {
                let sum: f64 = (0..FIRST).map(|i| wide(judge.second[h][i]) * first(i)).sum();
                (sum + wide(judge.second_offsets[h])).max(0.0)
            };
            (0..SECOND).map(|h| wide(judge.last[h]) * second(h)).sum()
        };
        let chances: Vec<f64> =
            (0..CANDIDATES).map(|k| if known.inside[k] { score(k).exp() } else { 0.0 }).collect();
        let all: f64 = chances.iter().sum();
        let expected = (0..CANDIDATES).map(|k| {
            let off = |i: usize| wide(known.disparities[k] - known.disparities[i]).abs().min(3.0);
            (0..CANDIDATES).map(|i| chances[i] / all * off(i)).sum()
        });
        expected.collect()
    }

    #[test]
    fn the_least_expected_error_wins_at_every_level() {
        let mut chance = Chance(5);
        for _ in 0..20 {
            let judge = judge(&mut chance);
            let known = Known {
                disparities: std::array::from_fn(|_| 8.0 * noise(&mut chance)),
                inside: std::array::from_fn(|k| k == 0 || noise(&mut chance) > -0.5),
                of_each: std::array::from_fn(|_| std::array::from_fn(|_| noise(&mut chance))),
                of_pixel: std::array::from_fn(|_| noise(&mut chance)),
            };
            let expected = definition(&judge, &known);
            let inside = (0..CANDIDATES).filter(|&k| known.inside[k]);
            let least = inside.map(|k| expected[k]).fold(f64::INFINITY, f64::min);
            let first = decide(Level::available()[0], &judge, &known);
            let chosen = known.disparities.iter().position(|&d| d == first.disparity).unwrap();
            assert!(known.inside[chosen] && expected[chosen] < least + 1e-4);
            assert!((f64::from(first.certainty) - (1.0 - least / 3.0)).abs() < 1e-4);
            for level in Level::available() {
                eprintln!("level {}", level.name());
                assert_eq!(decide(level, &judge, &known), first);
            }
        }
    }

    #[test]
    fn of_many_that_say_nearly_the_same_the_middle_wins_and_one_alone_does_not() {
        let judge = Judge::new(vec![0.0; Judge::NUMBERS]);
        let mut known = Known { inside: [true; CANDIDATES], ..Known::default() };
        known.disparities = std::array::from_fn(|k| if k == 0 { 30.0 } else { 0.01 * k as f32 });
        let verdict = judge.decide(&known);
        assert_eq!(verdict.disparity, 0.16);
        // One of 32 is as bad as can be, the others are off by a little.
        assert!(verdict.certainty > 0.9 && verdict.certainty < 31.0 / 32.0, "{verdict:?}");
    }

    #[test]
    fn powers_of_e() {
        for x in [0.0, -1e-3, -0.3, -0.5, -1.0, -7.7, -30.0] {
            let (ours, exact) = (f64::from(exp(x)), f64::from(x).exp());
            assert!((ours / exact - 1.0).abs() < 3e-6, "{x}: {ours} {exact}");
        }
        assert!(exp(-1000.0) < 1e-25 && exp(f32::MIN) >= 0.0);
    }
}
