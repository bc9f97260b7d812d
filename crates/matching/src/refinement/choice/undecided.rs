//! Which pixels look at their candidates: those that are not settled.

use raster::Reason;

use super::block::Scene;
use super::reach::Reach;
use super::slopes::continued;
use crate::kernels::level::at_every_level;

/// The column and the row of a pixel in the map.
pub(super) type At = [i32; 2];

/// Neighbours that are looked at together.
const TOGETHER: usize = 32;

at_every_level! {
    /// Finds those among the marked pixels of some rows, from row `first` on: matches that were never in doubt and
    /// whose inner rings agree are settled. They come to lie at the beginning of `found`; how many says the result.
    pub(super) fn undecided(
        scene: &Scene<'_>,
        reach: &Reach,
        first: usize,
        marks: &[bool],
        found: &mut [At],
    ) -> usize {
        let columns = scene.values.columns();
        let mut count = 0;
        for (y, marks) in (first..).zip(marks.chunks_exact(columns)) {
            for (i, marks) in marks.chunks(TOGETHER).enumerate() {
                let (mut asked, mut any) = ([0; TOGETHER], 0);
                for (asked, &marked) in asked.iter_mut().zip(marks) {
                    *asked = u8::from(marked);
                    any |= *asked;
                }
                if any == 0 {
                    continue;
                }
                let x = TOGETHER * i;
                for (asked, undecided) in asked.iter_mut().zip(undecided_from(scene, reach, (x, y))) {
                    *asked &= undecided;
                }
                for (i, asked) in asked.as_chunks().0.iter().enumerate() {
                    let mut left = u64::from_le_bytes(*asked);
                    while left != 0 {
                        let l = 8 * i + left.trailing_zeros() as usize / 8;
                        found[count] = [(x + l) as i32, y as i32];
                        count += 1;
                        left &= left - 1;
                    }
                }
            }
        }
        count
    }
}

/// 1 for those of the pixels from `(x, y)` on that are not settled, else 0.
#[inline(always)]
pub(super) fn undecided_from(
    scene: &Scene<'_>,
    reach: &Reach,
    (x, y): (usize, usize),
) -> [u8; TOGETHER] {
    let (columns, rows) = scene.values.size();
    let (least, most) = (scene.given.least, scene.given.most);
    let here: [f32; TOGETHER] = run(scene.values.row(y), x as i64);
    let (mut smallest, mut largest) = (here, here);
    for l in 0..TOGETHER {
        smallest[l] = if here[l] > most { most } else { here[l] };
        largest[l] = if here[l] < least { least } else { here[l] };
    }
    let mut ends = ([0.0; TOGETHER], [[0; 2]; TOGETHER]);
    // The first one is the pixel itself.
    for place in &reach.places[1..reach.inner] {
        let (u, row) = place.seen_from(x, y, rows);
        let Some(v) = row else { continue };
        let values = run_in(scene.values.row(v), u, &mut ends.0);
        let slopes = run_in(scene.strip.slopes.row(scene.strip.row(v)), u, &mut ends.1);
        let way = place.pixels(reach.every);
        // Which of them lie inside the map.
        let inside = [-u, columns as i64 - u].map(|end| end.clamp(0, TOGETHER as i64) as u32);
        for l in 0..TOGETHER {
            let is_inside = (l as u32 >= inside[0]) & ((l as u32) < inside[1]);
            let d = continued((values[l], slopes[l]), way, is_inside, here[l], [least, most]);
            smallest[l] = if d < smallest[l] { d } else { smallest[l] };
            largest[l] = if d > largest[l] { d } else { largest[l] };
        }
    }
    let reasons: [Reason; TOGETHER] = run(scene.reasons.row(y), x as i64);
    let doubtful = match scene.given.doubtful.samples() {
        [] => [false; TOGETHER],
        _ => run(scene.given.doubtful.row(y), x as i64),
    };
    let mut undecided = [0; TOGETHER];
    for l in 0..TOGETHER {
        let in_doubt = (reasons[l] != Reason::Matched) | doubtful[l];
        undecided[l] = u8::from(in_doubt | (largest[l] - smallest[l] > reach.settled));
    }
    undecided
}

/// The samples of a row from `start` on; beyond its ends the row is repeated.
#[inline(always)]
fn run<T: Copy, const N: usize>(row: &[T], start: i64) -> [T; N] {
    *run_in(row, start, &mut [row[0]; N])
}

/// The same where they lie, or else in `end`. Copied to the stack first, many of them are waited for: how long
/// depends on whether the copy lies across two cache lines.
#[inline(always)]
fn run_in<'a, T: Copy, const N: usize>(
    row: &'a [T],
    start: i64,
    end: &'a mut [T; N],
) -> &'a [T; N] {
    match row.get(start as usize..).and_then(|row| row.first_chunk()) {
        Some(run) => run,
        None => {
            *end = run_at_end(row, start);
            end
        }
    }
}

#[cold]
#[inline(never)]
fn run_at_end<T: Copy, const N: usize>(row: &[T], start: i64) -> [T; N] {
    let length = row.len() as i64;
    let [from, to] = [start, start + N as i64].map(|end| end.clamp(0, length) as usize);
    if from == to {
        return [row[if start < 0 { 0 } else { row.len() - 1 }]; N];
    }
    let before = (from as i64 - start) as usize;
    let mut run = [row[to - 1]; N];
    run[..before].fill(row[from]);
    run[before..][..to - from].copy_from_slice(&row[from..to]);
    run
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_repeat_the_ends_of_a_row() {
        for length in [1, 5, TOGETHER, 40] {
            let row: Vec<usize> = (0..length).collect();
            for start in -40..60 {
                let expected: [usize; TOGETHER] = std::array::from_fn(|l| {
                    (start + l as i64).clamp(0, length as i64 - 1) as usize
                });
                assert_eq!(run(&row, start), expected, "from {start} of {length}");
            }
        }
    }
}
