//! How noisy an image is (Immerkaer, *Fast Noise Variance Estimation*, CVIU 1996).
//!
//! ```text
//!      1 -2  1
//! N = -2  4 -2   over the image
//!      1 -2  1
//! ```
//!
//! is zero on planes of grey and along level and upright edges, and noise of standard deviation `s` gives
//! it one of `6 s`. Texture makes it large, so the estimate is taken from the quarter of the pixels where
//! it is smallest. Where all of an image is as fine as gravel it is taken for noise all the same; what two
//! images share is not (`alignment`).

use raster::View;

use super::histogram::quantile;
use crate::profile::Work;

/// Every so many-th row is looked at.
const EVERY: usize = 4;
/// Of a normal distribution a quarter lies within so many standard deviations.
const QUARTER: f32 = 0.3186;
/// The standard deviation of responses to noise of standard deviation 1.
pub(super) const GAIN: f32 = 6.0;
/// The largest response.
const LARGEST: usize = 8 * 255;

/// What [`noise`] does: rows are read, and eight numbers of 16 bits added up for each pixel.
pub(crate) fn work(grey: View<'_, u8>) -> Work {
    let looked_at = grey.columns() * grey.rows() / EVERY;
    Work::bytes(3 * looked_at) + Work::operations(8 * 2) * looked_at
}

/// The standard deviation of an image's noise, in grey values.
pub(crate) fn noise(grey: View<'_, u8>) -> f32 {
    let mut pixels_with = [0u32; LARGEST + 1];
    let last = grey.rows().saturating_sub(1);
    for y in (1..last).step_by(EVERY) {
        let [above, here, below] = [y - 1, y, y + 1].map(|y| grey.row(y).windows(3));
        for ((above, here), below) in above.zip(here).zip(below) {
            pixels_with[response([above, here, below]).unsigned_abs() as usize] += 1;
        }
    }
    quantile(&pixels_with, 0.25) / (GAIN * QUARTER)
}

/// The mask's response to three rows of three pixels.
#[inline(always)]
pub(super) fn response(rows: [&[u8]; 3]) -> i32 {
    let [above, here, below] =
        rows.map(|three| i32::from(three[0]) - 2 * i32::from(three[1]) + i32::from(three[2]));
    above - 2 * here + below
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use raster::Plane;

    const COLUMNS: usize = 200;
    const ROWS: usize = 150;

    /// Planes of grey with an edge between them, and noise: twelve equally likely numbers added up are
    /// nearly normal.
    fn picture(deviation: f32, texture: impl Fn(usize, usize) -> f32) -> Plane<u8> {
        let mut chance = Chance(5);
        Plane::from_fn(COLUMNS, ROWS, |x, y| {
            let plane = if x < 120 { 60.0 + 0.25 * x as f32 } else { 150.0 };
            let normal = (0..12).map(|_| chance.share()).sum::<f32>() - 6.0;
            (plane + texture(x, y) + deviation * normal).round().clamp(0.0, 255.0) as u8
        })
    }

    #[test]
    fn the_deviation_of_noise_is_found() {
        for deviation in [1.0, 3.0, 10.0, 20.0] {
            let found = noise(picture(deviation, |_, _| 0.0).view());
            assert!((found / deviation - 1.0).abs() < 0.1, "{deviation}: {found}");
        }
    }

    #[test]
    fn what_is_clean_or_tiny_has_none() {
        let flat = Plane::from_fn(COLUMNS, ROWS, |x, _| if x < 77 { 10u8 } else { 200 });
        // A response of 0 stands for some that were rounded to it.
        assert!(noise(flat.view()) < 0.1);
        for (columns, rows) in [(1, 1), (2, 9), (9, 2)] {
            assert_eq!(noise(Plane::from_fn(columns, rows, |x, y| (x * 90 + y) as u8).view()), 0.0);
        }
    }

    #[test]
    fn texture_on_half_of_the_image_says_little() {
        let checks = |x: usize, y: usize| {
            if y < ROWS / 2 && (x / 2 + y / 2).is_multiple_of(2) { 60.0 } else { 0.0 }
        };
        let found = noise(picture(3.0, checks).view());
        // The quarter of all is half of those that are left: within 0.67 deviations, not 0.32.
        assert!((3.0..7.0).contains(&found), "{found}");
    }
}
