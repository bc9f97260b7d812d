//! Winner takes all, in both views, from the costs of one row.
//!
//! Left: `k(x) = argmin_k C(x, k)` over the disparities whose match lies inside the right image.
//! Right: `k'(x') = argmin_k C(x' + min + k, k)`: the same costs read along their diagonal, so the
//! second view costs no second matching (Fua 1993; Muehlmann et al. 2002). Of equal costs the
//! smallest disparity wins, in both views.

use crate::cost::SearchSpace;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::path::LANES;

/// Operations on bytes per pixel and disparity, all of 16 bits: a minimum, then a comparison and a choice and a
/// minimum for the place, a difference, a comparison, a choice and a minimum for the margin; two comparisons, a
/// choice and a minimum for the right view.
pub(crate) const OPERATIONS: usize = (1 + 3 + 4 + 4) * 2;

/// Columns of the left view that are compared together with the right one: what they meet there is read and
/// written once. One after the other, each would read what the one before wrote a disparity beside, and wait
/// for it.
const TOGETHER: usize = 4;

/// Stands for "no disparity could be tried".
const NONE: u16 = u16::MAX;

/// The winner of a column of the left view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Winner {
    disparity: u16,
    /// How much lower its sum lies than that of any disparity but its neighbours; 0 without any other.
    pub margin: u16,
}

impl Winner {
    /// The disparity, counted from the smallest.
    #[inline(always)]
    pub fn disparity(self) -> Option<usize> {
        disparity(self.disparity)
    }
}

/// A disparity, counted from the smallest, if there is one.
#[inline(always)]
pub(crate) fn disparity(number: u16) -> Option<usize> {
    (number != NONE).then_some(usize::from(number))
}

/// The winners of a row in both views, with their memory.
#[derive(Debug, Default)]
pub(crate) struct Winners {
    /// One for each column of the search space.
    pub left: Vec<Winner>,
    right: Right,
}

/// The right view, as it looks in a mirror, between two margins.
#[derive(Debug, Default)]
struct Right {
    /// The least sums.
    least: Vec<u16>,
    /// Their disparities.
    disparities: Vec<u16>,
}

impl Winners {
    /// Finds the winners of a row of sums, `space.lanes` per column.
    pub fn select(&mut self, level: Level, space: &SearchSpace, sums: &[u16]) {
        self.left.clear();
        self.left.resize(space.columns(), Winner { disparity: NONE, margin: 0 });
        for row in [&mut self.right.least, &mut self.right.disparities] {
            row.clear();
            row.resize(space.width + 2 * space.lanes, NONE);
        }
        select_row(level, space, sums, &mut self.left, &mut self.right);
    }

    /// The disparities that win in the right view, which stands in a mirror; each may be [none](disparity).
    pub fn right(&self, space: &SearchSpace) -> &[u16] {
        &self.right.disparities[space.lanes..][..space.width]
    }
}

/// Whether a disparity is one of so many from the first on.
#[inline(always)]
fn is_one(k: u16, (first, count): (u16, u16)) -> bool {
    k.wrapping_sub(first) < count
}

/// The least of the first lanes.
#[inline(always)]
fn least_of(values: &[u16; LANES], lanes: usize) -> u16 {
    values[..lanes].iter().copied().fold(u16::MAX, u16::min)
}

/// The winner of a column from its sums. Without `ALL` only some disparities are tried.
#[inline(always)]
fn select_column<const ALL: bool>(candidates: (u16, u16), sums: &[u16]) -> Winner {
    // There are whole groups. The compiler does not know it, and so makes vectors of loops over the lanes; one
    // over all of them it would unroll first, and compare them one by one.
    let lanes = LANES.min(sums.len());
    let groups = || sums.as_chunks::<LANES>().0.iter().zip((0..).step_by(LANES));
    let mut lowest = [u16::MAX; LANES];
    for (sums, first) in groups() {
        for i in 0..LANES {
            let tried = ALL || is_one(first + i as u16, candidates);
            lowest[i] = lowest[i].min(if tried { sums[i] } else { u16::MAX });
        }
    }
    let least = least_of(&lowest, lanes);
    let mut places = [NONE; LANES];
    for (sums, first) in groups() {
        for i in 0..LANES {
            let k = first + i as u16;
            let wins = (sums[i] == least) & (ALL || is_one(k, candidates));
            places[i] = places[i].min(if wins { k } else { NONE });
        }
    }
    let disparity = least_of(&places, lanes);
    let mut others = [u16::MAX; LANES];
    for (sums, first) in groups() {
        for i in 0..LANES {
            let k = first + i as u16;
            let beside = is_one(k, (disparity.wrapping_sub(1), 3));
            let other = !beside & (ALL || is_one(k, candidates));
            others[i] = others[i].min(if other { sums[i] } else { u16::MAX });
        }
    }
    let margin = match least_of(&others, lanes) {
        u16::MAX => 0,
        second => second - least,
    };
    Winner { disparity, margin }
}

/// Compares the sums of `N` columns with the least ones so far of the right view, of which the first column's
/// begin with these. After the sums there are `N - 1` more of any value.
#[inline(always)]
fn meet_right<const N: usize>(
    candidates: [(u16, u16); N],
    lanes: usize,
    sums: &[u16],
    least: &mut [u16],
    disparities: &mut [u16],
) {
    let rights = least.as_chunks_mut::<LANES>().0.iter_mut().zip(disparities.as_chunks_mut().0);
    for ((least, disparities), first) in rights.zip((0..).step_by(LANES)).take(lanes / LANES) {
        for n in 0..N {
            // The same right columns stand one disparity further on in every column.
            let sums = &sums[n * lanes + first + n..][..LANES];
            meet(candidates[n], (first + n) as u16, sums, least, disparities);
        }
    }
}

/// Compares sums, of disparities from `first` on, with the least ones so far: of equal ones the smaller
/// disparity, which came before, stays.
#[inline(always)]
fn meet(
    candidates: (u16, u16),
    first: u16,
    sums: &[u16],
    least: &mut [u16; LANES],
    disparities: &mut [u16; LANES],
) {
    for i in 0..LANES {
        let k = first.wrapping_add(i as u16);
        let sum = if is_one(k, candidates) { sums[i] } else { u16::MAX };
        disparities[i] = if sum < least[i] { k } else { disparities[i] };
        least[i] = least[i].min(sum);
    }
}

at_every_level! {
    /// In the mirror the right columns that a left one can match stand in the order of their disparities, so
    /// that whole vectors of sums meet the least so far.
    fn select_row(space: &SearchSpace, sums: &[u16], left: &mut [Winner], right: &mut Right) {
        let lanes = space.lanes;
        for (x, sums) in sums.chunks_exact(lanes).enumerate() {
            let candidates = candidates(space, x);
            left[x] = match candidates.1 {
                0 => continue,
                all if usize::from(all) == lanes => select_column::<true>(candidates, sums),
                _ => select_column::<false>(candidates, sums),
            };
        }
        let mut x = 0;
        while x < left.len() {
            // Where disparity 0 of this column stands among the right ones.
            let place = (space.mirrored(space.first + x) + lanes as i64) as usize;
            let Right { least, disparities } = &mut *right;
            // A column more is left, whose sums come after those of these.
            if x + TOGETHER < left.len() {
                let mut some = [(0, 0); TOGETHER];
                for n in 0..TOGETHER {
                    some[n] = candidates(space, x + n);
                    // Disparities that stand before that of the first column.
                    for k in 0..n {
                        let sum = sums[(x + n) * lanes + k];
                        let at = place - n + k;
                        if is_one(k as u16, some[n]) && sum < least[at] {
                            (least[at], disparities[at]) = (sum, k as u16);
                        }
                    }
                }
                let sums = &sums[x * lanes..];
                meet_right::<TOGETHER>(some, lanes, sums, &mut least[place..], &mut disparities[place..]);
                x += TOGETHER;
            } else {
                let (one, sums) = (candidates(space, x), &sums[x * lanes..]);
                meet_right::<1>([one], lanes, sums, &mut least[place..], &mut disparities[place..]);
                x += 1;
            }
        }
    }
}

/// The first disparity that can be tried at a column, and how many there are.
#[inline(always)]
fn candidates(space: &SearchSpace, x: usize) -> (u16, u16) {
    let candidates = space.candidates(space.first + x);
    (candidates.start as u16, candidates.len() as u16)
}

/// Where the tip of a V through three costs lies, the second of which is the least, the shape
/// ("equiangular") that absolute differences have around their minimum (Shimizu & Okutomi 2001):
/// between -1/2 and 1/2, 0 where all are equal.
#[inline(always)]
pub(crate) fn tip_of_v(before: f32, least: f32, after: f32) -> f32 {
    let rise = before.max(after) - least;
    if rise > 0.0 { (before - after) / (2.0 * rise) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use raster::{BoundingBox, DisparityRange};

    type Definition = (Vec<Option<(usize, u16)>>, Vec<Option<usize>>);

    /// Left winners with their margins, and right winners in the mirror, disparity by disparity.
    fn definition(space: &SearchSpace, sums: &[u16]) -> Definition {
        let sum = |x: usize, k: usize| sums[(x - space.first) * space.lanes + k];
        let columns = space.first..=space.last;
        let left = columns.clone().map(|x| {
            let winner = space.candidates(x).min_by_key(|&k| sum(x, k))?;
            let others = space.candidates(x).filter(|k| k.abs_diff(winner) > 1);
            let second = others.map(|k| sum(x, k)).min();
            Some((winner, second.map_or(0, |second| second - sum(x, winner))))
        });
        let right = (0..space.width).rev().map(|right| {
            let pairs = columns.clone().filter_map(|x| {
                let k = space
                    .candidates(x)
                    .find(|&k| x as i32 - space.min - k as i32 == right as i32)?;
                Some((sum(x, k), k))
            });
            pairs.min().map(|(_, k)| k)
        });
        (left.collect(), right.collect())
    }

    #[test]
    fn winners_are_the_definitions_at_every_level() {
        let mut chance = Chance(5);
        let mut random = |n: u32| chance.below(n) as u16;
        for (width, columns, range) in [
            (50, (0, 49), (0, 36)),
            (50, (7, 31), (-9, 30)),
            (20, (3, 12), (8, 60)),
            (9, (0, 8), (2, 2)),
        ] {
            let bounds = BoundingBox::new(columns.0, 0, columns.1, 0).unwrap();
            let space =
                SearchSpace::new(width, bounds, DisparityRange::new(range.0, range.1).unwrap());
            let sums: Vec<u16> = (0..space.columns() * space.lanes).map(|_| random(40)).collect();
            let (left, right) = definition(&space, &sums);
            for level in Level::available() {
                eprintln!("level {}", level.name());
                let mut winners = Winners::default();
                winners.select(level, &space, &sums);
                let found = winners.left.iter().map(|w| w.disparity().map(|k| (k, w.margin)));
                assert_eq!(found.collect::<Vec<_>>(), left, "{space:?}");
                let found = winners.right(&space).iter().map(|&number| disparity(number));
                assert_eq!(found.collect::<Vec<_>>(), right, "{space:?}");
            }
        }
    }

    #[test]
    fn a_v_shape_gives_its_tip() {
        // Costs 4 |k - 0.25| + 3.
        assert_eq!(tip_of_v(8.0, 4.0, 6.0), 0.25);
        assert_eq!(tip_of_v(4.0, 4.0, 4.0), 0.0);
    }
}
