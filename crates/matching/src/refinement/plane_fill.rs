//! Holes filled from the surfaces beside them.
//!
//! * **Between two ends of one surface** (they differ by little, and by half of the hole's width at the most)
//!   the disparity runs straight from one to the other.
//! * **Otherwise something nearer hides the rest**, and the hole belongs to what lies behind: the
//!   smaller of the two ends wins (Hirschmueller 2008). Where nothing points at the pixel (it is
//!   occluded), and at the ends of a row, both ends are continued along their planes, since a wall
//!   that is seen at an angle goes on at this angle; a mismatched pixel takes the value as it is.
//!
//! The plane at a hole's end is a robust fit ([`Surface::along`]). Rows without any value take those of
//! the nearest row.

use std::ops::Range;

use raster::{DisparityRange, Plane, Reason};
use rayon::prelude::*;

use super::plane_fit::Surface;
use super::row_fill::{copy_nearest_rows, filled};
use crate::ingredient::{Ingredient, Ingredients};
use crate::kernels::level::Level;
use crate::profile::Work;
use crate::selection::cross_check::ViewMap;

/// Ends of a hole that differ by no more, in pixels, may be of one surface ...
const ONE_SURFACE: f32 = 7.5;
/// ... if the hole is so many times wider than they differ: an occlusion is about as wide as the
/// step of disparity beside it.
const WIDER: f32 = 2.0;
/// Surfaces steeper than this are not continued at their slope.
const STEEPEST: f32 = 0.5;
/// A plane is continued over at most so many columns, and is flat from there on.
const LONGEST: f32 = 100.0;

/// An end of a hole, and how its surface goes on.
#[derive(Clone, Copy)]
struct End {
    column: usize,
    value: f32,
    slope: f32,
}

impl End {
    fn flat(row: &[f32], column: usize) -> Self {
        Self { column, value: row[column], slope: 0.0 }
    }

    fn continued(self, column: usize, farthest: f32) -> f32 {
        let distance = column as f32 - self.column as f32;
        self.value + self.slope * distance.clamp(-farthest, farthest)
    }
}

/// A hole in a row: where it lies, and what stands beside it.
struct Hole {
    columns: Range<usize>,
    /// How far its columns are apart in the image.
    apart: f32,
    before: Option<End>,
    after: Option<End>,
}

impl Hole {
    fn new(row: &[f32], columns: Range<usize>, apart: usize) -> Self {
        let before = columns.start.checked_sub(1).map(|x| End::flat(row, x));
        let after = (columns.end < row.len()).then(|| End::flat(row, columns.end));
        Self { columns, apart: apart as f32, before, after }
    }

    /// How wide it is in the image, in pixels.
    fn width(&self) -> f32 {
        self.apart * self.columns.len() as f32
    }

    /// Both ends where they are of one surface.
    fn one_surface(&self) -> Option<(End, End)> {
        let (before, after) = self.before.zip(self.after)?;
        let step = (after.value - before.value).abs();
        let one = step <= ONE_SURFACE && WIDER * step <= self.width();
        one.then_some((before, after))
    }

    /// Finds the slopes of the ends. The farther surface is looked at first: mostly the nearer one
    /// stays in front of it whatever its slope, and then it does not matter. Says how many planes were
    /// fitted.
    fn find_slopes(&mut self, level: Level, values: &Plane<f32>, y: usize) -> usize {
        let (reach, steepest) = (STEEPEST * self.width(), STEEPEST * self.apart);
        let (lower, higher) = match (&mut self.before, &mut self.after) {
            (Some(before), Some(after)) if before.value > after.value => {
                (Some(after), Some(before))
            }
            (before, after) => (before.as_mut(), after.as_mut()),
        };
        let (mut highest, mut fits) = (f32::INFINITY, 0);
        for end in lower.into_iter().chain(higher) {
            if end.value - reach > highest {
                break;
            }
            let slope = Surface::along(level, values, end.column, y);
            end.slope = slope.clamp(-steepest, steepest);
            highest = end.value + end.slope.abs() * self.columns.len() as f32;
            fits += 1;
        }
        fits
    }

    /// What fills column `x`.
    fn value(&self, x: usize, hidden: bool) -> Option<f32> {
        let farthest = LONGEST / self.apart;
        let at = |end: End| if hidden { end.continued(x, farthest) } else { end.value };
        match (self.before, self.after) {
            (Some(before), Some(after)) => Some(at(before).min(at(after))),
            (end, None) | (None, end) => end.map(at),
        }
    }
}

/// Fills the holes of `view` into `out`; its reasons become `..Filled`. Every value lies in `range`.
/// All values are read and written, and planes are fitted beside holes.
pub(crate) fn fill(
    ingredients: Ingredients,
    level: Level,
    width: usize,
    range: DisparityRange,
    view: &mut ViewMap,
    out: &mut Plane<f32>,
) -> Work {
    let interpolates = ingredients.has(Ingredient::Interpolation);
    let continues = ingredients.has(Ingredient::PlaneFill);
    let (columns, rows) = view.values.size();
    out.reshape(columns, rows, f32::NAN);
    let &mut ViewMap { first, apart, ref values, ref mut reasons } = view;
    let (least, most) = (range.min() as f32, range.max() as f32);
    let of_rows = reasons.samples_mut().par_chunks_mut(columns);
    let rows = out.samples_mut().par_chunks_mut(columns).zip(of_rows).enumerate();
    let fits = rows
        .map(|(y, (out, reasons))| {
            let (row, mut fits) = (values.row(y), 0);
            out.copy_from_slice(row);
            let mut x = 0;
            while x < columns {
                if !row[x].is_nan() {
                    x += 1;
                    continue;
                }
                let end = row[x..].iter().position(|v| !v.is_nan()).map_or(columns, |n| x + n);
                let mut hole = Hole::new(row, x..end, apart);
                x = end;
                let inner = hole.before.is_some() && hole.after.is_some();
                let hidden = |reason| !inner || reason == Reason::OccludedHole;
                let one_surface = hole.one_surface().filter(|_| interpolates);
                let reasons = &mut reasons[hole.columns.clone()];
                let is_hidden = reasons.iter().any(|&reason| hidden(reason));
                if one_surface.is_none() && is_hidden && continues {
                    fits += hole.find_slopes(level, values, y);
                }
                for (u, reason) in hole.columns.clone().zip(reasons) {
                    let value = match one_surface {
                        Some((before, after)) => {
                            let part = (u - before.column) as f32;
                            let width = (after.column - before.column) as f32;
                            before.value + (after.value - before.value) * part / width
                        }
                        None => match hole.value(u, hidden(*reason)) {
                            Some(value) => value,
                            None => return fits,
                        },
                    };
                    out[u] = value.clamp(least, most);
                    *reason = filled(width, first + apart * u, out[u], *reason);
                }
            }
            fits
        })
        .sum::<usize>();
    let nowhere = 0.clamp(range.min(), range.max()) as f32;
    copy_nearest_rows(out.samples_mut(), columns, f32::is_nan, nowhere, |y, row| {
        let columns = (first..).step_by(apart);
        for ((x, &value), reason) in columns.zip(row).zip(reasons.row_mut(y)) {
            *reason = filled(width, x, value, *reason);
        }
    });
    Work::bytes(2 * size_of_val(out.samples())) + Work::operations(Surface::OPERATIONS_ALONG) * fits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;

    const HOLE: f32 = f32::NAN;

    fn view(values: Plane<f32>) -> ViewMap {
        let reasons =
            values.map(|v| if v.is_nan() { Reason::OccludedHole } else { Reason::Matched });
        ViewMap { first: 0, apart: 1, values, reasons }
    }

    fn filled_rows(view: &mut ViewMap) -> Plane<f32> {
        filled_in((0, 50), view)
    }

    fn filled_in((least, most): (i32, i32), view: &mut ViewMap) -> Plane<f32> {
        let mut out = Plane::default();
        let all = Ingredients::of(Preset::Balanced, &[]);
        fill(all, Level::detect(), 60, DisparityRange::new(least, most).unwrap(), view, &mut out);
        out
    }

    #[test]
    fn a_slanted_wall_goes_on_at_its_slope() {
        // d = 10 + 0.2 x; the first 15 columns are missing. Constant, it would be off by 3.
        let wall = |x: usize| 10.0 + 0.2 * x as f32;
        let mut view = view(Plane::from_fn(60, 30, |x, _| if x < 15 { HOLE } else { wall(x) }));
        let out = filled_rows(&mut view);
        for x in 0..15 {
            assert!((out.row(12)[x] - wall(x)).abs() < 0.5, "column {x}: {}", out.row(12)[x]);
        }
        assert_eq!(view.reasons.row(12)[3], Reason::OutsideRightFilled);
        assert_eq!(view.reasons.row(12)[14], Reason::OccludedFilled);
    }

    #[test]
    fn a_wall_goes_on_over_100_columns_and_is_flat_from_there_on() {
        let wall = |x: usize| 10.0 + 0.2 * x as f32;
        let mut view = view(Plane::from_fn(160, 30, |x, _| if x < 120 { HOLE } else { wall(x) }));
        let row = filled_rows(&mut view).row(12).to_vec();
        assert!(row[..20].iter().all(|&value| value == row[20]), "{row:?}");
        assert!(row[20..].is_sorted_by(|a, b| a < b), "{row:?}");
    }

    #[test]
    fn ends_are_of_one_surface_if_they_differ_by_little_and_by_half_of_the_hole() {
        for (step, width, one_surface) in
            [(7.5, 30, true), (7.75, 30, false), (7.0, 14, true), (7.25, 14, false)]
        {
            let after = 20 + width;
            let mut view = view(Plane::from_fn(60, 30, |x, _| match x {
                0..20 => 4.0,
                _ if x < after => HOLE,
                _ => 4.0 + step,
            }));
            let out = filled_rows(&mut view);
            let expected = if one_surface { 4.0 + step / (width + 1) as f32 } else { 4.0 };
            let found = out.row(9)[20];
            assert!((found - expected).abs() < 1e-3, "{step} over {width}: {found}");
        }
    }

    #[test]
    fn what_lies_behind_fills_an_occlusion_and_one_surface_runs_through() {
        let value = |x: usize| match x {
            20..28 => HOLE,
            40..50 => HOLE,
            28..40 => 12.0,
            50.. => 13.0,
            _ => 4.0,
        };
        let mut view = view(Plane::from_fn(60, 30, |x, _| value(x)));
        let out = filled_rows(&mut view);
        assert!((out.row(9)[24] - 4.0).abs() < 0.1);
        assert!((out.row(9)[45] - (12.0 + 6.0 / 11.0)).abs() < 1e-3);
    }

    #[test]
    fn a_row_of_holes_takes_its_neighbour_and_without_any_value_what_is_nearest_to_zero() {
        let mut one = view(Plane::from_fn(5, 3, |_, y| if y == 1 { 7.0 } else { HOLE }));
        assert!(filled_rows(&mut one).samples().iter().all(|&v| v == 7.0));
        for (range, nearest) in [((0, 50), 0.0), ((-9, 9), 0.0), ((7, 50), 7.0), ((-9, -4), -4.0)] {
            let mut none = view(Plane::from_fn(5, 3, |_, _| HOLE));
            let filled = filled_in(range, &mut none);
            assert!(filled.samples().iter().all(|&v| v == nearest), "{range:?}: {filled:?}");
        }
    }
}
