#![doc = include_str!("fast.md")]

use raster::{DisparityMap, Plane, Reason};
use rayon::prelude::*;

use crate::aggregation::window::SlidingWindow;
use crate::cost::SearchSpace;
use crate::kernels::level::Level;
use crate::kernels::median::median_of_5_rows;
use crate::matcher::{Frame, Pipeline};
use crate::prepare::grey::GreyBuffer;
use crate::refinement::groups::{Groups, LARGEST};
pub(super) use crate::refinement::row_fill::hole;
use crate::refinement::row_fill::{Filling, Row, copy_nearest_rows, filled};
use crate::selection::confirm::confirm_row;
use crate::selection::fixed_point::{FixedPoint, HOLE, row_in_pixels};
use crate::{Holes, MatchError};

/// Neighbours of one group differ by at most so many pixels.
const GROUP_STEP: f32 = 1.0;
/// Smaller groups are not believed: so many pixels, or this part of a small box.
const LEAST_GROUP: usize = 200;
const LEAST_PART: usize = 20;
/// Neighbours across a gap that differ by at most so many pixels are of one surface.
const SAME_SURFACE: f32 = 5.0;

/// The stages of `fast` and their memory.
pub(crate) struct Fast {
    level: Level,
    grey: [GreyBuffer; 2],
    bands: Vec<Band>,
    disparities: Plane<u16>,
    groups: Groups,
}

/// The scratch memory of one band of rows.
#[derive(Default)]
struct Band {
    window: SlidingWindow,
    opposite: Vec<u16>,
    medians: Vec<u16>,
}

impl Fast {
    pub fn new(level: Level) -> Self {
        Self {
            level,
            grey: Default::default(),
            bands: Vec::new(),
            disparities: Plane::default(),
            groups: Groups::default(),
        }
    }

    /// [`Pipeline::run`] in bands of `height` rows: the answer does not depend on it.
    fn run_in_bands(
        &mut self,
        frame: &Frame<'_>,
        height: usize,
        map: &mut DisparityMap,
    ) -> Result<(), MatchError> {
        let (columns, rows) = (frame.bounds.columns(), frame.bounds.rows());
        if columns * rows > LARGEST {
            let [needed, limit] = [columns * rows, LARGEST].map(|n| 4 * n as u64);
            return Err(MatchError::Memory { needed, limit });
        }
        let space = SearchSpace::new(frame.size().0, frame.bounds, frame.range);
        let numbers = FixedPoint::new(&space);
        self.disparities.reset(columns, rows, HOLE);
        self.bands.resize_with(rows.div_ceil(height), Band::default);
        if space.count > 0 {
            self.find_winners(frame, &space, numbers, height, map);
            let step = numbers.steps(GROUP_STEP);
            self.groups.find(self.level, self.disparities.samples(), columns, step, height);
            self.fill_gaps(frame, numbers, height, map);
        }
        if self.fill_empty_rows(frame, numbers, map) {
            self.smooth(frame, numbers, height, map);
        }
        if frame.holes == Holes::Keep {
            open_holes(frame, map);
        }
        Ok(())
    }

    /// Steps 1 to 6: disparities that the right view confirms, and their confidence.
    fn find_winners(
        &mut self,
        frame: &Frame<'_>,
        space: &SearchSpace,
        numbers: FixedPoint,
        height: usize,
        map: &mut DisparityMap,
    ) {
        let (bounds, (width, image_height)) = (frame.bounds, frame.size());
        let (columns, level) = (bounds.columns(), self.level);
        let [left, right] = &mut self.grey;
        let images = [left.view(frame.left), right.view(frame.right)];
        let confidence = rows_of_box(frame, &mut map.confidence);
        self.bands
            .par_iter_mut()
            .zip(self.disparities.samples_mut().par_chunks_mut(height * columns))
            .zip(confidence.par_chunks_mut(height * width))
            .enumerate()
            .for_each(|(i, ((band, disparities), confidence))| {
                let Band { window, opposite, .. } = band;
                opposite.resize(columns, 0);
                let rows = (bounds.y0 + i * height, disparities.len() / columns);
                window.slide(level, images, space, image_height, rows, |row, winners| {
                    let disparities = &mut disparities[row * columns..][..columns];
                    let confidence = &mut confidence[row * width + bounds.x0..][..columns];
                    confirm_row(level, winners, space, numbers, opposite, disparities, confidence);
                });
            });
    }

    /// Steps 7 and 8, row by row: small groups out, gaps filled.
    fn fill_gaps(
        &mut self,
        frame: &Frame<'_>,
        numbers: FixedPoint,
        height: usize,
        map: &mut DisparityMap,
    ) {
        let (bounds, (width, _)) = (frame.bounds, frame.size());
        let columns = bounds.columns();
        let least = LEAST_GROUP.min(columns * bounds.rows() / LEAST_PART);
        let filling =
            Filling { width, first: bounds.x0, numbers, same_surface: numbers.steps(SAME_SURFACE) };
        let groups = &self.groups;
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
                        groups.runs(y).filter(|(_, size)| *size >= least).map(|(run, _)| run);
                    let row = Row {
                        disparities,
                        reasons: &mut reasons[bounds.x0..=bounds.x1],
                        confidence: &mut confidence[bounds.x0..=bounds.x1],
                    };
                    filling.fill_between(believed, row);
                }
            },
        );
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
        let nowhere = frame.range.min().max(0).min(frame.range.max()) as f32;
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

    /// Step 9: the median, and disparities in pixels.
    fn smooth(
        &mut self,
        frame: &Frame<'_>,
        numbers: FixedPoint,
        height: usize,
        map: &mut DisparityMap,
    ) {
        let (bounds, (width, _), level) = (frame.bounds, frame.size(), self.level);
        let (columns, rows) = (bounds.columns(), bounds.rows());
        let disparities = &self.disparities;
        let values = rows_of_box(frame, &mut map.values).par_chunks_mut(height * width);
        self.bands.par_iter_mut().zip(values).enumerate().for_each(|(i, (band, values))| {
            band.medians.resize(columns, 0);
            for (y, values) in (i * height..).zip(values.chunks_exact_mut(width)) {
                let near = std::array::from_fn(|dy| {
                    disparities.row((y + dy).saturating_sub(2).min(rows - 1))
                });
                median_of_5_rows(level, near, &mut band.medians);
                let values = &mut values[bounds.x0..=bounds.x1];
                row_in_pixels(level, numbers, &band.medians, values);
            }
        });
    }
}

impl Pipeline for Fast {
    fn run(&mut self, frame: &Frame<'_>, map: &mut DisparityMap) -> Result<(), MatchError> {
        let height = frame.bounds.rows().div_ceil(rayon::current_num_threads());
        self.run_in_bands(frame, height, map)
    }
}

/// The rows of the box, in all their width.
fn rows_of_box<'a, T>(frame: &Frame<'_>, plane: &'a mut Plane<T>) -> &'a mut [T] {
    let (columns, bounds) = (plane.columns(), frame.bounds);
    &mut plane.samples_mut()[bounds.y0 * columns..(bounds.y1 + 1) * columns]
}

/// Takes filled values out again.
fn open_holes(frame: &Frame<'_>, map: &mut DisparityMap) {
    for (value, reason) in
        rows_of_box(frame, &mut map.values).iter_mut().zip(rows_of_box(frame, &mut map.reasons))
    {
        *reason = hole(*reason);
        if !reason.has_value() {
            *value = f32::NAN;
        }
    }
}
