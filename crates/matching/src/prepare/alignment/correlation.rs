//! How alike windows of the left and the right image are: normalised cross-correlation at whole pixels, in whole
//! numbers.

use raster::{DisparityRange, View};

use crate::kernels::aligned::Line;
use crate::kernels::products::{Pair, Products, packed};

/// Columns and rows of a window; its middle has 7 columns before it and 5 rows above it.
pub(super) const WIDE: usize = 16;
pub(super) const TALL: usize = 11;
pub(super) const BEFORE: usize = 7;
pub(super) const ABOVE: usize = 5;
/// Pixels of a window.
pub(super) const PIXELS: i32 = (WIDE * TALL) as i32;
/// Windows with less variance than this are flat: 1 per pixel, see [`variance`].
pub(super) const FLAT_WINDOW: i32 = PIXELS * PIXELS;

/// A place of an image.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub x: usize,
    pub y: usize,
}

/// Scratch memory: how alike the places of a row are.
#[derive(Debug, Default)]
pub(super) struct Scores(Vec<f32>);

impl Scores {
    fn most(columns: usize, range: DisparityRange) -> usize {
        range.count().min(columns).next_multiple_of(WIDE)
    }

    pub fn bytes(columns: usize, range: DisparityRange) -> usize {
        size_of::<f32>() * Self::most(columns, range)
    }

    pub fn reserve(&mut self, columns: usize, range: DisparityRange) {
        self.0.clear();
        self.0.reserve_exact(Self::most(columns, range));
    }
}

/// The samples of a window as pairs of neighbours along its rows, with what a correlation makes of them.
pub(super) struct Pattern {
    pairs: [[Pair; WIDE / 2]; TALL],
    sum: i32,
    /// 1 over the root of [`variance`].
    scale: f32,
}

impl Pattern {
    /// That of a place; none where it is flat.
    #[inline(always)]
    pub fn of(image: View<'_, u8>, Place { x, y }: Place) -> Option<Self> {
        let mut pairs = [[[0; 2]; WIDE / 2]; TALL];
        let (mut sums, mut squares) = ([0; WIDE], [0; WIDE]);
        for (j, pairs) in pairs.iter_mut().enumerate() {
            let row = &image.row(y + j - ABOVE)[x - BEFORE..][..WIDE];
            for l in 0..WIDE {
                let sample = i32::from(row[l]);
                sums[l] += sample;
                squares[l] += sample * sample;
            }
            for (pair, samples) in pairs.iter_mut().zip(row.as_chunks::<2>().0) {
                *pair = samples.map(i16::from);
            }
        }
        let sum = sums.iter().sum();
        let variance = variance(sum, squares.iter().sum());
        (variance >= FLAT_WINDOW).then(|| Self {
            pairs,
            sum,
            scale: 1.0 / (variance as f32).sqrt(),
        })
    }
}

/// How far the samples of a window are from their mean: their number times the squares of that, all of them. Of 8
/// bits it is less than 2^31.
#[inline(always)]
fn variance(sum: i32, squares: i32) -> i32 {
    PIXELS * squares - sum * sum
}

/// The largest score, lane by lane: one after the other each would wait for the last.
#[inline(always)]
pub(super) fn largest(scores: &[f32]) -> f32 {
    let mut most = Line([f32::NEG_INFINITY; WIDE]);
    let (blocks, rest) = scores.as_chunks::<WIDE>();
    for block in blocks {
        for l in 0..WIDE {
            most[l] = if block[l] > most[l] { block[l] } else { most[l] };
        }
    }
    most.iter().chain(rest).fold(f32::NEG_INFINITY, |most, &score| most.max(score))
}

/// Pairs of neighbours in a row, [`packed`], from `start` on, as many as windows at [`WIDE`] places see; zeros
/// beyond its end.
#[inline(always)]
fn pairs_from(row: &[u8], start: usize) -> [i32; 2 * WIDE] {
    #[inline(always)]
    fn pairs(samples: &[u8; 2 * WIDE + 1]) -> [i32; 2 * WIDE] {
        let mut out = [0; 2 * WIDE];
        for i in 0..2 * WIDE {
            out[i] = packed(i32::from(samples[i]), i32::from(samples[i + 1]));
        }
        out
    }
    let rest = &row[start..];
    match rest.first_chunk() {
        Some(whole) => pairs(whole),
        None => {
            let mut samples = [0; 2 * WIDE + 1];
            samples[..rest.len()].copy_from_slice(rest);
            pairs(&samples)
        }
    }
}

/// The correlation of a window with those of the right image whose middles are at row `y` from column
/// `first` on. In whole numbers, which are exact, and of which two products are added at once.
#[inline(always)]
pub(super) fn correlate<'a>(
    products: impl Products,
    wanted: &Pattern,
    right: View<'_, u8>,
    y: usize,
    first: usize,
    count: usize,
    scores: &'a mut Scores,
) -> &'a [f32] {
    let scores = &mut scores.0;
    scores.resize(count.next_multiple_of(WIDE), 0.0);
    for (block, scores) in scores.chunks_exact_mut(WIDE).enumerate() {
        let start = first + block * WIDE - BEFORE;
        // Of columns, then of windows.
        let (mut sums, mut squares) = (Line([0; 2 * WIDE]), Line([0; 2 * WIDE]));
        // All of them before any is read: what was only just written is slow to be had from elsewhere.
        let mut rows = Line([[0; 2 * WIDE]; TALL]);
        for (j, row) in rows.iter_mut().enumerate() {
            *row = pairs_from(right.row(y + j - ABOVE), start);
        }
        // Four sums of their own: one would wait for itself.
        let mut added = [Line([0; WIDE]); 4];
        for (row, wanted) in rows.iter().zip(&wanted.pairs) {
            for i in 0..2 * WIDE {
                let sample = row[i] & 0xFFFF;
                sums[i] += sample;
                squares[i] += sample * sample;
            }
            for (n, &pair) in wanted.iter().enumerate() {
                let own = row[2 * n..].first_chunk().expect("as many as there are places");
                products.add(&mut added[n % 4], pair, own);
            }
        }
        let (mut sum, mut square) = (Line([0; WIDE]), Line([0; WIDE]));
        for i in 0..WIDE {
            for l in 0..WIDE {
                sum[l] += sums[i + l];
                square[l] += squares[i + l];
            }
        }
        let [a, b, c, d] = &added;
        for l in 0..WIDE {
            let shared = PIXELS * (a[l] + b[l] + c[l] + d[l]) - wanted.sum * sum[l];
            let variance = variance(sum[l], square[l]);
            let score = wanted.scale * shared as f32 / (variance.max(1) as f32).sqrt();
            scores[l] = if variance > FLAT_WINDOW { score } else { 0.0 };
        }
    }
    &scores[..count]
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use super::super::correspondence::tests::seen;
    use super::super::correspondence::{EMPTY, MARGIN, Window, normalised};
    use super::*;
    use crate::kernels::level::{Level, at_every_level};

    /// The samples of a window.
    fn window(image: View<'_, u8>, Place { x, y }: Place) -> Window {
        let mut window = EMPTY;
        for (j, samples) in window.iter_mut().enumerate() {
            let row = &image.row(y + j - ABOVE)[x - BEFORE..][..WIDE];
            for l in 0..WIDE {
                samples[l] = f32::from(row[l]);
            }
        }
        window
    }

    at_every_level! {
        fn correlations[products](wanted: &Pattern, right: View<'_, u8>, y: usize, columns: Range<usize>) -> Vec<f32> {
            let mut scores = Scores::default();
            correlate(products, wanted, right, y, columns.start, columns.len(), &mut scores).to_vec()
        }
    }

    #[test]
    fn correlation_is_its_definition_at_every_level() {
        let images = [seen(0.0, 0.0, 1.0), seen(-6.0, 0.0, 1.0)];
        let place = Place { x: 60, y: 40 };
        let (wanted, _) = normalised(window(images[0].view(), place)).unwrap();
        let pattern = Pattern::of(images[0].view(), place).unwrap();
        let scores =
            |level| correlations(level, &pattern, images[1].view(), 40, MARGIN..120 - MARGIN);
        let first = scores(Level::available()[0]);
        for level in Level::available() {
            eprintln!("level {}", level.name());
            assert_eq!(scores(level), first);
        }
        for (x, score) in (MARGIN..).zip(first) {
            let there = Place { x, y: 40 };
            let (there, _) = normalised(window(images[1].view(), there)).unwrap();
            let products = there.iter().flatten().zip(wanted.iter().flatten());
            let expected: f32 = products.map(|(a, b)| a * b).sum();
            assert!((score - expected).abs() < 1e-5, "{x}: {score} {expected}");
        }
    }
}
