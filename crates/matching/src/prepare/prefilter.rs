//! The horizontal gradient, clipped: what absolute differences are taken of.
//!
//! `g(x, y) = clip(S(x, y), -c, c) + c` with the Sobel operator across the columns,
//!
//! ```text
//! S(x, y) =     I(x + 1, y - 1) -     I(x - 1, y - 1)
//!         + 2 * I(x + 1, y)     - 2 * I(x - 1, y)
//!         +     I(x + 1, y + 1) -     I(x - 1, y + 1)
//! ```
//!
//! on the scale of 8 bits (16-bit samples are divided by 257 after the sums, so nothing of their
//! precision is lost before), rows and columns beyond the image repeating its border. Konolige
//! (*Small Vision Systems*, 1997) and OpenCV's block matcher prepare their images alike.
//!
//! In: grey of either depth. Out: one byte per pixel, `0 ..= 2 c`.
//!
//! Why: a constant added to one image changes nothing, so cameras may differ in exposure; and a
//! strong edge cannot outvote the rest of the window, which keeps the borders of objects in place.

use raster::{Plane, View};
use rayon::prelude::*;

use crate::prepare::grey::GreyView;

/// A sample type of grey images.
trait Sample: Copy + Sync + Into<i32> {
    /// What one step of an 8-bit image is in this type.
    const STEP: i32;
}

impl Sample for u8 {
    const STEP: i32 = 1;
}

impl Sample for u16 {
    const STEP: i32 = 257;
}

/// Computes rows `first ..= last` of the clipped gradient into `out`, which has only these rows.
pub(crate) fn clipped_gradient(
    image: GreyView<'_>,
    (first, last): (usize, usize),
    clip: u8,
    out: &mut Plane<u8>,
) {
    match image {
        GreyView::Depth8(view) => gradient_rows(view, (first, last), clip, out),
        GreyView::Depth16(view) => gradient_rows(view, (first, last), clip, out),
    }
}

fn gradient_rows<T: Sample>(
    image: View<'_, T>,
    (first, last): (usize, usize),
    clip: u8,
    out: &mut Plane<u8>,
) {
    let columns = image.columns();
    out.reset(columns, last - first + 1, 0);
    out.samples_mut().par_chunks_mut(columns).enumerate().for_each(|(row, out)| {
        let y = first + row;
        let above = image.row(y.saturating_sub(1));
        let below = image.row((y + 1).min(image.rows() - 1));
        gradient_row(above, image.row(y), below, i32::from(clip), out);
    });
}

fn gradient_row<T: Sample>(above: &[T], here: &[T], below: &[T], clip: i32, out: &mut [u8]) {
    let columns = out.len();
    let smooth = |x: usize| above[x].into() + 2 * here[x].into() + below[x].into();
    // 257 is odd: rounding to nearest has no ties, so both signs round alike.
    let scale = |s: i32| (s + T::STEP / 2).div_euclid(T::STEP);
    for (x, g) in out.iter_mut().enumerate() {
        let s = scale(smooth((x + 1).min(columns - 1)) - smooth(x.saturating_sub(1)));
        *g = (s.clamp(-clip, clip) + clip) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filtered(image: GreyView<'_>, clip: u8) -> Vec<u8> {
        let rows = match image {
            GreyView::Depth8(view) => view.rows(),
            GreyView::Depth16(view) => view.rows(),
        };
        let mut out = Plane::default();
        clipped_gradient(image, (0, rows - 1), clip, &mut out);
        out.into_samples()
    }

    #[test]
    fn a_case_worked_by_hand() {
        let image = Plane::new(3, 3, vec![1u8, 2, 4, 8, 10, 9, 5, 5, 0]).unwrap();
        // Smoothed down the columns with borders repeated:
        //   row 0: 3*1+8, 3*2+10, 3*4+9    = 11 16 21
        //   row 1: 1+16+5, 2+20+5, 4+18+0  = 22 27 22
        //   row 2: 8+3*5, 10+3*5, 9+3*0    = 23 25  9
        // Differences of the neighbours, borders repeated, clipped to 6, plus 6.
        assert_eq!(
            filtered(GreyView::Depth8(image.view()), 6),
            [5 + 6, 6 + 6, 5 + 6, 5 + 6, 6, 6 - 5, 2 + 6, 0, 0]
        );
    }

    #[test]
    fn depth_and_offset_do_not_matter() {
        let value = |x: usize, y: usize| (x * 37 + y * 101 + x * y * 11) as u8 % 200;
        let plain = Plane::from_fn(13, 9, value);
        let deep = plain.map(|&v| u16::from(v) * 257);
        let lighter = plain.map(|&v| v + 55);
        let expected = filtered(GreyView::Depth8(plain.view()), 31);
        assert_eq!(filtered(GreyView::Depth16(deep.view()), 31), expected);
        assert_eq!(filtered(GreyView::Depth8(lighter.view()), 31), expected);
    }

    #[test]
    fn a_mirrored_image_has_the_opposite_gradient() {
        let value = |x: usize, y: usize| (x * x * 5003 + y * 30_011) as u16;
        let image = Plane::from_fn(17, 6, value);
        let mirrored = Plane::from_fn(17, 6, |x, y| value(16 - x, y));
        let (plain, mirrored) = (
            filtered(GreyView::Depth16(image.view()), 40),
            filtered(GreyView::Depth16(mirrored.view()), 40),
        );
        for (a, b) in plain.chunks(17).zip(mirrored.chunks(17)) {
            assert!(a.iter().zip(b.iter().rev()).all(|(a, b)| a + b == 80));
        }
    }

    #[test]
    fn one_pixel_has_no_gradient() {
        assert_eq!(filtered(GreyView::Depth8(Plane::filled(1, 1, 9u8).view()), 31), [31]);
    }
}
