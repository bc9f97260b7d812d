//! Hamming distance of census words: how many neighbours stand in another order to the pixel.

use raster::Plane;

use super::SearchSpace;
use crate::kernels::level::Level;
use crate::kernels::path::padded;
use crate::optimization::semi_global::CostRows;
use crate::prepare::census::{BITS, census_row};

/// The census words of both images, of the rows of a box.
#[derive(Default)]
pub(crate) struct CensusPair {
    left: Plane<u64>,
    right: Plane<u64>,
}

impl CensusPair {
    /// Computes the words of rows `first..first + rows` of both images.
    pub fn compute(&mut self, level: Level, images: [&Plane<u16>; 2], first: usize, rows: usize) {
        let columns = images[0].columns();
        let mut scratch = Vec::new();
        for (words, image) in [&mut self.left, &mut self.right].into_iter().zip(images) {
            words.reset(columns, rows, 0);
            for y in 0..rows {
                census_row(level, image, first + y, &mut scratch, words.row_mut(y));
            }
        }
    }

    /// The costs over a search space.
    pub fn costs<'a>(&'a self, space: &'a SearchSpace) -> HammingRows<'a> {
        HammingRows { words: self, space }
    }
}

/// Hamming distances, 0 to [`BITS`], of the rows of a box. A disparity whose match lies outside
/// the right image is compared with the nearest column inside, so that paths can cross.
pub(crate) struct HammingRows<'a> {
    words: &'a CensusPair,
    space: &'a SearchSpace,
}

impl CostRows for HammingRows<'_> {
    fn columns(&self) -> usize {
        self.space.columns()
    }

    fn rows(&self) -> usize {
        self.words.left.rows()
    }

    fn count(&self) -> usize {
        self.space.count
    }

    fn fill_row(&self, y: usize, costs: &mut [u8]) {
        const { assert!(BITS < 128) };
        let (left, right) = (self.words.left.row(y), self.words.right.row(y));
        let last = self.space.width as i64 - 1;
        let pixels = costs.chunks_exact_mut(padded(self.space.count));
        for (x, costs) in (self.space.first..).zip(pixels) {
            for (k, cost) in costs[..self.space.count].iter_mut().enumerate() {
                let match_at = x as i64 - i64::from(self.space.min) - k as i64;
                *cost = (left[x] ^ right[match_at.clamp(0, last) as usize]).count_ones() as u8;
            }
            costs[self.space.count..].fill(255);
        }
    }
}
