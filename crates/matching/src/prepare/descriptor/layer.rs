//! A layer of the network, a row at a time, in whole numbers.
//!
//! A row holds its pixels one after the other, each with all of its channels, two by two, and room for
//! as many more pixels as [`row_length`] says: pixels are computed in groups, and what the last group
//! makes beyond the row's end is of no interest.
//!
//! Samples are those of [`crate::kernels::products`], which reach from -64 to 64: an image that varies
//! at all stays within 6, and what the trained network makes of the tuning scenes within 50.

use crate::kernels::level::at_every_level;
use crate::kernels::products::{LANES, LEAST, Pair, Weighing, packed};

/// Pixels whose sums are taken together: each weight is loaded once for all of them.
const PIXELS: usize = 6;

/// How many pairs of channels a row of so many pixels holds, the second of a pair zero where there is
/// but one. The windows of whole groups of pixels must lie in it, which begin at one of its pixels.
pub(super) fn row_length(columns: usize, channels: usize) -> usize {
    (columns.next_multiple_of(PIXELS) + PIXELS) * channels.div_ceil(2)
}

/// What a convolution does at every pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Window {
    /// Columns and rows of the window: 1 or 3.
    pub side: usize,
    /// Channels in and out.
    pub from: usize,
    pub to: usize,
}

impl Window {
    pub const fn weights(self) -> usize {
        self.side * self.side * self.from * self.to
    }
}

/// The weights of a convolution.
#[derive(Debug)]
pub(super) struct Weights {
    pub window: Window,
    /// `[group][row][column][channels in, packed][lane]` with a group of [`LANES`] channels out.
    values: Vec<[i32; LANES]>,
    /// What each group of channels out begins with.
    offsets: Vec<[i32; LANES]>,
    weighing: Weighing,
}

impl Weights {
    /// What weights take that are so many numbers, while they are read too.
    pub const fn bytes(numbers: usize) -> usize {
        numbers * (size_of::<i16>() + size_of::<f32>())
    }

    /// From `numbers[group][row][column][channel in][lane]` and what is added to each channel out.
    pub fn new(window: Window, numbers: &[[f32; LANES]], offsets: &[f32]) -> Self {
        let inside = window.side * window.side * window.from;
        let (groups, offsets) = (numbers.chunks_exact(inside), offsets.as_chunks::<LANES>().0);
        let weighing = Weighing::of(groups.zip(offsets).flat_map(|(group, offsets)| {
            (0..LANES).map(|l| (group.iter().map(move |weights| weights[l]), offsets[l]))
        }));
        let pixels = numbers.chunks_exact(window.from);
        let mut values = Vec::with_capacity(pixels.len() * window.from.div_ceil(2));
        for pair in pixels.flat_map(|pixel| pixel.chunks(2)) {
            let [one, other] = [Some(&pair[0]), pair.get(1)]
                .map(|weights| weights.unwrap_or(&[0.0; LANES]).map(|w| weighing.weight(w)));
            values.push(std::array::from_fn(|l| packed(one[l], other[l])));
        }
        let offsets = offsets.iter().map(|group| group.map(|offset| weighing.offset(offset)));
        Self { window, values, offsets: offsets.collect(), weighing }
    }
}

at_every_level! {
    /// A row of a convolution: its pixel `x` sees the pixels from `x` on of the first of `rows`, as many
    /// as the window has. Negative sums become zero where `rectified`.
    pub(super) fn convolve[products](
        weights: &Weights,
        rows: [&[Pair]; 3],
        rectified: bool,
        columns: usize,
        out: &mut [Pair],
    ) {
        let Window { side, from, to } = weights.window;
        let from = from.div_ceil(2);
        let out = out.as_flattened_mut();
        let rows = &rows[..side];
        let least = if rectified { 0 } else { LEAST };
        let groups = weights.values.chunks_exact(side * side * from);
        for (group, (values, offsets)) in groups.zip(&weights.offsets).enumerate() {
            for first in (0..columns).step_by(PIXELS) {
                let mut sums = [*offsets; PIXELS];
                for (row, values) in rows.iter().zip(values.chunks_exact(side * from)) {
                    // The pixels of a window lie together: columns and channels are one.
                    let row = &row[first * from..];
                    // Written out: what a closure does is not compiled for the level.
                    let windows: [&[Pair]; PIXELS] = [
                        &row[..values.len()],
                        &row[from..][..values.len()],
                        &row[2 * from..][..values.len()],
                        &row[3 * from..][..values.len()],
                        &row[4 * from..][..values.len()],
                        &row[5 * from..][..values.len()],
                    ];
                    for (i, values) in values.iter().enumerate() {
                        for p in 0..PIXELS {
                            products.add(&mut sums[p], windows[p][i], values);
                        }
                    }
                }
                let pixels = out[first * to..].chunks_exact_mut(to);
                for (sums, pixel) in sums.iter().zip(pixels) {
                    let pixel = &mut pixel[group * LANES..][..LANES];
                    for lane in 0..LANES {
                        pixel[lane] = weights.weighing.sample(sums[lane], least) as i16;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::level::Level;
    use crate::kernels::products::ONE;

    fn noise(seed: usize) -> u32 {
        (seed as u32 ^ (seed as u32 >> 7)).wrapping_mul(0x9E37_79B1)
    }

    /// From -0.5 to 0.5.
    fn share(seed: usize) -> f32 {
        (noise(seed) >> 16) as f32 / 65536.0 - 0.5
    }

    #[test]
    fn a_convolution_is_its_definition_at_every_level() {
        for (side, from, to) in [(3, 1, 16), (3, 6, 32), (1, 16, 48), (3, 8, 16)] {
            let window = Window { side, from, to };
            let (columns, pairs) = (11, from.div_ceil(2));
            let input = columns + side - 1;
            let numbers: Vec<f32> = (0..window.weights()).map(|i| share(i + 99)).collect();
            let offsets: Vec<f32> = (0..to).map(|i| share(i + 7)).collect();
            let weights = Weights::new(window, numbers.as_chunks().0, &offsets);
            // The largest samples too.
            let sample =
                |i: usize| if i.is_multiple_of(5) { i16::MAX } else { noise(i) as i16 / 64 };
            let rows = [1, 2, 3].map(|seed| -> Vec<Pair> {
                (0..row_length(input, from)).map(|i| [seed + i, 7 * seed + i].map(sample)).collect()
            });
            for level in Level::available() {
                eprintln!("level {}", level.name());
                let mut out = vec![[0; 2]; row_length(columns, to)];
                convolve(level, &weights, rows.each_ref().map(|r| &r[..]), true, columns, &mut out);
                for (x, channel) in (0..columns).flat_map(|x| (0..to).map(move |c| (x, c))) {
                    let (group, lane) = (channel / LANES, channel % LANES);
                    let mut sum = f64::from(offsets[channel] * ONE);
                    for (dy, dx) in (0..side).flat_map(|dy| (0..side).map(move |dx| (dy, dx))) {
                        for c in 0..from {
                            let at = (((group * side + dy) * side + dx) * from + c) * LANES + lane;
                            let weight = weights.weighing.weight(numbers[at]) as f32;
                            let weight = weight * weights.weighing.unit() * ONE;
                            let pair = rows[dy][(x + dx) * pairs + c / 2];
                            sum += f64::from(pair[c % 2]) * f64::from(weight);
                        }
                    }
                    let found = f64::from(out[(x * to + channel) / 2][channel % 2]);
                    let off = found - sum.clamp(0.0, 32767.0);
                    assert!(off.abs() <= 0.51, "{window:?} ({x}, {channel}): {found}, {sum}");
                }
            }
        }
    }
}
