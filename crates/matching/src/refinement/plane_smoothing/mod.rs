//! Every pixel goes onto the [plane](plane) that its neighbours lie on, unless the [images](evidence) speak against it.
//!
//! Penalties of the paths press disparities towards whole numbers, and choices copy planes from afar: a floor comes out
//! as a staircase, and a wall rough. Planes go over what is as small as their window, too: most of what is near a stone
//! that stands a pixel before the ground is ground. So what they leave is compared with what was there before, by what
//! both images show.
//!
//! The shift by [least squares](super::least_squares) comes after it: one that is right in the mean of a window leaves
//! the stairs in it.

mod evidence;
mod plane;

use raster::{Plane, View};
use rayon::prelude::*;

use self::evidence::{Differences, Row, SIDE, decide};
use self::plane::smooth_row;
use super::Map;
use crate::kernels::level::Level;
use crate::profile::Work;

/// The memory of the stage, kept between frames.
#[derive(Default)]
pub(crate) struct PlaneSmoothing {
    bands: Vec<Band>,
}

/// That of a band of rows.
#[derive(Default)]
struct Band {
    /// The rows that windows of the images see.
    rows: [Smoothed; SIDE],
    /// By how much the images differ in a row.
    scratch: Vec<i16>,
}

/// A row on its planes, and by how much the images differ there: before, and on them.
#[derive(Default)]
struct Smoothed {
    values: Vec<f32>,
    differences: [Differences; 2],
}

impl PlaneSmoothing {
    /// What it takes for so many disparities in a row, each of which stands for so many columns.
    pub fn bytes(columns: usize, apart: usize) -> usize {
        let row = size_of::<f32>() + 2 * Differences::BYTES;
        rayon::current_num_threads() * columns * (SIDE * row + apart * size_of::<i16>())
    }

    /// Smooths a map whose columns are `apart` pixels of the image apart (1 or 2), as its rows are at the most. What `scratch`
    /// held is lost.
    pub fn smooth(
        &mut self,
        level: Level,
        apart: usize,
        grey: [View<'_, u8>; 2],
        map: Map<'_>,
        scratch: &mut Plane<f32>,
    ) -> Work {
        match apart {
            1 => self.smooth_map::<1>(level, grey, map, scratch),
            _ => self.smooth_map::<2>(level, grey, map, scratch),
        }
    }

    fn smooth_map<const APART: usize>(
        &mut self,
        level: Level,
        grey: [View<'_, u8>; 2],
        map: Map<'_>,
        scratch: &mut Plane<f32>,
    ) -> Work {
        let (columns, rows) = map.values.size();
        scratch.reshape(columns, rows, 0.0);
        let height = rows.div_ceil(rayon::current_num_threads());
        self.bands.resize_with(rayon::current_num_threads(), Band::default);
        let bands = scratch.samples_mut().par_chunks_mut(height * columns);
        let bands = self.bands.par_iter_mut().zip(bands).enumerate();
        bands.for_each(|(i, (band, out))| {
            band.smooth::<APART>(level, i * height, grey, &map, out);
        });
        map.values.samples_mut().copy_from_slice(scratch.samples());
        // Rows that two bands see are smoothed by both, which is not counted.
        let pixel = Work::bytes(4 * size_of::<f32>())
            + Work::operations(plane::OPERATIONS + evidence::operations(APART));
        pixel * (columns * rows)
    }
}

impl Band {
    /// Its rows, of which number `start` of the map is the first.
    fn smooth<const APART: usize>(
        &mut self,
        level: Level,
        start: usize,
        grey: [View<'_, u8>; 2],
        map: &Map<'_>,
        out: &mut [f32],
    ) {
        let (columns, rows) = map.values.size();
        let Self { rows: kept, scratch } = self;
        let radius = evidence::radius(APART);
        let mut next = start.saturating_sub(radius);
        for (y, out) in (start..).zip(out.chunks_mut(columns)) {
            let (first, end) = (y.saturating_sub(radius), (y + radius + 1).min(rows));
            while next < end {
                kept[next % SIDE].become_row::<APART>(level, next, grey, map, scratch);
                next += 1;
            }
            let window: [_; SIDE] = std::array::from_fn(|j| {
                let [before, after] = &kept[(first + j) % SIDE].differences;
                [before, after]
            });
            let (before, smoothed) = (map.values.row(y), &kept[y % SIDE].values);
            decide::<APART>(level, &window[..end - first], before, smoothed, out);
        }
    }
}

impl Smoothed {
    fn become_row<const APART: usize>(
        &mut self,
        level: Level,
        y: usize,
        grey: [View<'_, u8>; 2],
        map: &Map<'_>,
        scratch: &mut Vec<i16>,
    ) {
        self.values.resize(map.values.columns(), 0.0);
        smooth_row::<APART>(level, map.values, y, map.range, &mut self.values);
        let [left, right] = grey.map(|image| image.row(map.rows.in_image(y)));
        let row = Row { left, right, first: map.first };
        for (values, differences) in
            [map.values.row(y), &self.values].into_iter().zip(&mut self.differences)
        {
            differences.become_those_of::<APART>(level, row, values, scratch);
        }
    }
}

#[cfg(test)]
mod tests {
    use raster::DisparityRange;

    use super::*;
    use crate::cost::MatchedRows;

    const SIZE: (usize, usize) = (70, 50);
    const GROUND: f32 = 10.0;
    const STONE: f32 = 11.0;

    /// A disc of 15 pixels.
    fn is_stone(x: usize, y: usize) -> bool {
        x.abs_diff(40).pow(2) + y.abs_diff(24).pow(2) < 8 * 8
    }

    /// The left image, and the right one of a stone on the ground.
    fn seen(texture: impl Fn(usize, usize) -> u8) -> [Plane<u8>; 2] {
        let (columns, rows) = SIZE;
        let right = Plane::from_fn(columns, rows, |x, y| {
            let of_stone = is_stone(x + STONE as usize, y);
            texture(x + if of_stone { STONE } else { GROUND } as usize, y)
        });
        [Plane::from_fn(columns, rows, &texture), right]
    }

    /// The true map, every so many-th pixel of it, smoothed.
    fn smoothed(level: Level, apart: usize, [left, right]: &[Plane<u8>; 2]) -> Plane<f32> {
        let (columns, rows) = SIZE;
        let mut values = Plane::from_fn(columns / apart, rows / apart, |x, y| {
            if is_stone(apart * x, apart * y) { STONE } else { GROUND }
        });
        let map = Map {
            values: &mut values,
            first: 0,
            rows: MatchedRows { top: 0, count: rows / apart, apart },
            range: DisparityRange::new(0, 20).unwrap(),
        };
        let (grey, mut scratch) = ([left.view(), right.view()], Plane::default());
        PlaneSmoothing::default().smooth(level, apart, grey, map, &mut scratch);
        values
    }

    fn texture(x: usize, y: usize) -> u8 {
        (x * 7919 + y * 104_729 + x * x * y * 31) as u8
    }

    /// By how much the pixels of the stone stand before the ground, in the mean.
    fn height(apart: usize, map: &Plane<f32>) -> f32 {
        let places = (0..map.rows()).flat_map(|y| (0..map.columns()).map(move |x| (x, y)));
        let of_stone = places.filter(|(x, y)| is_stone(apart * x, apart * y));
        let heights: Vec<f32> = of_stone.map(|(x, y)| map.row(y)[x] - GROUND).collect();
        heights.iter().sum::<f32>() / heights.len() as f32
    }

    #[test]
    fn a_stone_stays_where_the_images_show_it() {
        for apart in [1, 2] {
            let shown = height(apart, &smoothed(Level::detect(), apart, &seen(texture)));
            let blank = height(apart, &smoothed(Level::detect(), apart, &seen(|_, _| 90)));
            assert!(shown > 0.95 && blank < 0.6, "{shown} px are left, of a blank one {blank}");
        }
    }

    #[test]
    fn every_level_and_number_of_threads_gives_the_same() {
        // Texture that ends, so that some of the stone goes and some stays.
        let images = seen(|x, y| if y < 24 { texture(x, y) } else { 90 });
        for apart in [1, 2] {
            let run = |level, threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| smoothed(level, apart, &images))
            };
            let expected = run(Level::available()[0], 1);
            for (level, threads) in
                Level::available().into_iter().flat_map(|level| [1, 3, 64].map(|n| (level, n)))
            {
                eprintln!("apart {apart}, level {}, {threads} threads", level.name());
                assert!(run(level, threads) == expected);
            }
        }
    }
}
