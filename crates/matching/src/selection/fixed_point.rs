//! Disparities as 16-bit fixed-point numbers, counted from the smallest disparity searched.
//!
//! `d = min + n / scale`. Refinement compares, sorts and fills millions of them: at 16 bits a
//! vector holds twice as many as of floats, and integers sort without a thought for NaN. The scale
//! is the largest power of two, up to 256, at which the whole range fits: at 64 disparities a step
//! is 1/256 pixel, at 1000 it is 1/64.

use crate::cost::SearchSpace;
use crate::kernels::level::at_every_level;

/// Stands for "no disparity". It is larger than every disparity, so that of two neighbours the
/// smaller is always one that exists, if any does.
pub(crate) const HOLE: u16 = u16::MAX;

/// How disparities are written as whole numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FixedPoint {
    min: i32,
    scale: u16,
}

impl FixedPoint {
    /// The finest scale for the disparities of a search space. One disparity more than there are
    /// fits, so that no disparity comes within a pixel of [`HOLE`].
    pub fn new(space: &SearchSpace) -> Self {
        let mut scale = 256;
        while scale > 1 && (space.count + 1) * usize::from(scale) >= usize::from(HOLE) {
            scale /= 2;
        }
        Self { min: space.min, scale }
    }

    /// Steps in a pixel.
    pub fn scale(self) -> u16 {
        self.scale
    }

    /// So many pixels as steps, rounded down.
    pub fn steps(self, pixels: f32) -> u16 {
        (pixels * f32::from(self.scale)) as u16
    }

    /// The disparity in pixels; NaN for a [`HOLE`].
    #[inline(always)]
    pub fn pixels(self, steps: u16) -> f32 {
        if steps == HOLE {
            f32::NAN
        } else {
            // The scale is a power of two: nothing is lost by multiplying with its inverse.
            self.min as f32 + f32::from(steps) * (1.0 / f32::from(self.scale))
        }
    }
}

at_every_level! {
    /// A row of disparities, none below the smallest searched, to the nearest step; NaN becomes a
    /// [`HOLE`].
    pub(crate) fn row_in_steps(numbers: FixedPoint, pixels: &[f32], steps: &mut [u16]) {
        let (min, scale) = (numbers.min as f32, f32::from(numbers.scale));
        for (steps, &pixels) in steps.iter_mut().zip(pixels) {
            let nearest = ((pixels - min) * scale + 0.5) as i32 as u16;
            *steps = if pixels.is_nan() { HOLE } else { nearest };
        }
    }

    /// A row of disparities in pixels.
    pub(crate) fn row_in_pixels(numbers: FixedPoint, steps: &[u16], pixels: &mut [f32]) {
        for (pixels, &steps) in pixels.iter_mut().zip(steps) {
            *pixels = numbers.pixels(steps);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::{BoundingBox, DisparityRange};

    #[test]
    fn every_range_fits_with_the_finest_scale_that_it_allows() {
        for (min, max, scale) in
            [(0, 63, 256), (-40, 200, 256), (0, 254, 128), (0, 999, 64), (-16_000, 16_000, 2)]
        {
            let range = DisparityRange::new(min, max).unwrap();
            let space = SearchSpace::new(40_000, BoundingBox::whole(40_000, 1), range);
            let numbers = FixedPoint::new(&space);
            assert_eq!(numbers.scale(), scale, "{min} to {max}");
            for disparity in [min as f32, max as f32, (min + max) as f32 / 2.0 + 0.5] {
                let steps = ((disparity - min as f32) * f32::from(scale)) as u16;
                assert_eq!(numbers.pixels(steps), disparity);
                assert!(HOLE - steps > scale, "{disparity} comes near a hole");
            }
            assert!(numbers.pixels(HOLE).is_nan());
            let row: Vec<u16> = (0..100).map(|i| i * 3).chain([HOLE]).collect();
            for level in crate::kernels::level::Level::available() {
                let mut pixels = vec![0.0; row.len()];
                row_in_pixels(level, numbers, &row, &mut pixels);
                for (&steps, pixels) in row.iter().zip(pixels) {
                    assert_eq!(pixels.to_bits(), numbers.pixels(steps).to_bits());
                }
            }
        }
    }

    #[test]
    fn disparities_become_the_nearest_step_at_every_level() {
        for (min, max) in [(0, 63), (-40, 200), (0, 999), (-16_000, 16_000)] {
            let range = DisparityRange::new(min, max).unwrap();
            let space = SearchSpace::new(40_000, BoundingBox::whole(40_000, 1), range);
            let numbers = FixedPoint::new(&space);
            let scale = numbers.scale();
            let last = (max - min) as u16 * scale;
            // All of these are floats without rounding: steps, a quarter more, a half, three quarters.
            let parts = [(0.0, 0), (0.25, 0), (0.5, 1), (0.75, 1)];
            let some = (0..=last).step_by(7).flat_map(|n| parts.map(|part| (n, part)));
            let mut pixels: Vec<f32> = some
                .clone()
                .map(|(n, (part, _))| min as f32 + (f32::from(n) + part) / f32::from(scale))
                .collect();
            let mut expected: Vec<u16> = some.map(|(n, (_, up))| n + up).collect();
            // Holes among them, and alone at the end.
            for at in [0, 5, 63, 64, pixels.len() - 1] {
                (pixels[at], expected[at]) = (f32::NAN, HOLE);
            }
            let all: Vec<u16> = (0..=last).chain([HOLE]).collect();
            for level in crate::kernels::level::Level::available() {
                let mut steps = vec![1; pixels.len()];
                row_in_steps(level, numbers, &pixels, &mut steps);
                assert!(steps == expected, "{min} to {max}, level {}", level.name());
                let (mut there, mut back) = (vec![0.0; all.len()], vec![1; all.len()]);
                row_in_pixels(level, numbers, &all, &mut there);
                row_in_steps(level, numbers, &there, &mut back);
                assert!(back == all, "{min} to {max} and back, level {}", level.name());
            }
        }
    }
}
