//! Surfaces that the paths of semi-global matching follow (SGM-P: Scharstein, Taniai & Sinha, 3DV
//! 2017).
//!
//! A path charges for every change of disparity, as if the world stood parallel to the image: a road
//! becomes a staircase. Once a first run has told roughly how the surfaces lie, a path may follow
//! them: where the plane at `p` rises across a whole disparity on the step from `q`,
//!
//! ```text
//! rise = round(f_p(p)) - round(f_p(q))
//! ```
//!
//! the change is free. `f_p` is a plane that is fitted robustly to the checked map around `p`, one
//! for every [`CELL`] x [`CELL`] pixels. Pixels that it does not fit get none, and neither do holes
//! that no such plane runs into.

use raster::Plane;
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;
use crate::refinement::plane_fit::Surface;

/// Pixels that share a plane: a square with this side.
const CELL: usize = 4;
/// A plane farther from a pixel's disparity is not its own, in pixels.
const FARTHEST: f32 = 1.5;
/// Surfaces steeper than this, in disparities per pixel, are followed at this.
const STEEPEST: f32 = 0.5;

/// A surface per pixel, with its memory.
#[derive(Default)]
pub(crate) struct SurfacePrior {
    cells: Plane<Surface>,
    surfaces: Plane<Surface>,
}

impl SurfacePrior {
    /// Surfaces of a checked map: `checked` has holes (NaN), `filled` none. Both are read; those of the
    /// cells are fitted where there is no hole, written and read, those of the pixels written.
    pub fn fit(&mut self, level: Level, checked: &Plane<f32>, filled: &Plane<f32>) -> Work {
        let (columns, rows) = checked.size();
        let across = columns.div_ceil(CELL);
        self.cells.reshape(across, rows.div_ceil(CELL), Surface::default());
        let middle = |cell: usize, end: usize| (cell * CELL + CELL / 2).min(end - 1);
        self.cells.samples_mut().par_chunks_mut(across).enumerate().for_each(|(v, cells)| {
            let y = middle(v, rows);
            for (u, cell) in cells.iter_mut().enumerate() {
                let x = middle(u, columns);
                let hole = checked.row(y)[x].is_nan();
                let nothing = Surface { disparity: f32::NAN, ..Surface::default() };
                *cell = if hole { nothing } else { Surface::fit(level, checked, x, y) };
            }
        });
        self.surfaces.reshape(columns, rows, Surface::default());
        let cells = &self.cells;
        self.surfaces.samples_mut().par_chunks_mut(columns).enumerate().for_each(|(y, row)| {
            let cells = cells.row(y / CELL);
            let dy = y as f32 - middle(y / CELL, rows) as f32;
            for (x, (surface, &value)) in row.iter_mut().zip(filled.row(y)).enumerate() {
                let cell = cells[x / CELL];
                let dx = x as f32 - middle(x / CELL, columns) as f32;
                let disparity = cell.disparity + cell.along * dx + cell.down * dy;
                *surface = Surface::default();
                if (disparity - value).abs() < FARTHEST {
                    let [along, down] =
                        [cell.along, cell.down].map(|slope| slope.clamp(-STEEPEST, STEEPEST));
                    *surface = Surface { disparity, along, down };
                }
            }
        });
        let maps = size_of_val(checked.samples()) + size_of_val(filled.samples());
        let cells = self.cells.samples();
        let fits = cells.iter().filter(|cell| !cell.disparity.is_nan()).count();
        Work::bytes(maps + 2 * size_of_val(cells) + self.bytes())
            + Work::operations(Surface::OPERATIONS) * fits
    }

    /// Bytes of the surfaces of all pixels.
    pub fn bytes(&self) -> usize {
        size_of_val(self.surfaces.samples())
    }

    /// The rises of row `y` on the last step of four paths: from the previous, the same and the
    /// next column of the row before, and along the row. In a `reverse` sweep the row before lies
    /// below, and the path along the row comes from the right.
    pub fn rises(&self, level: Level, y: usize, reverse: bool, rises: &mut [Vec<i8>; 4]) {
        rises_of_row(level, self.surfaces.row(y), reverse, rises);
        // Here paths begin.
        let [from_previous, _, from_next, along_row] = rises;
        let last = along_row.len() - 1;
        from_previous[0] = 0;
        from_next[last] = 0;
        along_row[if reverse { last } else { 0 }] = 0;
    }
}

at_every_level! {
    /// `round(f(p)) - round(f(q))` for the four pixels `q` before each pixel `p`.
    fn rises_of_row(surfaces: &[Surface], reverse: bool, rises: &mut [Vec<i8>; 4]) {
        let sign = if reverse { -1.0 } else { 1.0 };
        let [from_previous, from_same, from_next, along_row] = rises;
        let paths = from_previous.iter_mut().zip(from_same).zip(from_next).zip(along_row);
        for (&Surface { disparity, along, down }, (((previous, same), next), row)) in
            surfaces.iter().zip(paths)
        {
            let rise =
                |step: f32| ((disparity + 0.5).floor() - (disparity - step + 0.5).floor()) as i8;
            *previous = rise(along + sign * down);
            *same = rise(sign * down);
            *next = rise(-along + sign * down);
            *row = rise(sign * along);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rises_stand_where_the_surface_crosses_half_a_disparity() {
        // A floor d = 3.1 + 0.13 y; a pole at 20 in columns 30 to 32 has no plane of its own.
        let floor = |y: usize| 3.1 + 0.13 * y as f32;
        let values =
            Plane::from_fn(64, 40, |x, y| if (30..33).contains(&x) { 20.0 } else { floor(y) });
        let mut prior = SurfacePrior::default();
        prior.fit(Level::detect(), &values, &values);
        let mut rises = std::array::from_fn(|_| vec![9; 64]);
        for y in 10..30 {
            prior.rises(Level::detect(), y, false, &mut rises);
            let expected = (floor(y).round() - floor(y - 1).round()) as i8;
            assert_eq!(rises[1][10], expected, "row {y}");
            assert_eq!(rises[3][10], 0, "row {y}");
            assert_eq!(rises[1][31], 0, "row {y}");
            assert_eq!([0, 2].map(|path| rises[path][20]), [expected; 2], "row {y}");
            assert_eq!([rises[0][0], rises[2][63]], [0; 2], "where paths begin, row {y}");
            prior.rises(Level::detect(), y - 1, true, &mut rises);
            assert_eq!(rises[1][10], -expected, "row {y}");
        }
    }

    #[test]
    fn rises_are_their_definition_at_every_level() {
        let number = |i: usize| (i * i * 37 % 101) as f32 / 50.0 - 1.0;
        let mut surfaces = Plane::from_fn(75, 2, |x, y| Surface {
            disparity: 20.0 + 9.0 * number(x + 3 * y),
            along: STEEPEST * number(x + 80),
            down: STEEPEST * number(x + 170),
        });
        // Halves of a disparity before and behind a step, and a pixel without a plane.
        for (x, along, down) in [(9, 0.5, 0.0), (10, 0.0, -0.5), (11, -0.25, 0.25)] {
            surfaces.row_mut(1)[x] = Surface { disparity: 7.5, along, down };
        }
        surfaces.row_mut(1)[40] = Surface::default();
        let prior = SurfacePrior { surfaces, ..SurfacePrior::default() };
        for (level, reverse) in
            Level::available().into_iter().flat_map(|level| [(level, false), (level, true)])
        {
            let mut rises = std::array::from_fn(|_| vec![9; 75]);
            prior.rises(level, 1, reverse, &mut rises);
            let mut others = 0;
            for (x, &Surface { disparity, along, down }) in prior.surfaces.row(1).iter().enumerate()
            {
                let (first, sign) = if reverse { (74, -1) } else { (0, 1) };
                // From `p` to `q` before it, and where there is no such pixel.
                for (path, dx, dy, begins) in [
                    (0, -1, -sign, x == 0),
                    (1, 0, -sign, false),
                    (2, 1, -sign, x == 74),
                    (3, -sign, 0, x == first),
                ] {
                    let before = disparity + (dx as f32 * along + dy as f32 * down);
                    let rise = ((disparity + 0.5).floor() - (before + 0.5).floor()) as i8;
                    let expected = if begins { 0 } else { rise };
                    assert_eq!(rises[path][x], expected, "path {path}, column {x}, {level:?}");
                    others += usize::from(expected != 0);
                }
            }
            assert!(others > 40, "{others} rises");
        }
    }
}
