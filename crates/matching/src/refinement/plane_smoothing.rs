//! Every pixel goes onto the plane that its neighbours lie on.
//!
//! Penalties of the paths press disparities towards whole numbers, and choices copy planes from afar: a floor comes out
//! as a staircase, and a wall rough. A plane is fitted around each pixel to the disparities that lie near its own, then
//! to those that lie near this plane; those of another surface never count. The pixel moves onto the plane if half of
//! the window lies there: a thin rod has too few neighbours of its own, and stays as it is. The inner nine
//! disparities count twice, or a stone as small as the window would be gone: most of what is near it is ground.
//!
//! Besl & Jain (*Segmentation through variable-order surface fitting*, PAMI 1988) grow surfaces from such fits. The
//! shift by [least squares](super::least_squares) comes after it: one that is right in the mean of a window leaves the
//! stairs in it.

use raster::{DisparityRange, Plane};
use rayon::prelude::*;

use crate::kernels::border::around;
use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;

/// Half the window: 5 x 5 disparities, so many pixels of the image apart.
const RADIUS: usize = 2;
const APART: usize = 4;
const SIDE: usize = 2 * RADIUS + 1;
/// Disparities that are so far from the plane do not count, in pixels: in each round of the fit. The first, where the
/// plane is parallel to the image, sees the next stair too.
const NEAR: [f32; 2] = [1.5, 1.0];
/// A pixel moves no farther than this, in pixels.
const FARTHEST: f32 = 1.0;
/// What the pixel's own disparity and the eight next to it count for, and the others.
const INNER: f32 = 2.0;
const OUTER: f32 = 1.0;
/// So much of the window, which is 34 in all, must lie on the plane, or the pixel stays.
const ENOUGH: f32 = 16.0;
/// Added to sums of squares of columns and of rows: what lies in a line has no slope across it.
const RIDGE: f32 = 0.5;
/// Stands for what lies beyond the map: farther than any disparity.
const BEYOND: f32 = 1e9;

/// Pixels that are worked on together.
const LANES: usize = 16;
/// From a pixel to the farthest column of its window, at most.
const REACH: usize = APART * RADIUS;

/// Operations on bytes per pixel: per disparity of the window, per row of it and per round, on numbers of 32 bits.
const OPERATIONS: usize = 4 * NEAR.len() * (SIDE * (SIDE * 16 + 11) + 30);

/// Smoothes a map without holes, whose disparities are `apart` pixels apart (1 or 2) and stay in `range`. What `scratch`
/// held is lost.
pub(crate) fn smooth(
    level: Level,
    apart: usize,
    range: DisparityRange,
    values: &mut Plane<f32>,
    scratch: &mut Plane<f32>,
) -> Work {
    let (columns, rows) = values.size();
    scratch.reshape(columns, rows, 0.0);
    // The window has the same size in the image either way.
    let step = APART / apart;
    let (before, range) = (&*values, [range.min(), range.max()].map(|end| end as f32));
    scratch.samples_mut().par_chunks_mut(columns).enumerate().for_each(|(y, row)| {
        let seen = std::array::from_fn(|j| {
            let v = (y + step * j).checked_sub(step * RADIUS).filter(|&v| v < rows);
            v.map_or(&[][..], |v| before.row(v))
        });
        match apart {
            1 => smooth_row::<APART>(level, &seen, range, row),
            _ => smooth_row::<{ APART / 2 }>(level, &seen, range, row),
        }
    });
    values.samples_mut().copy_from_slice(scratch.samples());
    let pixel = Work::bytes(4 * size_of::<f32>()) + Work::operations(OPERATIONS);
    pixel * (columns * rows)
}

at_every_level! {
    /// A row, from those of its windows; of those beyond the map nothing is there.
    fn smooth_row<const STEP: usize>(rows: &[&[f32]; SIDE], range: [f32; 2], out: &mut [f32]) {
        let [least, most] = range;
        for (start, out) in (0..).step_by(LANES).zip(out.chunks_mut(LANES)) {
            let seen = rows.map(|row| around(row, start, REACH, BEYOND));
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
        let inner = if j.abs_diff(RADIUS) > 1 { OUTER } else { INNER };
        // Of 1, x, xx, z and xz.
        let [mut n, mut x, mut xx, mut z, mut xz] = [[0.0; LANES]; 5];
        for k in 0..SIDE {
            let dx = k as f32 - RADIUS as f32;
            let weight = if k.abs_diff(RADIUS) > 1 { OUTER } else { inner };
            let line: &[f32; LANES] =
                row[REACH + STEP * k - STEP * RADIUS..].first_chunk().expect("so many are seen");
            for i in 0..LANES {
                let value = line[i] - here[i];
                let plane = offset[i] + along[i] * dx + down[i] * dy;
                let is_near = if (value - plane).abs() < nearness { weight } else { 0.0 };
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
        let (mut values, range) = (map.clone(), DisparityRange::new(0, 60).unwrap());
        smooth(level, apart, range, &mut values, &mut Plane::default());
        values
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

    #[test]
    fn a_stone_as_small_as_the_window_keeps_half_of_its_height() {
        // A disc of 15 pixels, .9 px before the ground.
        let is_within =
            |r: usize, x: usize, y: usize| x.abs_diff(30).pow(2) + y.abs_diff(20).pow(2) < r * r;
        let map = Plane::from_fn(60, 40, |x, y| if is_within(8, x, y) { 10.9 } else { 10.0 });
        let after = smoothed(Level::detect(), 1, &map);
        let (mut sum, mut count) = (0.0, 0.0);
        for (y, x) in (0..40).flat_map(|y| (0..60).map(move |x| (y, x))) {
            if is_within(6, x, y) {
                (sum, count) = (sum + after.row(y)[x] - 10.0, count + 1.0);
            }
        }
        assert!(sum / count > 0.45, "{} px are left", sum / count);
    }

    /// The formulas one by one: of column `x` and row `y`.
    fn definition(step: usize, map: &Plane<f32>, x: usize, y: usize) -> f64 {
        let here = f64::from(map.row(y)[x]);
        let places = (0..SIDE).flat_map(|j| (0..SIDE).map(move |k| (j, k)));
        // What counts twice is there twice.
        let is_inner = |(j, k): &(usize, usize)| j.abs_diff(2) < 2 && k.abs_diff(2) < 2;
        let places = places.clone().chain(places.filter(is_inner));
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
    fn every_level_and_number_of_threads_does_what_the_formulas_say() {
        for (columns, rows) in [(1, 1), (5, 90), (64, 9), (131, 40)] {
            let mut chance = Chance(columns as u32);
            // Near the least disparity, so that planes run out of the range, with something nearer.
            let map = Plane::from_fn(columns, rows, |x, y| match chance.share() {
                share if share < 0.1 => 9.0,
                _ => 0.02 * (x + y) as f32 + 0.9 * chance.share(),
            });
            for apart in [1, 2] {
                let run = |level, threads| {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                    pool.unwrap().install(|| smoothed(level, apart, &map))
                };
                let expected = run(Level::available()[0], 1);
                for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                    let defined = definition(APART / apart, &map, x, y);
                    let found = f64::from(expected.row(y)[x]);
                    assert!((found - defined).abs() < 1e-4, "{found}, not {defined} at ({x}, {y})");
                }
                assert!(columns < 9 || expected != map, "nothing moved");
                for level in Level::available() {
                    eprintln!("{columns} x {rows}, apart {apart}, level {}", level.name());
                    for threads in [1, 3] {
                        assert!(run(level, threads) == expected, "{threads} threads");
                    }
                }
            }
        }
    }
}
