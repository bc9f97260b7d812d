//! The network: a table of layers, and a stream of rows through them.
//!
//! ```text
//! image - a1 - a2 ------------------------- a3 - a4 - a5     whole size; 16, 16, 32, 32, 64 channels
//!               `- b1 - b2 -------- b3 - b4 - b5 -´          half; 32 channels
//!                        `- c1 - c2 - c3 -´                  quarter; 48, 48, 32 channels
//! ```
//!
//! Coarser layers see farther for the same work. A row is computed once one that needs it is asked
//! for, and its place is taken by another some rows later: a stream holds a few rows of each layer,
//! whatever the height of the image. It can begin at any row, which is how threads share an image.

use std::sync::LazyLock;

use super::layer::{LANES, Shape, Weights, Window, add_twice_the_size, convolve};
use super::normalized::Normalized;
use crate::kernels::level::Level;

/// What a layer does: `max(convolution of input + coarser in twice the size, 0)`.
#[derive(Debug, Clone, Copy)]
struct Layer {
    /// The layer that is convolved; the image is number 0.
    input: usize,
    window: Window,
    /// The layer of half its size that is added.
    coarser: Option<usize>,
    /// Whether negative sums become zero.
    rectified: bool,
    /// Rows and columns of the image for one of its own.
    scale: usize,
    /// How many rows are held: those that are still needed when the layers below have looked ahead.
    held: usize,
}

const fn layer(input: usize, side: usize, from: usize, to: usize, scale: usize) -> Layer {
    let window = Window { side, stride: 1, from, to };
    Layer { input, window, coarser: None, rectified: true, scale, held: 4 }
}

impl Layer {
    /// Of half the size of its input.
    const fn halving(mut self) -> Self {
        self.window.stride = 2;
        self
    }

    const fn linear(mut self) -> Self {
        self.rectified = false;
        self
    }

    const fn with(mut self, coarser: usize) -> Self {
        self.coarser = Some(coarser);
        self
    }

    const fn holding(mut self, rows: usize) -> Self {
        self.held = rows;
        self
    }
}

/// Layers 1 to 13, a1 to a5 with the others between them.
const LAYERS: [Layer; 13] = [
    layer(0, 3, 1, 16, 1),
    layer(1, 3, 16, 16, 1).holding(32),
    layer(2, 3, 16, 32, 2).halving(),
    layer(3, 3, 32, 32, 2).holding(16),
    layer(4, 3, 32, 48, 4).halving(),
    layer(5, 3, 48, 48, 4),
    layer(6, 1, 48, 32, 4).linear(),
    layer(4, 1, 32, 32, 2).with(7),
    layer(8, 3, 32, 32, 2),
    layer(9, 1, 32, 32, 2).linear(),
    layer(2, 1, 16, 32, 1).with(10),
    layer(11, 3, 32, 32, 1),
    layer(12, 1, 32, 64, 1).linear(),
];

/// Rows of the image that are held.
const IMAGE_ROWS: usize = 4;
/// Rows and columns of an image are repeated up to a multiple of this, so that coarser layers have
/// whole pixels.
pub(super) const WHOLE: usize = 4;

/// Operations on bytes for a pixel of the image: a product and a sum of four bytes for every weight of
/// every layer.
pub(super) const OPERATIONS: usize = {
    let (mut products, mut i) = (0, 0);
    while i < LAYERS.len() {
        products += LAYERS[i].window.weights() / (LAYERS[i].scale * LAYERS[i].scale);
        i += 1;
    }
    8 * products
};

/// Numbers of the network, layer after layer: weights in the order of [`Weights`], then what is added
/// to each channel; the upper halves of 32-bit floats. `training/descriptor.py` makes them.
const TRAINED: &[u8] = include_bytes!("weights.bin");

/// What the weights take, once for all matchers.
pub(super) const WEIGHT_BYTES: usize = TRAINED.len() / 2 * size_of::<f32>();

/// The weights of all layers.
static WEIGHTS: LazyLock<Vec<Weights>> = LazyLock::new(|| {
    let mut numbers = TRAINED.as_chunks().0.iter().map(|&upper| {
        let bits = u32::from(u16::from_le_bytes(upper)) << 16;
        f32::from_bits(bits)
    });
    let mut next = || numbers.next().expect("there is a number for every weight");
    let weights = LAYERS.map(|layer| {
        let window = layer.window;
        let groups = window.weights() / LANES;
        let values = (0..groups).map(|_| std::array::from_fn(|_| next())).collect();
        Weights { window, values, offsets: (0..window.to).map(|_| next()).collect() }
    });
    weights.into()
});

/// The rows of a layer of half the size that row `y` of `rows` lies between: the nearer one, of which
/// it takes three quarters, and the farther one. Beyond its ends a layer is repeated.
fn rows_of_half_the_size(y: usize, rows: usize) -> [usize; 2] {
    let nearer = y / 2;
    let farther = if y.is_multiple_of(2) { nearer.saturating_sub(1) } else { nearer + 1 };
    [nearer, farther.min(rows / 2 - 1)]
}

/// Some rows of a layer: row `y` stands in place `y % held`.
#[derive(Debug, Default)]
struct Held {
    shape: Shape,
    rows: Vec<Option<usize>>,
    samples: Vec<f32>,
}

impl Held {
    fn reset(&mut self, shape: Shape, rows: usize) {
        self.shape = shape;
        self.rows.clear();
        self.rows.resize(rows, None);
        self.samples.clear();
        self.samples.resize(rows * shape.row(), 0.0);
    }

    fn has(&self, y: usize) -> bool {
        self.rows[y % self.rows.len()] == Some(y)
    }

    fn row(&self, y: usize) -> &[f32] {
        debug_assert!(self.has(y), "row {y} was asked for before it was computed");
        &self.samples[y % self.rows.len() * self.shape.row()..][..self.shape.row()]
    }

    /// The place of row `y`, for the caller to fill.
    fn place(&mut self, y: usize) -> &mut [f32] {
        let place = y % self.rows.len();
        self.rows[place] = Some(y);
        &mut self.samples[place * self.shape.row()..][..self.shape.row()]
    }
}

/// The rows of an image of so many columns and of its layers, and how many of each are held.
fn shapes(columns: usize) -> impl Iterator<Item = (Shape, usize)> {
    let columns = columns.next_multiple_of(WHOLE);
    let image = (Shape { columns, channels: 1 }, IMAGE_ROWS);
    let layers = LAYERS.iter().map(move |layer| {
        (Shape { columns: columns / layer.scale, channels: layer.window.to }, layer.held)
    });
    std::iter::once(image).chain(layers)
}

fn longest_row(columns: usize) -> usize {
    shapes(columns).map(|(shape, _)| shape.row()).max().unwrap_or(0)
}

/// Rows of all layers, of an image that is read from the top to the bottom.
#[derive(Debug, Default)]
pub(super) struct Stream {
    /// Of the image, then of the layers.
    held: Vec<Held>,
    /// A row of zeros, for windows over the border.
    zeros: Vec<f32>,
}

impl Stream {
    /// What a stream takes for images of so many columns.
    pub fn bytes(columns: usize) -> usize {
        let rows = shapes(columns).map(|(shape, held)| shape.row() * held);
        size_of::<f32>() * (rows.sum::<usize>() + longest_row(columns))
    }

    /// Begins another image of so many columns.
    pub fn begin(&mut self, columns: usize) {
        self.held.resize_with(1 + LAYERS.len(), Held::default);
        for (to, (shape, held)) in self.held.iter_mut().zip(shapes(columns)) {
            to.reset(shape, held);
        }
        self.zeros.resize(longest_row(columns), 0.0);
    }

    /// The channels of the pixels of row `y`.
    pub fn row(&mut self, level: Level, image: &Normalized<'_>, y: usize) -> &[f32] {
        let last = LAYERS.len();
        self.need(level, image, last, y);
        &self.held[last].row(y)[LAYERS[last - 1].window.to..]
    }

    /// Computes row `y` of a layer, and before it the rows that it needs.
    fn need(&mut self, level: Level, image: &Normalized<'_>, index: usize, y: usize) {
        if self.held[index].has(y) {
            return;
        }
        if index == 0 {
            image.row(y, &mut self.held[0].place(y)[1..]);
            return;
        }
        let layer = LAYERS[index - 1];
        let to = layer.window.to;
        let rows = image.rows().next_multiple_of(WHOLE) / layer.scale;
        let coarser = layer.coarser.map(|coarser| (coarser, rows_of_half_the_size(y, rows)));
        if let Some((coarser, rows)) = coarser {
            rows.into_iter().for_each(|row| self.need(level, image, coarser, row));
        }
        let seen = layer.window.rows(y, rows);
        for row in seen.into_iter().flatten() {
            self.need(level, image, layer.input, row);
        }
        let mut held = std::mem::take(&mut self.held[index]);
        let shape = held.shape;
        let out = held.place(y);
        let input = &self.held[layer.input];
        let seen =
            seen.map(|row| row.map_or(&self.zeros[..input.shape.row()], |row| input.row(row)));
        let rectified = layer.rectified && layer.coarser.is_none();
        convolve(level, &WEIGHTS[index - 1], seen, rectified, shape, out);
        if let Some((coarser, rows)) = coarser {
            let [nearer, farther] = rows.map(|row| self.held[coarser].row(row));
            add_twice_the_size(level, nearer, farther, to, shape.columns, out);
        }
        // Groups of pixels may have run over the border.
        out[(1 + shape.columns) * to..].fill(0.0);
        self.held[index] = held;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::grey::GreyView;
    use raster::Plane;

    fn image() -> Plane<u8> {
        Plane::from_fn(37, 50, |x, y| ((x * 7 + y * y * 3) % 90 + (x / 9) * 30) as u8)
    }

    /// All rows of all layers at once, pixel by pixel.
    fn definition(image: &Normalized<'_>, columns: usize) -> Vec<Vec<f64>> {
        let columns = columns.next_multiple_of(WHOLE);
        let rows = image.rows().next_multiple_of(WHOLE);
        let mut first = vec![0.0; columns * rows];
        for (y, out) in first.chunks_exact_mut(columns).enumerate() {
            let mut row = vec![0.0f32; columns];
            image.row(y, &mut row);
            out.iter_mut().zip(row).for_each(|(to, from)| *to = from.into());
        }
        let mut layers = vec![first];
        for (layer, weights) in LAYERS.iter().zip(WEIGHTS.iter()) {
            let Window { side, stride, from, to } = layer.window;
            let (width, height) = (columns / layer.scale, rows / layer.scale);
            let input = &layers[layer.input];
            let (input_width, input_height) = (width * stride, height * stride);
            let out = (0..width * height * to).map(|i| {
                let (x, y, channel) = (i / to % width, i / to / width, i % to);
                let mut sum = f64::from(weights.offsets[channel]);
                for (dy, dx) in (0..side).flat_map(|dy| (0..side).map(move |dx| (dy, dx))) {
                    let (u, v) = (x * stride + dx, y * stride + dy);
                    let inside = u >= side / 2 && v >= side / 2;
                    let (u, v) = (u.wrapping_sub(side / 2), v.wrapping_sub(side / 2));
                    if !inside || u >= input_width || v >= input_height {
                        continue;
                    }
                    for c in 0..from {
                        let at = ((channel / LANES * side + dy) * side + dx) * from + c;
                        let weight = weights.values[at][channel % LANES];
                        sum += input[(v * input_width + u) * from + c] * f64::from(weight);
                    }
                }
                if let Some(coarser) = layer.coarser {
                    let (coarse_width, coarse_height) = (width / 2, height / 2);
                    let ends = |z: usize, size: usize| {
                        let beside =
                            if z.is_multiple_of(2) { (z / 2).max(1) - 1 } else { z / 2 + 1 };
                        [(z / 2, 0.75), (beside.min(size - 1), 0.25)]
                    };
                    for (v, down) in ends(y, coarse_height) {
                        for (u, along) in ends(x, coarse_width) {
                            let at = (v * coarse_width + u) * to + channel;
                            sum += layers[coarser][at] * down * along;
                        }
                    }
                }
                let rectified = layer.rectified;
                if rectified { sum.max(0.0) } else { sum }
            });
            layers.push(out.collect());
        }
        layers
    }

    #[test]
    fn rows_are_those_of_whole_layers_wherever_a_stream_begins() {
        let image = image();
        let normalized = Normalized::new(GreyView::Depth8(image.view()));
        let expected = definition(&normalized, 37).pop().unwrap();
        let channels = LAYERS[LAYERS.len() - 1].window.to;
        let mut rows = Vec::new();
        for level in Level::available() {
            eprintln!("level {}", level.name());
            for begin in [0, 1, 30, 49] {
                let mut stream = Stream::default();
                stream.begin(37);
                for y in begin..50 {
                    let row = stream.row(level, &normalized, y)[..37 * channels].to_vec();
                    match rows.get(y) {
                        None => rows.push(row.clone()),
                        Some(first) => assert_eq!(*first, row, "row {y} from row {begin} on"),
                    }
                    let width = 37usize.next_multiple_of(WHOLE) * channels;
                    for (i, (&found, &expected)) in
                        row.iter().zip(&expected[y * width..]).enumerate()
                    {
                        let near =
                            (f64::from(found) - expected).abs() < 1e-3 * (1.0 + expected.abs());
                        assert!(near, "row {y}, number {i}: {found}, {expected}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_weights_are_those_of_all_layers() {
        let numbers: usize =
            LAYERS.iter().map(|layer| layer.window.weights() + layer.window.to).sum();
        assert_eq!(TRAINED.len(), 2 * numbers);
    }
}
