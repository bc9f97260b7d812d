//! Heights on a square grid, and where a ray meets them.
//!
//! Between four grid points the surface is the bilinear patch through them, so a ray meets it
//! where a quadratic has a root: no marching, no step that could be too long. Cells are visited
//! one after the other as the ray passes over them (Amanatides & Woo 1987), first in blocks whose
//! largest height is known, then, only where the ray dips below that, one by one.

use rayon::prelude::*;

use crate::geometry::{Ray, roots};
use crate::number::{greatest, least};

/// Cells along each side of a block.
const BLOCK: usize = 16;

/// Heights above the world's x-y plane.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    pub x0: f64,
    pub y0: f64,
    /// Side of a cell in metres.
    pub cell: f64,
    /// Cells along each side, a multiple of [`BLOCK`].
    pub count: usize,
    /// `count + 1` heights in each of `count + 1` rows.
    heights: Vec<f64>,
    /// Largest height in each block.
    tops: Vec<f64>,
    /// Largest height of all.
    top: f64,
}

impl Grid {
    /// Computes the height at every grid point.
    pub fn new(
        x0: f64,
        y0: f64,
        cell: f64,
        count: usize,
        height: impl Fn(f64, f64) -> f64 + Sync,
    ) -> Self {
        assert!(count.is_multiple_of(BLOCK), "a grid is made of whole blocks");
        let stride = count + 1;
        let mut heights = vec![0.0; stride * stride];
        heights.par_chunks_mut(stride).enumerate().for_each(|(j, row)| {
            for (i, out) in row.iter_mut().enumerate() {
                *out = height(x0 + cell * i as f64, y0 + cell * j as f64);
            }
        });
        let blocks = count / BLOCK;
        let mut tops = vec![f64::NEG_INFINITY; blocks * blocks];
        for (number, top) in tops.iter_mut().enumerate() {
            let (bi, bj) = (number % blocks * BLOCK, number / blocks * BLOCK);
            for j in bj..=bj + BLOCK {
                let row = &heights[j * stride + bi..][..=BLOCK];
                *top = row.iter().fold(*top, |top, &h| greatest(top, h));
            }
        }
        let top = tops.iter().fold(f64::NEG_INFINITY, |top, &h| greatest(top, h));
        Self { x0, y0, cell, count, heights, tops, top }
    }

    pub fn side(&self) -> f64 {
        self.cell * self.count as f64
    }

    /// Whether the point lies over the grid.
    pub fn holds(&self, x: f64, y: f64) -> bool {
        let side = self.side();
        (0.0..=side).contains(&(x - self.x0)) && (0.0..=side).contains(&(y - self.y0))
    }

    /// The cell under a point (the nearest one outside), and where in it the point is, 0 to 1.
    fn locate(&self, x: f64, y: f64) -> (usize, usize, f64, f64) {
        let part = |v: f64, start: f64| {
            let along = ((v - start) / self.cell).clamp(0.0, self.count as f64);
            let whole = (along as usize).min(self.count - 1);
            (whole, along - whole as f64)
        };
        let ((i, u), (j, v)) = (part(x, self.x0), part(y, self.y0));
        (i, j, u, v)
    }

    #[inline]
    fn at(&self, i: usize, j: usize) -> f64 {
        self.heights[j * (self.count + 1) + i]
    }

    /// Height of the surface; beyond the grid, that of its nearest point.
    pub fn height(&self, x: f64, y: f64) -> f64 {
        let (i, j, u, v) = self.locate(x, y);
        let low = self.at(i, j) + (self.at(i + 1, j) - self.at(i, j)) * u;
        let high = self.at(i, j + 1) + (self.at(i + 1, j + 1) - self.at(i, j + 1)) * u;
        low + (high - low) * v
    }

    /// Slopes along x and y, smoothed: central differences at the grid points, blended between
    /// them, so that light does not show the cells.
    pub fn slopes(&self, x: f64, y: f64) -> (f64, f64) {
        let (i, j, u, v) = self.locate(x, y);
        let slope = |i: usize, j: usize| {
            let (left, right) = (i.saturating_sub(1), (i + 1).min(self.count));
            let (back, front) = (j.saturating_sub(1), (j + 1).min(self.count));
            (
                (self.at(right, j) - self.at(left, j)) / (self.cell * (right - left) as f64),
                (self.at(i, front) - self.at(i, back)) / (self.cell * (front - back) as f64),
            )
        };
        let blend =
            |a: (f64, f64), b: (f64, f64), t: f64| (a.0 + (b.0 - a.0) * t, a.1 + (b.1 - a.1) * t);
        let low = blend(slope(i, j), slope(i + 1, j), u);
        let high = blend(slope(i, j + 1), slope(i + 1, j + 1), u);
        blend(low, high, v)
    }

    /// Where the ray is over the grid, cut to `after..before`.
    pub fn span(&self, ray: &Ray, after: f64, before: f64) -> Option<(f64, f64)> {
        let side = self.side();
        let (mut enter, mut leave) = (after, before);
        for (o, d, low) in
            [(ray.origin.x, ray.direction.x, self.x0), (ray.origin.y, ray.direction.y, self.y0)]
        {
            if d.abs() < 1e-150 {
                if o < low || o > low + side {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low - o) / d, (low + side - o) / d);
            enter = greatest(enter, least(a, b));
            leave = least(leave, greatest(a, b));
        }
        (enter < leave).then_some((enter, leave))
    }

    /// The first meeting between `after` and `before`, which must lie over the grid.
    pub fn meets(&self, ray: &Ray, after: f64, before: f64) -> Option<f64> {
        let (mut after, mut before) = (after, before);
        // Nothing is met above the highest point.
        let climb = ray.direction.z;
        let at_top = (self.top - ray.origin.z) / climb;
        if climb > 0.0 {
            before = least(before, at_top);
        } else if climb < 0.0 {
            after = greatest(after, at_top);
        } else if ray.origin.z > self.top {
            return None;
        }
        let dips_below = |top: f64, from: f64, to: f64| {
            ray.origin.z + climb * if climb < 0.0 { to } else { from } <= top
        };
        let blocks = self.count / BLOCK;
        let block = self.cell * BLOCK as f64;
        self.pass(ray, block, (0, 0), blocks, (after, before), |bi, bj, from, to| {
            if !dips_below(self.tops[bj * blocks + bi], from, to) {
                return None;
            }
            let corner = (bi * BLOCK, bj * BLOCK);
            self.pass(ray, self.cell, corner, BLOCK, (from, to), |i, j, from, to| {
                self.patch(ray, i, j, from, to)
            })
        })
    }

    /// Visits the squares of side `size` under the ray, in its order, among the `count` by `count`
    /// that begin at `corner`, until one answers. The ray is over them within `span`.
    #[inline]
    fn pass(
        &self,
        ray: &Ray,
        size: f64,
        corner: (usize, usize),
        count: usize,
        span: (f64, f64),
        visit: impl Fn(usize, usize, f64, f64) -> Option<f64>,
    ) -> Option<f64> {
        let (mut from, last) = span;
        let start = ray.at(from);
        let (end_i, end_j) = (corner.0 + count, corner.1 + count);
        // Rounding may put the start just outside: the nearest square is meant.
        let first = |v: f64, origin: f64, low: usize, end: usize| {
            (((v - origin) / size) as usize).clamp(low, end - 1)
        };
        let mut i = first(start.x, self.x0, corner.0, end_i);
        let mut j = first(start.y, self.y0, corner.1, end_j);
        let edge = |number: usize, forward: bool, origin: f64, o: f64, d: f64| {
            let line = origin + size * (number + usize::from(forward)) as f64;
            if d.abs() < 1e-150 { f64::INFINITY } else { (line - o) / d }
        };
        let (right, ahead) = (ray.direction.x > 0.0, ray.direction.y > 0.0);
        while from < last {
            let to_x = edge(i, right, self.x0, ray.origin.x, ray.direction.x);
            let to_y = edge(j, ahead, self.y0, ray.origin.y, ray.direction.y);
            let to = greatest(least(least(to_x, to_y), last), from);
            if let Some(t) = visit(i, j, from, to) {
                return Some(t);
            }
            let (number, end, forward, low) = if to_x < to_y {
                (&mut i, end_i, right, corner.0)
            } else {
                (&mut j, end_j, ahead, corner.1)
            };
            if forward && *number + 1 < end {
                *number += 1;
            } else if !forward && *number > low {
                *number -= 1;
            } else {
                return None;
            }
            from = to;
        }
        None
    }

    /// Where the ray meets the bilinear patch of a cell between `from` and `to`.
    fn patch(&self, ray: &Ray, i: usize, j: usize, from: f64, to: f64) -> Option<f64> {
        let (a, b) = (self.at(i, j), self.at(i + 1, j));
        let (c, d) = (self.at(i, j + 1), self.at(i + 1, j + 1));
        let (start, end) =
            (ray.origin.z + ray.direction.z * from, ray.origin.z + ray.direction.z * to);
        if least(start, end) > greatest(greatest(a, b), greatest(c, d)) {
            return None;
        }
        // With s = t - from: u = u0 + du s, v = v0 + dv s, and z - h(u, v) is a quadratic in s.
        let p = ray.at(from);
        let u0 = (p.x - self.x0) / self.cell - i as f64;
        let v0 = (p.y - self.y0) / self.cell - j as f64;
        let (du, dv) = (ray.direction.x / self.cell, ray.direction.y / self.cell);
        let (along_u, along_v, twist) = (b - a, c - a, a - b - c + d);
        let constant = p.z - (a + along_u * u0 + along_v * v0 + twist * u0 * v0);
        let linear = ray.direction.z - (along_u * du + along_v * dv + twist * (u0 * dv + v0 * du));
        let square = -twist * du * dv;
        let (first, second) = roots(square, 0.5 * linear, constant)?;
        // A root on the border of two cells must not be lost to rounding by both.
        let slack = 1e-9 * (to - from);
        let inside = |s: f64| s >= -slack && s <= to - from + slack;
        if inside(first) {
            Some(from + first)
        } else if inside(second) {
            Some(from + second)
        } else {
            None
        }
    }
}
