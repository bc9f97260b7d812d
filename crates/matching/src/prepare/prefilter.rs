//! The horizontal gradient, clipped: what absolute differences are taken of.
//!
//! ```text
//! s(x, y) = I(x, y - 1) + 2 I(x, y) + I(x, y + 1)
//! S(x, y) = s(x + 2, y) + s(x + 1, y) - s(x - 1, y) - s(x - 2, y)
//! g(x, y) = clip(S / 3, -c, c) + c
//! ```
//!
//! on the scale of 8 bits (16-bit samples are divided by 257 after the sums, so nothing of their
//! precision is lost before), rounded to nearest, rows and columns beyond the image
//! repeating its border. Konolige (*Small Vision Systems*, 1997) and OpenCV's block matcher prepare
//! their images alike, by a Sobel operator of three columns; five columns let less noise through.
//!
//! In: rows of grey of either depth. Out: one byte per pixel, `0 ..= 2 c`.
//!
//! Why: a constant added to one image changes nothing, so cameras may differ in exposure; and a
//! strong edge cannot outvote the rest of the window, which keeps the borders of objects in place.

use raster::View;

use crate::kernels::level::{Level, at_every_level};
use crate::prepare::grey::GreyView;

/// `S` is divided by this.
const DIVISOR: u16 = 3;
/// Columns to each side of a pixel that its gradient looks at.
const REACH: usize = 2;
/// The largest clip: the arithmetic of 16-bit samples would not fit 16 bits beyond it.
pub(crate) const LARGEST_CLIP: u8 = 60;

const _: () = assert!((LARGEST_CLIP as u32 + 1) * DIVISOR as u32 * 257 < 1 << 16);

/// Scratch memory: a row summed over three rows, with its ends repeated.
#[derive(Debug, Default)]
pub(crate) struct Smoothed {
    depth8: Vec<u16>,
    depth16: Vec<u32>,
}

/// Computes row `y` of the clipped gradient.
pub(crate) fn clipped_gradient(
    level: Level,
    image: GreyView<'_>,
    y: usize,
    clip: u8,
    smoothed: &mut Smoothed,
    out: &mut [u8],
) {
    debug_assert!(clip <= LARGEST_CLIP);
    match image {
        GreyView::Depth8(view) => {
            let smoothed = &mut smoothed.depth8;
            smoothed.resize(out.len() + 2 * REACH, 0);
            gradient_of_8_bit(level, three_rows(view, y), smoothed, clip, out);
        }
        GreyView::Depth16(view) => {
            let smoothed = &mut smoothed.depth16;
            smoothed.resize(out.len() + 2 * REACH, 0);
            gradient_of_16_bit(level, three_rows(view, y), smoothed, clip, out);
        }
    }
}

/// The rows above, at and below `y`.
fn three_rows<T>(image: View<'_, T>, y: usize) -> [&[T]; 3] {
    [image.row(y.saturating_sub(1)), image.row(y), image.row((y + 1).min(image.rows() - 1))]
}

at_every_level! {
    fn gradient_of_8_bit(rows: [&[u8]; 3], smoothed: &mut [u16], clip: u8, out: &mut [u8]) {
        let columns = out.len();
        let [above, here, below] = rows.map(|row| &row[..columns]);
        let inner = &mut smoothed[REACH..][..columns];
        for x in 0..columns {
            inner[x] = u16::from(above[x]) + 2 * u16::from(here[x]) + u16::from(below[x]);
        }
        repeat_ends(smoothed);
        let [a, b, c, d] = [0, 1, 3, 4].map(|shift| &smoothed[shift..][..columns]);
        let largest = u16::from(clip) * DIVISOR;
        for x in 0..columns {
            let (before, after) = (a[x] + b[x], c[x] + d[x]);
            let size = (before.abs_diff(after).min(largest) + DIVISOR / 2) / DIVISOR;
            out[x] = around(clip, size, after < before);
        }
    }

    fn gradient_of_16_bit(rows: [&[u16]; 3], smoothed: &mut [u32], clip: u8, out: &mut [u8]) {
        const STEP: u16 = 257 * DIVISOR;
        let columns = out.len();
        let [above, here, below] = rows.map(|row| &row[..columns]);
        let inner = &mut smoothed[REACH..][..columns];
        for x in 0..columns {
            inner[x] = u32::from(above[x]) + 2 * u32::from(here[x]) + u32::from(below[x]);
        }
        repeat_ends(smoothed);
        let [a, b, c, d] = [0, 1, 3, 4].map(|shift| &smoothed[shift..][..columns]);
        let largest = u32::from(clip) * u32::from(STEP);
        for x in 0..columns {
            let (before, after) = (a[x] + b[x], c[x] + d[x]);
            let size = (before.abs_diff(after).min(largest) as u16 + STEP / 2) / STEP;
            out[x] = around(clip, size, after < before);
        }
    }
}

#[inline(always)]
fn repeat_ends<T: Copy>(smoothed: &mut [T]) {
    let last = smoothed.len() - 1 - REACH;
    for i in 0..REACH {
        smoothed[i] = smoothed[REACH];
        smoothed[last + 1 + i] = smoothed[last];
    }
}

/// A gradient of this size on either side of the middle.
#[inline(always)]
fn around(clip: u8, size: u16, falls: bool) -> u8 {
    let size = size as u8;
    if falls { clip - size } else { clip + size }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::Plane;

    fn filtered(level: Level, image: GreyView<'_>, clip: u8) -> Vec<u8> {
        let (columns, rows) = match image {
            GreyView::Depth8(view) => (view.columns(), view.rows()),
            GreyView::Depth16(view) => (view.columns(), view.rows()),
        };
        let mut out = Plane::filled(columns, rows, 0);
        let mut smoothed = Smoothed::default();
        for y in 0..rows {
            clipped_gradient(level, image, y, clip, &mut smoothed, out.row_mut(y));
        }
        out.into_samples()
    }

    fn by_definition(image: &Plane<u16>, clip: i64) -> Vec<u8> {
        let (columns, rows) = image.size();
        let at = |x: i64, y: i64| {
            let (x, y) = (x.clamp(0, columns as i64 - 1), y.clamp(0, rows as i64 - 1));
            i64::from(image.row(y as usize)[x as usize])
        };
        let s = |x, y| at(x, y - 1) + 2 * at(x, y) + at(x, y + 1);
        let gradient = |x: i64, y: i64| {
            let sum = s(x + 2, y) + s(x + 1, y) - s(x - 1, y) - s(x - 2, y);
            let rounded = (sum as f64 / 257.0 / 3.0).round() as i64;
            (rounded.clamp(-clip, clip) + clip) as u8
        };
        let plane = Plane::from_fn(columns, rows, |x, y| gradient(x as i64, y as i64));
        plane.into_samples()
    }

    #[test]
    fn a_case_worked_by_hand() {
        let image = Plane::new(3, 3, vec![1u8, 2, 4, 8, 10, 9, 5, 5, 0]).unwrap();
        // Smoothed down the columns with borders repeated:
        //   row 0: 3*1+8, 3*2+10, 3*4+9    = 11 16 21
        //   row 1: 1+16+5, 2+20+5, 4+18+0  = 22 27 22
        //   row 2: 8+3*5, 10+3*5, 9+3*0    = 23 25  9
        // Row 0: (21 + 16 - 11 - 11) / 3 = 5, (21 + 21 - 11 - 11) / 3 = 6.7, (42 - 27) / 3 = 5.
        // Row 1: (22 + 27 - 44) / 3 = 1.7, 0, (44 - 49) / 3 = -1.7.
        // Row 2: (9 + 25 - 46) / 3 = -4, (18 - 46) / 3 = -9.3, (18 - 48) / 3 = -10; clipped to -6.
        for level in Level::available() {
            assert_eq!(
                filtered(level, GreyView::Depth8(image.view()), 6),
                [6 + 5, 6 + 6, 6 + 5, 6 + 2, 6, 6 - 2, 6 - 4, 0, 0]
            );
        }
    }

    #[test]
    fn both_depths_are_their_definition_at_every_level() {
        for level in Level::available() {
            eprintln!("level {}", level.name());
            for (columns, rows) in [(1, 1), (2, 3), (5, 1), (67, 9), (200, 4)] {
                let noise = |x: usize, y: usize| (x * 40_503 + y * 30_011 + x * y * 77) as u16;
                let deep = Plane::from_fn(columns, rows, noise);
                let plain = deep.map(|&v| (v >> 8) as u8 / 4);
                for clip in [1, 14, LARGEST_CLIP] {
                    assert_eq!(
                        filtered(level, GreyView::Depth16(deep.view()), clip),
                        by_definition(&deep, i64::from(clip))
                    );
                    assert_eq!(
                        filtered(level, GreyView::Depth8(plain.view()), clip),
                        by_definition(&plain.map(|&v| u16::from(v) * 257), i64::from(clip))
                    );
                }
            }
        }
    }

    #[test]
    fn an_offset_does_not_matter() {
        let plain = Plane::from_fn(13, 9, |x, y| (x * 37 + y * 101 + x * y * 11) as u8 % 200);
        let lighter = plain.map(|&v| v + 55);
        let level = Level::detect();
        assert_eq!(
            filtered(level, GreyView::Depth8(plain.view()), 31),
            filtered(level, GreyView::Depth8(lighter.view()), 31)
        );
    }

    #[test]
    fn a_mirrored_image_has_the_opposite_gradient() {
        let value = |x: usize, y: usize| (x * x * 5003 + y * 30_011) as u16;
        let image = Plane::from_fn(17, 6, value);
        let mirrored = Plane::from_fn(17, 6, |x, y| value(16 - x, y));
        let level = Level::detect();
        let (plain, mirrored) = (
            filtered(level, GreyView::Depth16(image.view()), 40),
            filtered(level, GreyView::Depth16(mirrored.view()), 40),
        );
        for (a, b) in plain.chunks(17).zip(mirrored.chunks(17)) {
            assert!(a.iter().zip(b.iter().rev()).all(|(a, b)| a + b == 80));
        }
    }
}
