//! What the network sees of an image: how far its grey values lie from their mean, in spreads.
//!
//! ```text
//! (I - mean) / (deviation + 4)
//! ```
//!
//! with `I` in 0 to 255, so that exposure and gain of a camera do not matter; the 4 keeps the noise of
//! a flat image small. As samples ([`crate::kernels::products`]), so no farther than 64.

use super::network::REACH;
use crate::kernels::products::{Pair, sample};
use crate::prepare::grey::GreyView;

/// Added to the standard deviation, in grey values of 8 bits.
const FLAT: f64 = 4.0;

/// An image with its mean and spread.
#[derive(Debug, Clone, Copy)]
pub(super) struct Normalized<'a> {
    image: GreyView<'a>,
    mean: f32,
    scale: f32,
}

/// The sum of some values, and that of their squares: of whole numbers, so the same in any order.
fn moments<T: Copy + Into<u64>>(values: &[T]) -> (u64, u64) {
    values.iter().fold((0, 0), |(sum, squares), &value| {
        let value = value.into();
        (sum + value, squares + value * value)
    })
}

impl<'a> Normalized<'a> {
    pub fn new(image: GreyView<'a>) -> Self {
        let (columns, rows) = image.size();
        let (mut sum, mut squares) = (0, 0);
        for y in 0..rows {
            let (row_sum, row_squares) = match image {
                GreyView::Depth8(view) => moments(view.row(y)),
                GreyView::Depth16(view) => moments(view.row(y)),
            };
            sum += u128::from(row_sum);
            squares += u128::from(row_squares);
        }
        let unit = match image {
            GreyView::Depth8(_) => 1.0,
            GreyView::Depth16(_) => 257.0,
        };
        let count = (columns * rows) as u128;
        let spread = (count * squares - sum * sum) as f64;
        let pairs = count * (count.max(2) - 1);
        let deviation = (spread / pairs as f64).sqrt();
        Self {
            image,
            mean: (sum as f64 / count as f64) as f32,
            scale: (1.0 / (deviation + FLAT * unit)) as f32,
        }
    }

    /// Row `y` of the image as it is continued beyond its borders, by its nearest pixel and as far as
    /// the network sees, into the first of `out`.
    pub fn row(&self, y: usize, out: &mut [Pair]) {
        let (columns, rows) = self.image.size();
        let y = y.saturating_sub(REACH).min(rows - 1);
        let value = |v: f32| [sample((v - self.mean) * self.scale) as i16, 0];
        let inside = &mut out[REACH..REACH + columns];
        match self.image {
            GreyView::Depth8(view) => {
                inside.iter_mut().zip(view.row(y)).for_each(|(to, &v)| *to = value(v.into()));
            }
            GreyView::Depth16(view) => {
                inside.iter_mut().zip(view.row(y)).for_each(|(to, &v)| *to = value(v.into()));
            }
        }
        let (first, last) = (inside[0], inside[columns - 1]);
        out[..REACH].fill(first);
        out[REACH + columns..][..REACH].fill(last);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::products::ONE;
    use raster::Plane;

    const COLUMNS: usize = 7 + 2 * REACH;
    const ROWS: usize = 5 + 2 * REACH;

    fn rows(image: GreyView<'_>) -> Vec<f32> {
        let normalized = Normalized::new(image);
        let mut out = vec![[0; 2]; COLUMNS * ROWS];
        out.chunks_exact_mut(COLUMNS).enumerate().for_each(|(y, row)| normalized.row(y, row));
        out.into_iter().map(|[sample, _]| f32::from(sample) / ONE).collect()
    }

    #[test]
    fn depth_does_not_matter_and_borders_are_repeated() {
        let image = Plane::<u8>::from_fn(7, 5, |x, y| (x * x * 5 + y * 11) as u8);
        let deep = Plane::<u16>::from_fn(7, 5, |x, y| 257 * u16::from(image.row(y)[x]));
        let [small, large] =
            [GreyView::Depth8(image.view()), GreyView::Depth16(deep.view())].map(rows);
        for (a, b) in small.iter().zip(&large) {
            assert!((a - b).abs() < 0.003, "{a} {b}");
        }
        for (y, row) in small.chunks_exact(COLUMNS).enumerate() {
            let nearest = y.clamp(REACH, REACH + 4) * COLUMNS;
            for (x, &found) in row.iter().enumerate() {
                assert_eq!(found, small[nearest + x.clamp(REACH, REACH + 6)], "({x}, {y})");
            }
        }
        // 35 values: mean 0, spread a little below 1.
        let lines = small.chunks_exact(COLUMNS).skip(REACH).take(5);
        let inside = || lines.clone().flat_map(|row| &row[REACH..REACH + 7]);
        let mean = inside().sum::<f32>() / 35.0;
        let spread = inside().map(|v| v * v).sum::<f32>() / 34.0;
        assert!(mean.abs() < 1e-3 && (0.8..1.0).contains(&spread), "{mean} {spread}");
    }

    #[test]
    fn a_flat_image_is_zero() {
        let image = Plane::<u8>::from_fn(7, 5, |_, _| 93);
        assert!(rows(GreyView::Depth8(image.view())).iter().all(|&v| v == 0.0));
    }
}
