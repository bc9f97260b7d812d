//! What adaptive support weights compare pixels by: `rho` of two pixels adds a 3 x 3 census, the grey
//! steps along the row and the grey values, each truncated.
//!
//! ```text
//! rho(a, b) = 5 |census(a) xor census(b)| + min(|step(a) - step(b)|, 20) + min(|I_a - I_b|, 10)
//! ```
//!
//! In: two images. Out: bytes, at most 70, those of a row for one disparity after the other, so that
//! neighbouring columns are compared together and a window of them lies together.

use raster::{Plane, View};
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::prepare::gradient::steps_along_row;
use crate::profile::Work;

/// What one census bit, a grey step and a grey difference count, the last two at most.
const BIT: u8 = 5;
pub(crate) const LARGEST_STEP: u8 = 20;
const LARGEST_GREY: u8 = 10;

/// Operations on bytes per pixel and disparity: words are compared, their bits counted and weighed; two
/// differences of three each are bounded and added.
pub(crate) const OPERATIONS: usize = 3 + 2 * (3 + 2);

/// Columns that are compared together.
pub(crate) const BLOCK: usize = 64;

/// What the pixels of one image are compared by: a row holds census words, then grey steps, then
/// grey values.
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
        self.0.reset(3 * columns, rows, 0);
        let looks = self.0.samples_mut().par_chunks_mut(3 * columns).enumerate();
        looks.for_each(|(y, looks)| {
            let y = first + y;
            let near = [y.saturating_sub(1), y, (y + 1).min(height - 1)].map(|y| image.row(y));
            let (census, rest) = looks.split_at_mut(columns);
            let (steps, grey) = rest.split_at_mut(columns);
            census_of_row(level, near, census);
            steps_along_row(image.row(y), steps);
            grey.copy_from_slice(image.row(y));
        });
        Work::bytes(columns * rows + self.bytes())
    }

    /// Bytes of all parts.
    pub fn bytes(&self) -> usize {
        size_of_val(self.0.samples())
    }

    /// The looks of the same image in a mirror.
    pub fn mirrored(&self, out: &mut Looks) -> Work {
        let columns = self.columns();
        out.0.reset(3 * columns, self.0.rows(), 0);
        let parts = self.0.samples().chunks(columns);
        // In the mirror steps run the other way: so do they in the other image.
        for (to, from) in out.0.samples_mut().chunks_mut(columns).zip(parts) {
            to.copy_from_slice(from);
            to.reverse();
        }
        Work::bytes(self.bytes() + out.bytes())
    }

    pub fn columns(&self) -> usize {
        self.0.columns() / 3
    }

    pub fn rows(&self) -> usize {
        self.0.rows()
    }

    /// The grey values of row `y`.
    #[inline(always)]
    pub fn grey_row(&self, y: usize) -> &[u8] {
        &self.0.row(y)[2 * self.columns()..]
    }

    /// The parts of row `y`.
    pub fn row(&self, y: usize) -> [&[u8]; 3] {
        let row = self.0.row(y);
        let columns = self.columns();
        [0, 1, 2].map(|part| &row[part * columns..][..columns])
    }
}

/// What is compared: a row of one image with that of another one.
pub(crate) struct Comparison<'a> {
    pub base: &'a Looks,
    pub other: &'a Looks,
    pub row: usize,
    /// The first column of `base`, and how many; beyond the ends of an image they are repeated.
    pub start: i64,
    /// A multiple of [`BLOCK`].
    pub columns: usize,
    pub least: i32,
    pub most: i32,
}

/// The memory of a comparison: rows with their ends repeated.
#[derive(Default)]
pub(crate) struct RowsWithEnds {
    base: [Vec<u8>; 3],
    other: [Vec<u8>; 3],
}

impl RowsWithEnds {
    /// `rho` of all columns at the least disparity, then at the next, and so on.
    pub fn compare(&mut self, level: Level, what: &Comparison<'_>, costs: &mut Vec<u8>) {
        let &Comparison { row, start, columns, least, most, .. } = what;
        let disparities = (most - least + 1) as usize;
        for part in 0..3 {
            self.base[part].resize(columns, 0);
            copy_with_ends(what.base.row(row)[part], start, &mut self.base[part]);
            self.other[part].resize(columns + disparities - 1, 0);
            let start = start - i64::from(most);
            copy_with_ends(what.other.row(row)[part], start, &mut self.other[part]);
        }
        let needed = columns * disparities;
        costs.reserve_exact(needed.saturating_sub(costs.len()));
        costs.resize(needed, 0);
        let [base, other] = [&self.base, &self.other].map(|parts| parts.each_ref().map(|p| &p[..]));
        costs_of_row(level, base, other, costs);
    }
}

/// `out[i] = row[start + i]`; beyond its ends the row is repeated.
fn copy_with_ends(row: &[u8], start: i64, out: &mut [u8]) {
    let last = row.len() as i64 - 1;
    for (i, sample) in (start..).zip(out) {
        *sample = row[i.clamp(0, last) as usize];
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

    /// Compares the columns of `base` with those of `other` at all disparities, the largest of which
    /// meets the first columns of `other`.
    fn costs_of_row(base: [&[u8]; 3], other: [&[u8]; 3], costs: &mut [u8]) {
        let stride = base[0].len();
        let most = other[0].len() - stride;
        for (k, costs) in costs.chunks_exact_mut(stride).enumerate() {
            let other = other.map(|part| &part[most - k..][..stride]);
            let [base, other] = [base, other].map(|parts| parts.map(|p| p.as_chunks::<BLOCK>().0));
            for (block, costs) in costs.as_chunks_mut::<BLOCK>().0.iter_mut().enumerate() {
                let [census, step, grey] = base.map(|part| &part[block]);
                let [other_census, other_step, other_grey] = other.map(|part| &part[block]);
                for i in 0..BLOCK {
                    let bits = (census[i] ^ other_census[i]).count_ones() as u8;
                    let step = step[i].abs_diff(other_step[i]).min(LARGEST_STEP);
                    let grey = grey[i].abs_diff(other_grey[i]).min(LARGEST_GREY);
                    costs[i] = BIT * bits + step + grey;
                }
            }
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
    use crate::chance::Chance;

    fn noise(columns: usize, rows: usize, seed: u32) -> Plane<u8> {
        let mut chance = Chance(seed);
        Plane::from_fn(columns, rows, |_, _| chance.bits(8) as u8)
    }

    #[test]
    fn a_case_worked_by_hand() {
        let image = Plane::new(3, 3, vec![1, 9, 2, 3, 4, 5, 8, 7, 6]).unwrap();
        let mut looks = Looks::default();
        for level in Level::available() {
            looks.compute(level, image.view(), 1, 1);
            // Below 3: 1 and its repetition. Below 4: 1, 2 and 3. Below 5: 4 and 2 twice.
            assert_eq!(
                looks.row(0),
                [&[0b1100_0000, 0b1011_0000, 0b0111_0000], &[129, 130, 129], &[3, 4, 5]]
            );
        }
        let mut mirrored = Looks::default();
        looks.mirrored(&mut mirrored);
        assert_eq!(mirrored.row(0)[2], [5, 4, 3]);
    }

    #[test]
    fn costs_are_rho_at_every_level() {
        for (width, start, least, most) in [(100, -5, 0, 20), (150, 30, -7, 9), (3, -5, -70, -68)] {
            for level in Level::available() {
                eprintln!("level {}", level.name());
                let [mut base, mut other] = [Looks::default(), Looks::default()];
                base.compute(level, noise(width, 5, 1).view(), 1, 3);
                other.compute(level, noise(width, 5, 2).view(), 1, 3);
                let columns = 2 * BLOCK;
                let [base, other] = [&base, &other];
                let what = Comparison { base, other, row: 1, start, columns, least, most };
                let mut costs = Vec::new();
                RowsWithEnds::default().compare(level, &what, &mut costs);
                for (i, &cost) in costs.iter().enumerate() {
                    let (u, d) =
                        (start + (i % columns) as i64, least as i64 + (i / columns) as i64);
                    let place = |u: i64| u.clamp(0, width as i64 - 1) as usize;
                    let a = base.row(1).map(|part| i32::from(part[place(u)]));
                    let b = other.row(1).map(|part| i32::from(part[place(u - d)]));
                    let (step, grey) = ((a[1] - b[1]).abs(), (a[2] - b[2]).abs());
                    let rho = 5 * (a[0] ^ b[0]).count_ones() as i32 + step.min(20) + grey.min(10);
                    assert_eq!(i32::from(cost), rho, "column {u}, disparity {d}");
                }
            }
        }
    }
}
