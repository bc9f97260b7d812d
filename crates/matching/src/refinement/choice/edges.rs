//! How much the grey changes on the way from one pixel to another.
//!
//! A plane that comes from beyond an edge of the image is less likely the pixel's own. The way is a
//! straight one along a row, a column or a diagonal, so the change is the difference of two running
//! sums: one pixel costs the same however long its ways are.

use crate::cost::looks::Looks;
use crate::profile::Work;

/// Steps of so many grey values are noise, and no edge counts more than this above it.
const NOISE: u8 = 3;
const LARGEST: u8 = 40;

/// The ways that there are.
const WAYS: usize = 4;

/// Per pixel the sums of the steps before it, of each way. They wrap around, as do their differences.
#[derive(Default)]
pub(crate) struct Edges(Vec<[u16; WAYS]>);

/// Which way leads to a place so many columns and rows away; any to the pixel itself.
pub(crate) const fn way((dx, dy): (i32, i32)) -> usize {
    match (dx, dy) {
        (_, 0) => 0,
        (0, _) => 1,
        _ if dx == dy => 2,
        _ => {
            assert!(dx == -dy, "neither a row, nor a column, nor a diagonal");
            3
        }
    }
}

fn step(a: u8, b: u8) -> u16 {
    u16::from(a.abs_diff(b).saturating_sub(NOISE).min(LARGEST))
}

impl Edges {
    /// What they take for so many pixels.
    pub fn bytes(pixels: usize) -> usize {
        size_of::<[u16; WAYS]>() * pixels
    }

    /// Adds up the steps of the columns `first..first + columns` of an image.
    pub fn compute(&mut self, image: &Looks, first: usize, columns: usize) -> Work {
        let Self(sums) = self;
        sums.clear();
        sums.resize(columns * image.rows(), [0; WAYS]);
        let row = |y: usize| &image.row(y)[2][first..first + columns];
        for y in 0..image.rows() {
            let (above, sums) = sums.split_at_mut(y * columns);
            let above = &above[y.saturating_sub(1) * columns..];
            let grey = row(y);
            for x in 1..columns {
                sums[x][0] = sums[x - 1][0].wrapping_add(step(grey[x - 1], grey[x]));
            }
            if y == 0 {
                continue;
            }
            let grey_above = row(y - 1);
            for x in 0..columns {
                let from =
                    |u: usize, way: usize| above[u][way].wrapping_add(step(grey_above[u], grey[x]));
                sums[x][1] = from(x, 1);
                if x > 0 {
                    sums[x][2] = from(x - 1, 2);
                }
                if x + 1 < columns {
                    sums[x][3] = from(x + 1, 3);
                }
            }
        }
        Work::bytes(columns * image.rows() + size_of_val(&sums[..]))
    }

    /// The steps between two pixels on a way.
    #[inline(always)]
    pub fn between(&self, one: usize, other: usize, way: usize) -> u16 {
        (self.0[one][way].wrapping_sub(self.0[other][way]) as i16).unsigned_abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::level::Level;
    use raster::Plane;

    #[test]
    fn steps_are_those_on_the_way() {
        let grey = Plane::from_fn(40, 9, |x, y| ((x * x * 13 + y * 57 + x * y * 5) % 251) as u8);
        let mut looks = Looks::default();
        looks.compute(Level::detect(), &grey, 0, 9);
        let mut edges = Edges::default();
        let (first, columns) = (5, 30);
        edges.compute(&looks, first, columns);
        let ways: [((i32, i32), (i32, i32)); 9] = [
            ((0, 0), (3, 3)),
            ((7, 0), (20, 0)),
            ((-5, 0), (5, 8)),
            ((0, 4), (29, 4)),
            ((0, -8), (0, 8)),
            ((6, 6), (23, 2)),
            ((-3, -3), (3, 3)),
            ((5, -5), (24, 8)),
            ((-8, 8), (8, 0)),
        ];
        for (place, (x, y)) in ways {
            let (length, (sx, sy)) =
                (i32::max(place.0.abs(), place.1.abs()), (place.0.signum(), place.1.signum()));
            let at = |n: i32| (x + n * sx, y + n * sy);
            let shade = |(x, y): (i32, i32)| grey.row(y as usize)[first + x as usize];
            let expected: u16 = (0..length)
                .map(|n| {
                    u16::from(shade(at(n)).abs_diff(shade(at(n + 1))).saturating_sub(3).min(40))
                })
                .sum();
            let index = |(x, y): (i32, i32)| y as usize * columns + x as usize;
            assert_eq!(edges.between(index(at(0)), index(at(length)), way(place)), expected);
        }
    }
}
