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
    /// 1 / cell.
    per_metre: f64,
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
        Self { x0, y0, cell, per_metre: 1.0 / cell, count, heights, tops, top }
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
            let along = ((v - start) * self.per_metre).clamp(0.0, self.count as f64);
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
    pub fn span(&self, ray: &GroundRay, after: f64, before: f64) -> Option<(f64, f64)> {
        let side = self.side();
        let (mut enter, mut leave) = (after, before);
        for (o, r, low) in [(ray.x, ray.reciprocal_x, self.x0), (ray.y, ray.reciprocal_y, self.y0)]
        {
            let (a, b) = ((low - o) * r, (low + side - o) * r);
            enter = greatest(enter, least(a, b));
            leave = least(leave, greatest(a, b));
        }
        (enter < leave).then_some((enter, leave))
    }

    /// The first meeting between `after` and `before`, which must lie over the grid.
    pub fn meets(&self, ray: &GroundRay, after: f64, before: f64) -> Option<f64> {
        let (mut after, mut before) = (after, before);
        // Nothing is met above the highest point.
        let at_top = (self.top - ray.height) * ray.reciprocal_climb;
        if ray.climb > 0.0 {
            before = least(before, at_top);
        } else {
            after = greatest(after, at_top);
        }
        if after >= before {
            return None;
        }
        let side = |start: f64, speed: f64, reciprocal: f64| Axis {
            start: start * self.per_metre,
            speed: speed * self.per_metre,
            reciprocal: reciprocal * self.cell,
        };
        let track = Track {
            x: side(ray.x - self.x0, ray.speed_x, ray.reciprocal_x),
            y: side(ray.y - self.y0, ray.speed_y, ray.reciprocal_y),
            height: ray.height,
            climb: ray.climb,
        };
        let blocks = self.count / BLOCK;
        track.pass(BLOCK, (0, 0), blocks, (after, before), |bi, bj, from, to| {
            if track.lowest(from, to) > self.tops[bj * blocks + bi] {
                return None;
            }
            let corner = (bi * BLOCK, bj * BLOCK);
            track.pass(1, corner, BLOCK, (from, to), |i, j, from, to| {
                let row = &self.heights[j * (self.count + 1) + i..];
                let next = &row[self.count + 1..];
                track.patch((i, j), [row[0], row[1], next[0], next[1]], from, to)
            })
        })
    }
}

/// A ray made ready for several grids: numbers that would otherwise be divided by again and again.
#[derive(Debug, Clone, Copy)]
pub(super) struct GroundRay {
    x: f64,
    y: f64,
    height: f64,
    speed_x: f64,
    speed_y: f64,
    climb: f64,
    reciprocal_x: f64,
    reciprocal_y: f64,
    reciprocal_climb: f64,
}

impl From<&Ray> for GroundRay {
    #[inline]
    fn from(ray: &Ray) -> Self {
        // A speed too small to matter instead of 0, so that no product is 0 times infinity.
        let speed = |v: f64| if v.abs() < 1e-100 { 1e-100 } else { v };
        let (speed_x, speed_y) = (speed(ray.direction.x), speed(ray.direction.y));
        let climb = speed(ray.direction.z);
        Self {
            x: ray.origin.x,
            y: ray.origin.y,
            height: ray.origin.z,
            speed_x,
            speed_y,
            climb,
            reciprocal_x: 1.0 / speed_x,
            reciprocal_y: 1.0 / speed_y,
            reciprocal_climb: 1.0 / climb,
        }
    }
}

/// A ray's way along one side of a grid, in cells.
#[derive(Debug, Clone, Copy)]
struct Axis {
    start: f64,
    speed: f64,
    /// 1 / speed.
    reciprocal: f64,
}

impl Axis {
    #[inline]
    fn at(&self, t: f64) -> f64 {
        self.start + self.speed * t
    }

    /// When the ray leaves the square with this number.
    #[inline]
    fn leaves(&self, number: usize, size: usize) -> f64 {
        let line = (number + usize::from(self.speed > 0.0)) * size;
        (line as f64 - self.start) * self.reciprocal
    }

    /// The square after this one, among those from `low` to before `end`.
    #[inline]
    fn next(&self, number: usize, low: usize, end: usize) -> Option<usize> {
        if self.speed > 0.0 {
            (number + 1 < end).then_some(number + 1)
        } else {
            (number > low).then(|| number - 1)
        }
    }
}

/// A ray over a grid: sideways in cells, height in metres.
#[derive(Debug, Clone, Copy)]
struct Track {
    x: Axis,
    y: Axis,
    height: f64,
    climb: f64,
}

impl Track {
    /// The ray's lowest point between `from` and `to`.
    #[inline]
    fn lowest(&self, from: f64, to: f64) -> f64 {
        self.height + self.climb * if self.climb < 0.0 { to } else { from }
    }

    /// Visits the squares of `size` cells under the ray, in its order, among the `count` by
    /// `count` that begin at the square `first`, until one answers. The ray is over them within
    /// `span`.
    #[inline]
    fn pass(
        &self,
        size: usize,
        first: (usize, usize),
        count: usize,
        span: (f64, f64),
        visit: impl Fn(usize, usize, f64, f64) -> Option<f64>,
    ) -> Option<f64> {
        let (mut from, last) = span;
        let (end_i, end_j) = (first.0 + count, first.1 + count);
        // Rounding may put the start just outside: the nearest square is meant.
        let mut i = (self.x.at(from) as usize / size).clamp(first.0, end_i - 1);
        let mut j = (self.y.at(from) as usize / size).clamp(first.1, end_j - 1);
        while from < last {
            let (to_x, to_y) = (self.x.leaves(i, size), self.y.leaves(j, size));
            let to = greatest(least(least(to_x, to_y), last), from);
            if let Some(t) = visit(i, j, from, to) {
                return Some(t);
            }
            if to_x < to_y {
                i = self.x.next(i, first.0, end_i)?;
            } else {
                j = self.y.next(j, first.1, end_j)?;
            }
            from = to;
        }
        None
    }

    /// Where the ray meets the bilinear patch of the cell `(i, j)` between `from` and `to`; `a` and
    /// `b` are its heights at the near side, `c` and `d` those one row on.
    #[inline]
    fn patch(
        &self,
        (i, j): (usize, usize),
        [a, b, c, d]: [f64; 4],
        from: f64,
        to: f64,
    ) -> Option<f64> {
        if self.lowest(from, to) > greatest(greatest(a, b), greatest(c, d)) {
            return None;
        }
        // With s = t - from: u = u0 + du s, v = v0 + dv s, and z - h(u, v) is a quadratic in s.
        let (u0, v0) = (self.x.at(from) - i as f64, self.y.at(from) - j as f64);
        let (du, dv) = (self.x.speed, self.y.speed);
        let (along_u, along_v, twist) = (b - a, c - a, a - b - c + d);
        let z = self.height + self.climb * from;
        let constant = z - (a + along_u * u0 + along_v * v0 + twist * u0 * v0);
        let linear = self.climb - (along_u * du + along_v * dv + twist * (u0 * dv + v0 * du));
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
