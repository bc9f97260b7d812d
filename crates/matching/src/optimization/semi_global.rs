//! Semi-global matching over eight paths (Hirschmüller, PAMI 2008).
//!
//! Every path adds to a pixel's cost the cheapest way to get there from the border of the image:
//! a change of one disparity costs `P1`, a larger one `P2`, and `P2` falls where the grey value
//! changes by more than noise and texture do, since that is where depth may jump (Banz et al., ICCV Workshops
//! 2011). The sum of the eight replaces the cost: `S(p, d) = L_1(p, d) + .. + L_8(p, d)`, which is eight times the
//! cost and the eight *detours* `L_r - C`, what the way from the border adds to it.
//!
//! Four paths come from above and the left, four from below and the right, so two sweeps do all.
//! They begin at opposite ends at the same time: until they meet in the middle each leaves what its
//! four paths add to the costs, afterwards each takes up what the other left and hands the finished
//! sums on. Two threads share the work evenly, nothing is stored twice, and the result cannot depend
//! on their pace. What there is no memory for is made again ([`crate::optimization::bands`]).

use std::ops::Range;

use raster::View;

use crate::kernels::aligned::Aligned;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::path::{self, Detours, Row, RowStates, RowTransitions, padded, paths_of_row};
use crate::optimization::bands::{Bands, Checkpoints, Volume};
use crate::optimization::surface_prior::SurfacePrior;
use crate::profile::Work;

/// Costs of a row of pixels, one byte each, made anew whenever they are needed.
pub trait CostRows: Sync {
    /// Operations on bytes per cost.
    const OPERATIONS: usize;
    /// Pixels per row.
    fn columns(&self) -> usize;
    /// Rows.
    fn rows(&self) -> usize;
    /// Disparities per pixel.
    fn count(&self) -> usize;
    /// Bytes that all of them are made from.
    fn bytes(&self) -> usize;
    /// The costs of row `y`: per column `padded(count)` bytes, those past `count` 255.
    fn fill_row(&self, y: usize, costs: &mut [u8]);
}

/// What a change of disparity costs along a path, in units of the cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Penalties {
    /// For a change of one.
    pub p1: u8,
    /// For a larger change where the image is flat.
    pub p2: u8,
    /// The least that a larger change ever costs.
    pub p2_least: u8,
    /// How fast the large penalty falls with the grey step beyond what is ignored, in 1/64:
    /// `P2 = max(p2_least, p2 - fall max(|dI| - ignored, 0) / 64)`.
    pub fall: u8,
    /// Grey steps up to this say nothing.
    pub ignored: u8,
}

impl Penalties {
    /// The large penalty between two pixels of these grey values.
    #[inline(always)]
    fn p2_between(&self, here: u8, there: u8) -> u8 {
        let step = u16::from((here.max(there) - here.min(there)).saturating_sub(self.ignored));
        let p2 = (u16::from(self.p2) * 64).saturating_sub(u16::from(self.fall) * step) / 64;
        p2.max(u16::from(self.p2_least)) as u8
    }
}

at_every_level! {
    /// The large penalties of a row for paths from the previous, the same and the next column of the
    /// row before and for the path along the row.
    fn penalties_of_row(
        penalties: Penalties,
        row: &[u8],
        before: &[u8],
        reverse: bool,
        p2: &mut [Vec<u8>; 4],
    ) {
        let last = row.len() - 1;
        let [previous, same, next, along] = p2.each_mut().map(|p2| &mut p2[..=last]);
        let fill = |p2: &mut [u8], here: &[u8], there: &[u8]| {
            for ((p2, &here), &there) in p2.iter_mut().zip(here).zip(there) {
                *p2 = penalties.p2_between(here, there);
            }
        };
        // Beyond the ends of the rows there are no paths; what stands there does not matter.
        fill(&mut previous[1..], &row[1..], before);
        fill(same, row, before);
        fill(next, row, &before[1..]);
        if reverse {
            fill(along, row, &row[1..]);
        } else {
            fill(&mut along[1..], &row[1..], row);
        }
    }
}

/// The memory of the optimisation, kept between frames.
#[derive(Default)]
pub struct SemiGlobal {
    /// From the first row to the last, and back.
    sweeps: [Sweep; 2],
    /// They do the work of these again, from checkpoints on.
    again: [Sweep; 2],
    trails: [Trail; 2],
}

/// What one sweep carries from row to row.
#[derive(Default)]
struct Sweep {
    /// From the last row to the first, and along rows from right to left.
    reverse: bool,
    states: RowStates,
    transitions: RowTransitions,
    costs: Aligned<u8>,
    /// Of a row that is finished.
    sums: Aligned<u16>,
}

/// What a sweep leaves in the half in which it begins, for the one that comes from the other.
#[derive(Default)]
struct Trail {
    /// The steps whose detours are there; rows are counted in steps of the sweep.
    held: Range<usize>,
    /// What four paths add to the costs ([`paths_of_row`]).
    detours: Aligned<u8>,
    checkpoints: Checkpoints,
}

/// What both sweeps look at.
struct Shared<'a, C> {
    level: Level,
    costs: &'a C,
    guide: View<'a, u8>,
    prior: Option<&'a SurfacePrior>,
    penalties: Penalties,
    bands: Bands,
}

impl<C: CostRows> Shared<'_, C> {
    /// The row at a step of a sweep.
    fn row(&self, step: usize, reverse: bool) -> usize {
        if reverse { self.costs.rows() - 1 - step } else { step }
    }

    /// Costs in a row.
    fn pitch(&self) -> usize {
        self.costs.columns() * padded(self.costs.count())
    }
}

impl Sweep {
    /// The memory of a sweep, without the finished row.
    fn bytes(&Volume { columns, lanes, .. }: &Volume) -> usize {
        // Penalties, rises and costs of a row.
        RowStates::bytes(columns, lanes) + 8 * columns + columns * lanes
    }

    /// The memory of a row that is finished.
    fn finished_bytes(&Volume { columns, lanes, .. }: &Volume) -> usize {
        size_of::<u16>() * columns * lanes
    }

    fn reset(&mut self, reverse: bool, columns: usize, count: usize) {
        self.reverse = reverse;
        self.states.reset(columns, count);
        let RowTransitions { p2, rise } = &mut self.transitions;
        p2.iter_mut().for_each(|p2| p2.resize(columns, 0));
        for rise in rise {
            rise.clear();
            rise.resize(columns, 0);
        }
        self.costs.resize(columns * count, 0);
    }

    /// Goes on to row `y`, and leaves the detours of its paths. If it is the `last` to come there, it
    /// finds those of the others, and finishes the sums.
    fn advance(
        &mut self,
        shared: &Shared<'_, impl CostRows>,
        y: usize,
        last: bool,
        detours: &mut [u8],
    ) {
        let reverse = self.reverse;
        let before =
            if reverse { (y + 1).min(shared.guide.rows() - 1) } else { y.saturating_sub(1) };
        let [row, row_before] = [y, before].map(|y| shared.guide.row(y));
        let p2 = &mut self.transitions.p2;
        penalties_of_row(shared.level, shared.penalties, row, row_before, reverse, p2);
        // Paths begin in a sweep's first row.
        let prior = shared.prior.filter(|_| before != y);
        if let Some(prior) = prior {
            prior.rises(shared.level, y, reverse, &mut self.transitions.rise);
        }
        shared.costs.fill_row(y, &mut self.costs);
        let detours = if last {
            Detours::Meet { opposite: detours, sums: &mut self.sums }
        } else {
            Detours::Leave(detours)
        };
        let row = Row {
            costs: &self.costs,
            count: padded(shared.costs.count()),
            transitions: &self.transitions,
            rising: prior.is_some(),
            p1: shared.penalties.p1,
            reverse,
        };
        paths_of_row(shared.level, &row, &mut self.states, detours);
    }
}

impl Trail {
    /// Leads `sweep` along `steps`, and holds the detours of the last of them.
    fn follow(
        &mut self,
        sweep: &mut Sweep,
        shared: &Shared<'_, impl CostRows>,
        steps: Range<usize>,
    ) {
        let Range { mut start, end } = steps;
        let pitch = shared.pitch();
        while let Some(spacing) = shared.bands.next(end - start) {
            self.checkpoints.push(start, &sweep.states);
            for step in start..start + spacing {
                // Not wanted yet: the next row replaces them.
                let detours = &mut self.detours[..pitch];
                sweep.advance(shared, shared.row(step, sweep.reverse), false, detours);
            }
            start += spacing;
        }
        self.held = start..end;
        for (step, detours) in self.held.clone().zip(self.detours.chunks_exact_mut(pitch)) {
            sweep.advance(shared, shared.row(step, sweep.reverse), false, detours);
        }
    }

    /// Leads the sweep `other` over this half, which it enters from the other one, and hands on what
    /// is finished. Detours that are not held are made by `again`.
    fn meet(
        &mut self,
        other: &mut Sweep,
        again: &mut Sweep,
        shared: &Shared<'_, impl CostRows>,
        mut finish: impl FnMut(usize, &[u16]),
    ) {
        loop {
            let rows = self.held.clone().zip(self.detours.chunks_exact_mut(shared.pitch()));
            for (step, detours) in rows.rev() {
                let y = shared.row(step, !other.reverse);
                other.advance(shared, y, true, detours);
                finish(y, &other.sums);
            }
            let Some(checkpoint) = self.checkpoints.pop(&mut again.states) else { return };
            self.follow(again, shared, checkpoint..self.held.start);
        }
    }
}

impl<C: CostRows> Shared<'_, C> {
    /// What the sweeps amount to: for each row that one of them does, that of the costs, the guide and
    /// the prior is read, and costs and paths are computed; detours are written by one sweep and read
    /// by the other, which writes the sums and hands them on.
    fn work(&self) -> Work {
        let (columns, rows) = (self.costs.columns(), self.costs.rows());
        let upper = SemiGlobal::middle(rows);
        let swept =
            rows + [upper, rows - upper].map(|half| self.bands.swept(half)).iter().sum::<usize>();
        let read = self.costs.bytes() / rows
            + columns
            + self.prior.map_or(0, |prior| prior.bytes() / rows);
        let pairs = columns * self.costs.count();
        let row = Work::bytes(read) + Work::operations(C::OPERATIONS + path::OPERATIONS) * pairs;
        let met = Work::bytes(2 * (size_of::<u8>() + size_of::<u16>())) * self.pitch()
            + Work::operations(path::LAST_OPERATIONS) * pairs;
        row * swept + met * rows
    }
}

impl SemiGlobal {
    /// The most memory that it takes for a volume.
    pub fn bytes(volume: &Volume, bands: Bands) -> usize {
        bands.bytes(volume) + 4 * Sweep::bytes(volume) + 2 * Sweep::finished_bytes(volume)
    }

    /// The first row of the lower of the two halves that are finished side by side.
    pub fn middle(rows: usize) -> usize {
        rows / 2
    }

    /// Optimises the costs along eight paths. `finish_upper(y, sums)` gets the rows above the middle
    /// from the last to the first, `finish_lower` those from the middle on, with `padded(count)` sums
    /// per column.
    ///
    /// `guide` is the grey image whose steps lower the large penalty. With a `prior` the paths follow
    /// its surfaces. The sums do not depend on `bands`.
    pub fn run<F: FnMut(usize, &[u16]) + Send>(
        &mut self,
        level: Level,
        costs: &impl CostRows,
        guide: View<'_, u8>,
        prior: Option<&SurfacePrior>,
        penalties: &Penalties,
        bands: Bands,
        [finish_upper, finish_lower]: [F; 2],
    ) -> Work {
        let (columns, rows, lanes) = (costs.columns(), costs.rows(), padded(costs.count()));
        assert_eq!(
            (guide.columns(), guide.rows()),
            (columns, rows),
            "the guide has the size of the costs"
        );
        let shared = Shared { level, costs, guide, prior, penalties: *penalties, bands };
        let halves = [Self::middle(rows), rows - Self::middle(rows)];
        for (i, half) in halves.into_iter().enumerate() {
            let reverse = i == 1;
            self.sweeps[i].reset(reverse, columns, lanes);
            self.sweeps[i].sums.resize(shared.pitch(), 0);
            let checkpoints = bands.checkpoints(half);
            if checkpoints > 0 {
                self.again[i].reset(reverse, columns, lanes);
            }
            self.trails[i].checkpoints.reset(checkpoints, columns, lanes);
            self.trails[i].detours.resize(shared.pitch() * bands.height().min(half), 0);
        }
        let Self { sweeps: [down, up], again: [down_again, up_again], trails: [upper, lower] } =
            self;
        rayon::join(
            || upper.follow(down, &shared, 0..halves[0]),
            || lower.follow(up, &shared, 0..halves[1]),
        );
        rayon::join(
            || lower.meet(down, up_again, &shared, finish_lower),
            || upper.meet(up, down_again, &shared, finish_upper),
        );
        shared.work()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::Plane;

    struct Given {
        columns: usize,
        count: usize,
        costs: Vec<u8>,
    }

    impl CostRows for Given {
        const OPERATIONS: usize = 0;

        fn columns(&self) -> usize {
            self.columns
        }
        fn rows(&self) -> usize {
            self.costs.len() / self.columns / self.count
        }
        fn count(&self) -> usize {
            self.count
        }
        fn bytes(&self) -> usize {
            self.costs.len()
        }
        fn fill_row(&self, y: usize, costs: &mut [u8]) {
            let stride = padded(self.count);
            costs.fill(255);
            for x in 0..self.columns {
                let from = &self.costs[(y * self.columns + x) * self.count..][..self.count];
                costs[x * stride..][..self.count].copy_from_slice(from);
            }
        }
    }

    /// The eight paths one by one over the whole image, as the paper writes them; what four add to the
    /// costs counts at most 255.
    fn definition(given: &Given, guide: &Plane<u8>, penalties: &Penalties) -> Vec<u16> {
        let (w, h, n) = (given.columns as isize, given.rows() as isize, given.count);
        let mut detours = [(); 2].map(|()| vec![0u16; given.costs.len()]);
        let directions =
            [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1isize)];
        for (i, (dx, dy)) in directions.into_iter().enumerate() {
            let detours = &mut detours[i / 4];
            let mut states = vec![0u16; given.costs.len()];
            let ys: Vec<isize> = if dy < 0 { (0..h).rev().collect() } else { (0..h).collect() };
            let xs: Vec<isize> = if dx < 0 { (0..w).rev().collect() } else { (0..w).collect() };
            for &y in &ys {
                for &x in &xs {
                    let here = (y * w + x) as usize * n;
                    let (qx, qy) = (x - dx, y - dy);
                    let inside = (0..w).contains(&qx) && (0..h).contains(&qy);
                    for d in 0..n {
                        let mut l = u16::from(given.costs[here + d]);
                        if inside {
                            let q = &states[(qy * w + qx) as usize * n..][..n];
                            let grey = |x: isize, y: isize| guide.row(y as usize)[x as usize];
                            let step = f32::from(grey(x, y).abs_diff(grey(qx, qy)));
                            let step = (step - f32::from(penalties.ignored)).max(0.0);
                            let fall = f32::from(penalties.fall) / 64.0;
                            let p2 = f32::from(penalties.p2) - fall * step;
                            let p2 = p2.max(f32::from(penalties.p2_least)) as u8;
                            let least = *q.iter().min().unwrap();
                            let mut best = q[d].min(least + u16::from(p2));
                            if d > 0 {
                                best = best.min(q[d - 1] + u16::from(penalties.p1));
                            }
                            if d + 1 < n {
                                best = best.min(q[d + 1] + u16::from(penalties.p1));
                            }
                            l += best - least;
                        }
                        states[here + d] = l;
                        detours[here + d] += l - u16::from(given.costs[here + d]);
                    }
                }
            }
        }
        let [down, up] = detours;
        let sum = |((&c, d), u): ((&u8, u16), u16)| 8 * u16::from(c) + d.min(255) + u.min(255);
        given.costs.iter().zip(down).zip(up).map(sum).collect()
    }

    /// Random costs and a guide.
    fn given(columns: usize, rows: usize, count: usize) -> (Given, Plane<u8>) {
        let mut state = 9u64;
        let mut random = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            ((state >> 33) % n) as u8
        };
        let costs = (0..columns * rows * count).map(|_| random(70)).collect();
        let guide = Plane::from_fn(columns, rows, |_, _| random(256));
        (Given { columns, count, costs }, guide)
    }

    const PENALTIES: Penalties = Penalties { p1: 9, p2: 90, p2_least: 20, fall: 45, ignored: 3 };

    /// All sums, row by row.
    fn run(
        memory: &mut SemiGlobal,
        level: Level,
        (given, guide): &(Given, Plane<u8>),
        prior: Option<&SurfacePrior>,
        bands: Bands,
    ) -> Vec<Vec<u16>> {
        let mut found = vec![Vec::new(); given.rows()];
        let middle = SemiGlobal::middle(given.rows());
        let (upper, lower) = found.split_at_mut(middle);
        let finish = [(upper, 0), (lower, middle)]
            .map(|(rows, first)| move |y: usize, sums: &[u16]| rows[y - first] = sums.to_vec());
        memory.run(level, given, guide.view(), prior, &PENALTIES, bands, finish);
        found
    }

    #[test]
    fn two_sweeps_are_eight_paths_at_every_level_and_number_of_threads() {
        let (columns, rows, count) = (11, 9, 37);
        let input = given(columns, rows, count);
        let expected = definition(&input.0, &input.1, &PENALTIES);
        let stride = padded(count);
        for level in Level::available() {
            for threads in [1, 2, 3] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let whole = Bands::new(rows, rows);
                let found =
                    pool.install(|| run(&mut SemiGlobal::default(), level, &input, None, whole));
                for (y, row) in found.iter().enumerate() {
                    for x in 0..columns {
                        let expected = &expected[(y * columns + x) * count..][..count];
                        assert_eq!(&row[x * stride..][..count], expected, "{level:?} at {x} {y}");
                    }
                }
            }
        }
    }

    #[test]
    fn work_counted_by_hand() {
        let input = given(4, 3, 5);
        let costs = &input.0;
        let bands = Bands::new(3, 3);
        let guide = input.1.view();
        let (level, penalties) = (Level::detect(), PENALTIES);
        let shared = Shared { level, costs, guide, prior: None, penalties, bands };
        // Either sweep does three rows: 20 bytes of costs and 4 of the guide, 31 operations for each
        // of 20 costs. 4 x 32 detours, then sums, are written and read; 20 sums are three operations.
        let [bytes, operations] = [6 * 24 + 3 * 2 * (1 + 2) * 4 * 32, 6 * 31 * 20 + 3 * 6 * 20];
        assert_eq!(shared.work(), Work::bytes(bytes) + Work::operations(operations));
    }

    #[test]
    fn bands_of_every_height_give_the_sums_of_the_whole_volume() {
        // A tall one, and one with a row in only one half.
        for (columns, rows) in [(7, 41), (4, 1)] {
            let input = given(columns, rows, 33);
            let slanted =
                Plane::from_fn(columns, rows, |x, y| (7 + y) as f32 / 3.0 + 0.2 * x as f32);
            let mut prior = SurfacePrior::default();
            prior.fit(Level::detect(), &slanted, &slanted);
            for level in Level::available() {
                for prior in [None, Some(&prior)] {
                    let whole = Bands::new(rows, rows);
                    // What a frame leaves behind does not show in the next.
                    let mut memory = SemiGlobal::default();
                    let expected = run(&mut memory, level, &input, prior, whole);
                    for stretch in 1..=rows.div_ceil(2) {
                        for height in [1, 2, 3, 5, 8].into_iter().filter(|&h| h <= stretch) {
                            let bands = Bands::new(stretch, height);
                            let pool = rayon::ThreadPoolBuilder::new().num_threads(1 + height % 3);
                            let pool = pool.build().unwrap();
                            let found =
                                pool.install(|| run(&mut memory, level, &input, prior, bands));
                            assert!(found == expected, "{level:?}, {bands:?}, {rows} rows");
                        }
                    }
                }
            }
        }
    }
}
