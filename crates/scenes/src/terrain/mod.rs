//! Ground to the horizon: heights on nested grids, fine near the cameras and coarse far away.
//!
//! Each level covers a square four times as wide as the one inside it, with cells four times as
//! large. A level's heights are those of the next coarser level, interpolated, plus its own finer
//! relief, which fades to nothing at its border; so the levels join without a step, and the ground
//! is one continuous surface made of bilinear patches. That surface *is* the ground: truth and
//! shading refer to it, not to the noise that it was made from.

mod grid;

use grid::{Grid, GroundRay};

use crate::geometry::{Ray, Surface};
use crate::number::{least, smoothstep};
use crate::texture::Material;
use crate::vector::{Vector, vector};

/// Cells along each side of every level.
const COUNT: usize = 512;
/// Cells behind the origin; the rest lies ahead, along y.
const BEHIND: usize = 32;
/// How much wider a level is than the one inside it.
const RATIO: f64 = 4.0;

/// The ground.
#[derive(Debug, Clone)]
pub(crate) struct Terrain {
    /// The finest first; each lies inside the next.
    levels: Vec<Grid>,
    material: Material,
}

impl Terrain {
    /// Ground around the origin, mostly ahead of it along y. The finest of `levels` has cells of
    /// `cell` metres. `relief(level, cell, x, y)` is the height that a level adds; the coarsest
    /// level is `levels - 1`, and adds all the rest.
    pub fn new(
        levels: usize,
        cell: f64,
        material: Material,
        relief: impl Fn(usize, f64, f64, f64) -> f64 + Sync,
    ) -> Self {
        let mut grids: Vec<Grid> = Vec::with_capacity(levels);
        let mut cell = (1..levels).fold(cell, |cell, _| cell * RATIO);
        for level in (0..levels).rev() {
            let (x0, y0) = (-0.5 * cell * COUNT as f64, -cell * BEHIND as f64);
            let side = cell * COUNT as f64;
            let coarser = grids.last();
            let grid = Grid::new(x0, y0, cell, COUNT, |x, y| {
                let Some(coarser) = coarser else { return relief(level, cell, x, y) };
                let border = least(
                    least(x - x0, x0 + side - x),
                    // Behind the cameras nothing is seen, so the border is short there.
                    least(8.0 * (y - y0), y0 + side - y),
                );
                let share = smoothstep(0.0, 0.2 * side, border);
                let own = if share > 0.0 { share * relief(level, cell, x, y) } else { 0.0 };
                coarser.height(x, y) + own
            });
            grids.push(grid);
            cell /= RATIO;
        }
        grids.reverse();
        Self { levels: grids, material }
    }

    pub fn material(&self) -> &Material {
        &self.material
    }

    fn finest_under(&self, x: f64, y: f64) -> &Grid {
        let found = self.levels.iter().find(|level| level.holds(x, y));
        found.unwrap_or(&self.levels[self.levels.len() - 1])
    }

    /// Height of the ground in metres.
    pub fn height(&self, x: f64, y: f64) -> f64 {
        self.finest_under(x, y).height(x, y)
    }

    pub fn surface(&self, point: Vector) -> Surface {
        let (along_x, along_y) = self.finest_under(point.x, point.y).slopes(point.x, point.y);
        Surface { normal: vector(-along_x, -along_y, 1.0).normalized(), local: point }
    }

    /// The first meeting with `after < t < before`.
    pub fn meets(&self, ray: &Ray, after: f64, before: f64) -> Option<f64> {
        self.meets_level(self.levels.len() - 1, &ray.into(), after, before)
            .filter(|&t| t > after && t < before)
    }

    /// Over the square of one level: first the part before the finer level's square, then that
    /// square, then the part behind it.
    fn meets_level(&self, level: usize, ray: &GroundRay, after: f64, before: f64) -> Option<f64> {
        let grid = &self.levels[level];
        let (after, before) = grid.span(ray, after, before)?;
        let finer = level.checked_sub(1);
        let inside = finer.and_then(|f| Some((f, self.levels[f].span(ray, after, before)?)));
        let Some((finer, (enter, leave))) = inside else {
            return grid.meets(ray, after, before);
        };
        grid.meets(ray, after, enter)
            .or_else(|| self.meets_level(finer, ray, enter, leave))
            .or_else(|| grid.meets(ray, leave, before))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::fractal;
    use crate::random::Random;

    fn hills(levels: usize) -> Terrain {
        Terrain::new(levels, 0.05, Material::matt(vector(0.5, 0.5, 0.5)), |_, cell, x, y| {
            let size = 8.0 * cell;
            0.3 * size * fractal(vector(x, y, 0.0), size, 2, 0.5, 1e-9, 3)
        })
    }

    #[test]
    fn rays_meet_the_ground_where_a_fine_march_does() {
        let ground = hills(3);
        let mut random = Random::new(4, "test");
        let mut met = 0;
        for _ in 0..300 {
            let origin = vector(random.between(-3.0, 3.0), random.between(-1.0, 5.0), 6.0);
            let direction = vector(random.between(-0.5, 0.5), 1.0, random.between(-0.9, -0.05));
            let ray = Ray { origin, direction };
            let above = |t: f64| ray.at(t).z - ground.height(ray.at(t).x, ray.at(t).y);
            let found = ground.meets(&ray, 0.0, f64::INFINITY);
            let marched = (1..40_000).map(|i| f64::from(i) * 2e-3).find(|&t| above(t) <= 0.0);
            match (found, marched) {
                (Some(t), Some(near)) => {
                    assert!(above(t).abs() < 1e-9, "{}", above(t));
                    // The march may step over a hump that the exact root finds.
                    assert!(t <= near, "{t} {near}");
                    if t < near - 2e-3 {
                        assert!(above(t + 1e-6) < 0.0 || above(t - 1e-6) < 1e-5);
                    }
                    met += 1;
                }
                (Some(t), None) => assert!(above(t).abs() < 1e-9),
                (None, Some(near)) => panic!("nothing met, but the march ends at {near}"),
                (None, None) => {}
            }
        }
        assert!(met > 200, "{met}");
    }

    #[test]
    fn levels_join_without_a_step() {
        let ground = hills(3);
        for k in 0..100 {
            let x = -12.0 + 0.24 * f64::from(k);
            // The finest level ends 480 cells ahead, at 24 m.
            let (inside, outside) = (ground.height(x, 24.0 - 1e-9), ground.height(x, 24.0 + 1e-9));
            assert!((inside - outside).abs() < 1e-6, "{x}: {inside} {outside}");
        }
    }

    #[test]
    fn a_ray_to_the_sky_meets_nothing() {
        let ground = hills(2);
        let ray = Ray { origin: vector(0.0, 0.0, 9.0), direction: vector(0.1, 1.0, 0.01) };
        assert_eq!(ground.meets(&ray, 0.0, f64::INFINITY), None);
    }
}
