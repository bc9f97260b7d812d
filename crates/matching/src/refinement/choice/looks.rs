//! What a pixel looks like: a 3 x 3 census, and the grey step along the row.
//!
//! In: an image. Out: two bytes per pixel; those of one kind lie side by side in a row.

use raster::{Plane, View};
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::prepare::gradient::steps_along_row;
use crate::profile::Work;

/// What the pixels of one image are compared by: a row holds census words, then grey steps.
#[derive(Debug, Default)]
pub(crate) struct Looks(Plane<u8>);

impl Looks {
    /// Looks at rows `first..first + rows` of an image.
    pub fn compute(
        &mut self,
        level: Level,
        image: View<'_, u8>,
        first: usize,
        rows: usize,
    ) -> Work {
        let (columns, height) = (image.columns(), image.rows());
        self.0.reshape(2 * columns, rows, 0);
        let looks = self.0.samples_mut().par_chunks_mut(2 * columns).enumerate();
        looks.for_each(|(y, looks)| {
            let y = first + y;
            let near = [y.saturating_sub(1), y, (y + 1).min(height - 1)].map(|y| image.row(y));
            let (census, steps) = looks.split_at_mut(columns);
            census_of_row(level, near, census);
            steps_along_row(image.row(y), steps);
        });
        Work::bytes(columns * rows + self.bytes())
    }

    /// Bytes of all parts.
    pub fn bytes(&self) -> usize {
        size_of_val(self.0.samples())
    }

    pub fn columns(&self) -> usize {
        self.0.columns() / 2
    }

    pub fn rows(&self) -> usize {
        self.0.rows()
    }

    /// The parts of row `y`.
    pub fn row(&self, y: usize) -> [&[u8]; 2] {
        let (census, steps) = self.0.row(y).split_at(self.columns());
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
            looks.compute(level, image.view(), 1, 1);
            // Below 3: 1 and its repetition. Below 4: 1, 2 and 3. Below 5: 4 and 2 twice.
            assert_eq!(looks.row(0), [&[0b1100_0000, 0b1011_0000, 0b0111_0000], &[129, 130, 129]]);
        }
    }
}
