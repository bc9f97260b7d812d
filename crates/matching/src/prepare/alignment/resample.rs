//! An image whose rows are taken from between its rows.
//!
//! `out(x, y) = I(x, y + dy(x, y))`, by a [cubic] through four samples of the column, rounded to nearest.
//! Beyond the ends of a column its samples are repeated.

use raster::View;

use super::correspondence::MARGIN;
use super::model::{AlongRow, VerticalDisparity};
use crate::kernels::cubic::cubic;
use crate::kernels::level::at_every_level;
use crate::kernels::rounding::nearest;

/// Columns that are taken from the same four rows.
const LANES: usize = 16;
// Corners keep this far from both borders, so only images that are wider have vertical disparity.
const _: () = assert!(LANES <= 2 * MARGIN);

/// Operations on bytes per pixel: a place and a cubic of 20 operations of 32 bits.
pub(super) const OPERATIONS: usize = 20 * 4;

at_every_level! {
    /// Row `y` of an image with 8 bits.
    pub(super) fn resample_8_bit(
        image: View<'_, u8>,
        vertical: &VerticalDisparity,
        y: usize,
        out: &mut [u8],
    ) {
        resample(image, vertical, y, out);
    }

    /// Row `y` of an image with 16 bits.
    pub(super) fn resample_16_bit(
        image: View<'_, u16>,
        vertical: &VerticalDisparity,
        y: usize,
        out: &mut [u16],
    ) {
        resample(image, vertical, y, out);
    }
}

/// A grey value of either depth. (Conversions of the standard library go through closures, which are not
/// compiled for the level.)
trait Grey: Copy + Default {
    const LARGEST: f32;
    fn wide(self) -> f32;
    fn narrow(number: i32) -> Self;
}

impl Grey for u8 {
    const LARGEST: f32 = 255.0;

    #[inline(always)]
    fn wide(self) -> f32 {
        f32::from(self)
    }

    #[inline(always)]
    fn narrow(number: i32) -> Self {
        number as u8
    }
}

impl Grey for u16 {
    const LARGEST: f32 = 65535.0;

    #[inline(always)]
    fn wide(self) -> f32 {
        f32::from(self)
    }

    #[inline(always)]
    fn narrow(number: i32) -> Self {
        number as u16
    }
}

#[inline(always)]
fn resample<T: Grey>(image: View<'_, T>, vertical: &VerticalDisparity, y: usize, out: &mut [T]) {
    let along = vertical.along_row(y);
    let columns = out.len();
    let (blocks, rest) = out.as_chunks_mut::<LANES>();
    for (block, out) in blocks.iter_mut().enumerate() {
        let x = block * LANES;
        *out = block_at(image, x, y, along);
    }
    if !rest.is_empty() {
        // The last block overlaps the one before it.
        let x = columns - LANES;
        let last = block_at(image, x, y, along);
        rest.copy_from_slice(&last[LANES - rest.len()..]);
    }
}

/// The four rows around one that lies so many pixels below row `y`.
#[inline(always)]
fn rows<'a, T>(image: View<'a, T>, y: usize, down: f32) -> [&'a [T]; 4] {
    let last = image.rows() as i64 - 1;
    let middle = y as i64 + down.floor() as i64;
    let row = |apart: i64| image.row((middle + apart).clamp(0, last) as usize);
    [row(-1), row(0), row(1), row(2)]
}

/// [`LANES`] columns of row `y` from `x` on. Vertical disparity hardly changes within them: all are taken from the rows
/// around the middle one, and it runs straight from their first to the next block's.
#[inline(always)]
fn block_at<T: Grey>(image: View<'_, T>, x: usize, y: usize, along: AlongRow) -> [T; LANES] {
    let first = along.at(x);
    let step = (along.at(x + LANES) - first) * (1.0 / LANES as f32);
    let middle = first + step * (LANES / 2) as f32;
    let [a, b, c, d] = rows(image, y, middle);
    let (a, b) = (&a[x..][..LANES], &b[x..][..LANES]);
    let (c, d) = (&c[x..][..LANES], &d[x..][..LANES]);
    let first = first - middle.floor();
    let mut out = [T::default(); LANES];
    for l in 0..LANES {
        out[l] = between(a[l], b[l], c[l], d[l], first + step * l as f32);
    }
    out
}

/// What lies the part `t` of the way from `b` to `c`.
#[inline(always)]
fn between<T: Grey>(a: T, b: T, c: T, d: T, t: f32) -> T {
    let (sample, _) = cubic([a.wide(), b.wide(), c.wide(), d.wide()], t);
    let sample = if sample > 0.0 { sample } else { 0.0 };
    let sample = if sample < T::LARGEST { sample } else { T::LARGEST };
    T::narrow(nearest(sample))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::level::Level;
    use crate::prepare::alignment::correspondence::Correspondence;
    use raster::Plane;

    /// The same everywhere.
    fn constant(size: (usize, usize), down: f64) -> VerticalDisparity {
        let found: Vec<_> = (0..100)
            .map(|i| {
                let (column, row) = ((i % 10 * size.0 / 10) as f32, (i / 10 * size.1 / 10) as f32);
                Correspondence { column, row, down, noise: 0.0 }
            })
            .collect();
        VerticalDisparity::fit(found.iter(), size, &mut Vec::new()).expect("all agree")
    }

    #[test]
    fn a_ramp_moves_by_what_is_asked_at_every_level() {
        let (columns, rows) = (77, 40);
        let image = Plane::from_fn(columns, rows, |x, y| (5 * y + x / 2) as u8);
        let deep = image.map(|&sample| 200 * u16::from(sample));
        for down in [-2.4, 0.2, 1.0, 3.6] {
            let vertical = constant((columns, rows), down);
            for level in Level::available() {
                eprintln!("level {}", level.name());
                for y in 6..30 {
                    let (mut out, mut out_deep) = (vec![0; columns], vec![0; columns]);
                    resample_8_bit(level, image.view(), &vertical, y, &mut out);
                    resample_16_bit(level, deep.view(), &vertical, y, &mut out_deep);
                    for x in 0..columns {
                        let expected = 5.0 * (y as f64 + down) + (x / 2) as f64;
                        assert!((f64::from(out[x]) - expected).abs() < 0.6, "{down} ({x}, {y})");
                        assert!((f64::from(out_deep[x]) - 200.0 * expected).abs() < 4.0);
                    }
                }
            }
        }
    }

    #[test]
    fn edges_stay_in_range_and_ends_are_repeated() {
        let image = Plane::from_fn(40, 12, |x, y| if (x + y / 2) % 2 == 0 { 255 } else { 0 });
        let deep = image.map(|&sample| u16::from(sample) * 257);
        let vertical = constant((40, 12), 1.5);
        for level in Level::available() {
            for y in 0..12 {
                let (mut out, mut out_deep) = (vec![9; 40], vec![9; 40]);
                resample_8_bit(level, image.view(), &vertical, y, &mut out);
                resample_16_bit(level, deep.view(), &vertical, y, &mut out_deep);
                let row = |down: usize| image.row((y + down).min(11));
                for x in 0..40 {
                    // Halfway between two samples, by those and the next ones.
                    let [a, b, c, d] = [0, 1, 2, 3].map(|down| f64::from(row(down)[x]));
                    let expected = (9.0 * (b + c) - a - d) / 16.0;
                    let expected = expected.clamp(0.0, 255.0);
                    assert!((f64::from(out[x]) - expected).abs() < 0.6, "({x}, {y})");
                    assert!((f64::from(out_deep[x]) - 257.0 * expected).abs() < 1.0, "({x}, {y})");
                }
            }
        }
    }
}
