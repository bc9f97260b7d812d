//! Speckles: small islands of disparity that stand alone are seldom real.
//!
//! Pixels whose disparities differ by at most a step from a neighbour's (above, below, left, right)
//! belong together; groups that weigh little are not believed (Hirschmueller 2008, section 2.5, counts
//! their pixels).
//!
//! Rows are cut into runs of pixels that belong together, and runs are joined to groups by
//! union-find (He et al., *A Run-Based Two-Scan Labeling Algorithm*, 2008). What decides is kept as
//! one bit per pixel, so 64 pixels are looked at together, and a run is joined to one of the row
//! above only where the two begin to touch. Bands of rows are grouped on their own, then along
//! their borders; weights do not depend on the order of joining.
//!
//! In: disparities in fixed point with [`HOLE`]s. Out: the runs of each row and the weight of the
//! group that a run belongs to.

use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, u16x32};
use rayon::prelude::*;

use crate::kernels::level::{Level, with_vectors};
use crate::profile::Work;
use crate::selection::fixed_point::HOLE;

/// Neighbours that differ by at most so many pixels are of one group, whatever its ends differ by.
pub(crate) const STEP: f32 = 1.0;
/// Pixels whose bits share a word.
const WORD: usize = 64;
/// Pixels that share a vector.
const HALF: usize = WORD / 2;
/// Words that are made together.
const TOGETHER: usize = 16;
/// Marks a node as the root of its group; the other bits are then the group's weight, not its parent.
const ROOT: u32 = 1 << 31;

/// The most that a group weighs.
const HEAVIEST: u32 = ROOT - 1;

/// Most pixels that can be grouped: their places need a bit less than a node has.
pub(crate) const LARGEST: usize = ROOT as usize - 1;

/// The groups of a disparity map, with their memory.
#[derive(Debug, Default)]
pub(crate) struct Groups {
    columns: usize,
    /// Per row, one bit per pixel: it belongs to its left neighbour.
    joined: Vec<u64>,
    /// Per row, one bit per pixel: a run begins.
    starts: Vec<u64>,
    /// Per run, at the place of its first pixel: its parent, or [`ROOT`] and its group's weight.
    nodes: Vec<u32>,
}

/// Some rows of the groups: nodes and bits from row `first` on.
struct Rows<'a> {
    columns: usize,
    first: usize,
    joined: &'a mut [u64],
    starts: &'a mut [u64],
    nodes: &'a mut [u32],
}

impl Groups {
    /// The memory for a map of this size.
    pub fn bytes(columns: usize, rows: usize) -> usize {
        rows * (2 * size_of::<u64>() * columns.div_ceil(WORD) + size_of::<u32>() * columns)
    }

    /// Groups the pixels of a map of `columns` columns, in bands of `height` rows. A group weighs what its runs do,
    /// of which `weight` is told the places in the map, or [`HEAVIEST`] if that is less. Disparities are
    /// read, bits written; each pixel is compared with a hole, and its difference from the one to the
    /// left and the one above with the step: nine operations of 16 bits, with three for a difference.
    pub fn find(
        &mut self,
        level: Level,
        disparities: &[u16],
        columns: usize,
        step: u16,
        height: usize,
        weight: impl Fn(Range<usize>) -> u32 + Sync,
    ) -> Work {
        let rows = disparities.len() / columns;
        let words = columns.div_ceil(WORD);
        assert!(disparities.len() <= LARGEST, "{} pixels are too many", disparities.len());
        self.columns = columns;
        self.joined.resize(rows * words, 0);
        self.starts.resize(rows * words, 0);
        self.nodes.resize(rows * columns, 0);
        let bands = self
            .joined
            .par_chunks_mut(height * words)
            .zip(self.starts.par_chunks_mut(height * words))
            .zip(self.nodes.par_chunks_mut(height * columns))
            .zip(disparities.par_chunks(height * columns));
        bands.enumerate().for_each(|(i, (((joined, starts), nodes), disparities))| {
            let mut rows = Rows { columns, first: i * height, joined, starts, nodes };
            for (y, row) in disparities.chunks_exact(columns).enumerate() {
                rows.cut(level, y, row, step, &weight);
                if y > 0 {
                    rows.join(level, y, &disparities[(y - 1) * columns..][..2 * columns], step);
                }
            }
        });
        let (joined, starts, nodes) = (&mut self.joined, &mut self.starts, &mut self.nodes);
        let mut whole = Rows { columns, first: 0, joined, starts, nodes };
        for y in (height..rows).step_by(height) {
            whole.join(level, y, &disparities[(y - 1) * columns..][..2 * columns], step);
        }
        let pixel = Work::bytes(2) + Work::operations((1 + 2 * (3 + 1)) * 2);
        pixel * disparities.len() + self.looked_at()
    }

    /// What it amounts to that all bits are written, or that all runs are looked at.
    pub fn looked_at(&self) -> Work {
        Work::bytes(size_of_val(&self.joined[..]) + size_of_val(&self.starts[..]))
    }

    /// The runs of row `y` from left to right, each with the weight of its group.
    pub fn runs(&self, y: usize) -> impl Iterator<Item = (Range<usize>, u32)> + '_ {
        let words = self.columns.div_ceil(WORD);
        let bits = y * words..(y + 1) * words;
        let (joined, starts) = (&self.joined[bits.clone()], &self.starts[bits]);
        runs(joined, starts, self.columns)
            .map(move |run| (run.clone(), self.weight(y * self.columns + run.start)))
    }

    fn weight(&self, mut at: usize) -> u32 {
        while self.nodes[at] & ROOT == 0 {
            at = self.nodes[at] as usize;
        }
        self.nodes[at] & !ROOT
    }
}

impl Rows<'_> {
    fn bits(&self, y: usize) -> Range<usize> {
        let words = self.columns.div_ceil(WORD);
        y * words..(y + 1) * words
    }

    /// Cuts row `y` (of these) into runs, each a group of its own.
    fn cut(
        &mut self,
        level: Level,
        y: usize,
        row: &[u16],
        step: u16,
        weight: impl Fn(Range<usize>) -> u32,
    ) {
        let bits = self.bits(y);
        let (joined, starts) = (&mut self.joined[bits.clone()], &mut self.starts[bits]);
        mark_runs(level, row, step, joined, starts);
        let nodes = &mut self.nodes[y * self.columns..][..self.columns];
        let place = (self.first + y) * self.columns;
        for run in runs(joined, starts, self.columns) {
            nodes[run.start] = ROOT | weight(place + run.start..place + run.end).min(HEAVIEST);
        }
    }

    /// Joins the runs of row `y` to those of the row above; `pair` holds both rows.
    fn join(&mut self, level: Level, y: usize, pair: &[u16], step: u16) {
        let (above, here) = pair.split_at(self.columns);
        let (bits_above, bits) = (self.bits(y - 1), self.bits(y));
        let (mut words, mut carry) = ([0; TOGETHER], 0);
        for w in 0..bits.len() {
            if w % TOGETHER == 0 {
                mark_touching(level, &above[w * WORD..], &here[w * WORD..], step, &mut words);
            }
            let touching = words[w % TOGETHER];
            // Where both rows go on and touched one pixel before, they are joined already.
            let going_on = self.joined[bits_above.start + w] & self.joined[bits.start + w];
            let mut new = touching & !((touching << 1 | carry) & going_on);
            carry = touching >> (WORD - 1);
            while new != 0 {
                let x = w * WORD + new.trailing_zeros() as usize;
                new &= new - 1;
                let run = |bits: &Range<usize>, y: usize| {
                    (self.first + y) * self.columns + start_of(&self.starts[bits.clone()], x)
                };
                let (a, b) = (run(&bits_above, y - 1), run(&bits, y));
                self.unite(a, b);
            }
        }
    }

    /// Makes one group of two; the root that comes first becomes the root of both.
    fn unite(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        if a != b {
            let offset = self.first * self.columns;
            let (root, other) = (a.min(b), a.max(b));
            let both = (self.nodes[root - offset] & !ROOT) + (self.nodes[other - offset] & !ROOT);
            self.nodes[root - offset] = ROOT | both.min(HEAVIEST);
            self.nodes[other - offset] = root as u32;
        }
    }

    /// The root of a node's group. Nodes on the way skip every other one from now on.
    fn root(&mut self, mut at: usize) -> usize {
        let offset = self.first * self.columns;
        loop {
            let parent = self.nodes[at - offset];
            if parent & ROOT != 0 {
                return at;
            }
            let next = self.nodes[parent as usize - offset];
            if next & ROOT != 0 {
                return parent as usize;
            }
            self.nodes[at - offset] = next;
            at = next as usize;
        }
    }
}

/// The runs that the bits of a row tell.
fn runs<'a>(
    joined: &'a [u64],
    starts: &'a [u64],
    columns: usize,
) -> impl Iterator<Item = Range<usize>> + 'a {
    let mut word = 0;
    let mut rest = starts.first().copied().unwrap_or(0);
    std::iter::from_fn(move || {
        while rest == 0 {
            word += 1;
            rest = *starts.get(word)?;
        }
        let start = word * WORD + rest.trailing_zeros() as usize;
        rest &= rest - 1;
        Some(start..end_of(joined, start).min(columns))
    })
}

/// The first place after `start` that is not joined to the one before it.
fn end_of(joined: &[u64], start: usize) -> usize {
    let next = start + 1;
    let mut word = next / WORD;
    let Some(&first) = joined.get(word) else { return next };
    let mut free = !first >> (next % WORD) << (next % WORD);
    while free == 0 {
        word += 1;
        free = joined.get(word).map_or(1, |&bits| !bits);
    }
    word * WORD + free.trailing_zeros() as usize
}

/// The last place up to `x` where a run begins.
fn start_of(starts: &[u64], x: usize) -> usize {
    let mut word = x / WORD;
    let mut upto = starts[word] << (WORD - 1 - x % WORD) >> (WORD - 1 - x % WORD);
    while upto == 0 {
        word -= 1;
        upto = starts[word];
    }
    word * WORD + upto.ilog2() as usize
}

/// Sets the bits of one row: pixels that belong to their left neighbour, and the first pixels of runs.
fn mark_runs(level: Level, row: &[u16], step: u16, joined: &mut [u64], starts: &mut [u64]) {
    with_vectors!(level, simd => runs_of_row(simd, row, step, joined, starts));
}

/// Sets the bits of pixels that belong to the pixel above.
fn mark_touching(level: Level, above: &[u16], here: &[u16], step: u16, touching: &mut [u64]) {
    with_vectors!(level, simd => touching_of_row(simd, above, here, step, touching));
}

#[inline(always)]
fn runs_of_row<S: Simd>(simd: S, row: &[u16], step: u16, joined: &mut [u64], starts: &mut [u64]) {
    // Of the next pixel and the one before it: one bit further left.
    let pairs = row[..row.len() - 1].chunks(WORD).zip(row[1..].chunks(WORD));
    let pairs = pairs.map(|(left, here)| alike(simd, left, here, step));
    let mut carry = 0;
    let words = row.chunks(WORD).zip(pairs.chain([0]));
    for ((here, same), (joined, starts)) in words.zip(joined.iter_mut().zip(starts)) {
        *joined = same << 1 | carry;
        carry = same >> (WORD - 1);
        // What is no hole is like itself.
        *starts = alike(simd, here, here, 0) & !*joined;
    }
}

#[inline(always)]
fn touching_of_row<S: Simd>(simd: S, above: &[u16], here: &[u16], step: u16, touching: &mut [u64]) {
    let words = above.chunks(WORD).zip(here.chunks(WORD));
    for (touching, (above, here)) in touching.iter_mut().zip(words) {
        *touching = alike(simd, above, here, step);
    }
}

/// One bit for each of up to 64 pixels: it is no hole, and differs from another one by at most a step.
#[inline(always)]
fn alike<S: Simd>(simd: S, others: &[u16], here: &[u16], step: u16) -> u64 {
    match (others.as_chunks().0, here.as_chunks().0) {
        ([others], [here]) => bits_of(simd, others, here, step),
        _ => {
            let mut ends = [[HOLE; WORD]; 2];
            ends[0][..others.len()].copy_from_slice(others);
            ends[1][..here.len()].copy_from_slice(here);
            bits_of(simd, &ends[0], &ends[1], step)
        }
    }
}

#[inline(always)]
fn bits_of<S: Simd>(simd: S, others: &[u16; WORD], here: &[u16; WORD], step: u16) -> u64 {
    let ([first, second], []) = others.as_chunks() else { unreachable!("a word has two halves") };
    let ([here, then], []) = here.as_chunks() else { unreachable!("a word has two halves") };
    half_of_bits(simd, first, here, step) | half_of_bits(simd, second, then, step) << HALF
}

#[inline(always)]
fn half_of_bits<S: Simd>(simd: S, others: &[u16; HALF], here: &[u16; HALF], step: u16) -> u64 {
    let (others, here) = (u16x32::from_slice(simd, others), u16x32::from_slice(simd, here));
    let near = (others.max(here) - others.min(here)).simd_le(u16x32::splat(simd, step));
    (near & here.simd_lt(u16x32::splat(simd, HOLE))).to_bitmask()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    /// What the pixel at a place of the map weighs.
    fn weight(place: usize) -> u32 {
        (3 * place) as u32 % 7
    }

    /// Group weights by flooding from every pixel; 0 in holes.
    fn weights_by_flooding(map: &[u16], columns: usize, step: u16) -> Vec<u32> {
        let mut weights = vec![0; map.len()];
        let mut seen = vec![false; map.len()];
        for seed in 0..map.len() {
            if map[seed] == HOLE || seen[seed] {
                continue;
            }
            let (mut group, mut next) = (vec![seed], 0);
            while let Some(&at) = group.get(next) {
                next += 1;
                let x = at % columns;
                let near = [
                    (x > 0).then(|| at - 1),
                    (x + 1 < columns).then_some(at + 1),
                    at.checked_sub(columns),
                    (at + columns < map.len()).then_some(at + columns),
                ];
                for to in near.into_iter().flatten() {
                    let belongs = map[to] != HOLE && map[to].abs_diff(map[at]) <= step;
                    if belongs && !group.contains(&to) {
                        group.push(to);
                    }
                }
            }
            let of_group = group.iter().map(|&at| weight(at)).sum();
            for &at in &group {
                (weights[at], seen[at]) = (of_group, true);
            }
        }
        weights
    }

    #[test]
    fn groups_are_what_flooding_finds_in_bands_of_any_height_at_every_level() {
        for level in Level::available() {
            eprintln!("level {}", level.name());
            for (columns, rows) in [(1, 1), (1, 30), (64, 9), (65, 9), (131, 14), (200, 6)] {
                for holes in [1u16, 3, 9] {
                    let mut chance = Chance((columns * rows) as u32 + u32::from(holes));
                    let map: Vec<u16> = (0..columns * rows)
                        .map(|_| {
                            let value = chance.bits(8) as u16;
                            if value % 10 < holes { HOLE } else { 100 * (value / 64) + value % 32 }
                        })
                        .collect();
                    let expected = weights_by_flooding(&map, columns, 20);
                    for height in [1, 2, 5, rows] {
                        let mut groups = Groups::default();
                        let by_place = |run: Range<usize>| run.map(weight).sum();
                        groups.find(level, &map, columns, 20, height, by_place);
                        let mut found = vec![0; map.len()];
                        for y in 0..rows {
                            for (run, weight) in groups.runs(y) {
                                found[y * columns..][run].fill(weight);
                            }
                        }
                        assert_eq!(found, expected, "{columns} x {rows}, bands of {height}");
                    }
                }
            }
        }
    }

    #[test]
    fn bits_are_their_definition_at_every_level() {
        let mut chance = Chance(3);
        for columns in [1usize, 31, 64, 65, 130] {
            let mut row = || -> Vec<u16> {
                let value = |bits: u16| if bits.is_multiple_of(5) { HOLE } else { 60_000 + bits };
                (0..columns).map(|_| value(chance.bits(6) as u16)).collect()
            };
            let (above, here, step) = (row(), row(), 9);
            let belongs = |x: usize, other: u16| here[x] != HOLE && other.abs_diff(here[x]) <= step;
            let words = |is: &dyn Fn(usize) -> bool| -> Vec<u64> {
                let mut words = vec![0; columns.div_ceil(WORD)];
                (0..columns).filter(|&x| is(x)).for_each(|x| words[x / WORD] |= 1 << (x % WORD));
                words
            };
            let left = |x: usize| x > 0 && belongs(x, here[x - 1]);
            let (joined, starts) = (words(&left), words(&|x| here[x] != HOLE && !left(x)));
            let touching = words(&|x| belongs(x, above[x]));
            for level in Level::available() {
                eprintln!("level {}", level.name());
                let mut found = [(); 3].map(|()| vec![0; touching.len()]);
                let [of_left, of_starts, of_above] = &mut found;
                mark_runs(level, &here, step, of_left, of_starts);
                mark_touching(level, &above, &here, step, of_above);
                assert_eq!(found, [&joined, &starts, &touching].map(Vec::clone), "{columns}");
            }
        }
    }

    #[test]
    fn a_slope_is_one_group_and_an_island_another() {
        let mut map: Vec<u16> = (0..12).map(|i| (i % 6) * 10).collect();
        map[3] = 400;
        let mut groups = Groups::default();
        let by_pixels = |run: Range<usize>| run.len() as u32;
        groups.find(Level::detect(), &map, 6, 10, 2, by_pixels);
        assert_eq!(groups.runs(0).collect::<Vec<_>>(), [(0..3, 11), (3..4, 1), (4..6, 11)]);
        assert_eq!(groups.runs(1).collect::<Vec<_>>(), [(0..6, 11)]);
        // What is too heavy to be counted stays the heaviest.
        groups.find(Level::detect(), &map, 6, 10, 1, |_| HEAVIEST - 3);
        assert_eq!(groups.runs(1).collect::<Vec<_>>(), [(0..6, HEAVIEST)]);
    }
}
