//! Census words (Zabih & Woodfill, ECCV 1994): which neighbours of a pixel are darker than it.
//!
//! A word depends only on the order of grey values, so exposure and gain of the cameras do not
//! matter. The window is 7 columns by 5 rows without two opposite corners: 32 bits. Wider ones blur
//! the edges of objects more than they help on blank walls. Beyond the border of the image the
//! nearest pixel is repeated.
//!
//! Where a pixel stands for itself, the next one, and both of the next row, every second column of the window is
//! that of the next row's pixel, and every second row that of the next column's: no pixel's noise is then in all
//! bits.

use crate::kernels::level::{Level, at_every_level};
use crate::prepare::grey::GreyView;

/// Columns to each side of the pixel.
const REACH_X: usize = 3;
/// Rows above and below the pixel.
const REACH_Y: usize = 2;
const ROWS: usize = 2 * REACH_Y + 1;
/// Of a row and the next.
const ROWS_OF_PAIR: usize = ROWS + 1;
/// Neighbours that are compared, hence the largest Hamming distance.
pub(crate) const BITS: u8 = 32;
/// Operations on bytes per pixel: each bit is a comparison of 16 bits that goes into a word of 32.
pub(crate) const OPERATIONS: usize = BITS as usize * (2 + 4);

/// Whether the neighbour at this place in the window has a bit.
const fn has_bit(dx: usize, dy: usize) -> bool {
    let centre = dx == REACH_X && dy == REACH_Y;
    let corner = (dx == 0 && dy == 0) || (dx == 2 * REACH_X && dy == 2 * REACH_Y);
    !centre && !corner
}

/// The rows around a pixel's row, their ends repeated.
#[derive(Default)]
pub(crate) struct CensusRows([Vec<u16>; ROWS_OF_PAIR]);

impl CensusRows {
    /// The census words of row `y`, one per column; or of that row and the next, and of columns and the next, if
    /// these are `pairs`.
    pub fn words(
        &mut self,
        level: Level,
        image: GreyView<'_>,
        y: usize,
        pairs: bool,
        words: &mut [u32],
    ) {
        let (columns, rows) = image.size();
        let padded = columns.next_multiple_of(LANES) + 2 * REACH_X + 1;
        let needed = if pairs { ROWS_OF_PAIR } else { ROWS };
        for (dy, to) in self.0[..needed].iter_mut().enumerate() {
            let from = (y + dy).saturating_sub(REACH_Y).min(rows - 1);
            to.resize(padded, 0);
            let middle = &mut to[REACH_X..REACH_X + columns];
            match image {
                GreyView::Depth8(view) => widened(level, view.row(from), middle),
                GreyView::Depth16(view) => middle.copy_from_slice(view.row(from)),
            }
            let (first, last) = (middle[0], middle[columns - 1]);
            to[..REACH_X].fill(first);
            to[REACH_X + columns..].fill(last);
        }
        let window = |first: usize| std::array::from_fn(|dy| &self.0[first + dy][..]);
        let next = usize::from(pairs);
        words_of_row(level, [window(0), window(next)], next, words);
    }
}

/// Pixels that are done together.
const LANES: usize = 32;

at_every_level! {
    fn widened(from: &[u8], to: &mut [u16]) {
        for (to, &sample) in to.iter_mut().zip(from) {
            *to = sample.into();
        }
    }

    /// Is the neighbour darker than the pixel? One bit each, in the order of reading; of the first window in even
    /// columns, of the second in odd ones, which both lie `next` columns further on in odd rows.
    fn words_of_row(windows: [[&[u16]; ROWS]; 2], next: usize, words: &mut [u32]) {
        for (block, words) in words.chunks_mut(LANES).enumerate() {
            let lanes = |rows: &[&[u16]; ROWS], dx: usize, dy: usize| -> [u16; LANES] {
                *rows[dy][block * LANES + dx..].first_chunk().expect("rows are padded")
            };
            let pixel = |rows, next: usize| lanes(rows, REACH_X + next, REACH_Y);
            let [above, below] = &windows;
            // Written out: `map` would not be compiled for the level.
            let pixels =
                [[pixel(above, 0), pixel(above, next)], [pixel(below, 0), pixel(below, next)]];
            let mut word = [0u32; LANES];
            for dy in 0..ROWS {
                for dx in 0..=2 * REACH_X {
                    if has_bit(dx, dy) {
                        let neighbours = lanes(&windows[dx % 2], dx + dy % 2 * next, dy);
                        let pixels = &pixels[dx % 2][dy % 2];
                        for i in 0..LANES {
                            word[i] = word[i] << 1 | u32::from(neighbours[i] < pixels[i]);
                        }
                    }
                }
            }
            words.copy_from_slice(&word[..words.len()]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::Plane;

    const HEIGHT: usize = 7;

    /// The word of a pixel, bit by bit.
    fn definition(image: &Plane<u16>, (x, y): (usize, usize), pairs: bool) -> u32 {
        let at = |u: i64, v: i64| {
            let (last_column, last_row) = (image.columns() as i64 - 1, image.rows() as i64 - 1);
            image.row(v.clamp(0, last_row) as usize)[u.clamp(0, last_column) as usize]
        };
        let mut word = 0;
        for dy in -2..=2 {
            for dx in -3..=3 {
                if [(0, 0), (-3, -2), (3, 2)].contains(&(dx, dy)) {
                    continue;
                }
                // -3, -1, 1 and 3 are columns 0, 2, 4 and 6 of the window.
                // As -1 and 1 are rows 1 and 3.
                let x = x as i64 + i64::from(pairs && dy % 2 != 0);
                let y = y as i64 + i64::from(pairs && dx % 2 == 0);
                word = word << 1 | u32::from(at(x + dx, y + dy) < at(x, y));
            }
        }
        word
    }

    fn check(level: Level, rows: &mut CensusRows, image: &Plane<u16>, view: GreyView<'_>) {
        for (y, pairs) in (0..HEIGHT).flat_map(|y| [(y, false), (y, true)]) {
            let mut words = vec![u32::MAX; image.columns()];
            rows.words(level, view, y, pairs, &mut words);
            for (x, word) in words.into_iter().enumerate() {
                let expected = definition(image, (x, y), pairs);
                assert_eq!(word, expected, "({x}, {y}) of {} columns, {pairs}", image.columns());
            }
        }
    }

    #[test]
    fn a_word_counts_the_darker_neighbours_at_every_level() {
        let scramble = |x: usize, y: usize| x * 7919 + y * 104_729 + x * x * y * 31 + x * x * 17;
        for level in Level::available() {
            eprintln!("level {}", level.name());
            // The memory of one width serves the next.
            let mut rows = CensusRows::default();
            for columns in [100, 1, 9, 31, 32, 33] {
                // Few grey values, so that neighbours are equal too.
                let narrow = Plane::from_fn(columns, HEIGHT, |x, y| (scramble(x, y) % 50) as u8);
                let image = narrow.map(|&grey| grey.into());
                check(level, &mut rows, &image, GreyView::Depth8(narrow.view()));
                let wide = Plane::from_fn(columns, HEIGHT, |x, y| scramble(x, y) as u16);
                check(level, &mut rows, &wide, GreyView::Depth16(wide.view()));
            }
        }
    }
}
