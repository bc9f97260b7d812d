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
//! largest cost plus `P2`, so one byte holds it as long as that sum stays below 256.
//!
//! A row is done with its four paths together: the costs are read once, the sum of the four detours is
//! built in registers, and the three paths from the row before hide the latency of the one along the
//! row. That sum is kept in one byte, bounded by 255: it decides between disparities of which some
//! path says that they are near the cheapest, and what all four call far off may be called so less
//! precisely. Bytes halve the memory and its traffic, which is what sums of 16 bits waited for.

use super::aligned::{Aligned, LINE};
use super::level::at_every_level;

/// Disparities are handled in groups of this many.
pub const LANES: usize = 32;
/// Room before a pixel's states for the neighbours `d - 1` and `d + 1`, and after the last pixel. As long as a
/// group, so that all groups begin where it takes one load to read them.
const MARGIN: usize = LANES;
/// No cost may be larger, so that a path's state fits a byte and a sum of all paths has bits to spare.
pub const LARGEST_COST: u8 = 127;
/// What a surface may rise or fall from one pixel to the next.
pub const HIGHEST_RISE: i8 = 2;
const _: () = assert!((HIGHEST_RISE as usize) < MARGIN);

/// Operations on bytes per pixel and disparity of a row with four paths: each takes six and a minimum
/// over all disparities, and their sum three.
pub const OPERATIONS: usize = 4 * (6 + 1) + 3;
/// Those that make a sum over all paths of both halves: a shift and two additions of 16 bits.
pub const LAST_OPERATIONS: usize = 3 * 2;

/// `count` rounded up to whole groups.
pub fn padded(count: usize) -> usize {
    count.div_ceil(LANES) * LANES
}

/// The states of three paths along one row: from the previous, the same and the next column of the
/// row before, in that order. Columns stand in the order in which the sweep comes to them, which
/// memory is read in fastest. One column more on each side stays zero: a path that enters the image
/// begins with its cost alone.
#[derive(Default)]
pub struct RowStates {
    /// Per path and column: `MARGIN` bytes of 255, the states; then once more `MARGIN` bytes of 255.
    states: [Aligned<u8>; 3],
    /// The least state of each column.
    least: [Vec<u8>; 3],
}

impl RowStates {
    /// Before the first row: every path begins anew.
    pub fn reset(&mut self, columns: usize, padded_count: usize) {
        let stride = padded_count + MARGIN;
        for (states, least) in self.states.iter_mut().zip(&mut self.least) {
            states.refill((columns + 2) * stride + MARGIN, 0);
            least.clear();
            least.resize(columns + 2, 0);
            // Also before what stays zero, which is after the last column.
            for column in states.chunks_mut(stride).skip(1) {
                column[..MARGIN].fill(255);
            }
        }
    }

    /// What [`RowStates::save`] appends.
    pub fn saved_bytes(columns: usize, padded_count: usize) -> usize {
        3 * columns * (padded_count + 1)
    }

    /// The memory of these states.
    pub fn bytes(columns: usize, padded_count: usize) -> usize {
        3 * ((columns + 2) * (padded_count + MARGIN + 1) + MARGIN + LINE)
    }

    /// Appends what is not the same in every row: the states between the margins, then the least.
    pub fn save(&self, saved: &mut Vec<u8>) {
        for (states, least) in self.states.iter().zip(&self.least) {
            let columns = 1..least.len() - 1;
            let stride = (states.len() - MARGIN) / least.len();
            for x in columns.clone() {
                saved.extend_from_slice(&states[x * stride..][MARGIN..stride]);
            }
            saved.extend_from_slice(&least[columns]);
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
            let columns = 1..least.len() - 1;
            let stride = (states.len() - MARGIN) / least.len();
            for x in columns.clone() {
                take(&mut states[x * stride..][MARGIN..stride]);
            }
            take(&mut least[columns]);
        }
    }
}

/// The state of the path along the row, of two columns in turn.
#[derive(Default)]
pub struct AlongState {
    states: [Aligned<u8>; 2],
}

impl AlongState {
    /// Makes room for this many disparities.
    pub fn reset(&mut self, padded_count: usize) {
        for states in &mut self.states {
            states.refill(padded_count + 2 * MARGIN, 255);
        }
    }
}

/// What is known per column of each path of a row: from the previous, the same and the next column
/// of the row before, and along the row.
#[derive(Default, Clone)]
pub struct RowTransitions {
    /// `P2`.
    pub p2: [Vec<u8>; 4],
    /// By how many disparities the surface rises on the last step, at most [`HIGHEST_RISE`]; 0
    /// where a path begins.
    pub rise: [Vec<i8>; 4],
}

/// States, costs or sums of one group of disparities.
type Group<T> = [T; LANES];

/// The states of a pixel before: of every group `d - 1`, `d` and `d + 1`. Cut once per column, so that
/// nothing is left to check per group.
#[derive(Clone, Copy)]
struct Around<'a>([&'a [Group<u8>]; 3]);

impl<'a> Around<'a> {
    #[inline(always)]
    fn new(states: &'a [u8], first: usize, count: usize) -> Self {
        let window = &states[first - 1..][..count * LANES + 2];
        Self([groups(window, count), groups(&window[1..], count), groups(&window[2..], count)])
    }
}

/// The first groups of a slice.
#[inline(always)]
fn groups(samples: &[u8], count: usize) -> &[Group<u8>] {
    &samples.as_chunks().0[..count]
}

/// One step of one path for one group of disparities, the definition above: the state and its detour.
#[inline(always)]
fn step(
    cost: &Group<u8>,
    before: Around<'_>,
    group: usize,
    least: u8,
    p1: u8,
    p2: u8,
) -> (Group<u8>, Group<u8>) {
    let [down, same, up] = [&before.0[0][group], &before.0[1][group], &before.0[2][group]];
    let jump = least.saturating_add(p2);
    let (mut after, mut detour) = ([0; LANES], [0; LANES]);
    for i in 0..LANES {
        let change = down[i].min(up[i]).saturating_add(p1);
        detour[i] = same[i].min(change).min(jump) - least;
        after[i] = cost[i].saturating_add(detour[i]);
    }
    (after, detour)
}

#[inline(always)]
fn least_of(values: &Group<u8>) -> u8 {
    values.iter().fold(255, |least, &value| least.min(value))
}

at_every_level! {
    /// Advances the four paths by one row.
    ///
    /// `cost`, `detours` and `sums` hold `columns x count` values with the disparities of a column side
    /// by side (`count` a multiple of [`LANES`]). `before` are the states of the row before, `after`
    /// those of this one. With `REVERSE` the path along the row runs from right to left.
    ///
    /// Without `LAST` the four detours' sum, at most 255, is left in `detours`. With it `detours` has
    /// what the four opposite paths left, and `sums` gets the sum of all eight: eight costs, and the
    /// detours of both.
    ///
    /// With `RISE` surfaces rise as `transitions` say, without it nowhere.
    pub fn paths_of_row<const REVERSE: bool, const LAST: bool, const RISE: bool>(
        cost: &[u8],
        count: usize,
        transitions: &RowTransitions,
        p1: u8,
        before: &RowStates,
        after: &mut RowStates,
        along: &mut AlongState,
        detours: &mut [u8],
        sums: &mut [u16],
    ) {
        let columns = cost.len() / count;
        let stride = count + MARGIN;
        let lanes = count / LANES;
        let [even, odd] = along.states.each_mut().map(|s| &mut s[..]);
        even[MARGIN..MARGIN + count].fill(0);
        let mut along_least = 0u8;
        // Cut before the loop, so that within it little is left to check.
        let p2 = transitions.p2.each_ref().map(|p2| &p2[..columns]);
        let rise = transitions.rise.each_ref().map(|rise| &rise[..columns]);
        let [before0, before1, before2] = before.states.each_ref().map(|states| &states[..]);
        let before_least = before.least.each_ref().map(|least| &least[..columns + 2]);
        let after_least = after.least.each_mut().map(|least| &mut least[1..=columns]);
        let [after0, after1, after2] = &mut after.states;
        let to = after0[stride..]
            .chunks_exact_mut(stride)
            .zip(after1[stride..].chunks_exact_mut(stride))
            .zip(after2[stride..].chunks_exact_mut(stride));
        for (step_at, ((to0, to1), to2)) in (0..columns).zip(to) {
            let x = if REVERSE { columns - 1 - step_at } else { step_at };
            let (old, new) =
                if step_at % 2 == 0 { (&*even, &mut *odd) } else { (&*odd, &mut *even) };
            let cost = groups(&cost[x * count..][..count], lanes);
            let detours = &mut detours[x * count..][..count].as_chunks_mut::<LANES>().0[..lanes];
            let sums = if LAST { &mut sums[x * count..][..count] } else { &mut [] };
            let sums = &mut sums.as_chunks_mut::<LANES>().0[..if LAST { lanes } else { 0 }];
            // In the order of the sweep, the next column of the image is the one before.
            let named = |path: usize| if REVERSE && path < 3 { 2 - path } else { path };
            // Where each path reads the state before.
            let first: [usize; 4] = std::array::from_fn(|path| {
                if !RISE {
                    return MARGIN;
                }
                let rise = rise[named(path)][x].clamp(-HIGHEST_RISE, HIGHEST_RISE);
                (MARGIN as isize - isize::from(rise)) as usize
            });
            // The column of a step is one further on in the states; paths come from one before to one after.
            let from0 = Around::new(before0, step_at * stride + first[0], lanes);
            let from1 = Around::new(before1, (step_at + 1) * stride + first[1], lanes);
            let from2 = Around::new(before2, (step_at + 2) * stride + first[2], lanes);
            let from3 = Around::new(old, first[3], lanes);
            let least: [u8; 3] = std::array::from_fn(|path| before_least[path][step_at + path]);
            let to0 = &mut to0[MARGIN..][..count].as_chunks_mut::<LANES>().0[..lanes];
            let to1 = &mut to1[MARGIN..][..count].as_chunks_mut::<LANES>().0[..lanes];
            let to2 = &mut to2[MARGIN..][..count].as_chunks_mut::<LANES>().0[..lanes];
            let to3 = &mut new[MARGIN..][..count].as_chunks_mut::<LANES>().0[..lanes];
            let p2: [u8; 4] = std::array::from_fn(|path| p2[named(path)][x]);
            let mut lowest = [[255u8; LANES]; 4];
            for group in 0..lanes {
                let c = &cost[group];
                let (l0, r0) = step(c, from0, group, least[0], p1, p2[0]);
                let (l1, r1) = step(c, from1, group, least[1], p1, p2[1]);
                let (l2, r2) = step(c, from2, group, least[2], p1, p2[2]);
                let (l3, r3) = step(c, from3, group, along_least, p1, p2[3]);
                to0[group] = l0;
                to1[group] = l1;
                to2[group] = l2;
                to3[group] = l3;
                // One loop per width of number, so that each fills its vectors.
                let mut four = [0u8; LANES];
                for i in 0..LANES {
                    let pairs = [r0[i].saturating_add(r1[i]), r2[i].saturating_add(r3[i])];
                    four[i] = pairs[0].saturating_add(pairs[1]);
                }
                if LAST {
                    let (opposite, sum) = (&detours[group], &mut sums[group]);
                    for i in 0..LANES {
                        let eight = u16::from(opposite[i]) + u16::from(four[i]);
                        sum[i] = 8 * u16::from(c[i]) + eight;
                    }
                } else {
                    detours[group] = four;
                }
                for i in 0..LANES {
                    lowest[0][i] = lowest[0][i].min(l0[i]);
                    lowest[1][i] = lowest[1][i].min(l1[i]);
                    lowest[2][i] = lowest[2][i].min(l2[i]);
                    lowest[3][i] = lowest[3][i].min(l3[i]);
                }
            }
            for path in 0..3 {
                after_least[path][step_at] = least_of(&lowest[path]);
            }
            along_least = least_of(&lowest[3]);
        }
    }
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
        let (columns, rows, count, p1) = (13, 5, 64, 7u8);
        let mut chance = Chance(1);
        let mut random = |n: u32| chance.below(n) as u8;
        let costs: Vec<u8> = (0..columns * rows * count).map(|_| random(80)).collect();
        let mut transitions = RowTransitions::default();
        for (p2, rise) in transitions.p2.iter_mut().zip(&mut transitions.rise) {
            *p2 = (0..columns).map(|_| 20 + random(100)).collect();
            *rise = vec![0; columns];
        }
        for level in Level::available() {
            eprintln!("level {}", level.name());
            let mut states = [RowStates::default(), RowStates::default()];
            states.iter_mut().for_each(|s| s.reset(columns, count));
            let mut along = AlongState::default();
            along.reset(count);
            let mut expected_before: Vec<[Vec<i32>; 3]> = Vec::new();
            for y in 0..rows {
                let cost = &costs[y * columns * count..][..columns * count];
                for (path, rise) in transitions.rise.iter_mut().enumerate() {
                    let begins = |x: usize| match path {
                        0 => y == 0 || x == 0,
                        1 => y == 0,
                        2 => y == 0 || x == columns - 1,
                        _ => x == 0,
                    };
                    let rises =
                        (0..columns).map(|x| if begins(x) { 0 } else { random(5) as i8 - 2 });
                    *rise = rises.collect();
                }
                // Even rows leave the detours, odd ones take up others.
                let mut detours = vec![3u8; columns * count];
                let mut sums = vec![0u16; columns * count];
                let [before, after] = &mut states;
                let paths =
                    [paths_of_row::<false, false, true>, paths_of_row::<false, true, true>][y % 2];
                paths(
                    level,
                    cost,
                    count,
                    &transitions,
                    p1,
                    before,
                    after,
                    &mut along,
                    &mut detours,
                    &mut sums,
                );
                states.swap(0, 1);

                let mut now = Vec::new();
                let mut along_before: Option<Vec<i32>> = None;
                for x in 0..columns {
                    let c = &cost[x * count..][..count];
                    let at = |path: usize, x: Option<usize>| {
                        x.and_then(|x| expected_before.get(x)).map(|s| &s[path][..])
                    };
                    let p2 = |path: usize| i32::from(transitions.p2[path][x]);
                    let rise = |path: usize| i32::from(transitions.rise[path][x]);
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
                        if y % 2 == 0 {
                            assert_eq!(i32::from(detours[at]), four, "x {x} y {y} d {d}");
                        } else {
                            let total = 8 * cost + four + 3;
                            assert_eq!(i32::from(sums[at]), total, "x {x} y {y} d {d}");
                        }
                    }
                    now.push(three);
                    along_before = Some(fourth);
                }
                expected_before = now;
            }
        }
    }
}
