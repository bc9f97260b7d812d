//! What a pixel looks like: a 3 x 3 census, and the grey step along the row.
//!
//! In: an image. Out: two bytes per pixel of every so many-th row; those of one kind lie side by side in a row, whose
//! ends are repeated for as far as windows see beyond them.

use std::ops::Range;

use raster::{Plane, View};
use rayon::prelude::*;

use super::windows::{APART, rows_apart};
use crate::kernels::level::{Level, at_every_level};
use crate::prepare::gradient::steps_along_row;
use crate::profile::Work;

/// What the pixels of one image are compared by: a row holds census words, then grey steps.
#[derive(Debug, Default)]
pub(crate) struct Looks {
    looks: Plane<u8>,
    /// The pixels of a window stand so many of these rows apart.
    apart: usize,
}

impl Looks {
    /// Looks at every so many-th of these rows of an image, and at the last one again for as far as windows see
    /// beyond it.
    pub fn compute(
        &mut self,
        level: Level,
        image: View<'_, u8>,
        rows: Range<usize>,
        every: usize,
    ) -> Work {
        let (columns, height) = (image.columns(), image.rows());
        self.apart = rows_apart(every);
        let count = rows.len().div_ceil(every) + self.apart;
        let wide = columns + 2 * APART;
        self.looks.reshape(2 * wide, count, 0);
        let looks = self.looks.samples_mut().par_chunks_mut(2 * wide).enumerate();
        looks.for_each(|(y, looks)| {
            let y = (rows.start + every * y).min(rows.end - 1);
            let near = [y.saturating_sub(1), y, (y + 1).min(height - 1)].map(|y| image.row(y));
            let (census, steps) = looks.split_at_mut(wide);
            census_of_row(level, near, &mut census[APART..][..columns]);
            steps_along_row(image.row(y), &mut steps[APART..][..columns]);
            for part in [census, steps] {
                let (first, last) = (part[APART], part[APART + columns - 1]);
                part[..APART].fill(first);
                part[APART + columns..].fill(last);
            }
        });
        Work::bytes(columns * count + size_of_val(self.looks.samples()))
    }

    /// Bytes of the looks of so many rows.
    pub fn bytes(columns: usize, rows: usize, every: usize) -> usize {
        2 * (columns + 2 * APART) * (rows + rows_apart(every))
    }

    pub fn columns(&self) -> usize {
        self.looks.columns() / 2 - 2 * APART
    }

    /// How many of these rows the pixels of a window stand apart.
    pub fn apart(&self) -> usize {
        self.apart
    }

    /// The parts of row `y`, with what is repeated before and after them.
    pub fn row(&self, y: usize) -> [&[u8]; 2] {
        let (census, steps) = self.looks.row(y).split_at(self.looks.columns() / 2);
        [census, steps]
    }
}

at_every_level! {
    /// The census words of the middle one of three rows; ends are repeated.
    fn census_of_row(near: [&[u8]; 3], census: &mut [u8]) {
        let last = census.len() - 1;
        for x in [0, last] {
            let places = [x.saturating_sub(1), x, (x + 1).min(last)];
            census[x] = word(near.map(|row| places.map(|x| row[x])));
        }
        if last < 2 {
            return;
        }
        let [above, here, below] = near.map(|row| [0, 1, 2].map(|x| &row[x..][..last - 1]));
        for (x, word_of) in census[1..last].iter_mut().enumerate() {
            *word_of = word([
                [above[0][x], above[1][x], above[2][x]],
                [here[0][x], here[1][x], here[2][x]],
                [below[0][x], below[1][x], below[2][x]],
            ]);
        }
    }
}

/// The census word of the middle one of 3 x 3 pixels.
#[inline(always)]
fn word(pixels: [[u8; 3]; 3]) -> u8 {
    let mut bits = 0;
    for i in 0..9 {
        if i != 4 {
            bits = bits << 1 | u8::from(pixels[i / 3][i % 3] < pixels[1][1]);
        }
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_worked_by_hand() {
        let image = Plane::new(3, 3, vec![1, 9, 2, 3, 4, 5, 8, 7, 6]).unwrap();
        let mut looks = Looks::default();
        for level in Level::available() {
            looks.compute(level, image.view(), 1..2, 1);
            let [census, steps] = looks.row(0).map(|part| &part[APART..][..3]);
            // Below 3: 1 and its repetition. Below 4: 1, 2 and 3. Below 5: 4 and 2 twice.
            assert_eq!(census, [0b1100_0000, 0b1011_0000, 0b0111_0000]);
            assert_eq!(steps, [129, 130, 129]);
            for part in looks.row(0) {
                assert_eq!([part[0], part[1]], [part[2]; 2], "the ends are repeated");
                assert_eq!([part[5], part[6]], [part[4]; 2]);
            }
        }
    }
}
