//! An image smoothed where it is noisy.
//!
//! ```text
//!            1 2 1
//! out = 1/16 2 4 2   over the image, rounded to nearest
//!            1 2 1
//! ```
//!
//! A census asks which of two grey values is larger, and where both are nearly the same noise answers. Of noise
//! that differs from pixel to pixel this mask leaves three eighths. Beyond its ends the image is repeated.
//! Of an image with 16 bits the upper 8 are smoothed: where noise shows in these, the others are nothing else.

use raster::{Plane, View};
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;

/// Images with noise of a larger standard deviation than this, in grey levels, are smoothed.
pub(crate) const NOISY: f32 = 1.8;

/// What [`smooth`] does: a byte is read and written for twelve operations of 16 bits.
pub(crate) fn work(image: View<'_, u8>) -> Work {
    (Work::bytes(1 + 1) + Work::operations(12 * 2)) * (image.columns() * image.rows())
}

/// Smooths an image into another one of its size.
pub(crate) fn smooth(level: Level, image: View<'_, u8>, smoothed: &mut Plane<u8>) {
    let last = image.rows() - 1;
    let rows = smoothed.samples_mut().par_chunks_mut(image.columns()).enumerate();
    rows.for_each(|(y, out)| {
        let around = [y.saturating_sub(1), y, (y + 1).min(last)].map(|y| image.row(y));
        smooth_row(level, around, out);
    });
}

at_every_level! {
    /// The row in the middle of three.
    fn smooth_row(rows: [&[u8]; 3], out: &mut [u8]) {
        let columns = out.len();
        out[0] = mean(rows, [0, 0, 1.min(columns - 1)]);
        out[columns - 1] = mean(rows, [columns.saturating_sub(2), columns - 1, columns - 1]);
        let Some(inner) = columns.checked_sub(2) else { return };
        let out = &mut out[1..][..inner];
        let rows = rows.map(|row| &row[..inner + 2]);
        for x in 0..inner {
            out[x] = mean(rows, [x, x + 1, x + 2]);
        }
    }
}

/// The weighed mean of three columns.
#[inline(always)]
fn mean([above, here, below]: [&[u8]; 3], [i, j, k]: [usize; 3]) -> u8 {
    let [a, b, c] = [above[i] as u16, above[j] as u16, above[k] as u16];
    let [d, e, f] = [here[i] as u16, here[j] as u16, here[k] as u16];
    let [g, h, i] = [below[i] as u16, below[j] as u16, below[k] as u16];
    ((a + c + g + i + 2 * (b + d + f + h) + 4 * e + 8) / 16) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    #[test]
    fn every_pixel_is_the_weighed_mean_of_nine_at_every_level() {
        let mut chance = Chance(4);
        for (columns, rows) in [(1, 1), (2, 3), (3, 2), (77, 9), (130, 4)] {
            let image = Plane::from_fn(columns, rows, |_, _| chance.bits(8) as u8);
            let expected = Plane::from_fn(columns, rows, |x, y| {
                let mut sum = 0;
                for (dy, down) in [(0, 1), (1, 2), (2, 1)] {
                    for (dx, across) in [(0, 1), (1, 2), (2, 1)] {
                        let x = (x + dx).saturating_sub(1).min(columns - 1);
                        let y = (y + dy).saturating_sub(1).min(rows - 1);
                        sum += down * across * u32::from(image.row(y)[x]);
                    }
                }
                ((sum + 8) / 16) as u8
            });
            for level in Level::available() {
                eprintln!("level {}", level.name());
                let mut smoothed = Plane::filled(columns, rows, 0);
                smooth(level, image.view(), &mut smoothed);
                assert_eq!(smoothed, expected);
            }
        }
    }

    #[test]
    fn three_eighths_of_noise_are_left() {
        let mut chance = Chance(8);
        let noisy = Plane::from_fn(300, 200, |_, _| (100.0 + 60.0 * chance.share()) as u8);
        let mut smoothed = Plane::filled(300, 200, 0);
        smooth(Level::detect(), noisy.view(), &mut smoothed);
        let [left, before] = [smoothed, noisy].map(|image| {
            let samples = image.samples().iter().map(|&sample| f64::from(sample));
            let mean = samples.clone().sum::<f64>() / samples.len() as f64;
            samples.map(|sample| (sample - mean).powi(2)).sum::<f64>().sqrt()
        });
        assert!((left / before - 0.375).abs() < 0.01, "{left} of {before}");
    }
}
