//! Semi-global matching over eight paths (Hirschmüller, PAMI 2008).
//!
//! Every path adds to a pixel's cost the cheapest way to get there from the border of the image:
//! a change of one disparity costs `P1`, a larger one `P2`, and `P2` falls where the grey value
//! changes, since that is where depth may jump (Banz et al., ICCV Workshops 2011). The sum of the
//! eight replaces the cost.
//!
//! Four paths come from above and the left, four from below and the right, so two sweeps do all.
//! They begin at opposite ends at the same time: until they meet in the middle each writes its
//! sums, afterwards each adds to what the other left and hands the finished row on. Two threads
//! share the work evenly, nothing is stored twice, and the result cannot depend on their pace.

use raster::Plane;

use crate::kernels::level::Level;
use crate::kernels::path::{AlongState, RowStates, RowTransitions, padded, paths_of_row};
use crate::optimization::surface_prior::SurfacePrior;

/// Costs of a row of pixels, one byte each, made anew whenever they are needed.
pub trait CostRows: Sync {
    /// Pixels per row.
    fn columns(&self) -> usize;
    /// Rows.
    fn rows(&self) -> usize;
    /// Disparities per pixel.
    fn count(&self) -> usize;
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
    /// How fast the large penalty falls with the grey step: `P2 = max(p2_least, p2 - fall |dI|)`.
    pub fall: f32,
}

impl Penalties {
    /// The large penalty for each grey step.
    fn table(&self) -> [u8; 256] {
        std::array::from_fn(|step| {
            (f32::from(self.p2) - self.fall * step as f32).max(f32::from(self.p2_least)) as u8
        })
    }
}

/// The memory of the optimisation, kept between frames.
#[derive(Default)]
pub struct SemiGlobal {
    sums: Vec<u16>,
    sweeps: [Sweep; 2],
}

/// What one sweep carries from row to row.
#[derive(Default)]
struct Sweep {
    states: [RowStates; 2],
    along: AlongState,
    transitions: RowTransitions,
    costs: Vec<u8>,
}

/// What both sweeps look at.
struct Shared<'a, C> {
    level: Level,
    costs: &'a C,
    guide: &'a Plane<u8>,
    prior: Option<&'a SurfacePrior>,
    p1: u8,
    p2: [u8; 256],
}

impl Sweep {
    fn reset(&mut self, columns: usize, count: usize) {
        self.states.iter_mut().for_each(|s| s.reset(columns, count));
        self.along.reset(count);
        let RowTransitions { p2, rise } = &mut self.transitions;
        p2.iter_mut().for_each(|p2| p2.resize(columns, 0));
        for rise in rise {
            rise.clear();
            rise.resize(columns, 0);
        }
        self.costs.clear();
        self.costs.resize(columns * count, 0);
    }

    /// Looks up the large penalty of each column for a row and the row before it on the paths.
    fn look_up_penalties(&mut self, table: &[u8; 256], row: &[u8], before: &[u8], reverse: bool) {
        let last = row.len() - 1;
        let [from0, from1, from2, along] = &mut self.transitions.p2;
        for x in 0..row.len() {
            let to = |other: u8| table[usize::from(row[x].abs_diff(other))];
            from0[x] = to(before[x.saturating_sub(1)]);
            from1[x] = to(before[x]);
            from2[x] = to(before[(x + 1).min(last)]);
            along[x] = to(row[if reverse { (x + 1).min(last) } else { x.saturating_sub(1) }]);
        }
    }

    fn row<const REVERSE: bool, const ADD: bool>(
        &mut self,
        shared: &Shared<'_, impl CostRows>,
        y: usize,
        sum: &mut [u16],
    ) {
        let before =
            if REVERSE { (y + 1).min(shared.guide.rows() - 1) } else { y.saturating_sub(1) };
        self.look_up_penalties(&shared.p2, shared.guide.row(y), shared.guide.row(before), REVERSE);
        // Paths begin in a sweep's first row.
        if let Some(prior) = shared.prior.filter(|_| before != y) {
            prior.rises(y, REVERSE, &mut self.transitions.rise);
        }
        shared.costs.fill_row(y, &mut self.costs);
        let [old, new] = &mut self.states;
        paths_of_row::<REVERSE, ADD>(
            shared.level,
            &self.costs,
            padded(shared.costs.count()),
            &self.transitions,
            shared.p1,
            old,
            new,
            &mut self.along,
            sum,
        );
        self.states.swap(0, 1);
    }
}

impl SemiGlobal {
    /// Optimises the costs along eight paths and calls `finish(y, sums, rows[y])` once per row, in
    /// any order, with `padded(count)` sums per column.
    ///
    /// `guide` is the grey image whose steps lower the large penalty; `rows` takes what `finish`
    /// makes of each row. With a `prior` the paths follow its surfaces.
    pub fn run<C: CostRows, R: Send>(
        &mut self,
        level: Level,
        costs: &C,
        guide: &Plane<u8>,
        prior: Option<&SurfacePrior>,
        penalties: &Penalties,
        rows: &mut [R],
        finish: impl Fn(usize, &[u16], &mut R) + Sync,
    ) {
        let (columns, height, count) = (costs.columns(), costs.rows(), padded(costs.count()));
        assert_eq!(guide.size(), (columns, height), "the guide has the size of the costs");
        assert_eq!(rows.len(), height, "one result per row");
        let pitch = columns * count;
        self.sums.resize(pitch * height, 0);
        self.sweeps.iter_mut().for_each(|s| s.reset(columns, count));
        let (p1, p2) = (penalties.p1, penalties.table());
        let shared = Shared { level, costs, guide, prior, p1, p2 };
        let middle = height / 2;
        let (upper, lower) = self.sums.split_at_mut(pitch * middle);
        let (upper_rows, lower_rows) = rows.split_at_mut(middle);
        let [down, up] = &mut self.sweeps;

        rayon::join(
            || {
                for (y, sum) in upper.chunks_exact_mut(pitch).enumerate() {
                    down.row::<false, false>(&shared, y, sum);
                }
            },
            || {
                for (y, sum) in lower.chunks_exact_mut(pitch).enumerate().rev() {
                    up.row::<true, false>(&shared, middle + y, sum);
                }
            },
        );
        rayon::join(
            || {
                let rows = lower.chunks_exact_mut(pitch).zip(lower_rows).enumerate();
                for (y, (sum, row)) in rows {
                    down.row::<false, true>(&shared, middle + y, sum);
                    finish(middle + y, sum, row);
                }
            },
            || {
                let rows = upper.chunks_exact_mut(pitch).zip(upper_rows).enumerate().rev();
                for (y, (sum, row)) in rows {
                    up.row::<true, true>(&shared, y, sum);
                    finish(y, sum, row);
                }
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Given {
        columns: usize,
        count: usize,
        costs: Vec<u8>,
    }

    impl CostRows for Given {
        fn columns(&self) -> usize {
            self.columns
        }
        fn rows(&self) -> usize {
            self.costs.len() / self.columns / self.count
        }
        fn count(&self) -> usize {
            self.count
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

    /// The eight paths one by one over the whole image, as the paper writes them.
    fn definition(given: &Given, guide: &Plane<u8>, penalties: &Penalties) -> Vec<u16> {
        let (w, h, n) = (given.columns as isize, given.rows() as isize, given.count);
        let mut sums = vec![0u16; given.costs.len()];
        let directions =
            [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1), (1, -1), (-1, 1isize)];
        let table = penalties.table();
        for (dx, dy) in directions {
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
                            let step = guide.row(y as usize)[x as usize]
                                .abs_diff(guide.row(qy as usize)[qx as usize]);
                            let least = *q.iter().min().unwrap();
                            let mut best = q[d].min(least + u16::from(table[usize::from(step)]));
                            if d > 0 {
                                best = best.min(q[d - 1] + u16::from(penalties.p1));
                            }
                            if d + 1 < n {
                                best = best.min(q[d + 1] + u16::from(penalties.p1));
                            }
                            l += best - least;
                        }
                        states[here + d] = l;
                        sums[here + d] += l;
                    }
                }
            }
        }
        sums
    }

    #[test]
    fn two_sweeps_are_eight_paths_at_every_level_and_number_of_threads() {
        let (columns, rows, count) = (11, 9, 37);
        let mut state = 9u64;
        let mut random = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            ((state >> 33) % n) as u8
        };
        let costs = (0..columns * rows * count).map(|_| random(70)).collect();
        let given = Given { columns, count, costs };
        let guide = Plane::from_fn(columns, rows, |_, _| random(256));
        let penalties = Penalties { p1: 9, p2: 90, p2_least: 20, fall: 0.7 };
        let expected = definition(&given, &guide, &penalties);
        let stride = padded(count);
        for level in Level::available() {
            for threads in [1, 2, 3] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let mut found = vec![Vec::new(); rows];
                let mut memory = SemiGlobal::default();
                pool.install(|| {
                    memory.run(
                        level,
                        &given,
                        &guide,
                        None,
                        &penalties,
                        &mut found,
                        |_, sums, row| {
                            *row = sums.to_vec();
                        },
                    );
                });
                for (y, row) in found.iter().enumerate() {
                    for x in 0..columns {
                        let expected = &expected[(y * columns + x) * count..][..count];
                        assert_eq!(&row[x * stride..][..count], expected, "{level:?} at {x} {y}");
                    }
                }
            }
        }
    }
}
