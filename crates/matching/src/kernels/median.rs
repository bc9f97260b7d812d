//! The median of 5 x 5 pixels.
//!
//! In: five rows of 16-bit numbers. Out: one row of medians, the rows' ends repeated.
//!
//! Columns of five are sorted first, once for the five windows that share them. In a window the
//! five least, the five second least, and so on, are then sorted among themselves, which leaves
//! the columns sorted. Now number `j` of column `i` has `(i + 1)(j + 1) - 1` others at or below it
//! and `(5 - i)(5 - j) - 1` at or above; where either is more than 12 it cannot be the median, and
//! as many fall out below as above. Of the 13 that are left the median is the median of all. How
//! they lie to each other is known in part, so 17 comparisons find it: a search for few of them
//! through the 252 ways in which zeros and ones can stand in sorted columns came to this network.

use raster::Plane;

use super::border::repeat_border;
use super::level::at_every_level;

/// Pixels that are done together.
const BLOCK: usize = 128;
/// Pixels to each side of the middle one.
pub(crate) const REACH: usize = 2;
pub(crate) const SIDE: usize = 2 * REACH + 1;

/// Operations on bytes per pixel of 16 bits: 71 pairs are put in order by a minimum and what it leaves, of
/// which 28 are never looked at.
pub(crate) const OPERATIONS: usize = (2 * 71 - 28) * 2;

/// Columns that the windows of a block hold.
const WIDE: usize = BLOCK + 2 * REACH;

/// Row `y` of a map between as many above as below it, `N` together; beyond the map's ends they are repeated.
pub(crate) fn rows_around<T, const N: usize>(map: &Plane<T>, y: usize) -> [&[T]; N] {
    std::array::from_fn(|i| map.row((y + i).saturating_sub(N / 2).min(map.rows() - 1)))
}

at_every_level! {
    /// The medians around the third of the rows, which are equally long.
    pub(crate) fn median_of_5_rows(rows: [&[u16]; SIDE], medians: &mut [u16]) {
        // Not cleared for every block, most of which need none of the other two.
        let mut sorted = [[0; WIDE]; SIDE];
        let (mut near, mut found) = ([[0; WIDE]; SIDE], [0; BLOCK]);
        for (block, medians) in medians.chunks_mut(BLOCK).enumerate() {
            let start = block * BLOCK;
            let is_inside = start >= REACH && start + BLOCK + REACH <= rows[0].len();
            match medians.as_mut_array() {
                Some(medians) if is_inside => {
                    let [a, b, c, d, e] = rows;
                    let [a, b, c] = [wide(a, start), wide(b, start), wide(c, start)];
                    let near = [a, b, c, wide(d, start), wide(e, start)];
                    medians_of_block(near, &mut sorted, medians);
                }
                _ => {
                    for (row, near) in rows.iter().zip(&mut near) {
                        copy_with_ends(row, start, REACH, near);
                    }
                    medians_of_block(near.each_ref(), &mut sorted, &mut found);
                    medians.copy_from_slice(&found[..medians.len()]);
                }
            }
        }
    }
}

/// The medians of the windows whose first columns are the first of these rows.
#[inline(always)]
fn medians_of_block(
    [a, b, c, d, e]: [&[u16; WIDE]; SIDE],
    sorted: &mut [[u16; WIDE]; SIDE],
    medians: &mut [u16; BLOCK],
) {
    // In place, the compiler might not see that columns do not depend on each other.
    for i in 0..WIDE {
        let mut column = [a[i], b[i], c[i], d[i], e[i]];
        sort_5(&mut column);
        [sorted[0][i], sorted[1][i], sorted[2][i], sorted[3][i], sorted[4][i]] = column;
    }
    for i in 0..BLOCK {
        let mut window = [[0; SIDE]; SIDE];
        for rank in 0..SIDE {
            for column in 0..SIDE {
                window[rank][column] = sorted[rank][i + column];
            }
        }
        medians[i] = median_of_sorted_columns(window);
    }
}

/// The columns of a block that has others on both sides, and those.
#[inline(always)]
fn wide(row: &[u16], start: usize) -> &[u16; WIDE] {
    row[start - REACH..].first_chunk().expect("columns on both sides")
}

/// Copies the samples of a row from `reach` before `start` on; its ends are repeated.
#[inline(always)]
pub(crate) fn copy_with_ends<T: Copy, const N: usize>(
    row: &[T],
    start: usize,
    reach: usize,
    block: &mut [T; N],
) {
    if start >= reach && start - reach + N <= row.len() {
        block.copy_from_slice(&row[start - reach..][..N]);
    } else {
        repeat_border(row, start as i64 - reach as i64, block);
    }
}

/// The smaller number first. The larger one is what is left of both: for that operation processors have more
/// units than for a maximum where it is one (AVX-512).
#[inline(always)]
fn order(a: &mut u16, b: &mut u16) {
    let least = (*a).min(*b);
    (*a, *b) = (least, *a ^ *b ^ least);
}

/// Nine comparisons sort five numbers.
#[inline(always)]
fn sort_5([a, b, c, d, e]: &mut [u16; SIDE]) {
    order(a, d);
    order(b, e);
    order(a, c);
    order(b, d);
    order(a, b);
    order(c, e);
    order(b, c);
    order(d, e);
    order(c, d);
}

/// The median of five sorted columns: `window[rank][column]`.
#[inline(always)]
fn median_of_sorted_columns(mut window: [[u16; SIDE]; SIDE]) -> u16 {
    // Written out: a loop of so much is not unrolled in time for pixels to be done side by side.
    let [a, b, c, d, e] = &mut window;
    sort_5(a);
    sort_5(b);
    sort_5(c);
    sort_5(d);
    sort_5(e);
    let [[.., mut a3, mut a4], [.., mut b2, mut b3, mut b4], [_, mut c1, mut c2, mut c3, _], ..] =
        window;
    let [.., [mut d0, mut d1, mut d2, ..], [mut e0, mut e1, ..]] = window;
    // Each of these moves numbers below the median down or numbers above it up, whichever they are.
    order(&mut a3, &mut c1);
    order(&mut b3, &mut c2);
    order(&mut b3, &mut d1);
    order(&mut b2, &mut d0);
    order(&mut a4, &mut d1);
    order(&mut b4, &mut d2);
    order(&mut c2, &mut e0);
    order(&mut c3, &mut e1);
    order(&mut d1, &mut e0);
    order(&mut a4, &mut c2);
    order(&mut c1, &mut d0);
    order(&mut c2, &mut b3);
    order(&mut b4, &mut c3);
    order(&mut b3, &mut b4);
    order(&mut b4, &mut d1);
    order(&mut b3, &mut d0);
    order(&mut b4, &mut d0);
    b4
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::kernels::level::Level;

    #[test]
    fn the_network_finds_the_median_of_all_that_can_be() {
        // A network of comparisons that is right for zeros and ones is right for all numbers
        // (Knuth's zero-one principle); a sorted column of those is known by its ones.
        for code in 0..6usize.pow(5) {
            let ones: [usize; 5] = std::array::from_fn(|i| code / 6usize.pow(i as u32) % 6);
            let window = std::array::from_fn(|rank| {
                std::array::from_fn(|column| u16::from(rank >= 5 - ones[column]))
            });
            let expected = u16::from(ones.iter().sum::<usize>() > 12);
            assert_eq!(median_of_sorted_columns(window), expected, "{ones:?}");
        }
        for code in 0..32u16 {
            let mut bits = std::array::from_fn(|i| code >> i & 1);
            sort_5(&mut bits);
            assert!(bits.is_sorted(), "{code:b}");
        }
    }

    #[test]
    fn medians_are_those_of_sorted_windows_at_every_level() {
        for level in Level::available() {
            eprintln!("level {}", level.name());
            for columns in [1, 2, 3, 64, 127, 128, 129, 130, 131, 300] {
                let mut chance = Chance(columns as u32);
                let rows: [Vec<u16>; 5] = std::array::from_fn(|_| {
                    let next = |_| chance.bits(16) as u16;
                    (0..columns).map(next).collect()
                });
                let mut found = vec![0; columns];
                median_of_5_rows(level, rows.each_ref().map(|row| &row[..]), &mut found);
                for (x, &found) in found.iter().enumerate() {
                    let near = |row: &Vec<u16>| -> Vec<u16> {
                        let at = |i: usize| row[(x + i).saturating_sub(2).min(columns - 1)];
                        (0..5).map(at).collect()
                    };
                    let mut window: Vec<u16> = rows.iter().flat_map(near).collect();
                    window.sort();
                    assert_eq!(found, window[12], "column {x} of {columns}");
                }
            }
        }
    }
}
