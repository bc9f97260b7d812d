//! Planes from the neighbourhood, judged by adaptive support weights.
//!
//! Semi-global matching compares windows, and a window at the edge of an object sees both sides: the
//! nearer surface grows beyond its edge. Here every pixel may take the plane of a neighbour up to
//! six pixels away if that fits the images clearly better. How well a plane `f` fits at `p` is
//!
//! ```text
//! m(p, f) = sum_q w(p, q) rho(q, q - f(q)) / sum_q w(p, q),   w(p, q) = exp(-|I_p - I_q| / 10)
//! ```
//!
//! over a window of 11 x 11 pixels `q`: pixels of another shade, most likely of another object,
//! hardly count (Yoon & Kweon, PAMI 2006), and slanted surfaces are compared as such (PatchMatch
//! Stereo, Bleyer et al., BMVC 2011, of which this is one round of propagation, started from a
//! map that is right nearly everywhere). `rho` (`cost/looks.rs`) compares small windows, since the
//! sum over `q` is the window.
//!
//! Only candidates that differ by [`CLEARLY_OTHER`] from what a pixel has are tried, so the work is
//! done along edges; once one has won, all compete. All pixels look at the map as it was before: rows
//! can be done in any order, by any number of threads.

use raster::Plane;
use rayon::prelude::*;

use crate::cost::looks::{self, BLOCK, Comparison, Looks, RowsWithEnds};
use crate::kernels::level::{Level, at_every_level};
use crate::optimization::support_window::{
    self, LANES, RADIUS, SIDE, Shades, Window, WindowRow, shades,
};
use crate::profile::Work;
use crate::refinement::plane_fit::Surface;
use crate::refinement::slopes::Slopes;

/// Candidates nearer to what is there, in pixels of disparity, are not tried.
const CLEARLY_OTHER: f32 = 2.0;
/// The same once a pixel has taken a plane: now all compete, that of its old surface included.
const OTHER: f32 = 0.25;
/// By how much a candidate must fit better than what is there.
const MARGIN: f32 = 2.0;
/// Where candidates come from.
const NEIGHBOURS: [(i32, i32); 16] = [
    (-1, 0),
    (0, -1),
    (1, 0),
    (0, 1),
    (-3, 0),
    (3, 0),
    (0, -3),
    (0, 3),
    (-6, 0),
    (6, 0),
    (0, -6),
    (0, 6),
    (-4, -4),
    (4, 4),
    (-4, 4),
    (4, -4),
];

/// Bands of rows per thread: some have more edges than others. Each has its memory.
const BANDS: usize = 2;

/// A view with its other one, and the disparities that both may have.
pub(crate) struct Pair<'a> {
    pub base: &'a Looks,
    pub other: &'a Looks,
    /// The column of the image at which the map begins.
    pub first: usize,
    pub least: i32,
    pub most: i32,
}

/// A map, and the slopes at every pixel.
struct Surfaces<'a> {
    values: &'a Plane<f32>,
    slopes: &'a Slopes,
}

impl Surfaces<'_> {
    #[inline(always)]
    fn at(&self, x: usize, y: usize) -> Surface {
        let [disparity, along, down] =
            [self.values, &self.slopes.along, &self.slopes.down].map(|p| p.row(y)[x]);
        Surface { disparity, along, down }
    }
}

/// The memory of a band of rows: the rows of one window, used in turns, and scratch.
#[derive(Default)]
struct Band {
    rows: [WindowRow; SIDE],
    rows_with_ends: RowsWithEnds,
    marks: Vec<u16>,
}

/// What was done along edges.
#[derive(Debug, Default, Clone, Copy)]
struct Tried {
    windows: usize,
    /// In all windows.
    surfaces: usize,
}

/// The memory of the method, kept between frames.
#[derive(Default)]
pub(crate) struct SupportWeights {
    bands: Vec<Band>,
}

impl SupportWeights {
    /// What it takes for maps of a size and so many disparities.
    pub fn bytes(columns: usize, rows: usize, disparities: usize) -> usize {
        let height = rows.div_ceil(BANDS * rayon::current_num_threads());
        let bands = rows.div_ceil(height);
        let compared = (columns + LANES).next_multiple_of(BLOCK);
        let window = SIDE * WindowRow::bytes(compared, disparities);
        let with_ends = 3 * (2 * compared + disparities);
        bands * (window + with_ends + 2 * columns)
    }

    /// Lets every pixel of `values` (finite) take a neighbour's plane, into `out`. Whatever the scene,
    /// values and their slopes are read, the looks of both views read and compared, and new values
    /// written.
    pub fn refine(
        &mut self,
        level: Level,
        pair: &Pair<'_>,
        values: &Plane<f32>,
        slopes: &Slopes,
        out: &mut Plane<f32>,
    ) -> Work {
        let (columns, rows) = values.size();
        let surfaces = Surfaces { values, slopes };
        let shades = shades();
        out.reset(columns, rows, 0.0);
        let height = rows.div_ceil(BANDS * rayon::current_num_threads());
        self.bands.resize_with(rows.div_ceil(height), Band::default);
        let bands = out.samples_mut().par_chunks_mut(columns * height).zip(&mut self.bands);
        let tried = bands
            .enumerate()
            .map(|(i, (out, band))| band.refine(level, pair, &shades, &surfaces, i * height, out));
        let tried = tried.reduce(Tried::default, |a, b| Tried {
            windows: a.windows + b.windows,
            surfaces: a.surfaces + b.surfaces,
        });
        let (map, looks) = (size_of_val(values.samples()), pair.base.bytes() + pair.other.bytes());
        let disparities = (pair.most - pair.least + 1) as usize;
        Work::bytes((3 + 2) * map + looks)
            + Work::operations(looks::OPERATIONS) * (disparities * columns * rows)
            + Work::operations(support_window::OPERATIONS) * tried.windows
            + Work::operations(support_window::OPERATIONS_PER_SURFACE) * tried.surfaces
    }
}

impl Band {
    /// Refines rows from `first` on.
    fn refine(
        &mut self,
        level: Level,
        pair: &Pair<'_>,
        shades: &Shades,
        surfaces: &Surfaces<'_>,
        first: usize,
        out: &mut [f32],
    ) -> Tried {
        let (columns, rows) = surfaces.values.size();
        let &Pair { base, other, least, most, .. } = pair;
        let what = Comparison {
            base,
            other,
            row: 0,
            start: pair.first as i64 - RADIUS as i64,
            columns: (columns + LANES).next_multiple_of(BLOCK),
            least,
            most,
        };
        let mut next = first.saturating_sub(RADIUS);
        let mut tried = Tried::default();
        self.marks.resize(columns, 0);
        for (y, out) in (first..).zip(out.chunks_mut(columns)) {
            while next <= (y + RADIUS).min(rows - 1) {
                let what = Comparison { row: next, ..what };
                self.rows[next % SIDE].compute(level, &what, shades, &mut self.rows_with_ends);
                next += 1;
            }
            mark_row(level, surfaces, least as f32, most as f32, y, &mut self.marks);
            let row = |j: usize| (y + j).saturating_sub(RADIUS).min(rows - 1);
            let near = std::array::from_fn(|j| &self.rows[row(j) % SIDE]);
            refine_row(level, least, most, near, surfaces, &self.marks, y, &mut tried, out);
        }
        tried
    }
}

/// The disparity at which the plane of the pixel at `(dx, dy)` passes here.
#[inline(always)]
fn continued(there: Surface, (dx, dy): (i32, i32)) -> f32 {
    there.disparity - (there.along * dx as f32 + there.down * dy as f32)
}

at_every_level! {
    /// Marks the pixels of row `y` that a neighbour's plane passes at a clearly other disparity:
    /// one bit for each neighbour.
    fn mark_row(surfaces: &Surfaces<'_>, least: f32, most: f32, y: usize, marks: &mut [u16]) {
        let (columns, rows) = surfaces.values.size();
        marks.fill(0);
        for (n, (dx, dy)) in NEIGHBOURS.into_iter().enumerate() {
            let (v, reach) = (y as i64 + i64::from(dy), dx.unsigned_abs() as usize);
            if v < 0 || v >= rows as i64 || reach >= columns {
                continue;
            }
            let count = columns - reach;
            let (here, there) = if dx < 0 { (reach, 0) } else { (0, reach) };
            let values = &surfaces.values.row(y)[here..][..count];
            let Slopes { along, down } = surfaces.slopes;
            let [disparity, along, down] = [surfaces.values, along, down]
                .map(|plane| &plane.row(v as usize)[there..][..count]);
            let marks = &mut marks[here..][..count];
            for i in 0..count {
                let there = Surface { disparity: disparity[i], along: along[i], down: down[i] };
                let d = continued(there, (dx, dy));
                let far = (d - values[i]).abs() >= CLEARLY_OTHER;
                marks[i] |= u16::from(far & (d >= least) & (d <= most)) << n;
            }
        }
    }

    /// Lets the marked pixels of row `y` take their neighbours' planes. `near` are the rows of its
    /// windows.
    fn refine_row(
        least: i32,
        most: i32,
        near: [&WindowRow; SIDE],
        surfaces: &Surfaces<'_>,
        marks: &[u16],
        y: usize,
        tried: &mut Tried,
        out: &mut [f32],
    ) {
        let (columns, rows) = surfaces.values.size();
        let inside = RADIUS.saturating_sub(y)..SIDE.min(rows + RADIUS - y);
        let range = (most - least) as f32;
        let (least, most) = (least as f32, most as f32);
        out.copy_from_slice(surfaces.values.row(y));
        for x in 0..columns {
            if marks[x] == 0 {
                continue;
            }
            let window = Window::new(&near, inside.clone(), x, range);
            let here = surfaces.at(x, y);
            let mut result = here.disparity;
            let above = |d: f32| d - least;
            let here = Surface { disparity: above(here.disparity), ..here };
            let mut limit = window.misfit(here) - MARGIN * window.total;
            let mut taken = false;
            tried.windows += 1;
            tried.surfaces += 1;
            for (n, (dx, dy)) in NEIGHBOURS.into_iter().enumerate() {
                if !taken && marks[x] >> n & 1 == 0 {
                    continue;
                }
                let (u, v) = (x as i64 + i64::from(dx), y as i64 + i64::from(dy));
                if u < 0 || v < 0 || u >= columns as i64 || v >= rows as i64 {
                    continue;
                }
                let there = surfaces.at(u as usize, v as usize);
                let d = continued(there, (dx, dy));
                if taken && ((d - result).abs() < OTHER || d < least || d > most) {
                    continue;
                }
                let misfit = window.misfit(Surface { disparity: above(d), ..there });
                tried.surfaces += 1;
                if misfit < limit {
                    (result, limit) = (d, misfit);
                    taken = true;
                }
            }
            out[x] = result;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::optimization::support_window::SHADE;

    /// A bright board at disparity 8 before a dark wall at 2, both textured.
    fn scene() -> (Plane<u8>, Plane<u8>, Plane<f32>) {
        let noise = |x: i64, y: usize| {
            let seed = ((x + 900) as u32 * 7919) ^ (y as u32 * 104_729);
            let mixed = (seed ^ (seed >> 9)).wrapping_mul(0x9E37_79B1);
            ((mixed ^ (mixed >> 15)).wrapping_mul(0x85EB_CA77) >> 16) & 31
        };
        let wall = |x: i64, y: usize| 30 + noise(x + 500, y) as u8;
        let board = |x: i64, y: usize| 180 + noise(x, y) as u8;
        let left = Plane::from_fn(60, 30, |x, y| {
            if (20..40).contains(&x) { board(x as i64, y) } else { wall(x as i64, y) }
        });
        let right = Plane::from_fn(60, 30, |x, y| {
            if (12..32).contains(&x) { board(x as i64 + 8, y) } else { wall(x as i64 + 2, y) }
        });
        let truth = Plane::from_fn(60, 30, |x, _| if (20..40).contains(&x) { 8.0 } else { 2.0 });
        (left, right, truth)
    }

    /// The same by its formulas, pixel after pixel; sums are added in halves here too.
    fn definition(
        pair: &Pair<'_>,
        costs: &dyn Fn(usize, i64, i32) -> f32,
        values: &Plane<f32>,
    ) -> Plane<f32> {
        let (columns, rows) = values.size();
        let mut slopes = Slopes::default();
        slopes.compute(Level::available()[0], values);
        let plane = |x: usize, y: usize| {
            let [along, down] = [&slopes.along, &slopes.down].map(|plane| plane.row(y)[x]);
            Surface { disparity: values.row(y)[x], along, down }
        };
        let halves = |mut numbers: Vec<f32>| {
            while numbers.len() > 1 {
                let back = numbers.split_off(numbers.len() / 2);
                numbers.iter_mut().zip(back).for_each(|(a, b)| *a += b);
            }
            numbers[0]
        };
        // The sum over the window of a pixel with and without costs.
        let sums = |x: usize, y: usize, surface: Surface| {
            let [mut weighted, mut weights] = [vec![0.0; 256], vec![0.0; 256]];
            let centre = (pair.first + x) as i64;
            let grey = |u: i64, v: usize| f32::from(pair.base.row(v)[2][u as usize]) / SHADE;
            for (j, v) in (y as i64 - 5..=y as i64 + 5).enumerate() {
                for (i, u) in (centre - 5..=centre + 5).enumerate() {
                    let width = pair.base.columns() as i64;
                    if !(0..rows as i64).contains(&v) || !(0..width).contains(&u) {
                        continue;
                    }
                    let (p, q) = (grey(centre, y), grey(u, v as usize));
                    let weight = (q.exp() * (-p).exp()).min((-q).exp() * p.exp());
                    let least = pair.least as f32;
                    let at_centre = surface.disparity - least + surface.down * (j as f32 - 5.0);
                    let d = at_centre + surface.along * (i as f32 - 5.0);
                    let d = d.clamp(0.0, pair.most as f32 - least);
                    let mut cost = 0.0;
                    for k in 0..=pair.most - pair.least {
                        let share = (1.0 - (d - k as f32).abs()).max(0.0);
                        cost += share * costs(v as usize, u, pair.least + k);
                    }
                    (weights[j * LANES + i], weighted[j * LANES + i]) = (weight, weight * cost);
                }
            }
            (halves(weighted), halves(weights))
        };
        Plane::from_fn(columns, rows, |x, y| {
            let here = plane(x, y);
            let (misfit, total) = sums(x, y, here);
            let (mut result, mut least) = (here.disparity, misfit - MARGIN * total);
            let mut different = CLEARLY_OTHER;
            for (dx, dy) in NEIGHBOURS {
                let (u, v) = (x as i32 + dx, y as i32 + dy);
                if u < 0 || v < 0 || u >= columns as i32 || v >= rows as i32 {
                    continue;
                }
                let there = plane(u as usize, v as usize);
                let d = there.disparity - (there.along * dx as f32 + there.down * dy as f32);
                let range = pair.least as f32..=pair.most as f32;
                if (d - result).abs() >= different && range.contains(&d) {
                    let (misfit, _) = sums(x, y, Surface { disparity: d, ..there });
                    if misfit < least {
                        (result, least, different) = (d, misfit, OTHER);
                    }
                }
            }
            result
        })
    }

    #[test]
    fn refined_maps_are_those_of_the_definition_at_every_level() {
        let (left, right, truth) = scene();
        let mut chance = Chance(1);
        let mut random = || chance.share();
        // Edges moved to and fro, slanted and rough; a map within the image, then all of it.
        for (first, columns, least, most) in [(7, 48, 0, 15), (0, 60, -4, 9), (3, 20, 8, 8)] {
            let values = Plane::from_fn(columns, 30, |x, y| {
                let moved = (first + x + y % 7).clamp(3, 62) - 3;
                truth.row(y)[moved] + 0.2 * random() + 0.03 * x as f32 - 0.04 * y as f32
            });
            for level in Level::available() {
                eprintln!("level {}", level.name());
                let [mut base, mut other] = [Looks::default(), Looks::default()];
                base.compute(level, left.view(), 0, 30);
                other.compute(level, right.view(), 0, 30);
                let pair = Pair { base: &base, other: &other, first, least, most };
                let cost = |y: usize, u: i64, d: i32| {
                    let a = base.row(y).map(|part| part[u as usize]);
                    let place = (u - i64::from(d)).clamp(0, 59) as usize;
                    rho(a, other.row(y).map(|part| part[place]))
                };
                let expected = definition(&pair, &cost, &values);
                let [mut out, mut again] = [Plane::default(), Plane::default()];
                let (mut weights, mut slopes) = (SupportWeights::default(), Slopes::default());
                slopes.compute(level, &values);
                weights.refine(level, &pair, &values, &slopes, &mut out);
                weights.refine(level, &pair, &values, &slopes, &mut again);
                assert!(out == expected && again == expected);
                assert!(most == least || out != values, "nothing to be seen");
            }
        }
    }

    fn rho(a: [u8; 3], b: [u8; 3]) -> f32 {
        let (step, grey) = (a[1].abs_diff(b[1]), a[2].abs_diff(b[2]));
        (5 * (a[0] ^ b[0]).count_ones() as u8 + step.min(20) + grey.min(10)).into()
    }

    #[test]
    fn a_board_that_has_grown_by_three_pixels_shrinks_to_its_edge() {
        let (left, right, truth) = scene();
        let grown = Plane::from_fn(60, 30, |x, _| if (20..43).contains(&x) { 8.0 } else { 2.0 });
        let (mut base, mut other) = (Looks::default(), Looks::default());
        base.compute(Level::detect(), left.view(), 0, 30);
        other.compute(Level::detect(), right.view(), 0, 30);
        let pair = Pair { base: &base, other: &other, first: 0, least: 0, most: 15 };
        for level in Level::available() {
            eprintln!("level {}", level.name());
            let (mut out, mut slopes) = (Plane::default(), Slopes::default());
            slopes.compute(level, &grown);
            SupportWeights::default().refine(level, &pair, &grown, &slopes, &mut out);
            for y in 0..30 {
                assert_eq!(out.row(y)[20..], truth.row(y)[20..], "row {y}");
            }
        }
    }
}
