//! Census words (Zabih & Woodfill, ECCV 1994): which neighbours of a pixel are darker than it.
//!
//! A word depends only on the order of grey values, so exposure and gain of the cameras do not
//! matter. The window is 7 columns by 5 rows: 34 bits. Wider ones blur the edges of objects more
//! than they help on blank walls. Beyond the border of the image the nearest pixel is repeated.

use raster::Plane;

use crate::kernels::level::{Level, at_every_level};

/// Columns to each side of the pixel.
pub const REACH_X: usize = 3;
/// Rows above and below the pixel.
pub const REACH_Y: usize = 2;
/// Neighbours that are compared, hence the largest Hamming distance.
pub const BITS: u8 = 34;

at_every_level! {
    /// Appends one bit to each word: is the neighbour darker than the pixel?
    fn append_bits(words: &mut [u64], pixels: &[u16], neighbours: &[u16]) {
        for ((word, &pixel), &neighbour) in words.iter_mut().zip(pixels).zip(neighbours) {
            *word = *word << 1 | u64::from(neighbour < pixel);
        }
    }
}

/// The census words of row `y`, one per column. `scratch` holds rows with repeated ends.
pub fn census_row(
    level: Level,
    image: &Plane<u16>,
    y: usize,
    scratch: &mut Vec<u16>,
    words: &mut [u64],
) {
    let (columns, rows) = image.size();
    words.fill(0);
    let centre = image.row(y);
    for dy in 0..=2 * REACH_Y {
        let row = image.row((y + dy).saturating_sub(REACH_Y).min(rows - 1));
        scratch.clear();
        scratch.extend([row[0]; REACH_X]);
        scratch.extend_from_slice(row);
        scratch.extend([row[columns - 1]; REACH_X]);
        for dx in 0..=2 * REACH_X {
            if (dx, dy) != (REACH_X, REACH_Y) {
                append_bits(level, words, centre, &scratch[dx..dx + columns]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_counts_the_darker_neighbours() {
        let image = Plane::from_fn(9, 7, |x, y| ((x * 37 + y * 91) % 50) as u16);
        for level in Level::available() {
            for y in 0..7 {
                let mut words = [u64::MAX; 9];
                census_row(level, &image, y, &mut Vec::new(), &mut words);
                for (x, word) in words.into_iter().enumerate() {
                    let mut expected = 0u64;
                    for v in y as i64 - 2..=y as i64 + 2 {
                        for u in x as i64 - 3..=x as i64 + 3 {
                            if (u, v) == (x as i64, y as i64) {
                                continue;
                            }
                            let neighbour =
                                image.row(v.clamp(0, 6) as usize)[u.clamp(0, 8) as usize];
                            expected = expected << 1 | u64::from(neighbour < image.row(y)[x]);
                        }
                    }
                    assert_eq!(word, expected, "({x}, {y})");
                }
            }
        }
    }
}
