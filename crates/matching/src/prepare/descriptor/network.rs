//! The network: five convolutions, and a stream of rows through them.
//!
//! ```text
//! image - 3x3 - 3x3 - 3x3 - 3x3 - 1x1        16, 16, 32, 32, 64 channels
//! ```
//!
//! All four windows together see 9 x 9 pixels. A layer is as much smaller than the one before as its
//! window is larger than a pixel, and the image is continued beyond its border for as far as the network
//! sees: nothing is made up on the way, and the last layer has a pixel for each one of the image.
//!
//! A row is computed once one that needs it is asked for, and takes the place of one that is no longer
//! needed: a stream holds three rows of each layer, whatever the height of the image. It can begin at any
//! row, which is how threads share an image.

use std::sync::LazyLock;

use super::layer::{Weights, Window, convolve, row_length};
use super::normalized::Normalized;
use crate::kernels::level::Level;
use crate::kernels::products::Pair;

const LAYERS: [Window; 5] = [
    Window { side: 3, from: 1, to: 16 },
    Window { side: 3, from: 16, to: 16 },
    Window { side: 3, from: 16, to: 32 },
    Window { side: 3, from: 32, to: 32 },
    Window { side: 1, from: 32, to: 64 },
];

/// How far the network sees to each side.
pub(super) const REACH: usize = {
    let (mut reach, mut i) = (0, 0);
    while i < LAYERS.len() {
        reach += LAYERS[i].side / 2;
        i += 1;
    }
    reach
};

/// Rows of a layer that are held: those that a window sees.
const HELD: usize = 3;

/// Products for a pixel of the image: one for every weight of every layer.
pub(super) const PRODUCTS: usize = {
    let (mut products, mut i) = (0, 0);
    while i < LAYERS.len() {
        products += LAYERS[i].weights();
        i += 1;
    }
    products
};

/// Numbers of the network, layer after layer: weights in the order of [`Weights::new`], then what is
/// added to each channel; the upper halves of 32-bit floats. `training/descriptor.py` makes them.
const TRAINED: &[u8] = include_bytes!("weights.bin");

/// What the weights take, once for all matchers.
pub(super) const WEIGHT_BYTES: usize = Weights::bytes(TRAINED.len() / 2);

/// The weights of all layers.
static WEIGHTS: LazyLock<Vec<Weights>> = LazyLock::new(|| {
    let weights = trained()
        .map(|(window, weights, offsets)| Weights::new(window, weights.as_chunks().0, &offsets));
    weights.into()
});

/// Of each layer its weights and what is added to each channel.
fn trained() -> [(Window, Vec<f32>, Vec<f32>); LAYERS.len()] {
    let mut numbers = TRAINED.as_chunks().0.iter().map(|&upper| {
        let bits = u32::from(u16::from_le_bytes(upper)) << 16;
        f32::from_bits(bits)
    });
    let mut next = |count| -> Vec<f32> { numbers.by_ref().take(count).collect() };
    LAYERS.map(|window| (window, next(window.weights()), next(window.to)))
}

/// Some rows of a layer: row `y` stands in place `y % HELD`.
#[derive(Debug, Default)]
struct Held {
    columns: usize,
    /// Pairs of a row.
    length: usize,
    rows: [Option<usize>; HELD],
    samples: Vec<Pair>,
}

impl Held {
    fn reset(&mut self, columns: usize, channels: usize) {
        self.columns = columns;
        self.length = row_length(columns, channels);
        self.rows = [None; HELD];
        self.samples.clear();
        self.samples.resize(HELD * self.length, [0; 2]);
    }

    fn has(&self, y: usize) -> bool {
        self.rows[y % HELD] == Some(y)
    }

    fn row(&self, y: usize) -> &[Pair] {
        debug_assert!(self.has(y), "row {y} was asked for before it was computed");
        &self.samples[y % HELD * self.length..][..self.length]
    }

    /// The place of row `y`, for the caller to fill.
    fn place(&mut self, y: usize) -> &mut [Pair] {
        self.rows[y % HELD] = Some(y);
        &mut self.samples[y % HELD * self.length..][..self.length]
    }
}

/// Columns and channels of the rows of an image of so many columns, continued, and of its layers.
fn shapes(columns: usize) -> impl Iterator<Item = (usize, usize)> {
    let image = columns + 2 * REACH;
    let layers = LAYERS.iter().scan(image, |columns, window| {
        *columns -= window.side - 1;
        Some((*columns, window.to))
    });
    std::iter::once((image, 1)).chain(layers)
}

/// Rows of all layers, of an image that is read from the top to the bottom.
#[derive(Debug, Default)]
pub(super) struct Stream {
    /// Of the image, then of the layers.
    held: Vec<Held>,
}

impl Stream {
    /// What a stream takes for images of so many columns.
    pub fn bytes(columns: usize) -> usize {
        let rows = shapes(columns).map(|(columns, channels)| row_length(columns, channels));
        HELD * size_of::<Pair>() * rows.sum::<usize>()
    }

    /// Begins another image of so many columns.
    pub fn begin(&mut self, columns: usize) {
        self.held.resize_with(1 + LAYERS.len(), Held::default);
        for (held, (columns, channels)) in self.held.iter_mut().zip(shapes(columns)) {
            held.reset(columns, channels);
        }
    }

    /// The channels of the pixels of row `y`.
    pub fn row(&mut self, level: Level, image: &Normalized<'_>, y: usize) -> &[Pair] {
        need(level, image, &mut self.held, y);
        self.held.last().expect("a stream has begun").row(y)
    }
}

/// Computes row `y` of the last of some layers, and before it the rows that it sees: those from `y` on.
fn need(level: Level, image: &Normalized<'_>, held: &mut [Held], y: usize) {
    let Some((last, before)) = held.split_last_mut() else { return };
    if last.has(y) {
        return;
    }
    let Some(layer) = before.len().checked_sub(1) else {
        image.row(y, last.place(y));
        return;
    };
    let weights = &WEIGHTS[layer];
    let seen = y..y + weights.window.side;
    seen.clone().for_each(|row| need(level, image, before, row));
    let rows = [0, 1, 2].map(|row| before[layer].row((y + row).min(seen.end - 1)));
    let rectified = layer + 1 < LAYERS.len();
    let columns = last.columns;
    convolve(level, weights, rows, rectified, columns, last.place(y));
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::kernels::products::{LANES, ONE};
    use crate::prepare::grey::GreyView;
    use raster::Plane;

    pub const COLUMNS: usize = 37;
    pub const ROWS: usize = 50;
    /// How far a channel may lie from its definition, which does not round: this much, and as large a part of it.
    pub const ROUNDED: f64 = 0.03;

    pub fn image() -> Plane<u8> {
        Plane::from_fn(COLUMNS, ROWS, |x, y| ((x * 7 + y * y * 3) % 90 + (x / 9) * 30) as u8)
    }

    /// All rows of the last layer at once, pixel by pixel, without any rounding.
    pub fn definition(image: &Normalized<'_>) -> Vec<f64> {
        let (mut columns, mut rows) = (COLUMNS + 2 * REACH, ROWS + 2 * REACH);
        let mut input = vec![0.0; columns * rows];
        for (y, out) in input.chunks_exact_mut(columns).enumerate() {
            let mut row = vec![[0; 2]; columns];
            image.row(y, &mut row);
            out.iter_mut()
                .zip(row)
                .for_each(|(to, [from, _])| *to = f64::from(from) / f64::from(ONE));
        }
        for (i, (window, weights, offsets)) in trained().into_iter().enumerate() {
            let Window { side, from, to } = window;
            let wide = columns;
            (columns, rows) = (columns + 1 - side, rows + 1 - side);
            let out = (0..columns * rows * to).map(|at| {
                let (x, y, channel) = (at / to % columns, at / to / columns, at % to);
                let mut sum = f64::from(offsets[channel]);
                for (dy, dx) in (0..side).flat_map(|dy| (0..side).map(move |dx| (dy, dx))) {
                    for c in 0..from {
                        let at = ((channel / LANES * side + dy) * side + dx) * from + c;
                        let weight = weights[at * LANES + channel % LANES];
                        sum += input[((y + dy) * wide + x + dx) * from + c] * f64::from(weight);
                    }
                }
                if i + 1 < LAYERS.len() { sum.max(0.0) } else { sum }
            });
            input = out.collect();
        }
        assert_eq!((columns, rows), (COLUMNS, ROWS));
        input
    }

    #[test]
    fn rows_are_those_of_whole_layers_wherever_a_stream_begins() {
        let image = image();
        let normalized = Normalized::new(GreyView::Depth8(image.view()));
        let expected = definition(&normalized);
        let width = COLUMNS * LAYERS[LAYERS.len() - 1].to;
        let mut rows = Vec::new();
        for level in Level::available() {
            eprintln!("level {}", level.name());
            for begin in [0, 1, 30, 49] {
                let mut stream = Stream::default();
                stream.begin(COLUMNS);
                for y in begin..ROWS {
                    let row = stream.row(level, &normalized, y).as_flattened()[..width].to_vec();
                    match rows.get(y) {
                        None => rows.push(row.clone()),
                        Some(first) => assert_eq!(*first, row, "row {y} from row {begin} on"),
                    }
                    let expected = &expected[y * width..];
                    for (i, (&found, &expected)) in row.iter().zip(expected).enumerate() {
                        let found = f64::from(found) / f64::from(ONE);
                        let near = (found - expected).abs() < ROUNDED * (1.0 + expected.abs());
                        assert!(near, "row {y}, number {i}: {found}, {expected}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_weights_are_those_of_all_layers() {
        let numbers: usize = LAYERS.iter().map(|window| window.weights() + window.to).sum();
        assert_eq!(TRAINED.len(), 2 * numbers);
    }
}
