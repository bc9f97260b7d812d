//! The plane that a pixel's neighbours lie on.
//!
//! It is fitted around the pixel to the disparities that lie near its own, then to those that lie near this plane;
//! those of another surface never count. The pixel moves onto it if a third of the window lies there: a thin rod has
//! too few neighbours of its own, and stays as it is.
//!
//! Besl & Jain (*Segmentation through variable-order surface fitting*, PAMI 1988) grow surfaces from such fits.

use raster::{DisparityRange, Plane};

use crate::kernels::border::around;
use crate::kernels::level::{Level, at_every_level};

/// Half the window: 5 x 5 disparities, so many pixels of the image apart.
const RADIUS: usize = 2;
const PIXELS: usize = 4;
const SIDE: usize = 2 * RADIUS + 1;
/// Disparities that are so far from the plane do not count, in pixels: in each round of the fit. The first, where the
/// plane is parallel to the image, sees the next stair too.
const NEAR: [f32; 2] = [2.0, 1.5];
/// A pixel moves no farther than this, in pixels.
const FARTHEST: f32 = 1.0;
/// So many of the 25 disparities of the window must lie on the plane, or the pixel stays.
const ENOUGH: f32 = 9.0;
/// Added to sums of squares of columns and of rows: what lies in a line has no slope across it.
const RIDGE: f32 = 0.5;
/// Stands for what lies beyond the map: farther than any disparity.
const BEYOND: f32 = 1e9;

/// Pixels that are worked on together.
const LANES: usize = 16;
/// From a pixel to the farthest column of its window, at most.
const REACH: usize = PIXELS * RADIUS;

/// Operations on bytes per pixel: per disparity of the window, per row of it and per round, on numbers of 32 bits.
pub(super) const OPERATIONS: usize = 4 * NEAR.len() * (SIDE * (SIDE * 15 + 11) + 30);

/// Row `y` of a map without holes, whose disparities are `APART` pixels apart (1 or 2) and stay in `range`.
pub(super) fn smooth_row<const APART: usize>(
    level: Level,
    map: &Plane<f32>,
    y: usize,
    range: DisparityRange,
    out: &mut [f32],
) {
    // The window has the same size in the image either way.
    let step = PIXELS / APART;
    let seen = std::array::from_fn(|j| {
        let v = (y + step * j).checked_sub(step * RADIUS).filter(|&v| v < map.rows());
        v.map_or(&[][..], |v| map.row(v))
    });
    let range = [range.min(), range.max()].map(|end| end as f32);
    match APART {
        1 => on_planes::<PIXELS>(level, &seen, range, out),
        _ => on_planes::<{ PIXELS / 2 }>(level, &seen, range, out),
    }
}

at_every_level! {
    /// A row, from those of its windows; of those beyond the map nothing is there.
    fn on_planes<const STEP: usize>(rows: &[&[f32]; SIDE], range: [f32; 2], out: &mut [f32]) {
        let [least, most] = range;
        for (start, out) in (0..).step_by(LANES).zip(out.chunks_mut(LANES)) {
            let mut seen = [[BEYOND; LANES + 2 * REACH]; SIDE];
            for (seen, row) in seen.iter_mut().zip(rows) {
                *seen = around(row, start, REACH, BEYOND);
            }
            let here: [f32; LANES] = std::array::from_fn(|i| seen[RADIUS][REACH + i]);
            // The plane, from the disparity here, and how much lies on it.
            let [mut offset, mut along, mut down, mut count] = [[0.0; LANES]; 4];
            for nearness in NEAR {
                let sums = sums::<STEP>(nearness, &seen, &here, [&offset, &along, &down]);
                let [n, x, y, xx, xy, yy, z, xz, yz] = sums;
                count = n;
                for i in 0..LANES {
                    let share = 1.0 / n[i].max(1.0);
                    let xx = xx[i] - x[i] * x[i] * share + RIDGE;
                    let yy = yy[i] - y[i] * y[i] * share + RIDGE;
                    let xy = xy[i] - x[i] * y[i] * share;
                    let xz = xz[i] - x[i] * z[i] * share;
                    let yz = yz[i] - y[i] * z[i] * share;
                    let inverse = 1.0 / (xx * yy - xy * xy);
                    along[i] = (xz * yy - yz * xy) * inverse;
                    down[i] = (yz * xx - xz * xy) * inverse;
                    offset[i] = (z[i] - along[i] * x[i] - down[i] * y[i]) * share;
                }
            }
            let mut moved = [0.0; LANES];
            for i in 0..LANES {
                let moves = (count[i] >= ENOUGH) & (offset[i].abs() <= FARTHEST);
                let shift = if moves { offset[i] } else { 0.0 };
                moved[i] = (here[i] + shift).clamp(least, most);
            }
            out.copy_from_slice(&moved[..out.len()]);
        }
    }
}

/// Sums over the disparities of the window that lie near the plane: of 1, x, y, xx, xy, yy, z, xz, yz, where z is
/// counted from the disparity `here`.
#[inline(always)]
fn sums<const STEP: usize>(
    nearness: f32,
    seen: &[[f32; LANES + 2 * REACH]; SIDE],
    here: &[f32; LANES],
    [offset, along, down]: [&[f32; LANES]; 3],
) -> [[f32; LANES]; 9] {
    let mut all = [[0.0; LANES]; 9];
    for (j, row) in seen.iter().enumerate() {
        let dy = j as f32 - RADIUS as f32;
        // Of 1, x, xx, z and xz.
        let [mut n, mut x, mut xx, mut z, mut xz] = [[0.0; LANES]; 5];
        for k in 0..SIDE {
            let dx = k as f32 - RADIUS as f32;
            let line: &[f32; LANES] =
                row[REACH + STEP * k - STEP * RADIUS..].first_chunk().expect("so many are seen");
            for i in 0..LANES {
                let value = line[i] - here[i];
                let plane = offset[i] + along[i] * dx + down[i] * dy;
                let is_near = if (value - plane).abs() < nearness { 1.0 } else { 0.0 };
                let value = is_near * value;
                n[i] += is_near;
                x[i] += is_near * dx;
                xx[i] += is_near * (dx * dx);
                z[i] += value;
                xz[i] += value * dx;
            }
        }
        for i in 0..LANES {
            let row =
                [n[i], x[i], n[i] * dy, xx[i], x[i] * dy, n[i] * (dy * dy), z[i], xz[i], z[i] * dy];
            for (all, row) in all.iter_mut().zip(row) {
                all[i] += row;
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    fn smoothed(level: Level, apart: usize, map: &Plane<f32>) -> Plane<f32> {
        let range = DisparityRange::new(0, 60).unwrap();
        let mut after = map.clone();
        for (y, out) in after.samples_mut().chunks_mut(map.columns()).enumerate() {
            match apart {
                1 => smooth_row::<1>(level, map, y, range, out),
                _ => smooth_row::<2>(level, map, y, range, out),
            }
        }
        after
    }

    #[test]
    fn a_staircase_becomes_a_slope_and_edges_and_rods_stay() {
        // A floor in whole disparities; from column 60 on a wall at 40, in the floor a rod that is a pixel wide.
        let floor = |x: usize, y: usize| 5.0 + 0.21 * x as f32 + 0.17 * y as f32;
        let rod = |x: usize| x == 30;
        let map = Plane::from_fn(100, 50, |x, y| match x {
            60.. => 40.0,
            30 => 35.0,
            _ => floor(x, y).round(),
        });
        for apart in [1, 2] {
            let after = smoothed(Level::detect(), apart, &map);
            let inside =
                |x: usize, y: usize| (8..52).contains(&x) && !rod(x) && (8..42).contains(&y);
            let (mut stairs, mut left) = (0.0, 0.0);
            for (y, x) in (0..50).flat_map(|y| (0..100).map(move |x| (y, x))) {
                let (before, after) = (map.row(y)[x], after.row(y)[x]);
                assert!(before == after || x < 60 && !rod(x), "column {x}, row {y}: {after}");
                if inside(x, y) {
                    stairs += (before - floor(x, y)).powi(2);
                    left += (after - floor(x, y)).powi(2);
                }
            }
            let share = (left / stairs).sqrt();
            assert!(share < 0.3, "{share} of the stairs is left");
        }
    }

    /// The formulas one by one: of column `x` and row `y`.
    fn definition(step: usize, map: &Plane<f32>, x: usize, y: usize) -> f64 {
        let here = f64::from(map.row(y)[x]);
        let places = (0..SIDE).flat_map(|j| (0..SIDE).map(move |k| (j, k)));
        let seen: Vec<[f64; 3]> = places
            .filter_map(|(j, k)| {
                let column =
                    (x + step * k).checked_sub(step * RADIUS).filter(|&u| u < map.columns())?;
                let row = (y + step * j).checked_sub(step * RADIUS).filter(|&v| v < map.rows())?;
                let [dx, dy] = [k, j].map(|i| i as f64 - RADIUS as f64);
                Some([dx, dy, f64::from(map.row(row)[column]) - here])
            })
            .collect();
        let (mut offset, mut along, mut down, mut count) = (0.0, 0.0, 0.0, 0);
        for nearness in NEAR {
            let near = |&&[x, y, z]: &&[f64; 3]| {
                (z - offset - along * x - down * y).abs() < f64::from(nearness)
            };
            let near: Vec<&[f64; 3]> = seen.iter().filter(near).collect();
            count = near.len();
            let mean = |of: &dyn Fn(&[f64; 3]) -> f64| {
                near.iter().map(|p| of(p)).sum::<f64>() / (count.max(1) as f64)
            };
            let ridge = f64::from(RIDGE) / count.max(1) as f64;
            let [mx, my, mz] = [0, 1, 2].map(|i| mean(&|p| p[i]));
            let product =
                |i: usize, j: usize| mean(&|p| p[i] * p[j]) - [mx, my, mz][i] * [mx, my, mz][j];
            let (xx, yy, xy) = (product(0, 0) + ridge, product(1, 1) + ridge, product(0, 1));
            let (xz, yz) = (product(0, 2), product(1, 2));
            let determinant = xx * yy - xy * xy;
            along = (xz * yy - yz * xy) / determinant;
            down = (yz * xx - xz * xy) / determinant;
            offset = mz - along * mx - down * my;
        }
        let moves = count as f64 >= f64::from(ENOUGH) && offset.abs() <= f64::from(FARTHEST);
        (here + if moves { offset } else { 0.0 }).clamp(0.0, 60.0)
    }

    #[test]
    fn every_level_does_what_the_formulas_say() {
        for (columns, rows) in [(1, 1), (5, 90), (64, 9), (131, 40)] {
            let mut chance = Chance(columns as u32);
            // Near the least disparity, so that planes run out of the range, with something nearer.
            let map = Plane::from_fn(columns, rows, |x, y| match chance.share() {
                share if share < 0.1 => 9.0,
                _ => 0.02 * (x + y) as f32 + 0.9 * chance.share(),
            });
            for apart in [1, 2] {
                let expected = smoothed(Level::available()[0], apart, &map);
                for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                    let defined = definition(PIXELS / apart, &map, x, y);
                    let found = f64::from(expected.row(y)[x]);
                    assert!((found - defined).abs() < 1e-4, "{found}, not {defined} at ({x}, {y})");
                }
                assert!(columns < 9 || expected != map, "nothing moved");
                for level in Level::available() {
                    eprintln!("{columns} x {rows}, apart {apart}, level {}", level.name());
                    assert!(smoothed(level, apart, &map) == expected);
                }
            }
        }
    }
}
