//! How far each row has to be searched, seen in the pair at a quarter of its size.
//!
//! A range that has room for what is nearest somewhere is too wide nearly everywhere else: over a road
//! the upper half of an image holds small disparities alone. The small pair is matched with a fixed
//! window, in a hundredth of the time that paths take. What is nearest among its confirmed matches says
//! how far the rows around are searched, with something to spare; what is farther away is always
//! searched too (coarse to fine, as Rothermel et al., *SURE*, LC3D 2012, do for each pixel). Where too
//! little is matched to know, the whole range is searched.

use raster::{BoundingBox, DisparityRange, Plane, View};
use rayon::prelude::*;

use crate::aggregation::window::SlidingWindow;
use crate::cost::{RowRanges, SearchSpace};
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::path::padded;
use crate::kernels::sad;
use crate::prepare::grey::GreyView;
use crate::profile::Work;
use crate::refinement::groups::Groups;
use crate::selection::confirm::confirm_row;
use crate::selection::fixed_point::{FixedPoint, HOLE};

/// So many columns and rows become one.
const SIZE: usize = 4;
/// So few disparities are searched before anybody could have looked.
const FEW: usize = 64;
/// So many rows of the small pair reach equally far: as far as what is nearest there, in the rows before
/// and in those after.
const BAND: usize = 8;
/// Disparities that are searched beyond what is nearest.
const SPARE: i32 = 8;
/// Matches with less confidence are none: what is blank matches anything.
const SURE: f32 = 0.1;
/// Neighbours of one group differ by at most so many pixels of the small pair.
const GROUP_STEP: f32 = 1.0;
/// Smaller groups are not believed.
const LEAST_GROUP: usize = 200;
/// Where less than one pixel of so many is matched nobody knows how near things are.
const KNOWN: usize = 4;

/// The small pair and what is seen there, kept between frames.
#[derive(Default)]
pub(super) struct Coarse {
    images: [Plane<u8>; 2],
    disparities: Plane<u16>,
    /// The scratch memory of bands of rows, one for each thread.
    scratch: Vec<Scratch>,
    groups: Groups,
    /// The nearest disparity of every [`BAND`] of rows, in pixels of the large pair; none where too little
    /// is matched.
    nearest: Vec<Option<i32>>,
}

#[derive(Default)]
struct Scratch {
    window: SlidingWindow,
    confidence: Vec<f32>,
}

at_every_level! {
    /// The means of squares of samples, rounded to nearest.
    fn means(rows: [&[u8]; SIZE], means: &mut [u8]) {
        let [a, b, c, d] = rows.map(|row| row.as_chunks::<SIZE>().0);
        for ((((mean, a), b), c), d) in means.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            let sum = |row: &[u8; SIZE]| row.iter().map(|&sample| u16::from(sample)).sum::<u16>();
            *mean = ((sum(a) + sum(b) + sum(c) + sum(d) + 8) / 16) as u8;
        }
    }
}

/// The part of the small pair that shows `work`, and what there is to search in it. None where it is not
/// worth a look, or too small for one.
fn small(
    (width, height): (usize, usize),
    work: BoundingBox,
    space: &SearchSpace,
) -> Option<(BoundingBox, SearchSpace)> {
    let last = [width / SIZE, height / SIZE].map(|size| size.checked_sub(1));
    let [Some(last_column), Some(last_row)] = last else { return None };
    let part = BoundingBox {
        x0: (work.x0 / SIZE).min(last_column),
        y0: (work.y0 / SIZE).min(last_row),
        x1: (work.x1 / SIZE).min(last_column),
        y1: (work.y1 / SIZE).min(last_row),
    };
    let (min, max) = (space.min, space.min + space.count as i32 - 1);
    let size = SIZE as i32;
    let range = DisparityRange::new(min.div_euclid(size), max.div_euclid(size) + 1);
    let small = SearchSpace::new(last_column + 1, part, range.ok()?);
    (space.count > FEW && small.count > 0).then_some((part, small))
}

impl Coarse {
    /// The memory that it takes.
    pub fn bytes((width, height): (usize, usize), work: BoundingBox, space: &SearchSpace) -> usize {
        let Some((part, small)) = small((width, height), work, space) else { return 0 };
        let (columns, rows) = (part.columns(), part.rows());
        let scratch = SlidingWindow::bytes(&small) + size_of::<f32>() * columns;
        2 * (width / SIZE) * (height / SIZE)
            + size_of::<u16>() * columns * rows
            + Groups::bytes(columns, rows)
            + rayon::current_num_threads() * scratch
            + size_of::<Option<i32>>() * rows.div_ceil(BAND)
            + size_of::<usize>() * work.rows()
    }

    /// Looks how far the rows of the part `work` have to be searched. None if they are all searched over
    /// the whole space without a look.
    pub fn look(
        &mut self,
        level: Level,
        images: [View<'_, u8>; 2],
        work: BoundingBox,
        space: &SearchSpace,
        ranges: &mut RowRanges,
    ) -> Option<Work> {
        ranges.widen();
        let size = (images[0].columns(), images[0].rows());
        let (part, small) = small(size, work, space)?;
        let (width, height) = (size.0 / SIZE, size.1 / SIZE);
        for (image, small) in images.iter().zip(&mut self.images) {
            small.reshape(width, height, 0);
            let rows = small.samples_mut().par_chunks_mut(width).enumerate();
            rows.for_each(|(y, small)| {
                means(level, std::array::from_fn(|i| image.row(SIZE * y + i)), small);
            });
        }
        let numbers = FixedPoint::new(&small);
        let grouped = self.find_matches(level, &small, part, numbers);
        self.find_nearest(part, numbers);
        let nearest = &self.nearest;
        let counts = (work.y0..=work.y1).map(|y| {
            let band = ((y / SIZE).min(part.y1) - part.y0) / BAND;
            let around = &nearest[band.saturating_sub(1)..(band + 2).min(nearest.len())];
            let nearest = around.iter().try_fold(i32::MIN, |most, near| Some(most.max((*near)?)));
            let reach = nearest.map(|nearest| (nearest + SPARE + 1 - space.min).max(1) as usize);
            // Paths take whole groups; what is left of one costs nothing.
            reach.map_or(space.count, |reach| padded(reach).min(space.count))
        });
        ranges.set(counts);
        // Images are read once and the small ones written, which are read again.
        let shrunk = Work::bytes(2 * (SIZE * SIZE + 2) * width * height);
        let matched = Work::bytes(size_of::<u16>() * part.columns() * part.rows())
            + Work::operations(sad::OPERATIONS) * small.pairs() * part.rows();
        Some(shrunk + matched + grouped + self.groups.looked_at())
    }

    /// Disparities of the small pair that the right view confirms, and their groups.
    fn find_matches(
        &mut self,
        level: Level,
        space: &SearchSpace,
        part: BoundingBox,
        numbers: FixedPoint,
    ) -> Work {
        let (columns, rows) = (part.columns(), part.rows());
        let Self { images, disparities, scratch, groups, .. } = self;
        let images_height = images[0].rows();
        let images = images.each_ref().map(|image| GreyView::Depth8(image.view()));
        let height = rows.div_ceil(rayon::current_num_threads());
        disparities.reshape(columns, rows, HOLE);
        scratch.resize_with(rows.div_ceil(height), Scratch::default);
        let bands = disparities.samples_mut().par_chunks_mut(height * columns);
        scratch.par_iter_mut().zip(bands).enumerate().for_each(|(i, (scratch, disparities))| {
            let rows = (part.y0 + i * height, disparities.len() / columns);
            let Scratch { window, confidence } = scratch;
            confidence.resize(columns, 0.0);
            window.slide(level, images, space, images_height, rows, |row, winners, layout| {
                let disparities = &mut disparities[row * columns..][..columns];
                confirm_row(level, winners, layout, numbers, disparities, confidence);
                for (disparity, confidence) in disparities.iter_mut().zip(&*confidence) {
                    *disparity = if *confidence < SURE { HOLE } else { *disparity };
                }
            });
        });
        groups.find(level, disparities.samples(), columns, numbers.steps(GROUP_STEP), height)
    }

    /// What is nearest in each band of rows.
    fn find_nearest(&mut self, part: BoundingBox, numbers: FixedPoint) {
        let (columns, rows) = (part.columns(), part.rows());
        self.nearest.clear();
        for first in (0..rows).step_by(BAND) {
            let band = first..(first + BAND).min(rows);
            let (mut nearest, mut matched) = (0, 0);
            for y in band.clone() {
                let believed = self.groups.runs(y).filter(|(_, size)| *size >= LEAST_GROUP);
                for (run, _) in believed {
                    matched += run.len();
                    nearest = self.disparities.row(y)[run].iter().copied().fold(nearest, u16::max);
                }
            }
            let known = matched * KNOWN >= columns * band.len();
            let in_pixels = (numbers.pixels(nearest) * SIZE as f32).ceil() as i32;
            self.nearest.push(known.then_some(in_pixels));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    const WIDTH: usize = 320;
    const HEIGHT: usize = 256;

    /// A wall of disparity 4, and before it a card of disparity 40 in rows 100 to 139.
    fn card_before_a_wall() -> [Plane<u8>; 2] {
        let mut chance = Chance(4);
        // Coarse enough to be seen in the small pair.
        let texture = Plane::from_fn(WIDTH, HEIGHT, |_, _| chance.below(256) as u8);
        let shown = |x: usize, y: usize| texture.row(y / 4 % HEIGHT)[x / 4 % WIDTH];
        let left = Plane::from_fn(WIDTH, HEIGHT, |x, y| match (x, y) {
            (150..=289, 100..=139) => shown(x + 444, y),
            _ => shown(x, y),
        });
        let right = Plane::from_fn(WIDTH, HEIGHT, |x, y| match (x, y) {
            (110..=249, 100..=139) => shown(x + 40 + 444, y),
            _ => shown(x + 4, y),
        });
        [left, right]
    }

    /// How many disparities are tried in each row of a part of the images.
    fn counts(
        images: &[Plane<u8>; 2],
        work: BoundingBox,
        range: (i32, i32),
        level: Level,
    ) -> Vec<usize> {
        let range = DisparityRange::new(range.0, range.1).unwrap();
        let space = SearchSpace::new(WIDTH, work, range);
        let (mut coarse, mut ranges) = (Coarse::default(), RowRanges::default());
        coarse.look(level, images.each_ref().map(Plane::view), work, &space, &mut ranges);
        (0..work.rows()).map(|y| ranges.of_row(&space, y).count).collect()
    }

    #[test]
    fn rows_are_searched_as_far_as_what_is_near_there() {
        let images = card_before_a_wall();
        let whole = BoundingBox::whole(WIDTH, HEIGHT);
        for level in Level::available() {
            eprintln!("level {}", level.name());
            for threads in [1, 2, 3] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let found = pool.install(|| counts(&images, whole, (0, 150), level));
                // Bands of 32 rows: the card lies in two of them, one more on either side reaches as far.
                let expected = (0..HEIGHT).map(|y| if (64..192).contains(&y) { 64 } else { 32 });
                assert_eq!(found, expected.collect::<Vec<_>>(), "{threads} threads");
            }
        }
        let level = Level::detect();
        // From the smallest disparity on, whatever it is.
        assert_eq!(counts(&images, whole, (-30, 120), level)[100], 96);
        // The rows of a part are counted from its first one.
        let part = BoundingBox::new(60, 40, 310, 250).unwrap();
        let found = counts(&images, part, (0, 150), level);
        assert_eq!(([found[0], found[60], found[205]], found.len()), ([64, 64, 32], 211));
    }

    #[test]
    fn what_is_not_known_is_searched_everywhere() {
        let whole = BoundingBox::whole(WIDTH, HEIGHT);
        let level = Level::detect();
        let flat = [(); 2].map(|()| Plane::filled(WIDTH, HEIGHT, 90));
        assert_eq!(counts(&flat, whole, (0, 150), level), [151; HEIGHT]);
        // Half of the rows show nothing.
        let mut images = card_before_a_wall();
        for image in &mut images {
            image.samples_mut()[..WIDTH * HEIGHT / 2].fill(90);
        }
        let found = counts(&images, whole, (0, 150), level);
        assert_eq!([found[0], found[127], found[255]], [151, 151, 32]);
    }

    #[test]
    fn few_disparities_and_small_images_are_not_looked_at() {
        let images = card_before_a_wall();
        let whole = BoundingBox::whole(WIDTH, HEIGHT);
        let level = Level::detect();
        assert_eq!(counts(&images, whole, (0, 63), level), [64; HEIGHT]);
        let small = images.map(|image| image.view().part(0..WIDTH, 0..3).to_plane());
        let rows = BoundingBox::whole(WIDTH, 3);
        assert_eq!(counts(&small, rows, (0, 150), level), [151; 3]);
    }

    #[test]
    fn means_are_their_definition_at_every_level() {
        let mut chance = Chance(8);
        // What is left of a square at the end is left out.
        let image = Plane::from_fn(203, 4, |_, _| chance.below(256) as u8);
        let expected = (0..50).map(|x| {
            let square = (0..4).flat_map(|y| &image.row(y)[4 * x..4 * x + 4]);
            (square.map(|&sample| f32::from(sample)).sum::<f32>() / 16.0 + 0.5) as u8
        });
        let expected: Vec<u8> = expected.collect();
        for level in Level::available() {
            eprintln!("level {}", level.name());
            let mut found = [0; 50];
            means(level, std::array::from_fn(|y| image.row(y)), &mut found);
            assert_eq!(found[..], expected);
        }
    }
}
