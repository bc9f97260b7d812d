#![doc = include_str!("fast.md")]

use raster::{BoundingBox, DisparityMap, Plane, Reason};
use rayon::prelude::*;

use crate::aggregation::window::sum_along_row;
use crate::cost::SearchSpace;
use crate::cost::absolute_difference::{add_row, reverse_row, subtract_row};
use crate::matcher::{Frame, Pipeline};
use crate::prepare::grey::GreyBuffer;
use crate::prepare::prefilter::clipped_gradient;
use crate::refinement::median::median_row;
use crate::refinement::row_fill::{fill_row, filled};
use crate::selection::cross_check::cross_check;
use crate::selection::winner::{NONE, fraction, left_winners, right_winners};
use crate::{Holes, MatchError};

/// Half the window: it is `2 RADIUS + 1` pixels wide and high.
const RADIUS: usize = 5;
/// The gradient is clipped to plus and minus this.
const CLIP: u8 = 31;
/// How far the two views may disagree, in pixels.
const TOLERANCE: u16 = 1;
/// Half the window of the last median.
const MEDIAN_RADIUS: usize = 2;

// The sum over a window must fit its 16 bits, below the value that stands for "not tried".
const _: () = assert!((2 * RADIUS + 1).pow(2) * 2 * (CLIP as usize) < u16::MAX as usize);

/// The stages of `fast` and their memory.
#[derive(Default)]
pub(crate) struct Fast {
    grey: GreyBuffer,
    left: Plane<u8>,
    right: Plane<u8>,
    bands: Vec<Band>,
    filled: Plane<f32>,
    reasons: Plane<Reason>,
    confidence: Plane<f32>,
}

/// The scratch memory of one band of rows.
#[derive(Default)]
struct Band {
    columns: Vec<u16>,
    running: Vec<u16>,
    costs: Vec<u16>,
    reversed: Vec<u8>,
    left: Vec<u16>,
    right: Vec<u16>,
    least: Vec<u16>,
    pointed_at: Vec<bool>,
}

/// The filtered images: their rows begin at row `top` of the image.
#[derive(Clone, Copy)]
struct Pair<'a> {
    left: &'a Plane<u8>,
    right: &'a Plane<u8>,
    top: usize,
}

fn resize<T: Clone>(buffer: &mut Vec<T>, length: usize, value: T) {
    buffer.clear();
    buffer.resize(length, value);
}

impl Band {
    /// Answers the rows that `values` holds, the first of which is row `first_row` of the image.
    fn run(
        &mut self,
        pair: Pair<'_>,
        space: &SearchSpace,
        first_row: usize,
        values: &mut [f32],
        reasons: &mut [Reason],
        confidence: &mut [f32],
    ) {
        let lanes = space.lanes;
        let (c0, c1) =
            (space.first.saturating_sub(RADIUS), (space.last + RADIUS).min(space.width - 1));
        let supplied = c1 - c0 + 1;
        resize(&mut self.columns, supplied * lanes, 0);
        resize(&mut self.running, lanes, 0);
        resize(&mut self.costs, space.columns() * lanes, 0);
        resize(&mut self.reversed, supplied + lanes, 0);
        resize(&mut self.left, space.columns(), NONE);
        resize(&mut self.right, space.width, NONE);
        resize(&mut self.least, space.width, 0);
        resize(&mut self.pointed_at, space.columns(), false);
        let bottom = pair.top + pair.left.rows() - 1;
        let rows = values
            .chunks_exact_mut(space.columns())
            .zip(reasons.chunks_exact_mut(space.columns()))
            .zip(confidence.chunks_exact_mut(space.columns()));
        for (row, ((values, reasons), confidence)) in rows.enumerate() {
            let y = first_row + row;
            let entering = if row == 0 { y.saturating_sub(RADIUS)..y + RADIUS } else { 0..0 };
            for y in entering.chain([y + RADIUS]).filter(|&y| y <= bottom) {
                let left = &pair.left.row(y - pair.top)[c0..=c1];
                let right = pair.right.row(y - pair.top);
                reverse_row(right, c1 as i64 - i64::from(space.min), &mut self.reversed);
                add_row(left, &self.reversed, lanes, &mut self.columns);
            }
            sum_along_row(
                &self.columns,
                lanes,
                space.first - c0,
                RADIUS,
                &mut self.running,
                &mut self.costs,
            );
            if y >= RADIUS {
                let y = y - RADIUS;
                let left = &pair.left.row(y - pair.top)[c0..=c1];
                let right = pair.right.row(y - pair.top);
                reverse_row(right, c1 as i64 - i64::from(space.min), &mut self.reversed);
                subtract_row(left, &self.reversed, lanes, &mut self.columns);
            }
            left_winners(space, &self.costs, &mut self.left);
            right_winners(space, &self.costs, &mut self.least, &mut self.right);
            cross_check(space, &self.left, &self.right, TOLERANCE, &mut self.pointed_at, reasons);
            for (x, value) in values.iter_mut().enumerate() {
                let k = usize::from(self.left[x]);
                if reasons[x] == Reason::Matched {
                    let costs = &self.costs[x * lanes..][..lanes];
                    let fraction = fraction(costs, k, space.candidates(space.first + x));
                    *value = (space.min + k as i32) as f32 + fraction;
                    confidence[x] = 1.0;
                }
            }
            fill_row(space.width, space.first, values, reasons);
        }
    }
}

impl Pipeline for Fast {
    fn run(&mut self, frame: &Frame<'_>, map: &mut DisparityMap) -> Result<(), MatchError> {
        let bounds = frame.bounds;
        let (width, height) = frame.size();
        let top = bounds.y0.saturating_sub(RADIUS);
        let bottom = (bounds.y1 + RADIUS).min(height - 1);
        clipped_gradient(self.grey.view(frame.left), (top, bottom), CLIP, &mut self.left);
        clipped_gradient(self.grey.view(frame.right), (top, bottom), CLIP, &mut self.right);

        let space = SearchSpace::new(width, bounds, frame.range);
        let (columns, rows) = (bounds.columns(), bounds.rows());
        self.filled.reset(columns, rows, f32::NAN);
        self.reasons.reset(columns, rows, Reason::OccludedHole);
        self.confidence.reset(columns, rows, 0.0);
        if space.count > 0 {
            let bands = rayon::current_num_threads().min(rows);
            let height = rows.div_ceil(bands);
            self.bands.resize_with(bands, Band::default);
            let pair = Pair { left: &self.left, right: &self.right, top };
            self.bands
                .par_iter_mut()
                .zip(self.filled.samples_mut().par_chunks_mut(height * columns))
                .zip(self.reasons.samples_mut().par_chunks_mut(height * columns))
                .zip(self.confidence.samples_mut().par_chunks_mut(height * columns))
                .enumerate()
                .for_each(|(i, (((band, values), reasons), confidence))| {
                    band.run(pair, &space, bounds.y0 + i * height, values, reasons, confidence);
                });
        }
        let nowhere = frame.range.min().max(0).min(frame.range.max()) as f32;
        fill_rows(&mut self.filled, &mut self.reasons, (width, bounds), nowhere);

        let band = map.values.samples_mut().par_chunks_mut(width);
        let reasons = map.reasons.samples_mut().par_chunks_mut(width);
        let confidence = map.confidence.samples_mut().par_chunks_mut(width);
        let (filled, found, sure) = (&self.filled, &self.reasons, &self.confidence);
        band.zip(reasons).zip(confidence).skip(bounds.y0).take(rows).enumerate().for_each(
            |(y, ((values, reasons), confidence))| {
                let answered = bounds.x0..=bounds.x1;
                let values = &mut values[answered.clone()];
                median_row(filled.samples(), columns, y, MEDIAN_RADIUS, values);
                let reasons = &mut reasons[answered.clone()];
                reasons.copy_from_slice(found.row(y));
                confidence[answered].copy_from_slice(sure.row(y));
                if frame.holes == Holes::Keep {
                    for (value, reason) in values.iter_mut().zip(reasons) {
                        *reason = hole(*reason);
                        if !reason.has_value() {
                            *value = f32::NAN;
                        }
                    }
                }
            },
        );
        Ok(())
    }
}

/// Fills rows without any value from the nearest row that has some, or with `nowhere`.
pub(super) fn fill_rows(
    values: &mut Plane<f32>,
    reasons: &mut Plane<Reason>,
    (width, bounds): (usize, BoundingBox),
    nowhere: f32,
) {
    let columns = bounds.columns();
    let empty: Vec<usize> = (0..values.rows()).filter(|&y| values.row(y)[0].is_nan()).collect();
    if empty.len() == values.rows() {
        values.samples_mut().fill(nowhere);
    } else {
        let full: Vec<usize> = (0..values.rows()).filter(|y| !empty.contains(y)).collect();
        for &y in &empty {
            let nearest = *full.iter().min_by_key(|f| f.abs_diff(y)).expect("some row is full");
            values
                .samples_mut()
                .copy_within(nearest * columns..(nearest + 1) * columns, y * columns);
        }
    }
    for &y in &empty {
        for x in 0..columns {
            let value = values.row(y)[x];
            let reason = &mut reasons.row_mut(y)[x];
            *reason = filled(width, bounds.x0 + x, value, *reason);
        }
    }
}

pub(super) fn hole(reason: Reason) -> Reason {
    match reason {
        Reason::OccludedFilled => Reason::OccludedHole,
        Reason::MismatchedFilled => Reason::MismatchedHole,
        Reason::OutsideRightFilled => Reason::OutsideRightHole,
        other => other,
    }
}
