//! The stages that `balanced` and `best` share, and the one in which they differ.
//!
//! `balanced`:
#![doc = include_str!("balanced.md")]
//!
//! `best`:
#![doc = include_str!("best.md")]

use raster::{DisparityMap, Plane, Reason};
use rayon::prelude::*;

use super::fast::{fill_rows, hole};
use crate::cost::SearchSpace;
use crate::cost::hamming::CensusPair;
use crate::kernels::level::Level;
use crate::kernels::path::padded;
use crate::matcher::{Frame, Pipeline};
use crate::optimization::semi_global::{Penalties, SemiGlobal};
use crate::prepare::grey::{GreyBuffer, GreyView};
use crate::refinement::median::median_row;
use crate::refinement::row_fill::fill_row;
use crate::refinement::speckle::Speckles;
use crate::refinement::weighted_median::weighted_median;
use crate::selection::cross_check::cross_check;
use crate::selection::winner::{NONE, fraction, left_winners, right_winners};
use crate::{Holes, MatchError};

/// What changes of disparity cost, in differing census bits.
const PENALTIES: Penalties = Penalties { p1: 12, p2: 75, p2_least: 30, fall: 1.5 };
/// How far the two views may disagree, in pixels.
const TOLERANCE: u16 = 1;
/// Smaller groups of equal disparity are speckles.
const LEAST_GROUP: usize = 60;
/// Neighbours of one group differ by at most this.
const GROUP_STEP: f32 = 1.0;
/// Half the window of the plain median.
const MEDIAN_RADIUS: usize = 2;
/// Half the window of the weighted median.
const WEIGHTED_RADIUS: usize = 9;

/// The last stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Smoothing {
    /// Plain median: quick.
    Median,
    /// Weighted median: edges follow the image.
    WeightedMedian,
}

/// The stages and their memory.
pub(crate) struct SemiGlobalMatching {
    smoothing: Smoothing,
    level: Level,
    grey: GreyBuffer,
    images: [Plane<u16>; 2],
    guide: Plane<u8>,
    census: CensusPair,
    optimizer: SemiGlobal,
    rows: Vec<Row>,
    values: Plane<f32>,
    reasons: Plane<Reason>,
    confidence: Plane<f32>,
    smooth: Plane<f32>,
    speckles: Speckles,
}

/// What the selection says of one row.
#[derive(Default)]
struct Row {
    left: Vec<u16>,
    right: Vec<u16>,
    least: Vec<u16>,
    pointed_at: Vec<bool>,
    values: Vec<f32>,
    reasons: Vec<Reason>,
}

impl Row {
    /// Winners of both views, their check and fractions.
    fn select(&mut self, space: &SearchSpace, sums: &[u16]) {
        fn resize<T: Clone>(buffer: &mut Vec<T>, length: usize, value: T) {
            buffer.clear();
            buffer.resize(length, value);
        }
        let columns = space.columns();
        resize(&mut self.left, columns, NONE);
        resize(&mut self.right, space.width, NONE);
        resize(&mut self.least, space.width, 0);
        resize(&mut self.pointed_at, columns, false);
        resize(&mut self.values, columns, f32::NAN);
        resize(&mut self.reasons, columns, Reason::OccludedHole);
        left_winners(space, sums, &mut self.left);
        right_winners(space, sums, &mut self.least, &mut self.right);
        let (left, right) = (&self.left, &self.right);
        cross_check(space, left, right, TOLERANCE, &mut self.pointed_at, &mut self.reasons);
        for (x, value) in self.values.iter_mut().enumerate() {
            if self.reasons[x] == Reason::Matched {
                let k = usize::from(left[x]);
                let sums = &sums[x * space.lanes..][..space.lanes];
                let part = fraction(sums, k, space.candidates(space.first + x));
                *value = (space.min + k as i32) as f32 + part;
            }
        }
    }
}

impl SemiGlobalMatching {
    pub fn new(smoothing: Smoothing, level: Level) -> Self {
        Self {
            smoothing,
            level,
            grey: GreyBuffer::default(),
            images: Default::default(),
            guide: Plane::default(),
            census: CensusPair::default(),
            optimizer: SemiGlobal::default(),
            rows: Vec::new(),
            values: Plane::default(),
            reasons: Plane::default(),
            confidence: Plane::default(),
            smooth: Plane::default(),
            speckles: Speckles::default(),
        }
    }
}

/// Grey at 16 bit, whatever its depth: census words only look at the order.
fn copy_grey(view: GreyView<'_>, image: &mut Plane<u16>) {
    match view {
        GreyView::Depth8(view) => {
            image.reset(view.columns(), view.rows(), 0);
            for y in 0..view.rows() {
                for (to, &from) in image.row_mut(y).iter_mut().zip(view.row(y)) {
                    *to = u16::from(from) * 257;
                }
            }
        }
        GreyView::Depth16(view) => {
            image.reset(view.columns(), view.rows(), 0);
            for y in 0..view.rows() {
                image.row_mut(y).copy_from_slice(view.row(y));
            }
        }
    }
}

impl Pipeline for SemiGlobalMatching {
    fn run(&mut self, frame: &Frame<'_>, map: &mut DisparityMap) -> Result<(), MatchError> {
        let bounds = frame.bounds;
        let (width, _) = frame.size();
        let (columns, rows) = (bounds.columns(), bounds.rows());
        for (image, grey) in [frame.left, frame.right].into_iter().zip(&mut self.images) {
            copy_grey(self.grey.view(image), grey);
        }
        self.guide.reset(columns, rows, 0);
        for y in 0..rows {
            let from = &self.images[0].row(bounds.y0 + y)[bounds.x0..=bounds.x1];
            for (to, &from) in self.guide.row_mut(y).iter_mut().zip(from) {
                *to = (from / 257) as u8;
            }
        }

        let mut space = SearchSpace::new(width, bounds, frame.range);
        space.lanes = padded(space.count);
        self.values.reset(columns, rows, f32::NAN);
        self.reasons.reset(columns, rows, Reason::OccludedHole);
        self.confidence.reset(columns, rows, 0.0);
        if space.count > 0 {
            let [left, right] = &self.images;
            self.census.compute(self.level, [left, right], bounds.y0, rows);
            self.rows.resize_with(rows, Row::default);
            self.optimizer.run(
                self.level,
                &self.census.costs(&space),
                &self.guide,
                &PENALTIES,
                &mut self.rows,
                |_, sums, row| row.select(&space, sums),
            );
            for (y, row) in self.rows.iter().enumerate() {
                self.values.row_mut(y).copy_from_slice(&row.values);
                self.reasons.row_mut(y).copy_from_slice(&row.reasons);
            }
            self.speckles.remove(&mut self.values, &mut self.reasons, LEAST_GROUP, GROUP_STEP);
            for (sure, value) in self.confidence.samples_mut().iter_mut().zip(self.values.samples())
            {
                *sure = if value.is_nan() { 0.0 } else { 1.0 };
            }
            for y in 0..rows {
                fill_row(width, bounds.x0, self.values.row_mut(y), self.reasons.row_mut(y));
            }
        }
        let nowhere = frame.range.min().max(0).min(frame.range.max()) as f32;
        fill_rows(&mut self.values, &mut self.reasons, (width, bounds), nowhere);

        match self.smoothing {
            Smoothing::Median => {
                self.smooth.reset(columns, rows, 0.0);
                let values = self.values.samples();
                self.smooth
                    .samples_mut()
                    .par_chunks_mut(columns)
                    .enumerate()
                    .for_each(|(y, out)| median_row(values, columns, y, MEDIAN_RADIUS, out));
            }
            Smoothing::WeightedMedian => weighted_median(
                &self.values,
                &self.reasons,
                &self.guide,
                WEIGHTED_RADIUS,
                &mut self.smooth,
            ),
        }
        for y in 0..rows {
            let answered = bounds.x0..=bounds.x1;
            let values = &mut map.values.row_mut(bounds.y0 + y)[answered.clone()];
            values.copy_from_slice(self.smooth.row(y));
            let reasons = &mut map.reasons.row_mut(bounds.y0 + y)[answered.clone()];
            reasons.copy_from_slice(self.reasons.row(y));
            map.confidence.row_mut(bounds.y0 + y)[answered].copy_from_slice(self.confidence.row(y));
            if frame.holes == Holes::Keep {
                for (value, reason) in values.iter_mut().zip(reasons) {
                    *reason = hole(*reason);
                    if !reason.has_value() {
                        *value = f32::NAN;
                    }
                }
            }
        }
        Ok(())
    }
}
