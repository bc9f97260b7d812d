//! Winner takes all, in both views, from the sums of one row.
//!
//! Left: `k(x) = argmin_k S(x, k)` over the disparities whose match lies inside the right image.
//! Right: `k'(x') = argmin_k S(x' + min + k, k)`: the same sums read along their diagonal, so the
//! second view costs no second matching (Fua 1993; Muehlmann et al. 2002); where only every second
//! column is matched, the one between has the sums of the one before. Of equal sums the smallest
//! disparity wins, in both views.

use std::ops::Range;

use crate::cost::SearchSpace;
use crate::kernels::aligned::Line;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::path::{self, LANES};

/// Operations on bytes per pixel and disparity, all on numbers of 16 bits: a shift, two marks, three minima and
/// a maximum.
pub(crate) const OPERATIONS: usize = 2 * 7;

/// So many things a sum can be marked with: groups of a column, or columns of a block.
const TAGS: usize = 32;
/// No sum is larger: eight costs and what the paths of both halves add. Marked, it fits 16 bits.
const LARGEST: u16 = 8 * path::LARGEST_COST as u16 + 2 * u8::MAX as u16;
const _: () = assert!((LARGEST as usize + 1) * TAGS <= u16::MAX as usize);
/// Columns of a block meet right pixels in turns, each of which has its own: what one column writes the next one
/// would read shifted by a lane, which takes as long as writing it to memory.
const TURNS: usize = 4;
/// So many disparities are marked together.
const PART: usize = TAGS * LANES;
const _: () = assert!(LANES == 32, "five steps make one of as many");

/// A sum and its disparity in one number, the sum above: of two keys the smaller one wins. The
/// largest stands for "no disparity could be tried".
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Key(u32);

impl Key {
    pub const NONE: Key = Key(u32::MAX);

    /// The disparity, counted from the smallest, if any could be tried.
    #[inline(always)]
    pub fn index(self) -> u16 {
        self.0 as u16
    }

    #[cfg(test)]
    pub fn disparity(self) -> Option<usize> {
        (self != Self::NONE).then_some(self.index().into())
    }
}

/// The winners of a row in both views, with their memory.
#[derive(Debug, Default)]
pub(crate) struct Winners {
    /// Per column of the search space: its winner.
    pub left: Vec<Key>,
    /// How much lower its sum lies than that of any disparity but its neighbours; 0 without any other.
    pub margins: Vec<u16>,
    /// Keys of the right view, as it looks in a mirror, between two margins.
    right: Vec<Key>,
    block: Block,
}

/// What a block of columns finds.
#[derive(Debug, Default)]
struct Block {
    /// Of the right pixels that the columns of each turn meet, the least sum marked with the column.
    right: [Vec<u16>; TURNS],
    /// Of each part of the disparities, as many as sums can be marked with groups.
    parts: Vec<Part>,
}

/// The two least sums of every lane of every column of a block, marked with their groups.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
struct Part {
    least: [[u16; LANES]; TAGS],
    next: [[u16; LANES]; TAGS],
}

impl Winners {
    /// Finds the winners of a row of sums, `space.lanes` per column.
    pub fn select(&mut self, level: Level, space: &SearchSpace, sums: &[u16]) {
        self.left.clear();
        self.left.resize(space.columns(), Key::NONE);
        self.margins.clear();
        self.margins.resize(space.columns(), 0);
        self.right.clear();
        let met = space.lanes + space.apart * TAGS;
        self.right.resize(space.width + 2 * met, Key::NONE);
        for right in &mut self.block.right {
            right.resize(met, NO_SUM);
        }
        self.block.parts.resize(space.lanes.div_ceil(PART), Part::EMPTY);
        let Self { left, margins, right, block } = self;
        select_row(level, space, sums, (left, margins), right, block);
        if space.apart > 1 {
            meet_next(level, right);
        }
    }

    /// The winners of the right view, which stands in a mirror.
    pub fn right(&self, space: &SearchSpace) -> &[Key] {
        &self.right[space.lanes + space.apart * TAGS..][..space.width]
    }
}

/// Stands for "no disparity could be tried" among marked sums.
const NO_SUM: u16 = u16::MAX;

impl Part {
    const EMPTY: Self = Self { least: [[NO_SUM; LANES]; TAGS], next: [[NO_SUM; LANES]; TAGS] };
}

at_every_level! {
    /// One pass over the sums of each column serves both views: in the mirror the right columns that
    /// a left one can match stand in the order of their disparities, so that whole vectors of sums
    /// meet the least so far. Columns do so in blocks, with as many as a sum can be marked with; of a block
    /// each step is taken for all columns, which do not wait for each other.
    fn select_row(
        space: &SearchSpace,
        sums: &[u16],
        left: (&mut [Key], &mut [u16]),
        right: &mut [Key],
        block: &mut Block,
    ) {
        let (left, margins) = left;
        let blocks = sums.chunks(TAGS * space.lanes);
        let blocks = blocks.zip(left.chunks_mut(TAGS)).zip(margins.chunks_mut(TAGS));
        for (number, ((sums, left), margins)) in blocks.enumerate() {
            let columns = sums.len() / space.lanes;
            let column = |i: usize| space.in_image(number * TAGS + i);
            // Where two columns try all disparities, those between do.
            let ends = [0, columns - 1].map(|i| space.candidates(column(i)).len());
            let all = ends == [space.lanes; 2];
            for right in &mut block.right {
                right.fill(NO_SUM);
            }
            for (part, start) in block.parts.iter_mut().zip((0..).step_by(PART)) {
                let count = PART.min(space.lanes - start);
                for (i, sums) in sums.chunks_exact(space.lanes).enumerate() {
                    // In the mirror a column further on lies before.
                    let place = space.apart * (TAGS - i) + start;
                    let right = &mut block.right[i % TURNS][place..][..count];
                    let (sums, tried) = (&sums[start..][..count], space.candidates(column(i)));
                    (part.least[i], part.next[i]) = if all {
                        meet_column::<true>(0..count, sums, i as u16, right)
                    } else {
                        let tried = [tried.start, tried.end].map(|k| k.saturating_sub(start));
                        meet_column::<false>(tried[0]..tried[1], sums, i as u16, right)
                    };
                }
            }
            if (0..columns).any(|i| !space.candidates(column(i)).is_empty()) {
                let (keys, differences) = select_block(&block.parts);
                left.copy_from_slice(&keys[..columns]);
                margins.copy_from_slice(&differences[..columns]);
                // Where disparity 0 of the block's first column stands, and so many before.
                let place = space.mirrored(column(0)) + space.lanes as i64;
                let met = &mut right[place as usize..][..block.right[0].len()];
                meet_block(&block.right, space.apart as u32, met);
            }
        }
    }

    /// Right pixels take what the one after them in the mirror has, if its sum is smaller: they are met by the
    /// column between, which has the sums of the one before.
    fn meet_next(right: &mut [Key]) {
        for place in 1..right.len() {
            right[place - 1].0 = right[place - 1].0.min(right[place].0);
        }
    }
}

/// The two least of the sums of a column that are `tried`, in every lane, marked with their groups. Those of the
/// right pixels that the column matches meet them, marked with the column. With `ALL` all are tried.
#[inline(always)]
fn meet_column<const ALL: bool>(
    tried: Range<usize>,
    sums: &[u16],
    column: u16,
    right: &mut [u16],
) -> ([u16; LANES], [u16; LANES]) {
    let [mut least, mut next] = [[NO_SUM; LANES]; 2];
    let groups = sums.as_chunks::<LANES>().0.iter().zip(right.as_chunks_mut::<LANES>().0);
    for (group, (sums, right)) in groups.enumerate() {
        let (first, marks) = (group * LANES, [group as u16, column]);
        if ALL || tried.start <= first && first + LANES <= tried.end {
            meet_group::<true>(0..0, sums, marks, &mut least, &mut next, right);
        } else {
            let lanes = tried.start.saturating_sub(first)..tried.end.saturating_sub(first);
            meet_group::<false>(lanes, sums, marks, &mut least, &mut next, right);
        }
    }
    (least, next)
}

/// The same of a group. Without `ALL` only some `lanes` are tried.
#[inline(always)]
fn meet_group<const ALL: bool>(
    lanes: Range<usize>,
    sums: &[u16; LANES],
    [group, column]: [u16; 2],
    least: &mut [u16; LANES],
    next: &mut [u16; LANES],
    right: &mut [u16; LANES],
) {
    let (start, count) = (lanes.start as u16, lanes.len() as u16);
    for i in 0..LANES {
        // Written without a condition, of which the compiler would make a jump below AVX-512.
        let is_untried = !ALL && (i as u16).wrapping_sub(start) >= count;
        let untried = NO_SUM & u16::from(is_untried).wrapping_neg();
        // What is not tried may be larger than what can be marked.
        let sum = sums[i].wrapping_mul(TAGS as u16) | untried;
        let [here, there] = [sum | group, sum | column];
        next[i] = next[i].min(least[i].max(here));
        least[i] = least[i].min(here);
        right[i] = right[i].min(there);
    }
}

/// The winners of a block and their margins.
#[inline(always)]
fn select_block(parts: &[Part]) -> ([Key; TAGS], [u16; TAGS]) {
    let mut winners = [Key::NONE.0; TAGS];
    for (part, first) in parts.iter().zip((0..).step_by(PART)) {
        let (least, lanes) = least_with_lane(&part.least);
        for i in 0..TAGS {
            let [sum, group] = [least[i] / TAGS as u16, least[i] % TAGS as u16].map(u32::from);
            let disparity = first + group * LANES as u32 + u32::from(lanes[i]);
            let found = if least[i] == NO_SUM { Key::NONE.0 } else { sum << 16 | disparity };
            winners[i] = winners[i].min(found);
        }
    }
    let mut second = [NO_SUM; TAGS];
    for (part, first) in parts.iter().zip((0u16..).step_by(PART)) {
        let mut others = Line([[NO_SUM; LANES]; TAGS]);
        let columns = part.least.iter().zip(&part.next).zip(winners);
        for (others, ((least, next), winner)) in others.iter_mut().zip(columns) {
            // A lane has at most one of the winner and its neighbours.
            let neighbours = (winner as u16).wrapping_sub(1).wrapping_sub(first);
            for i in 0..LANES {
                let k = least[i] % TAGS as u16 * LANES as u16 + i as u16;
                let is_near = u16::from(k.wrapping_sub(neighbours) <= 2).wrapping_neg();
                others[i] = least[i] ^ (least[i] ^ next[i]) & is_near;
            }
        }
        let others = least_with_lane(&others).0;
        for i in 0..TAGS {
            second[i] = second[i].min(others[i]);
        }
    }
    let mut margins = [0; TAGS];
    for i in 0..TAGS {
        let margin = (second[i] / TAGS as u16).wrapping_sub((winners[i] >> 16) as u16);
        margins[i] = if second[i] == NO_SUM { 0 } else { margin };
    }
    let mut keys = [Key::NONE; TAGS];
    for i in 0..TAGS {
        keys[i] = Key(winners[i]);
    }
    (keys, margins)
}

/// The least of the lanes of every column, and the first lane that has it.
#[inline(always)]
fn least_with_lane(columns: &[[u16; LANES]; TAGS]) -> (Line<[u16; TAGS]>, Line<[u16; TAGS]>) {
    /// Lanes are counted from the first of so many that were compared.
    #[inline(always)]
    fn halve<const N: usize>(
        values: &[u16],
        lanes: &[u16],
        compared: u16,
    ) -> (Line<[u16; N]>, Line<[u16; N]>) {
        let (mut least, mut lane) = (Line([0; N]), Line([0; N]));
        let pairs = values.as_chunks::<2>().0.iter().zip(lanes.as_chunks::<2>().0);
        for ((least, lane), (values, lanes)) in least.iter_mut().zip(&mut *lane).zip(pairs) {
            let (first, second) = (lanes[0], lanes[1] + compared);
            // Written without a condition, of which the compiler would make a jump.
            let is_second = u16::from(values[1] < values[0]).wrapping_neg();
            *least = values[0].min(values[1]);
            *lane = first ^ (first ^ second) & is_second;
        }
        (least, lane)
    }
    let none = Line([0; TAGS * LANES]);
    let of_16 = halve::<{ TAGS * LANES / 2 }>(columns.as_flattened(), &*none, 1);
    let of_8 = halve::<{ TAGS * LANES / 4 }>(&*of_16.0, &*of_16.1, 2);
    let of_4 = halve::<{ TAGS * LANES / 8 }>(&*of_8.0, &*of_8.1, 4);
    let of_2 = halve::<{ TAGS * LANES / 16 }>(&*of_4.0, &*of_4.1, 8);
    halve(&*of_2.0, &*of_2.1, 16)
}

/// The right pixels of a block meet those of all blocks so far.
#[inline(always)]
fn meet_block(turns: &[Vec<u16>; TURNS], apart: u32, right: &mut [Key]) {
    let [a, b, c, d] = turns;
    let turns = a.iter().zip(b).zip(c.iter().zip(d));
    for (place, (key, ((a, b), (c, d)))) in right.iter_mut().zip(turns).enumerate() {
        let marked = *a.min(b).min(c.min(d));
        let column = u32::from(marked) % TAGS as u32;
        let disparity = (place as u32 + apart * column).wrapping_sub(apart * TAGS as u32);
        let sum = u32::from(marked) / TAGS as u32;
        // All bits where there is no sum. Of a condition the compiler would make another one, whether to write, which
        // AVX2 is slow at.
        let none = ((u32::from(marked) + 1) >> u16::BITS).wrapping_neg();
        key.0 = key.0.min(sum << 16 | disparity & 0xFFFF | none);
    }
}

/// Where the tip of a V through three costs lies, the shape ("equiangular") that absolute differences have around their
/// minimum (Shimizu & Okutomi 2001): 0 where all are equal, between -1/2 and 1/2 where the second is the least.
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
        let sum = |x: usize, k: usize| sums[(x - space.first) / space.apart * space.lanes + k];
        let columns = (space.first..=space.last).step_by(space.apart);
        let left = columns.clone().map(|x| {
            let winner = space.candidates(x).min_by_key(|&k| sum(x, k))?;
            let others = space.candidates(x).filter(|k| k.abs_diff(winner) > 1);
            let second = others.map(|k| sum(x, k)).min();
            Some((winner, second.map_or(0, |second| second - sum(x, winner))))
        });
        let right = (0..space.width).rev().map(|right| {
            let pairs = columns.clone().flat_map(|x| {
                // A column stands for those up to the next one.
                let meets =
                    move |k: usize, u: usize| u as i32 - space.min - k as i32 == right as i32;
                let is_met = move |k: &usize| (x..x + space.apart).any(|u| meets(*k, u));
                space.candidates(x).filter(is_met).map(move |k| (sum(x, k), k))
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
            // Whole groups, all of which are tried in some blocks.
            (100, (20, 90), (0, 31)),
            // More disparities than can be marked at once, of which all or some are tried.
            (1500, (1060, 1130), (0, 1055)),
            (1200, (1130, 1199), (0, 1199)),
            (1200, (0, 60), (-1199, 30)),
        ] {
            let bounds = BoundingBox::new(columns.0, 0, columns.1, 0).unwrap();
            let range = DisparityRange::new(range.0, range.1).unwrap();
            let spaces = [1, 2].map(|apart| SearchSpace::of_every(apart, width, bounds, range));
            let pairs = spaces[0].columns() * spaces[0].lanes;
            // Among few sums many are equal; then those that come near the largest.
            let equal: Vec<u16> = (0..pairs).map(|_| random(40)).collect();
            let large: Vec<u16> = (0..pairs).map(|_| LARGEST - random(40) * random(40)).collect();
            let cases = [&equal, &large].into_iter().flat_map(|sums| spaces.map(|s| (s, sums)));
            let levels = Level::available().into_iter();
            for (level, (space, sums)) in levels.flat_map(|l| cases.clone().map(move |c| (l, c))) {
                eprintln!("level {}, every {}", level.name(), space.apart);
                let sums = &sums[..space.columns() * space.lanes];
                let (left, right) = definition(&space, sums);
                let mut winners = Winners::default();
                winners.select(level, &space, sums);
                let found = winners.left.iter().zip(&winners.margins);
                let found = found.map(|(key, &margin)| Some((key.disparity()?, margin)));
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
