//! The plane that a pixel of a disparity map lies on.

use std::ops::Range;

use raster::Plane;

use crate::kernels::level::{Level, at_every_level};

/// Half the window of a plane fit, in pixels.
const RADIUS: usize = 20;
/// How far its samples stand apart: where the plane itself is wanted, and where its slope is enough.
pub(crate) const FINE: usize = 2;
pub(crate) const COARSE: usize = 3;
/// Pulls slopes of small supports towards zero: added to the variance of the columns.
const RIDGE: f32 = 5.0;
/// Samples farther from the plane than this do not count, in pixels.
const OUTLIER: f32 = 1.5;
/// A fit with less support keeps what it has.
const LEAST_SUPPORT: f32 = 5.0;

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
/// 32 bits for each place of the window.
pub(crate) const fn operations(step: usize) -> usize {
    4 * 29 * 4 * side(step) * side(step)
}

impl Surface {
    /// The surface that pixel `(x, y)`, which must have a value, lies on: a plane is fitted to the
    /// disparities around it, four times, each time to those near the plane before (Tukey's
    /// biweight: Beaton & Tukey, Technometrics 1974). NaN values do not count. Every `STEP`th column
    /// and row is looked at, [`FINE`] or [`COARSE`].
    pub fn fit<const STEP: usize>(level: Level, values: &Plane<f32>, x: usize, y: usize) -> Self {
        const { assert!(side(STEP) <= SIDE) };
        let (columns, rows) = values.size();
        let here = values.row(y)[x];
        // Disparities above this one's, by their place in the window.
        let mut window = [[HOLE; PADDED]; SIDE];
        let (across, down) = (samples_inside(STEP, x, columns), samples_inside(STEP, y, rows));
        let first = x + STEP * across.start - reach(STEP);
        for j in down {
            let row = values.row(y + STEP * j - reach(STEP))[first..].iter().step_by(STEP);
            for (sample, &value) in window[j][across.clone()].iter_mut().zip(row) {
                *sample = if value.is_nan() { HOLE } else { value - here };
            }
        }
        let plane = fit_window::<STEP>(level, &window);
        Self { disparity: here + plane.disparity, ..plane }
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
    /// The plane through a window. Sums are kept per lane, so that they are added in the same order
    /// at every level.
    fn fit_window<const STEP: usize>(window: &[[f32; PADDED]; SIDE]) -> Surface {
        let groups = side(STEP).div_ceil(LANES);
        let Surface { disparity: mut offset, mut along, mut down } = Surface::default();
        for round in 0..4 {
            let (outlier, growth) = if round == 0 { (OUTLIER, 0.04) } else { (0.7 * OUTLIER, 0.01) };
            // Weighted sums of 1, x, y, z and of their products.
            let [mut s, mut sx, mut sy, mut sz] = [[0.0f32; LANES]; 4];
            let [mut sxx, mut sxy, mut syy, mut sxz, mut syz] = [[0.0f32; LANES]; 5];
            for (j, row) in window[..side(STEP)].iter().enumerate() {
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
        Surface { disparity: offset, along, down }
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
        check(Surface::fit::<FINE>, &values, plane(32, 21));
        check(Surface::fit::<COARSE>, &values, plane(32, 21));
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
            let Surface { along, down, .. } =
                Surface::fit::<FINE>(Level::detect(), &values, 20, 20);
            assert!((along - expected).abs() < 1e-3, "{columns}: {along}");
            assert!(down.abs() < 1e-3, "{columns}: {down}");
        }
    }

    fn check(
        fit: impl Fn(Level, &Plane<f32>, usize, usize) -> Surface,
        values: &Plane<f32>,
        expected: f32,
    ) {
        let found = fit(Level::detect(), values, 32, 21);
        let Surface { disparity, along, down } = found;
        assert!((disparity - expected).abs() < 0.1, "{disparity}");
        // A ridge pulls slopes towards zero by a few percent.
        assert!((along - 0.1).abs() < 0.02 && (down + 0.2).abs() < 0.02, "{along} {down}");
        for level in Level::available() {
            eprintln!("level {}", level.name());
            assert_eq!(fit(level, values, 32, 21), found);
        }
    }
}
