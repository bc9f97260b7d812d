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
//! map that is right nearly everywhere). `rho` adds a 3 x 3 census, the grey steps and the grey
//! values, each truncated: small windows, since the sum over `q` is the window.
//!
//! Only candidates that differ by [`CLEARLY_OTHER`] from what a pixel has are tried, so the work is
//! done along edges; once one has won, all compete. All pixels look at the map as it was before: rows
//! can be done in any order, by any number of threads.

use raster::Plane;
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::prepare::gradient::steps_along_row;
use crate::refinement::plane_fit::Surface;

/// Half the window.
const RADIUS: usize = 5;
/// A grey step at which a pixel counts 1/e.
const SHADE: f32 = 10.0;
/// Candidates nearer to what is there, in pixels of disparity, are not tried.
const CLEARLY_OTHER: f32 = 2.0;
/// The same once a pixel has taken a plane: now all compete, that of its old surface included.
const OTHER: f32 = 0.25;
/// By how much a candidate must fit better than what is there.
const MARGIN: f32 = 2.0;
/// Surfaces steeper than this do not count as such.
const STEEPEST: f32 = 0.5;
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

/// What one census bit, a grey step and a grey difference count, the last two at most.
const BIT: u32 = 5;
const LARGEST_STEP: u8 = 20;
const LARGEST_GREY: u8 = 10;

/// What pixels are compared by.
#[derive(Debug, Clone, Copy, Default)]
struct Look {
    census: u8,
    step: u8,
    grey: u8,
}

impl Look {
    #[inline(always)]
    fn cost(self, other: Look) -> f32 {
        let census = BIT * (self.census ^ other.census).count_ones();
        let step = self.step.abs_diff(other.step).min(LARGEST_STEP);
        let grey = self.grey.abs_diff(other.grey).min(LARGEST_GREY);
        (census + u32::from(step) + u32::from(grey)) as f32
    }
}

/// The looks of one image.
#[derive(Debug, Default)]
pub(crate) struct Looks(Plane<Look>);

impl Looks {
    /// Looks at rows `first..first + rows` of an image.
    pub fn compute(&mut self, image: &Plane<u8>, first: usize, rows: usize) {
        let (columns, height) = image.size();
        self.0.reset(columns, rows, Look::default());
        let looks = self.0.samples_mut().par_chunks_mut(columns).enumerate();
        looks.for_each_init(Vec::new, |steps, (y, looks)| {
            let y = first + y;
            steps.resize(columns, 0);
            steps_along_row(image.row(y), steps);
            let [above, here, below] = [y.saturating_sub(1), y, (y + 1).min(height - 1)];
            let rows = [above, here, below].map(|y| image.row(y));
            for (x, look) in looks.iter_mut().enumerate() {
                let grey = rows[1][x];
                let mut census = 0u8;
                for (i, row) in rows.iter().enumerate() {
                    for (j, u) in
                        [x.saturating_sub(1), x, (x + 1).min(columns - 1)].into_iter().enumerate()
                    {
                        if (i, j) != (1, 1) {
                            census = census << 1 | u8::from(row[u] < grey);
                        }
                    }
                }
                *look = Look { census, step: steps[x], grey };
            }
        });
    }

    /// The looks of the same image in a mirror.
    pub fn mirrored(&self, out: &mut Looks) {
        let (columns, rows) = self.0.size();
        out.0.reset(columns, rows, Look::default());
        for y in 0..rows {
            // In the mirror steps run the other way: so do they in the other image.
            for (to, &from) in out.0.row_mut(y).iter_mut().zip(self.0.row(y).iter().rev()) {
                *to = from;
            }
        }
    }
}

/// A view with its other one, and the disparities that both may have.
pub(crate) struct Pair<'a> {
    pub base: &'a Looks,
    pub other: &'a Looks,
    /// The column of the image at which the map begins.
    pub first: usize,
    pub least: f32,
    pub most: f32,
}

/// The memory of the method, kept between frames.
#[derive(Default)]
pub(crate) struct SupportWeights {
    surfaces: Plane<Surface>,
}

impl SupportWeights {
    /// Lets every pixel of `values` (finite) take a neighbour's plane, into `out`.
    pub fn refine(
        &mut self,
        level: Level,
        pair: &Pair<'_>,
        values: &Plane<f32>,
        out: &mut Plane<f32>,
    ) {
        let (columns, rows) = values.size();
        self.surfaces.reset(columns, rows, Surface::default());
        self.surfaces.samples_mut().par_chunks_mut(columns).enumerate().for_each(|(y, row)| {
            for (x, surface) in row.iter_mut().enumerate() {
                *surface = surface_at(values, x, y);
            }
        });
        let weights: Vec<f32> = (0..256).map(|step| (-(step as f32) / SHADE).exp()).collect();
        out.reset(columns, rows, 0.0);
        let rows = out.samples_mut().par_chunks_mut(columns).enumerate();
        rows.for_each(|(y, out)| refine_row(level, pair, &weights, &self.surfaces, y, out));
    }
}

at_every_level! {
    /// Lets the pixels of row `y` take their neighbours' planes.
    fn refine_row(
        pair: &Pair<'_>,
        weights: &[f32],
        surfaces: &Plane<Surface>,
        y: usize,
        out: &mut [f32],
    ) {
        let (columns, rows) = surfaces.size();
        for (x, result) in out.iter_mut().enumerate() {
            let here = surfaces.row(y)[x];
            *result = here.disparity;
            let mut least = f32::NAN;
            let mut different = CLEARLY_OTHER;
            for (dx, dy) in NEIGHBOURS {
                let (u, v) = (x as i64 + i64::from(dx), y as i64 + i64::from(dy));
                if u < 0 || v < 0 || u >= columns as i64 || v >= rows as i64 {
                    continue;
                }
                let there = surfaces.row(v as usize)[u as usize];
                let moved = there.along * dx as f32 + there.down * dy as f32;
                let candidate = Surface { disparity: there.disparity - moved, ..there };
                let d = candidate.disparity;
                if (d - *result).abs() < different || d < pair.least || d > pair.most {
                    continue;
                }
                if least.is_nan() {
                    least = misfit(pair, weights, x, y, here) - MARGIN;
                }
                let misfit = misfit(pair, weights, x, y, candidate);
                if misfit < least {
                    (*result, least) = (d, misfit);
                    different = OTHER;
                }
            }
        }
    }
}

/// `m(p, f)` at pixel `(x, y)` of the map.
#[inline(always)]
fn misfit(pair: &Pair<'_>, weights: &[f32], x: usize, y: usize, surface: Surface) -> f32 {
    let (columns, rows) = pair.base.0.size();
    let last = (columns - 1) as f32;
    let centre = pair.first + x;
    let shade = pair.base.0.row(y)[centre].grey;
    let (mut sum, mut total) = (0.0, 0.0);
    for v in y.saturating_sub(RADIUS)..=(y + RADIUS).min(rows - 1) {
        let (base, other) = (pair.base.0.row(v), pair.other.0.row(v));
        let at_centre = surface.disparity + surface.down * (v as f32 - y as f32);
        for u in centre.saturating_sub(RADIUS)..=(centre + RADIUS).min(columns - 1) {
            let look = base[u];
            let weight = weights[usize::from(look.grey.abs_diff(shade))];
            let d = at_centre + surface.along * (u as f32 - centre as f32);
            let d = d.clamp(pair.least, pair.most);
            // Between the costs of the two whole disparities beside it.
            let below = d.floor();
            let part = d - below;
            let place = (u as f32 - below).clamp(0.0, last) as usize;
            let beyond = (u as f32 - below - 1.0).clamp(0.0, last) as usize;
            let (near, far) = (look.cost(other[place]), look.cost(other[beyond]));
            sum += weight * (near + (far - near) * part);
            total += weight;
        }
    }
    sum / total
}

/// The plane at a pixel: slopes are the medians of differences over four pixels, in a 5 x 5 window.
fn surface_at(values: &Plane<f32>, x: usize, y: usize) -> Surface {
    let (columns, rows) = values.size();
    let (mut along, mut down) = ([0.0f32; 25], [0.0f32; 25]);
    let (mut n, mut m) = (0, 0);
    for v in y.saturating_sub(2)..=(y + 2).min(rows - 1) {
        for u in x.saturating_sub(2)..=(x + 2).min(columns - 1) {
            if u >= 2 && u + 2 < columns {
                along[n] = 0.25 * (values.row(v)[u + 2] - values.row(v)[u - 2]);
                n += 1;
            }
            if v >= 2 && v + 2 < rows {
                down[m] = 0.25 * (values.row(v + 2)[u] - values.row(v - 2)[u]);
                m += 1;
            }
        }
    }
    let median = |differences: &mut [f32]| {
        let middle = differences.len() / 2;
        if differences.is_empty() {
            0.0
        } else {
            let (_, &mut median, _) = differences.select_nth_unstable_by(middle, f32::total_cmp);
            median.clamp(-STEEPEST, STEEPEST)
        }
    };
    Surface {
        disparity: values.row(y)[x],
        along: median(&mut along[..n]),
        down: median(&mut down[..m]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn a_board_that_has_grown_by_three_pixels_shrinks_to_its_edge() {
        let (left, right, truth) = scene();
        let grown = Plane::from_fn(60, 30, |x, _| if (20..43).contains(&x) { 8.0 } else { 2.0 });
        let (mut base, mut other) = (Looks::default(), Looks::default());
        base.compute(&left, 0, 30);
        other.compute(&right, 0, 30);
        let pair = Pair { base: &base, other: &other, first: 0, least: 0.0, most: 15.0 };
        for level in Level::available() {
            eprintln!("level {}", level.name());
            let mut out = Plane::default();
            SupportWeights::default().refine(level, &pair, &grown, &mut out);
            for y in 0..30 {
                assert_eq!(out.row(y)[20..], truth.row(y)[20..], "row {y}");
            }
        }
    }
}
