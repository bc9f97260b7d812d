//! What is seen around some rows of a map. Only so much is kept at once: a large image is worked on
//! strip after strip.

use std::ops::Range;

use raster::Plane;

use super::block::Given;
use super::edges::Edges;
use super::looks::Looks;
use super::reach::Reach;
use super::slopes::Slopes;
use super::windows::APART;
use crate::kernels::level::Level;
use crate::profile::Work;

/// At least so many rows are worked on at once, and less than twice as many.
const LEAST: usize = 192;

/// The looks of both images, the slopes of a map and the edges of the left image, in some of their rows.
#[derive(Default)]
pub(crate) struct Strip {
    /// The row of the map at which it begins.
    top: usize,
    pub base: Looks,
    pub other: Looks,
    pub slopes: Slopes,
    pub edges: Edges,
}

impl Strip {
    /// What one takes of a map of so many columns and rows, in images of a width.
    pub fn bytes(columns: usize, rows: usize, width: usize, reach: &Reach) -> usize {
        let rows = Self::height(rows, reach);
        let looks = 2 * 3 * width * rows;
        looks + Slopes::bytes(columns, rows) + Edges::bytes(columns * rows)
    }

    /// How many rows it has where the map has so many.
    fn height(rows: usize, reach: &Reach) -> usize {
        rows.min(Self::rows(rows) + 2 * (reach.rows() + APART))
    }

    /// How many rows of a map are worked on with it.
    fn rows(rows: usize) -> usize {
        rows.div_ceil((rows / LEAST).max(1))
    }

    /// The rows of a map, in strips.
    pub fn all(rows: usize) -> impl Iterator<Item = Range<usize>> {
        let height = Self::rows(rows);
        (0..rows).step_by(height).map(move |first| first..(first + height).min(rows))
    }

    /// Looks at the images wherever pixels of these rows of a map reach.
    pub fn look(
        &mut self,
        level: Level,
        given: &Given<'_>,
        reach: &Reach,
        (columns, all): (usize, usize),
        rows: &Range<usize>,
    ) -> Work {
        // All strips have one height, so that memory is taken once.
        let height = Self::height(all, reach);
        let above = rows.start.saturating_sub(reach.rows() + APART);
        self.top = above.min(all - height);
        let [base, other] = given.grey;
        let top = given.top + self.top;
        self.base.compute(level, base, top, height)
            + self.other.compute(level, other, top, height)
            + self.edges.compute(level, &self.base, given.first, columns)
    }

    /// Finds the slopes of the map in the rows that were looked at.
    pub fn slope(&mut self, level: Level, values: &Plane<f32>) -> Work {
        let rows = self.top..self.top + self.base.rows();
        self.slopes.compute(level, values, rows)
    }

    /// Where row `y` of the map lies in it.
    #[inline(always)]
    pub fn row(&self, y: usize) -> usize {
        y - self.top
    }
}

#[cfg(test)]
mod tests {
    use super::super::reach::{NARROW, WIDE};
    use super::*;
    use crate::chance::Chance;

    /// Rows of the images above the map.
    const TOP: usize = 7;

    #[test]
    fn what_is_seen_does_not_depend_on_the_strip() {
        let (columns, rows) = (30, 2 * LEAST + 90);
        let mut chance = Chance(8);
        let mut noise =
            |most: f32| Plane::from_fn(columns, TOP + rows, |_, _| most * chance.share());
        let values = noise(30.0);
        let [left, right] = [noise(255.0), noise(255.0)].map(|grey| grey.map(|&grey| grey as u8));
        let given = Given {
            doubtful: &Plane::default(),
            grey: [left.view(), right.view()],
            right: &values,
            first: 3,
            top: TOP,
            least: 0.0,
            most: 60.0,
        };
        let part = Plane::from_fn(columns - 3, rows, |x, y| values.row(y)[x + 3]);
        let level = Level::detect();
        let (mut slopes, mut edges) = (Slopes::default(), Edges::default());
        let mut looks = [Looks::default(), Looks::default()];
        slopes.compute(level, &part, 0..rows);
        for (looks, grey) in looks.iter_mut().zip(given.grey) {
            looks.compute(level, grey, TOP, rows);
        }
        edges.compute(level, &looks[0], given.first, columns - 3);
        for reach in [&NARROW, &WIDE] {
            let mut strip = Strip::default();
            let mut seen = 0;
            for rows_of_strip in Strip::all(rows) {
                assert_eq!(rows_of_strip.start, seen);
                seen = rows_of_strip.end;
                strip.look(level, &given, reach, part.size(), &rows_of_strip);
                strip.slope(level, &part);
                let reached = rows_of_strip.start.saturating_sub(reach.rows())
                    ..(rows_of_strip.end + reach.rows()).min(rows);
                for y in reached {
                    let row = strip.row(y);
                    assert_eq!(strip.slopes.along.row(row), slopes.along.row(y));
                    assert_eq!(strip.slopes.down.row(row), slopes.down.row(y));
                    assert_eq!(strip.base.row(row), looks[0].row(y));
                    assert_eq!(strip.other.row(row), looks[1].row(y));
                    // Straight up to the first row of the strip.
                    let change = |edges: &Edges, from: usize, to: usize| -> Vec<u16> {
                        let rows = edges.row(1, to).iter().zip(edges.row(1, from));
                        rows.map(|(to, from)| to.wrapping_sub(*from)).collect()
                    };
                    assert_eq!(change(&strip.edges, 0, row), change(&edges, strip.top, y));
                }
            }
            assert_eq!(seen, rows);
        }
    }
}
