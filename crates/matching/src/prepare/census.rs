//! Census words (Zabih & Woodfill, ECCV 1994): which neighbours of a pixel are darker than it.
//!
//! A word depends only on the order of grey values, so exposure and gain of the cameras do not
//! matter. The window is 9 columns by 7 rows: 62 bits. Beyond the border of the image the nearest
//! pixel is repeated.

use raster::Plane;

use crate::kernels::level::{Level, at_every_level};

/// Columns to each side of the pixel.
pub const REACH_X: usize = 4;
/// Rows above and below the pixel.
pub const REACH_Y: usize = 3;
/// Neighbours that are compared, hence the largest Hamming distance.
pub const BITS: u8 = 62;

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
