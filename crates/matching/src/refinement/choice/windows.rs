//! How a pixel fits a match: what lies around it, in words that are compared at once.
//!
//! A pixel's window is two words: one of census bytes, those of eight pixels around it two columns and rows
//! apart, and one of its own census byte and of the grey steps of itself and the four nearest of the eight.
//! Beyond the ends of an image its pixels are repeated.

use super::block::LANES;
use super::looks::Looks;
use super::taken;
use crate::cost::census_gradient::LARGEST_STEP;
use crate::kernels::aligned::Line;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::products::Sums;
use crate::kernels::records::{Places, Record, Records};
use crate::kernels::unlike::{Unlike, Words};

/// The pixels of a window stand so far apart.
pub(super) const APART: usize = 2;
/// Steps in a window.
pub(super) const STEPS: u32 = 5;
/// The census bits in a window.
pub(super) const BITS: u32 = 9 * 8;
/// The bits of the second word that hold the own census byte, and those that hold steps.
const OWN_BYTE: u64 = 0xff;
const STEP_BYTES: u64 = 0xffff_ffff_ff00;
/// Where a grey value does not change along its row.
const FLAT: u8 = 128;
/// Steps beyond this are as much texture as this.
const LARGEST_TEXTURE: u8 = 32;

/// How many rows apart they are where every so many-th row is looked at.
pub(super) fn rows_apart(every: usize) -> usize {
    debug_assert!(APART.is_multiple_of(every), "windows see no row that is not looked at");
    APART / every
}

/// The windows of pixels, or of their matches.
#[derive(Clone, Copy, Default)]
pub(super) struct Several {
    census: Words,
    own_and_steps: Words,
}

/// How well windows fit: numbers of bits and of grey levels.
pub(super) struct Fits {
    /// Census bits that differ, in all and of the pixel itself.
    pub bits: Sums,
    pub bits_here: Sums,
    /// Differences of steps, each bounded.
    pub steps: Sums,
}

impl Several {
    /// The windows at these places.
    #[inline(always)]
    pub fn at(records: impl Records, windows: &[Record], places: &Places) -> Self {
        let [census, own_and_steps] = records.halves(windows, places);
        Self { census, own_and_steps }
    }

    /// How they fit others.
    #[inline(always)]
    pub fn fit(&self, unlike: impl Unlike, other: &Self) -> Fits {
        let mut bits = unlike.bits(&self.census, &other.census, u64::MAX);
        let bits_here = unlike.bits(&self.own_and_steps, &other.own_and_steps, OWN_BYTE);
        for l in 0..LANES {
            bits[l] += bits_here[l];
        }
        let (ours, theirs) = (&self.own_and_steps, &other.own_and_steps);
        Fits { bits, bits_here, steps: unlike.bytes(ours, theirs, LARGEST_STEP, STEP_BYTES) }
    }

    /// The sums of their grey steps, each bounded.
    #[inline(always)]
    pub fn textures(&self, unlike: impl Unlike) -> Sums {
        let flat = Line([u64::from_le_bytes([FLAT; 8]); LANES]);
        unlike.bytes(&self.own_and_steps, &flat, LARGEST_TEXTURE, STEP_BYTES)
    }
}

/// The windows of some rows of an image, one after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Windows(Vec<Record>);

impl Windows {
    /// What they take for so many rows of so many columns.
    pub fn bytes(columns: usize, rows: usize) -> usize {
        size_of::<Record>() * rows * columns
    }

    /// With the memory for one row of so many columns.
    pub fn new(columns: usize) -> Self {
        let mut windows = Self::default();
        windows.reset(columns, 1);
        windows
    }

    /// Takes the memory for so many rows of so many columns.
    pub fn reset(&mut self, columns: usize, rows: usize) {
        taken(&mut self.0, columns * rows, Record::default());
    }

    /// Those of row `y` of what was looked at, of an image as wide as the rows that there is memory for, as row
    /// `place` of them.
    pub fn compute(&mut self, level: Level, image: &Looks, y: usize, place: usize) {
        let columns = image.columns();
        let near = [y.saturating_sub(image.apart()), y, y + image.apart()];
        let rows = near.map(|y| image.row(y));
        windows_of_row(level, rows, &mut self.0[place * columns..][..columns]);
    }

    pub fn get(&self) -> &[Record] {
        &self.0
    }
}

at_every_level! {
    /// The windows of a row from those around it.
    fn windows_of_row(rows: [[&[u8]; 2]; 3], windows: &mut [Record]) {
        let columns = windows.len();
        let [[above, steps_above], [here, steps_here], [below, steps_below]] = rows;
        let [a, b, c] = [0, APART, 2 * APART].map(|column| &above[column..][..columns]);
        let [d, e, f] = [0, APART, 2 * APART].map(|column| &here[column..][..columns]);
        let [g, h, i] = [0, APART, 2 * APART].map(|column| &below[column..][..columns]);
        let [left, own, right] = [0, APART, 2 * APART].map(|column| &steps_here[column..][..columns]);
        let [up, down] = [steps_above, steps_below].map(|row| &row[APART..][..columns]);
        for x in 0..columns {
            windows[x] = Record([
                word([a[x], b[x], c[x], d[x], f[x], g[x], h[x], i[x]]),
                word([e[x], own[x], left[x], right[x], up[x], down[x], 0, 0]),
            ]);
        }
    }
}

/// A word of bytes, the first one lowest. Shifts are taken together for many words, bytes are not.
#[inline(always)]
fn word(bytes: [u8; 8]) -> u64 {
    let mut word = 0;
    for i in 0..8 {
        word |= u64::from(bytes[i]) << (8 * i);
    }
    word
}

#[cfg(test)]
mod tests {
    use raster::Plane;

    use super::*;
    use crate::chance::Chance;
    use crate::kernels::products::Plain;

    at_every_level! {
        fn fits[products](base: &Several, other: &Several) -> (Fits, Sums) {
            (base.fit(products, other), base.textures(products))
        }
    }

    #[test]
    fn fits_are_those_of_pixel_after_pixel_at_every_level() {
        let (columns, rows) = (37, 6);
        let mut chance = Chance(4);
        let images = [(); 2].map(|()| Plane::from_fn(columns, rows, |_, _| chance.bits(8) as u8));
        for level in Level::available() {
            eprintln!("level {}", level.name());
            let looks = |every: usize| {
                images.each_ref().map(|image| {
                    let mut looks = Looks::default();
                    looks.compute(level, image.view(), 0..rows, every);
                    looks
                })
            };
            let of_all_rows = looks(1);
            for (y, every) in [(0, 1), (3, 1), (5, 1), (0, 2), (2, 2), (4, 2)] {
                let windows = looks(every).map(|looks| {
                    let mut windows = Windows::default();
                    windows.reset(columns, 2);
                    windows.compute(level, &looks, y / every, 1);
                    windows
                });
                let places: [Places; 2] = [(); 2].map(|()| {
                    Line(std::array::from_fn(|l| match l {
                        0 => 0,
                        1 => columns as u32 - 1,
                        _ => chance.below(columns as u32),
                    }))
                });
                let [base, other] =
                    [0, 1].map(|i| Several::at(Plain, &windows[i].get()[columns..], &places[i]));
                let (fits, textures) = fits(level, &base, &other);
                for l in 0..LANES {
                    let [x, there] = places.map(|places| places[l] as usize);
                    let (mut bits, mut here, mut steps, mut texture) = (0, 0, 0, 0);
                    for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                        let of = |place: usize, by: i64, end: usize| {
                            (place as i64 + 2 * by).clamp(0, end as i64 - 1) as usize
                        };
                        let row = of(y, dy, rows);
                        let [a, b] = [(0, x), (1, there)].map(|(image, x): (usize, usize)| {
                            let [census, steps] = of_all_rows[image].row(row);
                            let x = APART + of(x, dx, columns);
                            (census[x], steps[x])
                        });
                        let unlike = (a.0 ^ b.0).count_ones();
                        bits += unlike;
                        if (dx, dy) == (0, 0) {
                            here = unlike;
                        }
                        if dx == 0 || dy == 0 {
                            steps += u32::from(a.1.abs_diff(b.1).min(20));
                            texture += u32::from(a.1.abs_diff(128).min(32));
                        }
                    }
                    let found = [fits.bits[l], fits.bits_here[l], fits.steps[l], textures[l]];
                    assert_eq!(found, [bits, here, steps, texture].map(|sum| sum as i32));
                }
            }
        }
    }
}
