//! Winner takes all, in both views, from the costs of one row.
//!
//! Left: `k(x) = argmin_k C(x, k)` over the disparities whose match lies inside the right image.
//! Right: `k'(x') = argmin_k C(x' + min + k, k)`: the same costs read along their diagonal, so the
//! second view costs no second matching (Fua 1993; Muehlmann et al. 2002). Of equal costs the
//! smallest disparity wins, in both views.

use std::ops::Range;

use crate::cost::SearchSpace;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::path::LANES;

/// Operations on bytes per pixel and disparity: a key and two minima of 32 bits, then a comparison and
/// a minimum of 16.
pub(crate) const OPERATIONS: usize = 3 * 4 + 2 * 2;

/// A sum and its disparity in one number, the sum above: of two keys the smaller one wins. The
/// largest stands for "no disparity could be tried".
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Key(u32);

impl Key {
    const NONE: Key = Key(u32::MAX);

    /// The disparity, counted from the smallest.
    pub fn disparity(self) -> Option<usize> {
        (self != Self::NONE).then_some((self.0 & 0xFFFF) as usize)
    }

    fn sum(self) -> u16 {
        (self.0 >> 16) as u16
    }
}

/// The winners of a row in both views, with their memory.
#[derive(Debug, Default)]
pub(crate) struct Winners {
    /// Per column of the search space: its winner, and how much lower its sum lies than that of any
    /// disparity but its neighbours; 0 without any other.
    pub left: Vec<(Key, u16)>,
    /// Keys of the right view, as it looks in a mirror, between two margins.
    right: Vec<Key>,
}

impl Winners {
    /// Finds the winners of a row of sums, `space.lanes` per column.
    pub fn select(&mut self, level: Level, space: &SearchSpace, sums: &[u16]) {
        self.left.clear();
        self.left.resize(space.columns(), (Key::NONE, 0));
        self.right.clear();
        self.right.resize(space.width + 2 * space.lanes, Key::NONE);
        select_row(level, space, sums, &mut self.left, &mut self.right);
    }

    /// The winners of the right view, which stands in a mirror.
    pub fn right(&self, space: &SearchSpace) -> &[Key] {
        &self.right[space.lanes..][..space.width]
    }
}

/// The winner of a column with its margin, from its sums; the right view's keys meet these. Without
/// `ALL` only `candidates` are tried.
#[inline(always)]
fn select_column<const ALL: bool>(
    candidates: Range<usize>,
    sums: &[u16],
    right: &mut [Key],
) -> (Key, u16) {
    let (start, count) = (candidates.start as u32, candidates.len() as u32);
    let mut lowest = [u32::MAX; LANES];
    let groups = sums.as_chunks::<LANES>().0.iter().zip(right.as_chunks_mut::<LANES>().0);
    for (group, (sums, right)) in groups.enumerate() {
        for i in 0..LANES {
            let k = (group * LANES + i) as u32;
            let key = u32::from(sums[i]) << 16 | k;
            let key = if ALL || k.wrapping_sub(start) < count { key } else { u32::MAX };
            lowest[i] = lowest[i].min(key);
            right[i] = Key(right[i].0.min(key));
        }
    }
    // There are whole groups. The compiler does not know it, and so makes vectors of this loop; one over all
    // lanes it would unroll first, and compare them one by one.
    let lanes = LANES.min(sums.len());
    let winner = Key(lowest[..lanes].iter().copied().fold(u32::MAX, u32::min));
    let neighbour = (winner.0 as u16).wrapping_sub(1);
    let mut others = [u16::MAX; LANES];
    for (group, sums) in sums.as_chunks::<LANES>().0.iter().enumerate() {
        for i in 0..LANES {
            let k = (group * LANES + i) as u16;
            let other = k.wrapping_sub(neighbour) > 2;
            let tried = ALL || k.wrapping_sub(start as u16) < count as u16;
            let sum = if other & tried { sums[i] } else { u16::MAX };
            others[i] = others[i].min(sum);
        }
    }
    let margin = match others.into_iter().fold(u16::MAX, u16::min) {
        u16::MAX => 0,
        second => second - winner.sum(),
    };
    (winner, margin)
}

at_every_level! {
    /// One pass over the sums of each column serves both views: in the mirror the right columns that
    /// a left one can match stand in the order of their disparities, so that whole vectors of keys
    /// meet the least so far.
    fn select_row(space: &SearchSpace, sums: &[u16], left: &mut [(Key, u16)], right: &mut [Key]) {
        for (x, sums) in sums.chunks_exact(space.lanes).enumerate() {
            let candidates = space.candidates(space.first + x);
            if candidates.is_empty() {
                continue;
            }
            // Where disparity 0 of this column stands among the right keys.
            let place = (space.mirrored(space.first + x) + space.lanes as i64) as usize;
            let right = &mut right[place..place + space.lanes];
            left[x] = if candidates.len() == space.lanes {
                select_column::<true>(candidates, sums, right)
            } else {
                select_column::<false>(candidates, sums, right)
            };
        }
    }
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
                let found = winners.left.iter().map(|&(key, m)| key.disparity().map(|k| (k, m)));
                assert_eq!(found.collect::<Vec<_>>(), left, "{space:?}");
                let found = winners.right(&space).iter().map(|key| key.disparity());
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
