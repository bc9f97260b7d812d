//! Columns between those that were asked: where only every second one is, the others follow the neighbour that
//! they are most like.

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

/// Lets the pixels of a map, which had the disparities `values`, follow those of their row that were asked, in
/// `out` and in `certainty`. The map has every so many-th row of the image.
pub(super) fn follow(
    level: Level,
    every: usize,
    given: &Given<'_>,
    values: &Plane<f32>,
    asked: (&Plane<f32>, &Plane<u8>),
    certainty: &mut Plane<u8>,
    out: &mut Plane<f32>,
) -> Work {
    let (columns, rows) = values.size();
    let out = out.samples_mut().par_chunks_mut(columns);
    let out = out.zip(certainty.samples_mut().par_chunks_mut(columns)).enumerate();
    out.for_each(|(y, (out, certainty))| {
        let grey = given.grey[0].row(given.top + every * y);
        let before = (values.row(y), &grey[given.first..given.first + columns]);
        along_row(level, before, (asked.0.row(y), asked.1.row(y)), out, certainty);
    });
    Work::bytes((2 * 4 + 1) * columns * rows)
}

/// What a pixel follows: a neighbour's disparity before and now, its grey value and certainty.
type Neighbour = (f32, f32, u8, u8);

/// The disparity and the certainty of a pixel between two.
#[inline(always)]
fn between(neighbours: [Neighbour; 2], before: f32, grey: u8) -> (f32, u8) {
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

/// Pixels that are worked on together, as copies: the compiler then knows that nothing overlaps.
const GROUP: usize = 64;

/// Every second column from `at` on, and those two further on.
#[inline(always)]
fn pairs<T: Copy>(row: &[T], at: usize) -> [[T; GROUP / 2]; 2] {
    let row = &row[at..=at + GROUP];
    [0, 2].map(|first| std::array::from_fn(|i| row[first + 2 * i]))
}

/// Columns from `at` on, and those one further on.
#[inline(always)]
fn neighbours<T: Copy>(row: &[T], at: usize) -> [[T; GROUP / 2]; 2] {
    let row = &row[at..=at + GROUP / 2];
    [0, 1].map(|first| std::array::from_fn(|i| row[first + i]))
}

/// The columns between them.
#[inline(always)]
fn betweens<T: Copy>(row: &[T], at: usize) -> [T; GROUP / 2] {
    let row = &row[at..=at + GROUP];
    std::array::from_fn(|i| row[1 + 2 * i])
}

/// Puts a whole group into a row.
#[inline(always)]
fn put<T: Copy>(group: &[T; GROUP], row: &mut [T], at: usize) {
    *row[at..].first_chunk_mut().expect("there is a whole group") = *group;
}

at_every_level! {
    /// A row of which every second pixel was asked. `was` are its disparities before, and grey.
    fn along_row(
        was: (&[f32], &[u8]),
        asked: (&[f32], &[u8]),
        out: &mut [f32],
        certainty: &mut [u8],
    ) {
        let ((before, grey), (now, sure)) = (was, asked);
        let mut at = 0;
        while at + GROUP < out.len() {
            let ([one, other], old) = (pairs(before, at), betweens(before, at));
            let [new, new_after] = neighbours(now, at / 2);
            let ([shade, shade_after], own) = (pairs(grey, at), betweens(grey, at));
            let [sure, sure_after] = neighbours(sure, at / 2);
            let (mut found, mut told) = ([0.0; GROUP], [0; GROUP]);
            for i in 0..GROUP / 2 {
                let left = (one[i], new[i], shade[i], sure[i]);
                let right = (other[i], new_after[i], shade_after[i], sure_after[i]);
                (found[2 * i], told[2 * i]) = (new[i], sure[i]);
                (found[2 * i + 1], told[2 * i + 1]) = between([left, right], old[i], own[i]);
            }
            put(&found, out, at);
            put(&told, certainty, at);
            at += GROUP;
        }
        for x in at..out.len() {
            let near = [x / 2, x.div_ceil(2).min(now.len() - 1)];
            let [left, right] = near.map(|u| (before[2 * u], now[u], grey[2 * u], sure[u]));
            (out[x], certainty[x]) = match x % 2 {
                0 => (left.1, left.3),
                _ => between([left, right], before[x], grey[x]),
            };
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
        asked: (&Plane<f32>, &Plane<u8>),
    ) -> (Plane<f32>, Plane<u8>) {
        let given = Given {
            doubtful: &Plane::default(),
            grey: [grey.view(); 2],
            right: values,
            first: 0,
            top: 0,
            least: 0.0,
            most: 60.0,
        };
        let mut out = values.map(|_| f32::NAN);
        let mut certainty = values.map(|_| 0);
        follow(level, 2, &given, values, asked, &mut certainty, &mut out);
        (out, certainty)
    }

    #[test]
    fn a_pixel_follows_the_neighbour_that_it_is_most_like() {
        // Three grown columns of a board at 9 before a wall at 4. The judge takes back the even one, 4;
        // 3 is the wall's by its grey, 5 is wall already.
        let values = Plane::from_fn(8, 3, |x, _| if x < 5 { 9.0 } else { 4.0 });
        let grey = Plane::from_fn(8, 5, |x, _| if x < 3 { 200 } else { 90 });
        let asked = Plane::from_fn(4, 3, |x, _| if x < 2 { 9.0 } else { 4.0 });
        let sure = Plane::from_fn(4, 3, |x, _| if x == 2 { 90 } else { 200 });
        for level in Level::available() {
            eprintln!("level {}", level.name());
            let (out, certainty) = follow_all(level, &grey, &values, (&asked, &sure));
            for y in 0..3 {
                assert_eq!(out.row(y), [9.0, 9.0, 9.0, 4.0, 4.0, 4.0, 4.0, 4.0]);
                assert_eq!(certainty.row(y), [200, 200, 200, 90, 90, 200, 200, 200]);
            }
        }
    }

    #[test]
    fn every_level_and_number_of_threads_follows_alike_and_leaves_those_that_were_asked() {
        for (columns, rows) in [(1, 1), (2, 5), (37, 6), (100usize, 9)] {
            let mut chance = Chance(columns as u32);
            let of_asked = (columns.div_ceil(2), rows);
            let mut noise = |(columns, rows), most: f32| {
                Plane::from_fn(columns, rows, |_, _| most * chance.share())
            };
            let [values, asked] = [noise((columns, rows), 4.0), noise(of_asked, 4.0)];
            let [grey, sure] = [noise((columns, 2 * rows), 255.0), noise(of_asked, 255.0)]
                .map(|noise| noise.map(|&n| n as u8));
            let expected = follow_all(Level::available()[0], &grey, &values, (&asked, &sure));
            for (y, x) in (0..rows).flat_map(|y| (0..columns).step_by(2).map(move |x| (y, x))) {
                assert_eq!(expected.0.row(y)[x], asked.row(y)[x / 2]);
                assert_eq!(expected.1.row(y)[x], sure.row(y)[x / 2]);
            }
            for level in Level::available() {
                eprintln!("level {}", level.name());
                for threads in 1..=4 {
                    let pool =
                        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                    let found = pool.install(|| follow_all(level, &grey, &values, (&asked, &sure)));
                    assert!(found == expected, "{columns} x {rows}, {threads} threads");
                }
            }
        }
    }
}
