//! Which pixels show nothing but noise: a wall of one colour.
//!
//! A learned descriptor finds a likeness in noise too, and where nothing else speaks it is believed. So descriptors do
//! not count where grey varies no more than noise does, in 9 x 9 pixels. Of white noise of standard deviation `s` the
//! variance of grey is `s^2`, and the mask of [`noise`](super::noise) gives `36 s^2` in the mean of its squares, so the
//! window itself tells what its noise is; texture, which a lens has blurred, varies more than its mask tells. What
//! varies more than the noise of the whole image is texture too, however fine.

use std::ops::Range;

use raster::{BoundingBox, Plane, View};
use rayon::prelude::*;

use super::noise::{GAIN, response};
use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;

/// A window reaches so far: 9 x 9 pixels, of which the part within the image counts.
const REACH: usize = 4;
/// So many columns are looked at together.
const BLOCK: usize = 64;
const SEEN: usize = BLOCK + 2 * REACH;
/// How many times as large as that of noise the variance may be, of the window and of the whole image: within both,
/// noise is seven times in ten.
const OF_WINDOW: f32 = 1.2;
const OF_IMAGE: f32 = 1.69;
/// The square of the mask's response to noise of standard deviation 1, in the mean.
const OF_MASK: f32 = GAIN * GAIN;

/// Operations on bytes per pixel: per row of the window a sum, a square and a response of the mask, squared, on numbers
/// of 32 bits; sums along the row.
const OPERATIONS: usize = 4 * (2 * REACH + 1) * (3 + 14 + 3);

/// Marks the pixels of a box that are plain in an image with noise of this standard deviation.
pub(crate) fn find(
    level: Level,
    grey: View<'_, u8>,
    noise: f32,
    bounds: BoundingBox,
    plain: &mut Plane<bool>,
) -> Work {
    plain.reset(bounds.columns(), bounds.rows(), false);
    let columns = plain.columns();
    let most = OF_IMAGE * noise * noise;
    plain.samples_mut().par_chunks_mut(columns).enumerate().for_each(|(y, plain)| {
        plain_row(level, grey, most, (bounds.x0, bounds.y0 + y), plain);
    });
    let pixels = plain.samples().len();
    (Work::bytes(2) + Work::operations(OPERATIONS)) * pixels
}

at_every_level! {
    /// A row of the box, which begins at `begin`. Grey varies by `most` at the most.
    fn plain_row(grey: View<'_, u8>, most: f32, begin: (usize, usize), plain: &mut [bool]) {
        let (first, y) = begin;
        let rows = window(y, 0..grey.rows());
        let masked_rows = window(y, inner(grey.rows()));
        for (start, plain) in (first..).step_by(BLOCK).zip(plain.chunks_mut(BLOCK)) {
            // Down the columns of the window: of grey, its squares and those of the mask. 0 beyond the image.
            let [mut sum, mut square, mut masked] = [[0u32; SEEN]; 3];
            let seen = start.saturating_sub(REACH)..(start + BLOCK + REACH).min(grey.columns());
            for y in rows.clone() {
                let row = &grey.row(y)[seen.clone()];
                let places = sum[seen.start + REACH - start..].iter_mut();
                let places = places.zip(&mut square[seen.start + REACH - start..]);
                for ((sum, square), &grey) in places.zip(row) {
                    *sum += u32::from(grey);
                    *square += u32::from(grey) * u32::from(grey);
                }
            }
            let seen = seen.start.max(1)..seen.end.min(grey.columns().saturating_sub(1));
            for y in masked_rows.clone().filter(|_| !seen.is_empty()) {
                let [above, here, below] =
                    [y - 1, y, y + 1].map(|y| &grey.row(y)[seen.start - 1..seen.end + 1]);
                let rows = above.windows(3).zip(here.windows(3)).zip(below.windows(3));
                let places = &mut masked[seen.start + REACH - start..];
                for (masked, ((above, here), below)) in places.iter_mut().zip(rows) {
                    *masked += response([above, here, below]).unsigned_abs().pow(2);
                }
            }
            let [sum, square, masked] = [sum, square, masked].map(|sums| along(&sums));
            for (i, plain) in plain.iter_mut().enumerate() {
                let x = start + i;
                let count = (rows.len() * window(x, 0..grey.columns()).len()) as u32;
                let masks = masked_rows.len() * window(x, inner(grey.columns())).len();
                // The variance, times the square of the count, which is whole.
                let varies = (count * square[i] - sum[i] * sum[i]) as f32;
                let count = (count * count) as f32;
                let of_window = OF_MASK * masks as f32 * varies < OF_WINDOW * count * masked[i] as f32;
                *plain = of_window & (varies < most * count);
            }
        }
    }
}

/// What a window around `at` sees of a row or column.
#[inline(always)]
fn window(at: usize, all: Range<usize>) -> Range<usize> {
    let start = at.saturating_sub(REACH).max(all.start);
    start..(at + REACH + 1).min(all.end).max(start)
}

/// Where the mask lies within the image.
#[inline(always)]
fn inner(end: usize) -> Range<usize> {
    1..end.saturating_sub(1)
}

/// Sums over the windows of the columns of a block.
#[inline(always)]
fn along(sums: &[u32; SEEN]) -> [u32; BLOCK] {
    let mut all = [0; BLOCK];
    for shift in 0..=2 * REACH {
        let sums = &sums[shift..][..BLOCK];
        for i in 0..BLOCK {
            all[i] += sums[i];
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    /// Noise of a standard deviation on texture: twelve equally likely numbers added up are nearly normal.
    fn picture(
        size: (usize, usize),
        deviation: f32,
        texture: impl Fn(usize, usize) -> f32,
    ) -> Plane<u8> {
        let mut chance = Chance(size.0 as u32);
        Plane::from_fn(size.0, size.1, |x, y| {
            let normal = (0..12).map(|_| chance.share()).sum::<f32>() - 6.0;
            (100.0 + texture(x, y) + deviation * normal).round() as u8
        })
    }

    fn found(level: Level, grey: &Plane<u8>, noise: f32, bounds: BoundingBox) -> Plane<bool> {
        let mut plain = Plane::default();
        find(level, grey.view(), noise, bounds, &mut plain);
        plain
    }

    fn share(grey: &Plane<u8>, noise: f32) -> f32 {
        let all = BoundingBox::new(0, 0, grey.columns() - 1, grey.rows() - 1).unwrap();
        let plain = found(Level::detect(), grey, noise, all);
        plain.samples().iter().filter(|&&plain| plain).count() as f32 / plain.samples().len() as f32
    }

    #[test]
    fn noise_is_plain_and_texture_is_not() {
        let size = (200, 150);
        let wave = |x: usize, y: usize| (x as f32 / 3.0).sin() * (y as f32 / 4.0).cos();
        for deviation in [0.7f32, 1.0, 3.0] {
            let noise = (deviation * deviation + 1.0 / 12.0).sqrt();
            let blank = share(&picture(size, deviation, |_, _| 0.0), noise);
            assert!(blank > 0.6, "{deviation}: {blank}");
            let faint =
                share(&picture(size, deviation, |x, y| 2.5 * deviation * wave(x, y)), noise);
            assert!(faint < 0.1, "{deviation}: {faint}");
            // As white as noise, but the rest of the image has less.
            let gravel = share(&picture(size, 2.0 * deviation, |_, _| 0.0), noise);
            assert!(gravel < 0.01, "{deviation}: {gravel}");
        }
        // What has no noise has no plain pixels: in deep images the lower bits may tell.
        assert_eq!(share(&Plane::filled(40, 30, 9), 0.0), 0.0);
        assert_eq!(share(&Plane::filled(40, 30, 9), 1.0), 0.0);
    }

    /// Of pixel `(x, y)` of the image.
    fn definition(grey: &Plane<u8>, noise: f32, x: usize, y: usize) -> bool {
        let (columns, rows) = grey.size();
        let window = |at: usize, end: usize| at.saturating_sub(REACH)..(at + REACH + 1).min(end);
        let seen: Vec<(usize, usize)> =
            window(y, rows).flat_map(|v| window(x, columns).map(move |u| (u, v))).collect();
        let at = |u: usize, v: usize| f64::from(grey.row(v)[u]);
        let mean = |of: &dyn Fn(usize, usize) -> f64, of_all: &[(usize, usize)]| {
            of_all.iter().map(|&(u, v)| of(u, v)).sum::<f64>() / of_all.len() as f64
        };
        let here = mean(&at, &seen);
        let variance = mean(&|u, v| (at(u, v) - here).powi(2), &seen);
        let inner = |&&(u, v): &&(usize, usize)| u > 0 && v > 0 && u + 1 < columns && v + 1 < rows;
        let inner: Vec<(usize, usize)> = seen.iter().filter(inner).copied().collect();
        let mask = |u: usize, v: usize| {
            let across = |v: usize| at(u - 1, v) - 2.0 * at(u, v) + at(u + 1, v);
            across(v - 1) - 2.0 * across(v) + across(v + 1)
        };
        let of_mask = mean(&|u, v| mask(u, v).powi(2) / f64::from(OF_MASK), &inner);
        variance < f64::from(OF_WINDOW) * of_mask && variance < f64::from(OF_IMAGE * noise * noise)
    }

    #[test]
    fn every_level_does_what_the_definition_says() {
        for (columns, rows, bounds) in [
            (1, 1, (0, 0, 0, 0)),
            (2, 30, (0, 3, 1, 29)),
            (30, 2, (5, 0, 29, 1)),
            (170, 20, (3, 0, 169, 19)),
        ] {
            let grey =
                picture((columns, rows), 1.5, |x, _| if x > 60 { 0.3 * x as f32 } else { 0.0 });
            let bounds = BoundingBox::new(bounds.0, bounds.1, bounds.2, bounds.3).unwrap();
            let mut kinds = [0; 2];
            for level in Level::available() {
                eprintln!("{columns} x {rows}, level {}", level.name());
                let plain = found(level, &grey, 1.5, bounds);
                for (y, x) in
                    (0..plain.rows()).flat_map(|y| (0..plain.columns()).map(move |x| (y, x)))
                {
                    let defined = definition(&grey, 1.5, bounds.x0 + x, bounds.y0 + y);
                    assert_eq!(plain.row(y)[x], defined, "column {x}, row {y}");
                    kinds[usize::from(defined)] += 1;
                }
            }
            assert!(columns < 100 || kinds.iter().all(|&pixels| pixels > 300), "{kinds:?}");
        }
    }
}
