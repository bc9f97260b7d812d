//! One row of four semi-global paths (Hirschmüller, PAMI 2008).
//!
//! A path arriving from pixel `q` at pixel `p` carries, per disparity `d`,
//!
//! ```text
//! L(p, d) = C(p, d) + min( L(q, d), L(q, d - 1) + P1, L(q, d + 1) + P1, min_k L(q, k) + P2 )
//!                   - min_k L(q, k)
//! ```
//!
//! Where the surface at `p` is known to rise by `s` disparities from `q` on, `q` is read `s` lower
//! (`L(q, d - s)` and its neighbours): to follow the surface costs nothing then, to leave it costs
//! what a step costs elsewhere.
//!
//! What a path adds to the cost, its *detour* `L - C`, is at most `P2`. A state never exceeds the
//! largest cost plus `P2`, so one byte holds it as long as that sum stays below 256. The detour is the least
//! of `P2` and of what the first three say above the least state: so it is reckoned.
//!
//! A row is done with its four paths together: the costs are read once, and the sum of the four detours is
//! built in registers. That sum is kept in one byte, bounded by 255: it decides between disparities of which
//! some path says that they are near the cheapest, and what all four call far off may be called so less
//! precisely. Bytes halve the memory and its traffic, which is what sums of 16 bits waited for.
//!
//! The neighbours of a disparity are shifted into place within registers. Read from memory, each of their
//! vectors would lie across two cache lines; and where the path along the row reads what it has just
//! written, it would wait until that is in the cache, since a store is handed on only to a load of the same
//! place.

mod vectors;

use std::ops::Range;

use fearless_simd::{Simd, SimdBase};

use self::vectors::Disparities;
use super::ahead;
use super::aligned::{Aligned, LINE, align_frame};
use super::level::{Level, with_vectors};

/// Disparities come in groups of this many.
pub const LANES: usize = 32;
/// No cost may be larger, so that a path's state fits a byte and a sum of all paths has bits to spare.
pub const LARGEST_COST: u8 = 127;
/// The most disparities in a vector. The states of a pixel are whole vectors at every level.
const WIDEST: usize = LINE;

/// Operations on bytes per pixel and disparity of a row with four paths: each takes six and a minimum
/// over all disparities, and their sum three.
pub const OPERATIONS: usize = 4 * (6 + 1) + 3;
/// Those that make a sum over all paths of both halves: a shift and two additions of 16 bits.
pub const LAST_OPERATIONS: usize = 3 * 2;

/// `count` rounded up to whole groups.
pub fn padded(count: usize) -> usize {
    count.next_multiple_of(LANES)
}

/// States of a pixel, for so many disparities.
fn pitch(count: usize) -> usize {
    count.next_multiple_of(WIDEST)
}

/// The states of the paths that come from the row before: from its previous, its same and its next
/// column, in that order. Columns stand in the order in which the sweep comes to them, which memory is
/// read in fastest. A row puts its states in the place of those of the row before.
#[derive(Default)]
pub struct RowStates {
    /// The path from the previous column has one more before all others, that from the next column one
    /// behind them: these stay zero, since a path that enters the image begins with its cost alone.
    states: [Aligned<u8>; 3],
    /// The least state of each of these columns.
    least: [Vec<u8>; 3],
    /// Of one pixel, while a row is done: states of the path from the previous column that were replaced
    /// and are still wanted.
    replaced: Aligned<u8>,
    /// Of one pixel: the path along the row.
    along: Aligned<u8>,
}

impl RowStates {
    /// Before the first row: every path begins anew.
    pub fn reset(&mut self, columns: usize, count: usize) {
        for (path, (states, least)) in self.states.iter_mut().zip(&mut self.least).enumerate() {
            let columns = columns + usize::from(path != 1);
            states.refill(columns * pitch(count), 0);
            least.clear();
            least.resize(columns, 0);
        }
        self.replaced.resize(pitch(count), 0);
        self.along.resize(pitch(count), 0);
    }

    /// What [`RowStates::save`] appends.
    pub fn saved_bytes(columns: usize, count: usize) -> usize {
        (3 * columns + 2) * (pitch(count) + 1)
    }

    /// The memory of these states.
    pub fn bytes(columns: usize, count: usize) -> usize {
        Self::saved_bytes(columns, count) + 2 * pitch(count) + 5 * LINE
    }

    /// Appends what the next row goes on from.
    pub fn save(&self, saved: &mut Vec<u8>) {
        for (states, least) in self.states.iter().zip(&self.least) {
            saved.extend_from_slice(states);
            saved.extend_from_slice(least);
        }
    }

    /// Takes back what [`RowStates::save`] appended.
    pub fn restore(&mut self, mut saved: &[u8]) {
        let mut take = |to: &mut [u8]| {
            let (from, rest) = saved.split_at(to.len());
            to.copy_from_slice(from);
            saved = rest;
        };
        for (states, least) in self.states.iter_mut().zip(&mut self.least) {
            take(states);
            take(least);
        }
    }
}

/// What is known per column of each path of a row: from the previous, the same and the next column
/// of the row before, and along the row.
#[derive(Default, Clone)]
pub struct RowTransitions {
    /// `P2`.
    pub p2: [Vec<u8>; 4],
    /// By how many disparities the surface rises on the last step, -2 to 2; 0 where a path begins.
    pub rise: [Vec<i8>; 4],
}

/// A row for the paths to go along.
pub struct Row<'a> {
    /// `columns x count`, the disparities of a column side by side.
    pub costs: &'a [u8],
    /// A multiple of [`LANES`].
    pub count: usize,
    pub transitions: &'a RowTransitions,
    /// Surfaces rise as `transitions` say, else nowhere.
    pub rising: bool,
    pub p1: u8,
    /// The path along the row runs from right to left.
    pub reverse: bool,
}

/// What becomes of the sums of the four detours, each at most 255.
pub enum Detours<'a> {
    /// They are left here.
    Leave(&'a mut [u8]),
    /// The four `opposite` paths have left theirs: `sums` get those of all eight, which are eight costs and
    /// the detours of both.
    Meet { opposite: &'a [u8], sums: &'a mut [u16] },
}

/// What will be wanted is asked for so many bytes ahead: more than the processor can be kept waiting for, and
/// little of the nearest cache.
const AHEAD: usize = 2048;

impl Detours<'_> {
    /// Asks for what will be wanted soon after these.
    #[inline(always)]
    fn look_ahead(&self, places: &Range<usize>, reverse: bool) {
        let bytes = match self {
            Detours::Leave(left) => &left[..],
            Detours::Meet { opposite, .. } => opposite,
        };
        for place in places.clone().step_by(LINE) {
            let ahead = if reverse { place.wrapping_sub(AHEAD) } else { place + AHEAD };
            if let Some(byte) = bytes.get(ahead) {
                ahead::read(byte);
            }
        }
    }

    /// Those of some disparities.
    #[inline(always)]
    fn part(&mut self, places: Range<usize>) -> Detours<'_> {
        match self {
            Detours::Leave(left) => Detours::Leave(&mut left[places]),
            Detours::Meet { opposite, sums } => {
                Detours::Meet { opposite: &opposite[places.clone()], sums: &mut sums[places] }
            }
        }
    }
}

/// Advances the four paths by one row. `costs`, detours and sums are `columns x count` with the disparities
/// of a column side by side.
pub fn paths_of_row(level: Level, row: &Row<'_>, states: &mut RowStates, detours: Detours<'_>) {
    match row.rising {
        false => with_vectors!(level, simd => advance::<_, false>(simd, row, states, detours)),
        true => with_vectors!(level, simd => advance::<_, true>(simd, row, states, detours)),
    }
}

/// What all disparities of a column share, per path.
struct Column<V> {
    least: [V; 4],
    p2: [V; 4],
    rise: [i8; 4],
    p1: V,
}

/// What goes from vector to vector of a column, per path.
struct Walk<V> {
    /// States before the step: of the disparities before these, and of these.
    earlier: [V; 4],
    now: [V; 4],
    /// Lane by lane, the least after the step.
    lowest: [V; 4],
}

/// What there is of a column, in vectors.
struct Pixel<'a, V: SimdBase<S>, S: Simd> {
    costs: &'a [u8],
    /// States of the path from the previous column, before and after the step.
    replaced: &'a mut [V::Array],
    /// After the step; that from the same column before it, too.
    states: [&'a mut [V::Array]; 3],
    /// Of the path from the next column, before the step.
    next: &'a [V::Array],
    /// Before and after the step.
    along: &'a mut [V::Array],
    detours: Detours<'a>,
}

impl<S: Simd, V: Disparities<S>> Pixel<'_, V, S> {
    /// The states before the step in vector `i`.
    #[inline(always)]
    fn before(&self, simd: S, i: usize) -> [V; 4] {
        let load = V::load_array_ref;
        let [_, same, _] = &self.states;
        [
            load(simd, &self.replaced[i]),
            load(simd, &same[i]),
            load(simd, &self.next[i]),
            load(simd, &self.along[i]),
        ]
    }

    /// One step of four paths, the definition above, in vector `i`, all or only half of which is wanted.
    /// `later` are states before the step in the vector after it.
    #[inline(always)]
    fn step<const RISE: bool>(
        &mut self,
        simd: S,
        column: &Column<V>,
        walk: &mut Walk<V>,
        i: usize,
        later: [V; 4],
        whole: bool,
    ) {
        let first = i * V::LEN;
        let cost = V::load(simd, &self.costs[first..], whole);
        let (mut detours, mut after) = (later, later);
        // Not in closures: these would not be compiled for the level.
        for path in 0..4 {
            let now = walk.now[path];
            let rise = if RISE { column.rise[path] } else { 0 };
            let [down, same, up] = now.around(walk.earlier[path], later[path], rise);
            let least = same.min(down.min(up).saturating_add(column.p1));
            detours[path] = (least - column.least[path]).min(column.p2[path]);
            after[path] = cost.saturating_add(detours[path]);
            walk.lowest[path] = walk.lowest[path].min(after[path]);
        }
        (walk.earlier, walk.now) = (walk.now, later);
        let [previous, same, next] = &mut self.states;
        self.replaced[i] = previous[i];
        previous[i] = after[0].to_array();
        same[i] = after[1].to_array();
        next[i] = after[2].to_array();
        self.along[i] = after[3].to_array();
        let [a, b, c, d] = detours;
        let four = a.saturating_add(b).saturating_add(c.saturating_add(d));
        match &mut self.detours {
            Detours::Leave(left) => four.store(&mut left[first..], whole),
            Detours::Meet { opposite, sums } => {
                let opposite = V::load(simd, &opposite[first..], whole);
                cost.total(four, opposite, &mut sums[first..], whole);
            }
        }
    }
}

/// The body of [`paths_of_row`].
#[inline(always)]
fn advance<S: Simd, const RISE: bool>(
    simd: S,
    row: &Row<'_>,
    states: &mut RowStates,
    mut detours: Detours<'_>,
) where
    S::u8s: Disparities<S>,
{
    // With AVX2 there are too few registers.
    align_frame();
    let &Row { costs, count, transitions, p1, reverse, .. } = row;
    let columns = costs.len() / count;
    let width = <S::u8s as SimdBase<S>>::LEN;
    // The vectors of a pixel that are wanted, and all that are there.
    let (vectors, all) = (count.div_ceil(width), pitch(count) / width);
    let last = vectors - 1;
    let whole = count.is_multiple_of(width);
    // In the order of the sweep, the next column of the image is the one before.
    let named = if reverse { [2, 1, 0, 3] } else { [0, 1, 2, 3] };
    let p2 = named.map(|path| &transitions.p2[path][..columns]);
    let rise = named.map(|path| &transitions.rise[path][..columns]);

    let [states0, states1, states2] = states.states.each_mut().map(|s| S::u8s::vectors_mut(s));
    let [least0, least1, least2] = states.least.each_mut().map(|least| &mut least[..]);
    let (least0, least2) = (&mut least0[1..=columns], &mut least2[..=columns]);
    let replaced = &mut S::u8s::vectors_mut(&mut states.replaced)[..vectors];
    let along = &mut S::u8s::vectors_mut(&mut states.along)[..vectors];
    let none = S::u8s::splat(simd, 255);
    let zero = S::u8s::splat(simd, 0).to_array();
    replaced.fill(zero);
    along.fill(zero);
    let (mut replaced_least, mut along_least) = (0, 0);
    let from_above = states0.chunks_exact_mut(all).skip(1).zip(states1.chunks_exact_mut(all));
    let least = least0.iter_mut().zip(least1);
    for (at, ((states0, states1), (least0, least1))) in (0..columns).zip(from_above.zip(least)) {
        let x = if reverse { columns - 1 - at } else { at };
        let places = x * count..(x + 1) * count;
        detours.look_ahead(&places, reverse);
        let (states2, next) = states2[at * all..][..2 * all].split_at_mut(all);
        let column = Column {
            least: splat(simd, [replaced_least, *least1, least2[at + 1], along_least]),
            p2: splat(simd, [p2[0][x], p2[1][x], p2[2][x], p2[3][x]]),
            rise: if RISE { [rise[0][x], rise[1][x], rise[2][x], rise[3][x]] } else { [0; 4] },
            p1: S::u8s::splat(simd, p1),
        };
        let mut pixel = Pixel {
            costs: &costs[places.clone()],
            replaced: &mut *replaced,
            states: [&mut states0[..vectors], &mut states1[..vectors], &mut states2[..vectors]],
            next: &next[..vectors],
            along: &mut *along,
            detours: detours.part(places),
        };
        let now = pixel.before(simd, 0);
        let mut walk = Walk { earlier: [none; 4], now, lowest: [none; 4] };
        for i in 0..last {
            let later = pixel.before(simd, i + 1);
            pixel.step::<RISE>(simd, &column, &mut walk, i, later, true);
        }
        pixel.step::<RISE>(simd, &column, &mut walk, last, [none; 4], whole);
        replaced_least = *least0;
        *least0 = walk.lowest[0].reduce_min();
        *least1 = walk.lowest[1].reduce_min();
        least2[at] = walk.lowest[2].reduce_min();
        along_least = walk.lowest[3].reduce_min();
    }
}

#[inline(always)]
fn splat<S: Simd, V: Disparities<S>>(simd: S, [a, b, c, d]: [u8; 4]) -> [V; 4] {
    [V::splat(simd, a), V::splat(simd, b), V::splat(simd, c), V::splat(simd, d)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::kernels::level::Level;

    /// The recurrence as the paper writes it, in whole numbers, for one path.
    fn definition(cost: &[u8], before: Option<&[i32]>, p1: i32, p2: i32, rise: i32) -> Vec<i32> {
        let Some(before) = before else { return cost.iter().map(|&c| i32::from(c)).collect() };
        let least = *before.iter().min().unwrap();
        (0..cost.len())
            .map(|d| {
                let before = |d: i32| usize::try_from(d).ok().and_then(|d| before.get(d));
                let d = d as i32;
                let changes = [(0, 0), (-1, p1), (1, p1)];
                let best = changes
                    .into_iter()
                    .filter_map(|(change, price)| Some(before(d - rise + change)? + price))
                    .fold(least + p2, i32::min);
                i32::from(cost[d as usize]) + best - least
            })
            .collect()
    }

    #[test]
    fn four_paths_are_the_papers_recurrence_at_every_level() {
        // One vector or several, with and without half of one at the end.
        for (count, reverse) in [(32, true), (64, false), (96, true), (160, false), (192, true)] {
            four_paths_are_the_papers_recurrence(count, reverse);
        }
    }

    fn four_paths_are_the_papers_recurrence(count: usize, reverse: bool) {
        let (columns, rows, p1) = (13, 6, 7u8);
        let mut chance = Chance(1);
        let mut random = |n: u32| chance.below(n) as u8;
        let costs: Vec<u8> = (0..columns * rows * count).map(|_| random(80)).collect();
        let others: Vec<u8> = (0..columns * count).map(|_| random(255)).collect();
        let mut transitions = RowTransitions::default();
        for (p2, rise) in transitions.p2.iter_mut().zip(&mut transitions.rise) {
            *p2 = (0..columns).map(|_| 20 + random(100)).collect();
            *rise = vec![0; columns];
        }
        for level in Level::available() {
            eprintln!("level {}, {count} disparities", level.name());
            let mut states = RowStates::default();
            states.reset(columns, count);
            let mut expected_before: Vec<[Vec<i32>; 3]> = Vec::new();
            for y in 0..rows {
                let costs = &costs[y * columns * count..][..columns * count];
                for (path, rise) in transitions.rise.iter_mut().enumerate() {
                    let begins = |x: usize| match path {
                        0 => y == 0 || x == 0,
                        1 => y == 0,
                        2 => y == 0 || x == columns - 1,
                        _ => x == if reverse { columns - 1 } else { 0 },
                    };
                    let rises =
                        (0..columns).map(|x| if begins(x) { 0 } else { random(5) as i8 - 2 });
                    *rise = rises.collect();
                }
                // Even rows leave the detours, odd ones meet others; two of three have surfaces that rise.
                let (meet, rising) = (y % 2 == 1, y % 3 > 0);
                let (mut left, mut sums) = (vec![0; costs.len()], vec![0; costs.len()]);
                let row = Row { costs, count, transitions: &transitions, rising, p1, reverse };
                let detours = if meet {
                    Detours::Meet { opposite: &others, sums: &mut sums }
                } else {
                    Detours::Leave(&mut left)
                };
                paths_of_row(level, &row, &mut states, detours);

                let mut now = vec![[const { Vec::new() }; 3]; columns];
                let mut along_before: Option<Vec<i32>> = None;
                for step in 0..columns {
                    let x = if reverse { columns - 1 - step } else { step };
                    let c = &costs[x * count..][..count];
                    let at = |path: usize, x: Option<usize>| {
                        x.and_then(|x| expected_before.get(x)).map(|s| &s[path][..])
                    };
                    let p2 = |path: usize| i32::from(transitions.p2[path][x]);
                    let rise =
                        |path: usize| if rising { i32::from(transitions.rise[path][x]) } else { 0 };
                    let p1 = i32::from(p1);
                    let three = [
                        definition(c, at(0, x.checked_sub(1)), p1, p2(0), rise(0)),
                        definition(c, at(1, Some(x)), p1, p2(1), rise(1)),
                        definition(c, at(2, Some(x + 1)), p1, p2(2), rise(2)),
                    ];
                    let fourth = definition(c, along_before.as_deref(), p1, p2(3), rise(3));
                    for d in 0..count {
                        let (at, cost) = (x * count + d, i32::from(c[d]));
                        let four = three.iter().map(|l| l[d]).sum::<i32>() + fourth[d] - 4 * cost;
                        let four = four.min(255);
                        if meet {
                            let total = 8 * cost + four + i32::from(others[at]);
                            assert_eq!(i32::from(sums[at]), total, "x {x} y {y} d {d}");
                        } else {
                            assert_eq!(i32::from(left[at]), four, "x {x} y {y} d {d}");
                        }
                    }
                    now[x] = three;
                    along_before = Some(fourth);
                }
                expected_before = now;
            }
        }
    }

    #[test]
    fn what_was_saved_goes_on_as_if_nothing_had_been_between() {
        let (columns, count) = (9, 96);
        let mut chance = Chance(3);
        let rows: [Vec<u8>; 3] =
            std::array::from_fn(|_| (0..columns * count).map(|_| chance.below(99) as u8).collect());
        let mut transitions = RowTransitions::default();
        transitions.p2 = transitions.p2.map(|_| vec![60; columns]);
        transitions.rise = transitions.rise.map(|_| vec![0; columns]);
        let level = Level::detect();
        let mut states = RowStates::default();
        states.reset(columns, count);
        let go = |states: &mut RowStates, costs: &[u8]| {
            let mut left = vec![0; costs.len()];
            let row = Row {
                costs,
                count,
                transitions: &transitions,
                rising: false,
                p1: 9,
                reverse: false,
            };
            paths_of_row(level, &row, states, Detours::Leave(&mut left));
            left
        };
        go(&mut states, &rows[0]);
        let mut saved = vec![7; 5];
        states.save(&mut saved);
        assert_eq!(saved.len() - 5, RowStates::saved_bytes(columns, count));
        let expected = go(&mut states, &rows[1]);
        go(&mut states, &rows[2]);
        states.restore(&saved[5..]);
        assert_eq!(go(&mut states, &rows[1]), expected);
    }
}
