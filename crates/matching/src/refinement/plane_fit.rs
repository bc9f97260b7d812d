//! The plane that a pixel of a disparity map lies on.
//!
//! A fit finds what is near its first guess, and from a flat one none that is steep: a few columns away that lies
//! beyond all outliers. So a second fit begins at the medians of the slopes around the pixel, and is believed where
//! more samples lie on it, and enough of all.

use std::ops::Range;

use raster::Plane;

use crate::kernels::level::{Level, at_every_level};

/// Half the window of a plane fit, in pixels.
const RADIUS: usize = 20;
/// How far its samples stand apart: where the plane itself is wanted, and where its slope is enough.
const FINE: usize = 2;
const COARSE: usize = 3;
/// Pulls slopes of small supports towards zero: added to the variance of the columns.
const RIDGE: f32 = 5.0;
/// Samples farther from the plane than this do not count, in pixels.
const OUTLIER: f32 = 1.5;
/// A fit with less support keeps what it has.
const LEAST_SUPPORT: f32 = 5.0;
/// Slopes whose median is a first guess go over so many pixels, which takes out what noise and whole disparities do.
const APART: usize = 12;
/// Guesses that lean no farther than this from the plane of a flat one, in pixels a pixel, lead to it as well.
const ALIKE: f32 = 0.05;
/// Others lead to one that must have so many times its support ...
const MORE: f32 = 1.2;
/// ... and this part of all samples: more where it goes on far beyond them.
const QUARTER: f32 = 0.25;
const HALF: f32 = 0.5;

/// A plane through a pixel: its disparity there, and the change per column and per row.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Surface {
    pub disparity: f32,
    pub along: f32,
    pub down: f32,
}

/// Samples that are done together.
const LANES: usize = 8;
/// Room for the samples of a side, and for all groups of them.
const SIDE: usize = side(FINE);
const PADDED: usize = SIDE.next_multiple_of(LANES);
/// Stands for a hole: farther than any outlier.
const HOLE: f32 = 1e9;

/// Samples per side of a window whose samples stand so far apart.
const fn side(step: usize) -> usize {
    2 * (RADIUS / step) + 1
}

/// From the middle of such a window to its outermost sample, in pixels.
const fn reach(step: usize) -> usize {
    RADIUS / step * step
}

/// Operations on bytes per fit: four rounds, which all take but those with hardly any support, of 29 of
/// 32 bits for each place of the window. Second fits, of a part of all, are not counted.
const fn operations(step: usize) -> usize {
    4 * 29 * 4 * side(step) * side(step)
}

impl Surface {
    /// Operations on bytes of [`Surface::fit`] and of [`Surface::along`].
    pub const OPERATIONS: usize = operations(FINE);
    pub const OPERATIONS_ALONG: usize = operations(COARSE);

    /// The surface that pixel `(x, y)`, which must have a value, lies on: a plane is fitted to the
    /// disparities around it, four times, each time to those near the plane before (Tukey's
    /// biweight: Beaton & Tukey, Technometrics 1974). NaN values do not count.
    pub fn fit(level: Level, values: &Plane<f32>, x: usize, y: usize) -> Self {
        let plane = steeper(level, Window::<FINE>::around(values, x, y), QUARTER);
        Self { disparity: values.row(y)[x] + plane.disparity, ..plane }
    }

    /// The slope along the row of a surface that goes on far beyond the pixel, by fewer samples.
    pub fn along(level: Level, values: &Plane<f32>, x: usize, y: usize) -> f32 {
        steeper(level, Window::<COARSE>::around(values, x, y), HALF).along
    }
}

/// The plane from the medians of slopes if it has more support than the flat guess's, and this part of all samples.
fn steeper<const STEP: usize>(level: Level, mut window: Window<STEP>, part: f32) -> Surface {
    let (flat, support) = fit_window::<STEP>(level, &window.samples);
    let least = (MORE * support).max(part * window.count as f32);
    // No plane has more support than there are samples.
    if window.count as f32 <= least {
        return flat;
    }
    let (along, down) = (window.median_slope([1, 0]), window.median_slope([0, 1]));
    // The second fit would find the first one's plane.
    if (along - flat.along).abs().max((down - flat.down).abs()) < ALIKE {
        return flat;
    }
    // What is left above the guess is nearly flat, and slopes of small supports are pulled towards the guess.
    window.lean(-along, -down);
    let (rest, support) = fit_window::<STEP>(level, &window.samples);
    if support > least {
        Surface { along: along + rest.along, down: down + rest.down, ..rest }
    } else {
        flat
    }
}

/// Disparities around a pixel, every `STEP`th of every `STEP`th row, above the pixel's own.
struct Window<const STEP: usize> {
    samples: [[f32; PADDED]; SIDE],
    /// How many there are.
    count: usize,
}

impl<const STEP: usize> Window<STEP> {
    /// That of a pixel with a value.
    fn around(values: &Plane<f32>, x: usize, y: usize) -> Self {
        const { assert!(side(STEP) <= SIDE && APART.is_multiple_of(STEP)) };
        let (columns, rows) = values.size();
        let here = values.row(y)[x];
        let mut samples = [[HOLE; PADDED]; SIDE];
        let mut count = 0;
        let (across, down) = (samples_inside(STEP, x, columns), samples_inside(STEP, y, rows));
        let first = x + STEP * across.start - reach(STEP);
        for j in down {
            let row = values.row(y + STEP * j - reach(STEP))[first..].iter().step_by(STEP);
            for (sample, &value) in samples[j][across.clone()].iter_mut().zip(row) {
                *sample = if value.is_nan() { HOLE } else { value - here };
                count += usize::from(!value.is_nan());
            }
        }
        Self { samples, count }
    }

    /// Adds a plane through the pixel. Holes stay beyond all outliers.
    fn lean(&mut self, along: f32, down: f32) {
        for (j, row) in self.samples.iter_mut().enumerate() {
            for (i, sample) in row.iter_mut().enumerate() {
                *sample += along * distance(STEP, i) + down * distance(STEP, j);
            }
        }
    }

    /// The median of the slopes over [`APART`] pixels in a direction, columns and rows, by every second sample of every
    /// second row; 0 where there are few. More than a pixel in each pixel is a step: no surface that both cameras see is
    /// so steep along a row.
    fn median_slope(&self, [across, down]: [usize; 2]) -> f32 {
        const EVERY: usize = 2;
        let (mut slopes, mut count) = ([0.0; PADDED * PADDED / (EVERY * EVERY)], 0);
        let apart = APART / STEP;
        let (across, down) = (apart * across, apart * down);
        let rows = self.samples.iter().zip(&self.samples[down..side(STEP)]);
        for (from, to) in rows.step_by(EVERY) {
            let pairs = from.iter().zip(&to[across..side(STEP)]);
            for (&from, &to) in pairs.step_by(EVERY) {
                slopes[count] = to - from;
                let is_slope = from != HOLE && to != HOLE && (to - from).abs() <= APART as f32;
                count += usize::from(is_slope);
            }
        }
        let slopes = &mut slopes[..count];
        if (count as f32) < LEAST_SUPPORT {
            return 0.0;
        }
        *slopes.select_nth_unstable_by(count / 2, f32::total_cmp).1 / APART as f32
    }
}

/// The samples of a window around `at` that lie between 0 and `end`.
fn samples_inside(step: usize, at: usize, end: usize) -> Range<usize> {
    let first = reach(step).saturating_sub(at).div_ceil(step);
    let last = (end - 1 - at + reach(step)) / step;
    first..side(step).min(last + 1)
}

/// From the middle of a window to its place `i`, in pixels.
#[inline(always)]
fn distance(step: usize, i: usize) -> f32 {
    (i * step) as f32 - reach(step) as f32
}

at_every_level! {
    /// The plane through the samples of a window, from a flat guess, and the sum of their weights. Sums are kept per
    /// lane, so that they are added in the same order at every level.
    fn fit_window<const STEP: usize>(samples: &[[f32; PADDED]; SIDE]) -> (Surface, f32) {
        let groups = side(STEP).div_ceil(LANES);
        let Surface { disparity: mut offset, mut along, mut down } = Surface::default();
        let mut support = 0.0;
        for round in 0..4 {
            let (outlier, growth) = if round == 0 { (OUTLIER, 0.04) } else { (0.7 * OUTLIER, 0.01) };
            // Weighted sums of 1, x, y, z and of their products.
            let [mut s, mut sx, mut sy, mut sz] = [[0.0f32; LANES]; 4];
            let [mut sxx, mut sxy, mut syy, mut sxz, mut syz] = [[0.0f32; LANES]; 5];
            for (j, row) in samples[..side(STEP)].iter().enumerate() {
                let dy = distance(STEP, j);
                let (plane, widest) = (offset + down * dy, outlier + growth * dy.abs());
                for (group, z) in row.as_chunks::<LANES>().0[..groups].iter().enumerate() {
                    for i in 0..LANES {
                        let dx = distance(STEP, group * LANES + i);
                        let off = (z[i] - along * dx - plane).abs();
                        let share = off / (widest + growth * dx.abs());
                        let rest = 1.0 - share * share;
                        let w = if share < 1.0 { rest * rest } else { 0.0 };
                        let (wx, wy) = (w * dx, w * dy);
                        s[i] += w;
                        sx[i] += wx;
                        sy[i] += wy;
                        sz[i] += w * z[i];
                        sxx[i] += wx * dx;
                        sxy[i] += wx * dy;
                        syy[i] += wy * dy;
                        sxz[i] += wx * z[i];
                        syz[i] += wy * z[i];
                    }
                }
            }
            let [s, sx, sy, sz, sxx, sxy, syy, sxz, syz] =
                [s, sx, sy, sz, sxx, sxy, syy, sxz, syz].map(|sums| sums.iter().sum::<f32>());
            support = s;
            if s < LEAST_SUPPORT {
                break;
            }
            let (mx, my, mz) = (sx / s, sy / s, sz / s);
            let (xx, yy) = (sxx / s - mx * mx + RIDGE, syy / s - my * my + RIDGE);
            let (xy, xz, yz) = (sxy / s - mx * my, sxz / s - mx * mz, syz / s - my * mz);
            let determinant = xx * yy - xy * xy;
            along = (xz * yy - yz * xy) / determinant;
            down = (yz * xx - xz * xy) / determinant;
            offset = mz - along * mx - down * my;
        }
        (Surface { disparity: offset, along, down }, support)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_found_beside_another_surface_and_among_holes() {
        // d = 9 + 0.1 x - 0.2 y, some of it missing; another object at 30 on the right.
        let plane = |x: usize, y: usize| 9.0 + 0.1 * x as f32 - 0.2 * y as f32;
        let values = Plane::from_fn(60, 40, |x, y| match (x, y) {
            (40.., _) => 30.0,
            _ if (x * 7 + y * 3) % 5 == 0 => f32::NAN,
            _ => plane(x, y),
        });
        let fine = |level| Surface::fit(level, &values, 32, 21);
        let coarse = |level| {
            let plane = steeper(level, Window::<COARSE>::around(&values, 32, 21), HALF);
            assert_eq!(Surface::along(level, &values, 32, 21), plane.along);
            Surface { disparity: values.row(21)[32] + plane.disparity, ..plane }
        };
        let fits: [&dyn Fn(Level) -> Surface; 2] = [&fine, &coarse];
        for fit in fits {
            let found = fit(Level::detect());
            let Surface { disparity, along, down } = found;
            assert!((disparity - plane(32, 21)).abs() < 0.1, "{disparity}");
            // A ridge pulls slopes towards zero by a few percent.
            assert!((along - 0.1).abs() < 0.02 && (down + 0.2).abs() < 0.02, "{along} {down}");
            for level in Level::available() {
                eprintln!("level {}", level.name());
                assert_eq!(fit(level), found);
            }
        }
    }

    #[test]
    fn a_steep_plane_is_found_though_it_leaves_the_outliers_of_a_flat_one() {
        // Beside it a wall at 60.
        for (along, down) in [(0.5, 0.0), (-0.5, 0.0), (0.0, 0.5), (0.4, -0.3)] {
            let plane = |x: usize, y: usize| 30.0 + along * x as f32 + down * y as f32;
            let values =
                Plane::from_fn(60, 60, |x, y| if x < 20 { 60.0 } else { plane(x, y).round() });
            let found = Surface::fit(Level::detect(), &values, 24, 30);
            let off = (found.along - along).abs().max((found.down - down).abs());
            assert!(off < 0.03, "{along} {down}: {found:?}");
            let slope = Surface::along(Level::detect(), &values, 24, 30);
            assert!((slope - along).abs() < 0.03, "{along} {down}: {slope}");
        }
    }

    #[test]
    fn a_narrow_support_has_little_slope_and_a_line_none() {
        // The variance of two columns 2 pixels apart is 1, to which the ridge adds 5.
        for (columns, expected) in [(1, 0.0), (3, 0.15 / 6.0)] {
            let inside = 20..20 + columns;
            let values = Plane::from_fn(41, 41, |x, _| match inside.contains(&x) {
                true => 9.0 + 0.15 * (x - 20) as f32,
                false => f32::NAN,
            });
            let Surface { along, down, .. } = Surface::fit(Level::detect(), &values, 20, 20);
            assert!((along - expected).abs() < 1e-3, "{columns}: {along}");
            assert!(down.abs() < 1e-3, "{columns}: {down}");
        }
    }
}
