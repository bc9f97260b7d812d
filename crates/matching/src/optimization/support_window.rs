//! The window of a pixel: how well planes fit there.
//!
//! Bytes of `rho` (`cost/looks.rs`) are there for all columns and disparities of its rows. Along a
//! plane they are looked up, 16 columns at a time, and between two whole disparities the costs of both
//! count by their nearness: `sum_k max(0, 1 - |d - k|) rho_k`, where only those `k` are visited that
//! the plane comes near to in some row. No column needs a place of its own to be looked up at.
//!
//! Weights `exp(-|I_p - I_q| / 10)` are products of `exp(I_p / 10)` and `exp(-I_q / 10)` or of their
//! inverses, whichever is smaller: nothing is looked up for them either. Sums are added in halves, so
//! that they are the same at every level.

use std::ops::Range;

use crate::cost::looks::{Comparison, RowsWithEnds};
use crate::kernels::level::Level;
use crate::kernels::rounding::nearest;
use crate::refinement::plane_fit::Surface;

/// Half the window.
pub(crate) const RADIUS: usize = 5;
/// A grey step at which a pixel counts 1/e.
pub(crate) const SHADE: f32 = 10.0;
/// Columns of a window, and those that are done together: the last ones weigh nothing.
pub(crate) const SIDE: usize = 2 * RADIUS + 1;
pub(crate) const LANES: usize = SIDE.next_multiple_of(16);

/// `exp(I / 10)` and `exp(-I / 10)` of all grey values.
pub(crate) type Shades = [[f32; 2]; 256];

pub(crate) fn shades() -> Shades {
    let shade = |grey: usize, sign: f32| (sign * grey as f32 / SHADE).exp();
    std::array::from_fn(|grey| [shade(grey, 1.0), shade(grey, -1.0)])
}

/// What the windows of a row are compared by. Column `i` is that `RADIUS - i` before the map's first.
#[derive(Default)]
pub(crate) struct WindowRow {
    /// `rho` of all columns at the least disparity, then at the next, and so on.
    costs: Vec<u8>,
    /// `exp(I / 10)` and `exp(-I / 10)`; 0 beyond the image.
    rising: Vec<f32>,
    falling: Vec<f32>,
}

impl WindowRow {
    /// What it takes for so many columns and disparities.
    pub fn bytes(columns: usize, disparities: usize) -> usize {
        columns * disparities + 8 * columns
    }

    /// Compares a row of the images at all disparities.
    pub fn compute(
        &mut self,
        level: Level,
        what: &Comparison<'_>,
        shades: &Shades,
        rows_with_ends: &mut RowsWithEnds,
    ) {
        let Self { costs, rising, falling } = self;
        rows_with_ends.compare(level, what, costs);
        rising.resize(what.columns, 0.0);
        falling.resize(what.columns, 0.0);
        let grey = what.base.row(what.row)[2];
        for (column, (rising, falling)) in (what.start..).zip(rising.iter_mut().zip(falling)) {
            let grey = usize::try_from(column).ok().and_then(|column| grey.get(column));
            [*rising, *falling] = grey.map_or([0.0; 2], |&grey| shades[usize::from(grey)]);
        }
    }
}

/// Operations on bytes per window: two products, a minimum and a sum of 32 bits for each pixel.
pub(crate) const OPERATIONS: usize = 4 * 4 * SIDE * SIDE;
/// Operations on bytes per surface that is tried there, of 32 bits: for each pixel five to find its
/// disparity, at least twice seven for the costs on both sides of it, and two to add them up.
pub(crate) const OPERATIONS_PER_SURFACE: usize = (5 + 2 * 7 + 2) * 4 * SIDE * SIDE;

/// The window of a pixel, shared by all its candidates.
pub(crate) struct Window<'a> {
    rows: &'a [&'a WindowRow; SIDE],
    /// Its first column.
    x: usize,
    /// From one disparity to the next in the costs of a row.
    stride: usize,
    /// The largest disparity, less the least.
    range: f32,
    weights: [[f32; LANES]; SIDE],
    pub total: f32,
}

impl<'a> Window<'a> {
    /// The window that begins with column `x`. Only its rows `inside` lie in the image.
    #[inline(always)]
    pub fn new(
        rows: &'a [&'a WindowRow; SIDE],
        inside: Range<usize>,
        x: usize,
        range: f32,
    ) -> Self {
        let [mut rising, mut falling] = [[[0.0; LANES]; SIDE]; 2];
        for j in inside {
            rising[j][..SIDE].copy_from_slice(&rows[j].rising[x..][..SIDE]);
            falling[j][..SIDE].copy_from_slice(&rows[j].falling[x..][..SIDE]);
        }
        let (up, down) = (rising[RADIUS][RADIUS], falling[RADIUS][RADIUS]);
        let mut weights = [[0.0; LANES]; SIDE];
        let samples = rising.as_flattened().iter().zip(falling.as_flattened());
        for (weight, (rising, falling)) in weights.as_flattened_mut().iter_mut().zip(samples) {
            *weight = smaller(rising * down, falling * up);
        }
        let total = dot(&weights, &[[1.0; LANES]; SIDE]);
        let stride = rows[RADIUS].rising.len();
        Self { rows, x, stride, range, weights, total }
    }

    /// The weighted sum of costs along a surface.
    #[inline(always)]
    pub fn misfit(&self, surface: Surface) -> f32 {
        let disparities = self.range as usize + 1;
        let within = |d: f32| smaller(larger(d, 0.0), self.range);
        let (first, last) = (surface.along * COLUMNS[0][0], surface.along * COLUMNS[0][SIDE - 1]);
        // The whole disparities from the one below a row's least to the one above its largest.
        let mut centres = [0.0; LANES];
        let mut lowest = [0; LANES];
        let mut steps = 0;
        for j in 0..LANES {
            let row = j.min(SIDE - 1) as f32 - RADIUS as f32;
            centres[j] = surface.disparity + surface.down * row;
            let [one, other] = [first, last].map(|off| whole(within(centres[j] + off)));
            lowest[j] = one.min(other);
            steps = steps.max(one.max(other) + 2 - lowest[j]);
        }
        let steps = disparities.min(steps as usize);
        let [mut above, mut from] = [[[0.0; LANES]; SIDE]; 2];
        let mut places = [0; SIDE];
        for j in 0..SIDE {
            lowest[j] = lowest[j].min((disparities - steps) as i32);
            places[j] = lowest[j] as usize * self.stride + self.x;
            above[j] = [centres[j]; LANES];
            from[j] = [lowest[j] as f32; LANES];
        }
        let columns = COLUMNS.as_flattened().iter().zip(from.as_flattened());
        for (above, (column, from)) in above.as_flattened_mut().iter_mut().zip(columns) {
            *above = within(*above + surface.along * column) - from;
        }
        let mut costs = [[0.0; LANES]; SIDE];
        for k in 0..steps {
            let mut at_k = [[0; LANES]; SIDE];
            for j in 0..SIDE {
                at_k[j] = *lanes(&self.rows[j].costs[places[j] + k * self.stride..]);
            }
            let at_k = at_k.as_flattened().iter().zip(above.as_flattened());
            for (cost, (&at_k, above)) in costs.as_flattened_mut().iter_mut().zip(at_k) {
                *cost += larger(1.0 - (above - k as f32).abs(), 0.0) * f32::from(at_k);
            }
        }
        dot(&self.weights, &costs)
    }
}

/// How far the columns of a window are from its middle.
static COLUMNS: [[f32; LANES]; SIDE] = {
    let mut row = [0.0; LANES];
    let mut i = 0;
    while i < LANES {
        row[i] = i as f32 - RADIUS as f32;
        i += 1;
    }
    [row; SIDE]
};

/// A whole number below `d` by 1 at most, for `d` from 0 to a million. (A conversion that minds all
/// other numbers, as `as` does, is several times as long.)
#[inline(always)]
fn whole(d: f32) -> i32 {
    nearest(d - 0.5)
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The sum of products: halves are added until one number is left.
#[inline(always)]
fn dot(a: &[[f32; LANES]; SIDE], b: &[[f32; LANES]; SIDE]) -> f32 {
    let mut products = [0.0; (SIDE * LANES).next_power_of_two()];
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    for (product, (a, b)) in products.iter_mut().zip(pairs) {
        *product = a * b;
    }
    let mut half = products.len() / 2;
    while half > 0 {
        let (front, back) = products.split_at_mut(half);
        for (front, back) in front.iter_mut().zip(back) {
            *front += *back;
        }
        half /= 2;
    }
    products[0]
}

#[inline(always)]
fn lanes<T>(samples: &[T]) -> &[T; LANES] {
    samples.first_chunk().expect("rows are as long as their last window")
}
