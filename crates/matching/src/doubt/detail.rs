//! How much detail an image has along its rows and down its columns: fine beside coarse, and more at the borders of
//! blocks than within. One pass over its rows, of which no more than a few are kept.

use std::ops::AddAssign;

use raster::Image;

/// The side of the blocks of JPEG and of most videos, in pixels.
pub(super) const BLOCK: usize = 8;
/// Steps of grey count up to this many values, so that edges of things do not hide those of blocks.
const LARGEST_STEP: f32 = 6.0;
/// Coarse detail is what changes over so many pixels.
const COARSE: usize = 8;
/// Pairs of samples that are looked at together: those of a lane have one place modulo the side of a block.
const LANES: usize = BLOCK;

/// The detail of an image in one direction.
#[derive(Debug, Default)]
pub(super) struct Detail {
    /// Steps from one pixel to the next, each bounded, by the place of the first one modulo the side of a block.
    steps: [Mean; BLOCK],
    /// Squares of changes from one pixel to the next, and over more.
    fine: Mean,
    coarse: Mean,
}

#[derive(Debug, Clone, Copy, Default)]
struct Mean {
    sum: f64,
    count: usize,
}

impl Mean {
    fn add(&mut self, sum: f64, count: usize) {
        self.sum += sum;
        self.count += count;
    }

    fn value(self) -> f64 {
        self.sum / self.count as f64
    }
}

impl Detail {
    /// How many times as large the steps are at the best of eight places modulo eight as at the middle one.
    pub fn blockiness(&self) -> f64 {
        let mut means = self.steps.map(Mean::value);
        means.sort_unstable_by(f64::total_cmp);
        let middle = f64::midpoint(means[BLOCK / 2 - 1], means[BLOCK / 2]);
        if middle > 0.0 { means[BLOCK - 1] / middle } else { 1.0 }
    }

    /// The mean square of steps over that of changes over more pixels.
    pub fn fineness(&self) -> f64 {
        self.fine.value() / self.coarse.value()
    }
}

/// The detail of an image along its rows, and down its columns, of which it has more than [`COARSE`].
pub(super) fn details(image: &Image) -> [Detail; 2] {
    let (columns, rows) = image.size();
    let [mut along, mut down] = [Detail::default(), Detail::default()];
    // The last few rows, in turns.
    let mut near = vec![vec![0.0; columns]; COARSE + 1];
    for y in 0..rows {
        image.grey_row_f32(y, &mut near[y % (COARSE + 1)]);
        let above = |by: usize| y.checked_sub(by).map(|y| &near[y % (COARSE + 1)][..]);
        let row = &near[y % (COARSE + 1)][..];
        let next = &row[1..];
        for (place, (steps, sum)) in along.steps.iter_mut().zip(steps(row, next)).enumerate() {
            steps.add(sum, (next.len() + BLOCK - 1 - place) / BLOCK);
        }
        along.fine.add(squares(row, next), next.len());
        if let Some(far) = row.get(COARSE..) {
            along.coarse.add(squares(row, far), far.len());
        }
        if let Some(above) = above(1) {
            down.steps[(y - 1) % BLOCK].add(steps(above, row).iter().sum(), columns);
            down.fine.add(squares(above, row), columns);
        }
        if let Some(above) = above(COARSE) {
            down.coarse.add(squares(above, row), columns);
        }
    }
    [along, down]
}

/// The sums of steps from samples to others, each bounded, by their places modulo the side of a block. In floats, of
/// which more fit a vector: off by less than a millionth, where it takes a tenth to be told.
fn steps(from: &[f32], to: &[f32]) -> [f64; LANES] {
    let step = |from: f32, to: f32| {
        let step = (to - from).abs();
        if step < LARGEST_STEP { step } else { LARGEST_STEP }
    };
    sums(from, to, step).map(f64::from)
}

/// The sum of squares of the differences of samples from others.
fn squares(from: &[f32], to: &[f32]) -> f64 {
    sums(from, to, |from, to| f64::from(to - from) * f64::from(to - from)).iter().sum()
}

/// Sums over samples and the others beside them, lane by lane.
fn sums<T: Default + Copy + AddAssign>(
    from: &[f32],
    to: &[f32],
    of: impl Fn(f32, f32) -> T,
) -> [T; LANES] {
    let mut sums = [T::default(); LANES];
    let pairs = from.len().min(to.len());
    let (from, to) = (from[..pairs].as_chunks::<LANES>(), to[..pairs].as_chunks::<LANES>());
    for (from, to) in from.0.iter().zip(to.0) {
        for l in 0..LANES {
            sums[l] += of(from[l], to[l]);
        }
    }
    for (sum, (&from, &to)) in sums.iter_mut().zip(from.1.iter().zip(to.1)) {
        *sum += of(from, to);
    }
    sums
}

#[cfg(test)]
mod tests {
    use raster::Plane;

    use super::*;
    use crate::chance::Chance;

    /// The definition, along the rows of a picture.
    fn defined(grey: &Plane<f32>) -> [f64; 2] {
        let mut steps = [(0.0, 0.0); BLOCK];
        let (mut fine, mut coarse) = (Vec::new(), Vec::new());
        for y in 0..grey.rows() {
            let row = grey.row(y);
            for (x, pair) in row.windows(2).enumerate() {
                let step = f64::from((pair[1] - pair[0]).abs());
                steps[x % BLOCK].0 += step.min(6.0);
                steps[x % BLOCK].1 += 1.0;
                fine.push(step * step);
            }
            coarse.extend(row.windows(9).map(|run| f64::from(run[8] - run[0]).powi(2)));
        }
        let mut means = steps.map(|(sum, count)| sum / count);
        means.sort_by(f64::total_cmp);
        let mean = |squares: Vec<f64>| squares.iter().sum::<f64>() / squares.len() as f64;
        [2.0 * means[7] / (means[3] + means[4]), mean(fine) / mean(coarse)]
    }

    #[test]
    fn detail_is_what_its_definition_says_in_both_directions() {
        let mut chance = Chance(8);
        for (columns, rows) in [(64, 64), (70, 93), (131, 67)] {
            let grey = Plane::from_fn(columns, rows, |x, y| {
                let blocks = x / BLOCK * 3 % 5 + y / BLOCK * 2 % 7;
                (chance.bits(3) as usize + 4 * blocks) as u8
            });
            let along = grey.map(|&v| f32::from(v));
            let down = Plane::from_fn(rows, columns, |x, y| along.row(x)[y]);
            let found = details(&Image::Grey8(grey));
            for (detail, grey) in found.iter().zip([along, down]) {
                let [blockiness, fineness] = defined(&grey);
                assert!((detail.blockiness() - blockiness).abs() < 1e-9);
                assert!((detail.fineness() - fineness).abs() < 1e-9);
            }
        }
    }
}
