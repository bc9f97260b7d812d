//! The median of 3 x 3 pixels: lone outliers out, edges kept.
//!
//! In: finite values, borders repeated. Out: one row of medians.

use raster::Plane;
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::kernels::median::{copy_with_ends, rows_around};
use crate::profile::Work;

/// Pixels that are done together.
const BLOCK: usize = 64;

/// The medians of a map without holes.
pub(crate) fn median_of_map(level: Level, values: &Plane<f32>, out: &mut Plane<f32>) -> Work {
    let (columns, rows) = values.size();
    out.reshape(columns, rows, 0.0);
    let rows = out.samples_mut().par_chunks_mut(columns).enumerate();
    rows.for_each(|(y, out)| median_row(level, values, y, out));
    Work::bytes(2 * size_of_val(values.samples()))
}

/// The medians around row `y` of a map without holes; beyond its ends it is repeated.
pub(crate) fn median_row(level: Level, values: &Plane<f32>, y: usize, out: &mut [f32]) {
    median_of_3_rows(level, rows_around(values, y), out);
}

/// The smaller number first.
#[inline(always)]
fn order(a: &mut f32, b: &mut f32) {
    (*a, *b) = if *b < *a { (*b, *a) } else { (*a, *b) };
}

#[inline(always)]
fn sort_3(mut numbers: [f32; 3]) -> [f32; 3] {
    let [a, b, c] = &mut numbers;
    order(a, b);
    order(b, c);
    order(a, b);
    numbers
}

at_every_level! {
    /// Columns are sorted first. The median of nine is that of the largest of their least numbers,
    /// the median of their middle ones and the least of their largest.
    fn median_of_3_rows(rows: [&[f32]; 3], medians: &mut [f32]) {
        let mut near = [[0.0; BLOCK + 2]; 3];
        for (block, medians) in medians.chunks_mut(BLOCK).enumerate() {
            for (row, near) in rows.iter().zip(&mut near) {
                copy_with_ends(row, block * BLOCK, 1, near);
            }
            // Not in place: below AVX-512 the compiler would write what moves, and nothing else.
            let mut sorted = [[0.0; BLOCK + 2]; 3];
            for i in 0..BLOCK + 2 {
                [sorted[0][i], sorted[1][i], sorted[2][i]] =
                    sort_3([near[0][i], near[1][i], near[2][i]]);
            }
            let mut found = [0.0; BLOCK];
            for i in 0..BLOCK {
                let [[_, _, a], [_, b, _], [c, _, _]] =
                    sorted.each_ref().map(|row| sort_3([row[i], row[i + 1], row[i + 2]]));
                found[i] = sort_3([a, b, c])[1];
            }
            medians.copy_from_slice(&found[..medians.len()]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_worked_by_hand() {
        #[rustfmt::skip]
        let values = [
            1.0, 9.0, 2.0,
            3.0, 4.0, 5.0,
            8.0, 7.0, 6.0,
        ];
        let mut out = [0.0; 3];
        median_row(Level::detect(), &Plane::new(3, 3, values.to_vec()).unwrap(), 1, &mut out);
        // Column 0 repeated: 1 1 9 3 3 4 8 8 7 -> 4; all nine -> 5; 9 2 2 4 5 5 7 6 6 -> 5.
        assert_eq!(out, [4.0, 5.0, 5.0]);
    }

    #[test]
    fn medians_are_the_fifth_of_nine_at_every_level() {
        let scramble =
            |x: usize, y: usize| ((x * 7919 + y * 104_729 + x * y * 31) % 97) as f32 / 8.0;
        let values = Plane::from_fn(150, 4, scramble);
        for level in Level::available() {
            eprintln!("level {}", level.name());
            for y in 0..4 {
                let mut out = vec![0.0; 150];
                median_row(level, &values, y, &mut out);
                for (x, found) in out.into_iter().enumerate() {
                    let place = |at: usize, step: usize, end: usize| {
                        (at + step).saturating_sub(1).min(end - 1)
                    };
                    let mut window: [f32; 9] = std::array::from_fn(|i| {
                        values.row(place(y, i / 3, 4))[place(x, i % 3, 150)]
                    });
                    window.sort_by(f32::total_cmp);
                    assert_eq!(found, window[4], "({x}, {y})");
                }
            }
        }
    }
}
