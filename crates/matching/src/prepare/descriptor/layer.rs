//! The layers of the network, a row at a time.
//!
//! A row holds its pixels one after the other, each with all of its channels, with a pixel of zeros
//! before the first one and at least as many after the last one as [`Shape::row`] says: a window that
//! looks over the border of the image sees zeros there.
//!
//! A weighted sum is taken channel after channel, in the same order for every pixel and at every
//! level, and never with a fused multiply-add: all levels give the same bits.

use crate::kernels::level::at_every_level;

/// Channels of the output that are summed together.
pub(super) const LANES: usize = 16;
/// Pixels whose sums are taken together: each weight is loaded once for all of them.
const PIXELS: usize = 6;

/// Columns and channels of a layer's rows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Shape {
    pub columns: usize,
    pub channels: usize,
}

impl Shape {
    /// How many numbers a row holds, with its borders: windows are taken in whole groups of pixels,
    /// and with a step of two columns they reach that much farther.
    pub fn row(self) -> usize {
        (1 + self.columns.next_multiple_of(2 * PIXELS) + 2 * PIXELS) * self.channels
    }
}

/// What a convolution does at every pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Window {
    /// Columns and rows of the window: 1 or 3.
    pub side: usize,
    /// Columns and rows from one window to the next.
    pub stride: usize,
    /// Channels in and out.
    pub from: usize,
    pub to: usize,
}

impl Window {
    pub const fn weights(self) -> usize {
        self.side * self.side * self.from * self.to
    }

    /// The rows of the input that the window at row `y` of `rows` sees, above, at and below its middle;
    /// none beyond the border, and none beside the middle of a single pixel.
    pub fn rows(self, y: usize, rows: usize) -> [Option<usize>; 3] {
        let middle = y * self.stride;
        [0, 1, 2].map(|row| {
            let row = (middle + row).checked_sub(1)?;
            (row < rows * self.stride && (self.side == 3 || row == middle)).then_some(row)
        })
    }
}

/// The weights of a convolution: `values[group][row][column][channel in][lane]` with a group of
/// [`LANES`] channels out, and what is added to each channel out.
#[derive(Debug)]
pub(super) struct Weights {
    pub window: Window,
    pub values: Vec<[f32; LANES]>,
    pub offsets: Vec<f32>,
}

at_every_level! {
    /// A row of a convolution: `rows` are those that its window sees, the sums go to the pixels of
    /// `out`. Negative ones become zero where `rectified`.
    pub(super) fn convolve(
        weights: &Weights,
        rows: [&[f32]; 3],
        rectified: bool,
        shape: Shape,
        out: &mut [f32],
    ) {
        let Window { side, stride, from, to } = weights.window;
        // A single pixel lies in the middle of what three would be.
        let rows = if side == 3 { &rows[..] } else { &rows[1..2] };
        let border = if side == 3 { 0 } else { from };
        let least = if rectified { 0.0 } else { f32::NEG_INFINITY };
        let groups = weights.values.chunks_exact(side * side * from);
        let (groups, offsets) = (groups, weights.offsets.as_chunks::<LANES>().0);
        for (group, (values, offsets)) in groups.zip(offsets).enumerate() {
            for first in (0..shape.columns).step_by(PIXELS) {
                let mut sums = [*offsets; PIXELS];
                for (row, values) in rows.iter().zip(values.chunks_exact(side * from)) {
                    // The pixels of a window lie together: columns and channels are one.
                    let next = stride * from;
                    let row = &row[border + first * next..];
                    // Written out: what a closure does is not compiled for the level.
                    let windows: [&[f32]; PIXELS] = [
                        &row[..values.len()],
                        &row[next..][..values.len()],
                        &row[2 * next..][..values.len()],
                        &row[3 * next..][..values.len()],
                        &row[4 * next..][..values.len()],
                        &row[5 * next..][..values.len()],
                    ];
                    for (i, values) in values.iter().enumerate() {
                        for p in 0..PIXELS {
                            let sample = windows[p][i];
                            for lane in 0..LANES {
                                sums[p][lane] += sample * values[lane];
                            }
                        }
                    }
                }
                let pixels = out[(1 + first) * to..].chunks_exact_mut(to);
                for (sums, pixel) in sums.iter().zip(pixels) {
                    let pixel = &mut pixel[group * LANES..][..LANES];
                    for lane in 0..LANES {
                        pixel[lane] = sums[lane].max(least);
                    }
                }
            }
        }
    }
}

at_every_level! {
    /// Adds a row of twice the size to `out`, and what is negative becomes zero: row `y` of the
    /// larger image lies a quarter of a row from the `nearer` one of the smaller image, three
    /// quarters from the `farther` one, and columns likewise. Beyond its ends a row is repeated.
    pub(super) fn add_twice_the_size(
        nearer: &[f32],
        farther: &[f32],
        channels: usize,
        columns: usize,
        out: &mut [f32],
    ) {
        let pixel = |x: usize| 1 + x.min(columns.div_ceil(2) - 1);
        for (x, out) in out.chunks_exact_mut(channels).skip(1).take(columns).enumerate() {
            let half = x / 2;
            let beside = if x % 2 == 0 { half.saturating_sub(1) } else { half + 1 };
            let [a, b] = [half, beside].map(|x| &nearer[pixel(x) * channels..][..channels]);
            let [c, d] = [half, beside].map(|x| &farther[pixel(x) * channels..][..channels]);
            for i in 0..channels {
                let (near, far) = (0.75 * a[i] + 0.25 * b[i], 0.75 * c[i] + 0.25 * d[i]);
                out[i] = (out[i] + (0.75 * near + 0.25 * far)).max(0.0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::level::Level;

    fn noise(seed: usize) -> f32 {
        let mixed = (seed as u32 ^ (seed as u32 >> 7)).wrapping_mul(0x9E37_79B1);
        (mixed >> 16) as f32 / 65536.0 - 0.5
    }

    /// A row with its borders; what lies beyond them must not count.
    fn row(shape: Shape, seed: usize) -> Vec<f32> {
        let inside = shape.channels..(1 + shape.columns) * shape.channels;
        let sample = |i| if inside.contains(&i) { noise(i + seed) } else { 0.0 };
        (0..shape.row()).map(sample).collect()
    }

    #[test]
    fn a_convolution_is_its_definition_at_every_level() {
        for (side, stride, from, to) in
            [(3, 1, 1, 16), (3, 2, 5, 32), (1, 1, 16, 48), (3, 1, 8, 16)]
        {
            let window = Window { side, stride, from, to };
            let shape = Shape { columns: 11, channels: to };
            let input = Shape { columns: 11 * stride, channels: from };
            let numbers: Vec<f32> = (0..window.weights()).map(|i| noise(i + 99)).collect();
            let values = numbers.as_chunks().0.to_vec();
            let offsets: Vec<f32> = (0..to).map(|i| noise(i + 7)).collect();
            let weights = Weights { window, values, offsets };
            let rows = [1, 2, 3].map(|seed| row(input, 1000 * seed));
            for level in Level::available() {
                eprintln!("level {}", level.name());
                let mut out = vec![0.0; shape.row()];
                convolve(level, &weights, rows.each_ref().map(|r| &r[..]), true, shape, &mut out);
                for (x, channel) in (0..11).flat_map(|x| (0..to).map(move |c| (x, c))) {
                    let (group, lane) = (channel / LANES, channel % LANES);
                    let mut sum = weights.offsets[channel];
                    for (dy, dx) in (0..side).flat_map(|dy| (0..side).map(move |dx| (dy, dx))) {
                        for c in 0..from {
                            let at = ((group * side + dy) * side + dx) * from + c;
                            let (row, column) = match side {
                                1 => (1, x + 1),
                                _ => (dy, x * stride + dx),
                            };
                            sum += rows[row][column * from + c] * weights.values[at][lane];
                        }
                    }
                    assert_eq!(
                        out[(1 + x) * to + channel],
                        sum.max(0.0),
                        "{window:?} ({x}, {channel})"
                    );
                }
            }
        }
    }

    #[test]
    fn twice_the_size_keeps_a_slope() {
        // Values rise by 4 per coarse column, by 8 per coarse row: by 2 and 4 per fine one.
        let (coarse, fine) =
            (Shape { columns: 6, channels: 1 }, Shape { columns: 12, channels: 1 });
        let ramp = |y: f32| -> Vec<f32> {
            (0..coarse.row()).map(|i| 100.0 + 4.0 * (i as f32 - 1.0) + 8.0 * y).collect()
        };
        for level in Level::available() {
            let mut out = vec![0.0; fine.row()];
            add_twice_the_size(level, &ramp(1.0), &ramp(0.0), 1, 12, &mut out);
            for x in 1..11 {
                // Half a coarse pixel before and above the first fine one.
                let expected = 100.0 + 2.0 * (x as f32 - 0.5) + 8.0 * 0.75;
                assert!((out[1 + x] - expected).abs() < 1e-3, "{x}: {} {expected}", out[1 + x]);
            }
        }
    }
}
