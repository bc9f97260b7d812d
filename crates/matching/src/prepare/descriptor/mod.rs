//! Learned descriptors: 64 bits per pixel whose Hamming distance tells how unlike two places are.
//!
//! A small convolutional network is trained to tell the right match of a pixel from all others of its
//! row (MC-CNN: Zbontar & LeCun, JMLR 2016; as a choice among disparities: Luo, Schwing & Urtasun, CVPR
//! 2016). It looks at 9 x 9 pixels: not far, so that it keeps the edges of objects, but it tells places
//! apart that census words of 7 x 5 pixels cannot, on walls with little texture, roads, gloss.
//!
//! `training/descriptor.py` made the weights (18 480 numbers), from pairs of Middlebury 2005, 2006 and
//! 2014 (Scharstein & Pal 2007, Hirschmueller & Scharstein 2007, Scharstein et al. 2014), KITTI 2015
//! (Menze & Geiger 2015), ETH3D (Schoeps et al. 2017), SceneFlow (Mayer et al. 2016) and rendered ones.

mod layer;
mod network;
mod normalized;

use raster::Plane;
use rayon::prelude::*;

use self::network::Stream;
use self::normalized::Normalized;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::products::Pair;
use crate::prepare::grey::GreyView;
use crate::profile::Work;

/// The memory of the network, kept between frames.
#[derive(Debug, Default)]
pub(crate) struct Descriptors {
    /// Of each band of rows.
    bands: Vec<Band>,
}

/// The memory of a band of rows.
#[derive(Debug, Default)]
struct Band {
    stream: Stream,
    row: Vec<u64>,
}

impl Descriptors {
    /// What it takes for images of so many columns.
    pub fn bytes(columns: usize) -> usize {
        let band = Stream::bytes(columns) + size_of::<u64>() * columns;
        network::WEIGHT_BYTES + rayon::current_num_threads() * band
    }

    /// The descriptors of as many rows of an image as `out` has, from row `first` on: `put(row, out)`
    /// copies those of a row to their place. The image is read once for its mean and once for its rows.
    pub fn compute(
        &mut self,
        level: Level,
        image: GreyView<'_>,
        first: usize,
        out: &mut Plane<u64>,
        put: impl Fn(&[u64], &mut [u64]) + Sync,
    ) -> Work {
        let (width, height) = image.size();
        let read = image.bytes(height) + image.bytes(out.rows());
        let image = Normalized::new(image);
        let (columns, rows) = out.size();
        let height = rows.div_ceil(rayon::current_num_threads());
        self.bands.resize_with(rayon::current_num_threads(), Band::default);
        let bands = out.samples_mut().par_chunks_mut(columns * height).zip(&mut self.bands);
        bands.enumerate().for_each(|(i, (out, Band { stream, row }))| {
            stream.begin(width);
            row.resize(width, 0);
            for (y, out) in (first + i * height..).zip(out.chunks_exact_mut(columns)) {
                signs(level, stream.row(level, &image, y), row);
                put(row, out);
            }
        });
        Work::bytes(read) + Work::products(network::PRODUCTS) * (width * rows)
    }
}

at_every_level! {
    /// A bit per channel: whether it is above zero.
    fn signs(pixels: &[Pair], words: &mut [u64]) {
        for (word, channels) in words.iter_mut().zip(pixels.as_flattened().as_chunks::<64>().0) {
            *word = 0;
            for (i, &channel) in channels.iter().enumerate() {
                *word |= u64::from(channel > 0) << i;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::network::tests::{COLUMNS, ROUNDED, ROWS, definition, image};
    use super::*;

    #[test]
    fn a_bit_is_set_where_its_channel_is_above_zero() {
        let channel = |i: usize| [1, 0, -1, 40, i16::MIN, i16::MAX, -40][i * i % 37 % 7];
        let pixels: Vec<Pair> = (0..32 * 9).map(|i| [channel(2 * i), channel(2 * i + 1)]).collect();
        let expected: Vec<u64> = (0..9)
            .map(|x| (0..64).map(|i| u64::from(channel(64 * x + i) > 0) << i).sum())
            .collect();
        for level in Level::available() {
            let mut words = vec![u64::MAX; 9];
            signs(level, &pixels, &mut words);
            assert_eq!(words, expected, "level {}", level.name());
        }
    }

    #[test]
    fn descriptors_are_the_signs_of_the_network_whatever_the_bands() {
        let image = image();
        let view = GreyView::Depth8(image.view());
        let expected = definition(&Normalized::new(view));
        // Some rows of some columns, so that bands end within them and the last is shorter.
        let (left, first) = (5, 3);
        let (columns, rows) = (COLUMNS - left - 2, ROWS - first - 6);
        let mut found: Option<Plane<u64>> = None;
        for level in Level::available() {
            eprintln!("level {}", level.name());
            let mut descriptors = Descriptors::default();
            for threads in [1, 7, 2, 3, 50] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let mut words = Plane::filled(columns, rows, 0);
                let put = |row: &[u64], to: &mut [u64]| to.copy_from_slice(&row[left..][..columns]);
                pool.install(|| descriptors.compute(level, view, first, &mut words, put));
                let found = found.get_or_insert_with(|| words.clone());
                assert!(words == *found, "{threads} threads");
            }
        }
        let found = found.expect("there is a level");
        let mut told = 0;
        for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
            let channels = &expected[((first + y) * COLUMNS + left + x) * 64..][..64];
            for (i, &channel) in channels.iter().enumerate() {
                // What lies nearer to zero may be rounded to its other side.
                if channel.abs() > ROUNDED * (1.0 + channel.abs()) {
                    let bit = found.row(y)[x] >> i & 1 == 1;
                    assert_eq!(bit, channel > 0.0, "({x}, {y}), bit {i}: {channel}");
                    told += 1;
                }
            }
        }
        let all = 64 * columns * rows;
        assert!(told * 10 > all * 9, "{told} of {all} bits are clear");
    }
}
