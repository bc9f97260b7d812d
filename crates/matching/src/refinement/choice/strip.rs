//! What is seen around some rows of a map. Only so much is kept at once: a large image is worked on
//! strip after strip.

use std::ops::Range;

use raster::{Plane, Reason};
use rayon::prelude::*;

use super::block::Given;
use super::edges::Edges;
use super::looks::Looks;
use super::notes::{Notes, Sources};
use super::reach::Reach;
use super::slopes::Slopes;
use super::windows::rows_apart;
use crate::kernels::every::take_every;
use crate::kernels::level::Level;
use crate::profile::Work;

/// At least so many rows are worked on at once, and less than twice as many.
const LEAST: usize = 192;

/// The looks of both images, the slopes of a map, grey values and edges of the left image, and notes, in some of their
/// rows: all but looks of the pixels that are matched.
#[derive(Default)]
pub(crate) struct Strip {
    /// The row of the map at which it begins.
    top: usize,
    /// A row of the map is every so many-th one of the image.
    every: usize,
    pub base: Looks,
    pub other: Looks,
    pub slopes: Slopes,
    /// The grey values of the left image.
    pub grey: Plane<u8>,
    pub edges: Edges,
    pub notes: Notes,
}

impl Strip {
    /// What one takes of a map of so many columns and rows, in images of a width.
    pub fn bytes(columns: usize, rows: usize, width: usize, reach: &Reach) -> usize {
        let rows = Self::height(rows, reach);
        let looks = 2 * Looks::bytes(width, rows, reach.every);
        let pixels = columns * rows;
        let notes = Notes::bytes(pixels);
        looks + Slopes::bytes(columns, rows) + pixels + Edges::bytes(pixels) + notes
    }

    /// How many rows it has where the map has so many.
    fn height(rows: usize, reach: &Reach) -> usize {
        rows.min(Self::rows(rows) + 2 * Self::margin(reach))
    }

    /// How many rows of a map are worked on with it.
    fn rows(rows: usize) -> usize {
        rows.div_ceil((rows / LEAST).max(1))
    }

    /// How many rows beyond these are looked at.
    fn margin(reach: &Reach) -> usize {
        reach.rows() + rows_apart(reach.every)
    }

    /// The rows of a map, in strips.
    pub fn all(rows: usize) -> impl Iterator<Item = Range<usize>> {
        let height = Self::rows(rows);
        (0..rows).step_by(height).map(move |first| first..(first + height).min(rows))
    }

    /// Looks at the images wherever pixels of these rows of a map reach, which has so many columns and rows.
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
        let above = rows.start.saturating_sub(Self::margin(reach));
        self.top = above.min(all - height);
        self.every = reach.every;
        let [base, other] = given.grey;
        let top = given.top + self.every * self.top;
        let lines = top..base.rows().min(top + self.every * height);
        let asked = base.part(given.first..base.columns(), top..base.rows()).every_row(self.every);
        self.grey.reshape(columns, height, 0);
        let rows = self.grey.samples_mut().par_chunks_mut(columns).enumerate();
        rows.for_each(|(y, to)| take_every(reach.every, asked.row(y), to));
        Work::bytes(2 * columns * height)
            + self.base.compute(level, base, lines.clone(), reach.every)
            + self.other.compute(level, other, lines, reach.every)
            + self.edges.compute(level, &self.grey)
    }

    /// Finds the slopes of the map in the rows that were looked at, and notes what is known of its pixels.
    pub fn know(
        &mut self,
        level: Level,
        given: &Given<'_>,
        values: &Plane<f32>,
        certainty: &Plane<u8>,
        reasons: &Plane<Reason>,
    ) -> Work {
        let rows = self.top..self.top + self.grey.rows();
        let Self { top, every, slopes, grey, edges, notes, .. } = self;
        let done = slopes.compute(level, values, *every, rows);
        let doubtful = given.doubtful;
        let sources = Sources { values, certainty, reasons, doubtful, grey, slopes, edges };
        done + notes.take(level, *top, sources)
    }

    /// The row of the map at which it begins.
    pub fn top(&self) -> usize {
        self.top
    }

    /// Where row `y` of the map lies in it.
    #[inline(always)]
    pub fn row(&self, y: usize) -> usize {
        y - self.top
    }

    /// A pixel of the map is every so many-th one of the image.
    pub fn every(&self) -> usize {
        self.every
    }
}

#[cfg(test)]
mod tests {
    use super::super::block::LANES;
    use super::super::notes::{Mark, Noted};
    use super::super::reach::{NARROW, WIDE};
    use super::*;
    use crate::chance::Chance;
    use crate::kernels::aligned::Line;
    use crate::kernels::products::Plain;

    /// Rows of the images above the map.
    const TOP: usize = 7;

    #[test]
    fn what_is_seen_does_not_depend_on_the_strip() {
        for reach in [&NARROW, &WIDE] {
            let every = reach.every;
            let (columns, rows) = (27, 2 * LEAST + 90);
            let mut chance = Chance(8);
            let mut grey = || {
                Plane::from_fn(3 + every * columns, TOP + every * rows, |_, _| chance.bits(8) as u8)
            };
            let [left, right] = [grey(), grey()];
            let values = Plane::from_fn(columns, rows, |_, _| 30.0 * chance.share());
            let given = Given {
                doubtful: &Plane::default(),
                grey: [left.view(), right.view()],
                right: &values,
                first: 3,
                top: TOP,
                least: 0.0,
                most: 60.0,
            };
            let level = Level::detect();
            let certainty = values.map(|&value| value as u8);
            let reasons = values.map(|_| Reason::Matched);
            let (mut slopes, mut edges) = (Slopes::default(), Edges::default());
            let mut notes = Notes::default();
            let mut looks = [Looks::default(), Looks::default()];
            slopes.compute(level, &values, every, 0..rows);
            for (looks, grey) in looks.iter_mut().zip(given.grey) {
                looks.compute(level, grey, TOP..TOP + every * rows, every);
            }
            let grey =
                Plane::from_fn(columns, rows, |x, y| left.row(TOP + every * y)[3 + every * x]);
            edges.compute(level, &grey);
            let sources = Sources {
                values: &values,
                certainty: &certainty,
                reasons: &reasons,
                doubtful: given.doubtful,
                grey: &grey,
                slopes: &slopes,
                edges: &edges,
            };
            notes.take(level, 0, sources);
            let marks = |notes: &Notes, y: usize| -> Vec<Mark> {
                let places = (y * columns..(y + 1) * columns).map(|at| Line([at as u32; LANES]));
                places.map(|at| Noted::of(Plain, notes.samples(), &at).mark(0)).collect()
            };
            let mut strip = Strip::default();
            let mut seen = 0;
            for rows_of_strip in Strip::all(rows) {
                assert_eq!(rows_of_strip.start, seen);
                seen = rows_of_strip.end;
                strip.look(level, &given, reach, values.size(), &rows_of_strip);
                strip.know(level, &given, &values, &certainty, &reasons);
                let reached = rows_of_strip.start.saturating_sub(reach.rows())
                    ..(rows_of_strip.end + reach.rows()).min(rows);
                for y in reached {
                    let row = strip.row(y);
                    assert_eq!(strip.slopes.row(row), slopes.row(y));
                    assert_eq!(marks(&strip.notes, row), marks(&notes, y));
                    assert_eq!(strip.base.row(row), looks[0].row(y));
                    assert_eq!(strip.other.row(row), looks[1].row(y));
                    assert_eq!(strip.grey.row(row), grey.row(y));
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
