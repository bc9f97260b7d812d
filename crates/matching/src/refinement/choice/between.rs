//! Pixels between those that were asked: where only every second one of every second row is, the others
//! follow the neighbour that they are most like.

use raster::Plane;
use rayon::prelude::*;

use super::block::Given;
use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;

/// A pixel follows a neighbour that had its disparity, within so many pixels, and took another.
const SAME: f32 = 1.0;
/// How far neighbours are alike: so many grey values count as much as a pixel of disparity, and more
/// than so many pixels do not count.
const GREY: f32 = 20.0;
const FAR: f32 = 2.0;

/// A row: its disparities before, its grey values, its disparities now and how sure they are.
#[derive(Clone, Copy)]
struct Row<'a> {
    before: &'a [f32],
    grey: &'a [u8],
    now: &'a [f32],
    certainty: &'a [f32],
}

/// Lets the pixels between those that were asked follow them, in `out` and in `certainty`.
pub(super) fn follow(
    level: Level,
    given: &Given<'_>,
    values: &Plane<f32>,
    certainty: &mut Plane<f32>,
    out: &mut Plane<f32>,
) -> Work {
    let (columns, rows) = values.size();
    let grey = |y: usize| &given.grey[0].row(given.top + y)[given.first..given.first + columns];
    let pairs = out.samples_mut().par_chunks_mut(2 * columns);
    let pairs = pairs.zip(certainty.samples_mut().par_chunks_mut(2 * columns)).enumerate();
    pairs.for_each(|(i, (out, certainty))| {
        let (before, grey) = (values.row(2 * i), grey(2 * i));
        along_row(level, before, grey, &mut out[..columns], &mut certainty[..columns]);
    });
    // Rows between two of which all pixels know.
    for y in (1..rows).step_by(2) {
        let (above, rest) = out.samples_mut().split_at_mut(y * columns);
        let (out, below) = rest.split_at_mut(columns);
        let (above_sure, rest) = certainty.samples_mut().split_at_mut(y * columns);
        let (sure, below_sure) = rest.split_at_mut(columns);
        let last = (y - 1) * columns;
        let above = Row {
            before: values.row(y - 1),
            grey: grey(y - 1),
            now: &above[last..],
            certainty: &above_sure[last..],
        };
        let below = match y + 1 < rows {
            false => above,
            true => Row {
                before: values.row(y + 1),
                grey: grey(y + 1),
                now: &below[..columns],
                certainty: &below_sure[..columns],
            },
        };
        between_rows(level, [above, below], values.row(y), grey(y), out, sure);
    }
    Work::bytes(3 * 4 * columns * rows)
}

/// What a pixel follows: a neighbour's disparity before and now, its grey value and certainty.
type Neighbour = (f32, f32, u8, f32);

/// The disparity and the certainty of a pixel between two.
#[inline(always)]
fn between(neighbours: [Neighbour; 2], before: f32, grey: u8) -> (f32, f32) {
    let [one, other] = neighbours;
    let nearer = unlike(other, before, grey) < unlike(one, before, grey);
    let old = if nearer { other.0 } else { one.0 };
    let new = if nearer { other.1 } else { one.1 };
    let certainty = if nearer { other.3 } else { one.3 };
    let follows = ((old - before).abs() <= SAME) & ((new - old).abs() > SAME);
    (if follows { new } else { before }, certainty)
}

#[inline(always)]
fn unlike(neighbour: Neighbour, before: f32, grey: u8) -> f32 {
    let apart = (neighbour.0 - before).abs();
    let apart = if apart < FAR { apart } else { FAR };
    apart + f32::from(neighbour.2.abs_diff(grey)) / GREY
}

at_every_level! {
    /// Every second pixel of a row, between two that were asked.
    fn along_row(before: &[f32], grey: &[u8], out: &mut [f32], certainty: &mut [f32]) {
        let last = out.len() - 1;
        for x in (1..=last).step_by(2) {
            let [left, right] =
                [x - 1, (x + 1).min(last - last % 2)].map(|u| (before[u], out[u], grey[u], certainty[u]));
            (out[x], certainty[x]) = between([left, right], before[x], grey[x]);
        }
    }

    /// All pixels of a row between two.
    fn between_rows(
        rows: [Row<'_>; 2],
        before: &[f32],
        grey: &[u8],
        out: &mut [f32],
        certainty: &mut [f32],
    ) {
        let columns = out.len();
        let rows = rows.map(|row| Row {
            before: &row.before[..columns],
            grey: &row.grey[..columns],
            now: &row.now[..columns],
            certainty: &row.certainty[..columns],
        });
        let [above, below] = rows;
        let (before, grey, certainty) =
            (&before[..columns], &grey[..columns], &mut certainty[..columns]);
        for x in 0..columns {
            let one = (above.before[x], above.now[x], above.grey[x], above.certainty[x]);
            let other = (below.before[x], below.now[x], below.grey[x], below.certainty[x]);
            (out[x], certainty[x]) = between([one, other], before[x], grey[x]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    /// Two images of one map, of which the left one counts.
    fn follow_all(
        level: Level,
        grey: &Plane<u8>,
        values: &Plane<f32>,
        asked: (&Plane<f32>, &Plane<f32>),
    ) -> [Plane<f32>; 2] {
        let given = Given {
            doubtful: &Plane::default(),
            grey: [grey.view(); 2],
            right: values,
            first: 0,
            top: 0,
            least: 0.0,
            most: 60.0,
        };
        let [mut out, mut certainty] = [asked.0.clone(), asked.1.clone()];
        follow(level, &given, values, &mut certainty, &mut out);
        [out, certainty]
    }

    #[test]
    fn a_pixel_follows_the_neighbour_that_it_is_most_like() {
        // Three grown columns of a board at 9 before a wall at 4. The judge takes back the even one, 4;
        // 3 is the wall's by its grey, 5 is wall already.
        let values = Plane::from_fn(8, 3, |x, _| if x < 5 { 9.0 } else { 4.0 });
        let grey = Plane::from_fn(8, 3, |x, _| if x < 3 { 200 } else { 90 });
        let mut asked = values.clone();
        let mut sure = Plane::filled(8, 3, 1.0);
        for y in [0, 2] {
            asked.row_mut(y)[4] = 4.0;
            sure.row_mut(y)[4] = 0.5;
        }
        for level in Level::available() {
            eprintln!("level {}", level.name());
            let [out, certainty] = follow_all(level, &grey, &values, (&asked, &sure));
            for y in 0..3 {
                assert_eq!(out.row(y), [9.0, 9.0, 9.0, 4.0, 4.0, 4.0, 4.0, 4.0]);
                assert_eq!(certainty.row(y), [1.0, 1.0, 1.0, 0.5, 0.5, 1.0, 1.0, 1.0]);
            }
        }
    }

    #[test]
    fn every_level_follows_alike_and_leaves_those_that_were_asked() {
        for (columns, rows) in [(1, 1), (2, 5), (37, 6), (100, 9)] {
            let mut chance = Chance(columns as u32);
            let mut noise = |most: f32| Plane::from_fn(columns, rows, |_, _| most * chance.share());
            let [values, asked, sure] = [noise(4.0), noise(4.0), noise(1.0)];
            let grey = noise(255.0).map(|&grey| grey as u8);
            let expected = follow_all(Level::available()[0], &grey, &values, (&asked, &sure));
            for (y, x) in
                (0..rows).step_by(2).flat_map(|y| (0..columns).step_by(2).map(move |x| (y, x)))
            {
                assert_eq!(expected[0].row(y)[x], asked.row(y)[x]);
            }
            for level in Level::available() {
                eprintln!("level {}", level.name());
                assert!(follow_all(level, &grey, &values, (&asked, &sure)) == expected);
            }
        }
    }
}
