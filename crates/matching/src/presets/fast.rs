#![doc = include_str!("fast.md")]

use std::ops::Range;

use raster::{DisparityMap, Plane, Reason};
use rayon::prelude::*;

use super::memory;
use crate::aggregation::window::SlidingWindow;
use crate::allowance::Allowance;
use crate::cost::SearchSpace;
use crate::kernels::level::Level;
use crate::kernels::sad;
use crate::matcher::{Frame, Pipeline};
use crate::prepare::grey::GreyBuffer;
use crate::profile::{Profile, Work};
use crate::refinement::groups::{self, Groups};
use crate::refinement::median_in_steps::{Medians, Smoothing, Steps};
use crate::refinement::repetition::Repetition;
use crate::refinement::row_fill::{Filling, Row, copy_nearest_rows, filled};
use crate::selection::confirm::confirm_row;
use crate::selection::fixed_point::{FixedPoint, HOLE};

/// Smaller groups are not believed: so many pixels, or this part of a small box.
const LEAST_GROUP: usize = 200;
const LEAST_PART: usize = 20;
/// Neighbours across a gap that differ by at most so many pixels are of one surface.
const SAME_SURFACE: f32 = 5.0;

/// The stages of `fast` and their memory.
pub(crate) struct Fast {
    level: Level,
    grey: [GreyBuffer; 2],
    /// Of each band of rows.
    windows: Vec<SlidingWindow>,
    disparities: Plane<u16>,
    repetition: Repetition,
    groups: Groups,
    medians: Medians,
}

impl Fast {
    pub fn new(level: Level) -> Self {
        Self {
            level,
            grey: Default::default(),
            windows: Vec::new(),
            disparities: Plane::default(),
            repetition: Repetition::default(),
            groups: Groups::default(),
            medians: Medians::default(),
        }
    }

    /// [`Pipeline::run`] in bands of `height` rows: the answer does not depend on it.
    fn run_in_bands(
        &mut self,
        frame: &Frame<'_>,
        height: usize,
        map: &mut DisparityMap,
        profile: &mut Profile,
    ) {
        let asked = frame.bounds;
        let frame = &widened(frame);
        let (columns, rows) = (frame.bounds.columns(), frame.bounds.rows());
        let space = SearchSpace::new(frame.size().0, frame.bounds, frame.range);
        let numbers = FixedPoint::new(&space);
        self.disparities.reshape(columns, rows, HOLE);
        let bands = rows.div_ceil(height).max(rayon::current_num_threads());
        self.windows.resize_with(bands, SlidingWindow::default);
        let mut gaps = Work::default();
        if space.count > 0 {
            self.find_winners(frame, &space, numbers, height, map, profile);
            let (disparities, step) = (self.disparities.samples(), numbers.steps(groups::STEP));
            let pixels = |run: Range<usize>| run.len() as u32;
            let work = self.groups.find(self.level, disparities, columns, step, height, pixels);
            profile.end("speckles", work);
            gaps = self.fill_gaps(frame, numbers, height, map);
        } else {
            self.disparities.samples_mut().fill(HOLE);
            map.confidence.samples_mut().fill(0.0);
        }
        let any = self.fill_empty_rows(frame, numbers, map);
        profile.end("gaps", gaps);
        if any {
            let work = self.smooth(frame, numbers, height, map);
            profile.end("median", work);
        }
        map.empty_around(asked);
    }

    /// Steps 1 to 6: disparities that the right view confirms, and their confidence. Both are written,
    /// the grey of both images is read. Beside them the first half of step 10: where the left image repeats.
    fn find_winners(
        &mut self,
        frame: &Frame<'_>,
        space: &SearchSpace,
        numbers: FixedPoint,
        height: usize,
        map: &mut DisparityMap,
        profile: &mut Profile,
    ) {
        let (bounds, (width, image_height)) = (frame.bounds, frame.size());
        let (columns, level) = (bounds.columns(), self.level);
        let [left, right] = &mut self.grey;
        let (left, upper) = left.with_upper_bits(level, frame.left);
        let images = [left, right.view(level, frame.right)];
        let confidence = rows_of_box(frame, &mut map.confidence);
        let match_band = |(i, ((window, disparities), confidence)): (usize, Band<'_>)| {
            let rows = (bounds.y0 + i * height, disparities.len() / columns);
            window.slide(level, images, space, image_height, rows, |row, winners, layout| {
                let disparities = &mut disparities[row * columns..][..columns];
                let confidence = &mut confidence[row * width + bounds.x0..][..columns];
                confirm_row(level, winners, layout, numbers, disparities, confidence);
            });
        };
        let Self { windows, disparities, repetition, .. } = self;
        let (first_window, windows) = windows.split_at_mut(1);
        let first_rows = height.min(bounds.rows());
        let (of_first, disparities) = disparities.samples_mut().split_at_mut(first_rows * columns);
        let (confidence_of_first, confidence) = confidence.split_at_mut(first_rows * width);
        let first = ((&mut first_window[0], of_first), confidence_of_first);
        let others = windows
            .par_iter_mut()
            .zip(disparities.par_chunks_mut(height * columns))
            .zip(confidence.par_chunks_mut(height * width));
        // Threads that slept begin late. Whoever is done with its band before them looks for repetitions.
        let ((_, repeats), ()) = rayon::join(
            || {
                rayon::join(
                    || match_band((0, first)),
                    || repetition.find(level, upper, bounds, Some(frame.range)),
                )
            },
            || others.enumerate().for_each(|(i, band)| match_band((i + 1, band))),
        );
        let read = images.iter().map(|image| image.bytes(bounds.rows())).sum::<usize>();
        let written = (size_of::<u16>() + size_of::<f32>()) * columns * bounds.rows();
        let work = Work::bytes(read + written)
            + Work::operations(sad::OPERATIONS) * space.pairs() * bounds.rows()
            + GreyBuffer::work_with_upper_bits(frame.left)
            + GreyBuffer::work(frame.right);
        profile.end("windows, winners, check, repetition", work + repeats);
    }

    /// Steps 7, 8 and 10, row by row: small groups out, gaps filled, what repeats doubted. Whatever these are, all runs are
    /// looked at and all reasons written.
    fn fill_gaps(
        &mut self,
        frame: &Frame<'_>,
        numbers: FixedPoint,
        height: usize,
        map: &mut DisparityMap,
    ) -> Work {
        let (bounds, (width, _)) = (frame.bounds, frame.size());
        let columns = bounds.columns();
        let least = LEAST_GROUP.min(columns * bounds.rows() / LEAST_PART) as u32;
        let filling =
            Filling { width, first: bounds.x0, numbers, same_surface: numbers.steps(SAME_SURFACE) };
        let (groups, repetition) = (&self.groups, &self.repetition);
        let reasons = rows_of_box(frame, &mut map.reasons).par_chunks_mut(height * width);
        let confidence = rows_of_box(frame, &mut map.confidence).par_chunks_mut(height * width);
        let bands = self.disparities.samples_mut().par_chunks_mut(height * columns);
        bands.zip(reasons).zip(confidence).enumerate().for_each(
            |(i, ((disparities, reasons), confidence))| {
                let rows = disparities
                    .chunks_exact_mut(columns)
                    .zip(reasons.chunks_exact_mut(width))
                    .zip(confidence.chunks_exact_mut(width));
                for (y, ((disparities, reasons), confidence)) in (i * height..).zip(rows) {
                    let believed =
                        groups.runs(y).filter(|(_, pixels)| *pixels >= least).map(|(run, _)| run);
                    let row = Row {
                        disparities,
                        reasons: &mut reasons[bounds.x0..=bounds.x1],
                        confidence: &mut confidence[bounds.x0..=bounds.x1],
                    };
                    filling.fill_between(believed, row);
                    let confidence = &mut confidence[bounds.x0..=bounds.x1];
                    let first = (bounds.x0, bounds.y0 + y);
                    let pixels = |x: usize| numbers.pixels(disparities[x]);
                    repetition.doubt(frame.range, first, pixels, confidence);
                }
            },
        );
        groups.looked_at() + Work::bytes(size_of::<Reason>()) * (columns * bounds.rows())
    }

    /// The rest of step 8: rows without any value. Says whether there was one at all; without, the
    /// map is complete.
    fn fill_empty_rows(
        &mut self,
        frame: &Frame<'_>,
        numbers: FixedPoint,
        map: &mut DisparityMap,
    ) -> bool {
        let (bounds, (width, _)) = (frame.bounds, frame.size());
        let columns = bounds.columns();
        let nowhere = 0.clamp(frame.range.min(), frame.range.max()) as f32;
        let reasons = &mut map.reasons;
        let values = self.disparities.samples_mut();
        copy_nearest_rows(
            values,
            columns,
            |steps| steps == HOLE,
            HOLE,
            |y, row| {
                let reasons = &mut reasons.row_mut(bounds.y0 + y)[bounds.x0..=bounds.x1];
                for ((x, &steps), reason) in (bounds.x0..).zip(row).zip(reasons) {
                    let value = if steps == HOLE { nowhere } else { numbers.pixels(steps) };
                    *reason = filled(width, x, value, Reason::MismatchedHole);
                }
            },
        );
        let any = self.disparities.row(0)[0] != HOLE;
        if !any {
            for y in bounds.y0..=bounds.y1 {
                map.values.row_mut(y)[bounds.x0..=bounds.x1].fill(nowhere);
            }
        }
        any
    }

    /// Step 9: the median, disparities in pixels, and which of them lie outside the right image.
    fn smooth(
        &mut self,
        frame: &Frame<'_>,
        numbers: FixedPoint,
        height: usize,
        map: &mut DisparityMap,
    ) -> Work {
        let bounds = frame.bounds;
        let first = (bounds.x0, bounds.y0);
        let steps = Steps { steps: &self.disparities, numbers, first, range: frame.range };
        self.medians.of_box(self.level, Smoothing::All, steps, bounds, height, map)
    }
}

impl Pipeline for Fast {
    fn least_memory(&self, frame: &Frame<'_>) -> usize {
        let (bounds, (width, height)) = (widened(frame).bounds, frame.size());
        let (columns, rows) = (bounds.columns(), bounds.rows());
        let grey =
            memory::grey(frame.left) + memory::grey(frame.right) + memory::upper_bits(frame.left);
        let space = SearchSpace::new(width, bounds, frame.range);
        (memory::ANSWER + grey) * width * height
            + size_of::<u16>() * columns * rows
            + Groups::bytes(columns, rows)
            + Repetition::bytes(width, bounds, frame.range)
            + rayon::current_num_threads() * SlidingWindow::bytes(&space)
            + memory::rows(width, rows)
    }

    fn run(
        &mut self,
        frame: &Frame<'_>,
        _: Allowance,
        map: &mut DisparityMap,
        profile: &mut Profile,
    ) {
        let height = frame.bounds.rows().div_ceil(rayon::current_num_threads());
        self.run_in_bands(frame, height, map, profile);
    }
}

/// What one thread matches: its window, and the rows of disparities and confidence that it writes.
type Band<'a> = ((&'a mut SlidingWindow, &'a mut [u16]), &'a mut [f32]);

/// The frame with a box that is not narrow.
fn widened<'a>(frame: &Frame<'a>) -> Frame<'a> {
    Frame { bounds: super::widened::widened(frame.bounds, frame.range, frame.size().0), ..*frame }
}

/// The rows of the box, in all their width.
fn rows_of_box<'a, T>(frame: &Frame<'_>, plane: &'a mut Plane<T>) -> &'a mut [T] {
    let (columns, bounds) = (plane.columns(), frame.bounds);
    &mut plane.samples_mut()[bounds.y0 * columns..(bounds.y1 + 1) * columns]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Holes;
    use crate::matcher::open_holes;
    use crate::matcher::tests::bits;
    use raster::{BoundingBox, DisparityRange, Image};

    /// Something to match: a near square before a slanted wall, noise, and a blank corner.
    fn scene(columns: usize, rows: usize) -> [Image; 2] {
        let texture = |x: i64, y: i64, seed: i64| {
            let v = (x * 0x9E37 + y * 0x79B9 + seed * 0x7F4A).wrapping_mul(0x2545_F491_4F6C_DD1D);
            (v ^ v >> 29).wrapping_mul(0x5851_F42D_4C95_7F2D) >> 40 & 0xFF
        };
        let near = |x: i64, y: i64| (30..60).contains(&x) && (10..30).contains(&y);
        let grey = |x: i64, y: i64| match () {
            () if x + y < 12 => 90,
            () if near(x, y) => texture(x, y, 1),
            () => texture(x, y, 2) / 2,
        };
        let left = Plane::from_fn(columns, rows, |x, y| grey(x as i64, y as i64) as u8);
        let right = Plane::from_fn(columns, rows, |x, y| {
            let (x, y) = (x as i64, y as i64);
            let seen = if near(x + 9, y) { grey(x + 9, y) } else { grey(x + 2 + y / 16, y) };
            (seen + texture(x, y, 3) / 32).min(255) as u8
        });
        [Image::Grey8(left), Image::Grey8(right)]
    }

    fn map(level: Level, frame: &Frame<'_>, height: usize, threads: usize) -> DisparityMap {
        let (columns, rows) = frame.size();
        let mut map = DisparityMap::empty(columns, rows);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            Fast::new(level).run_in_bands(frame, height, &mut map, &mut Profile::new());
        });
        map
    }

    #[test]
    fn levels_threads_and_heights_of_bands_give_the_same_bits() {
        let [left, right] = scene(101, 43);
        let range = DisparityRange::new(-3, 20).unwrap();
        for bounds in [BoundingBox::whole(101, 43), BoundingBox::new(7, 5, 90, 41).unwrap()] {
            for holes in [Holes::Fill, Holes::Keep] {
                let frame = Frame { left: &left, right: &right, bounds, range };
                let map = |level, height, threads| {
                    let mut map = map(level, &frame, height, threads);
                    if holes == Holes::Keep {
                        open_holes(&mut map, bounds);
                    }
                    map
                };
                let expected = bits(&map(Level::available()[0], bounds.rows(), 1));
                let matched = expected.iter().filter(|pixel| pixel.1 == Reason::Matched).count();
                assert!(matched > 2000, "the scene is hard to match: {matched} pixels");
                for level in Level::available() {
                    eprintln!("level {}", level.name());
                    for height in 1..=bounds.rows() {
                        let found = bits(&map(level, height, 1 + height % 4));
                        assert!(found == expected, "{level:?}, bands of {height}, box {bounds}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_a_frame_leaves_behind_does_not_show_in_the_next() {
        let range = DisparityRange::new(0, 15).unwrap();
        let (mut reused, mut found) = (Fast::new(Level::detect()), DisparityMap::default());
        for (columns, rows) in [(90, 40), (33, 12), (1, 1), (101, 43)] {
            let [left, right] = scene(columns, rows);
            let bounds = BoundingBox::whole(columns, rows);
            let frame = Frame { left: &left, right: &right, bounds, range };
            found.reshape(columns, rows, bounds);
            reused.run_in_bands(&frame, 7, &mut found, &mut Profile::new());
            let expected = map(Level::detect(), &frame, 7, 1);
            assert!(bits(&found) == bits(&expected), "{columns} x {rows}");
        }
    }
}
