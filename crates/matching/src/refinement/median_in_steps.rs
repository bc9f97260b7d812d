//! The median of 5 x 5 pixels of disparities in fixed point, which become disparities in pixels: what
//! every preset ends with, in `balanced` and `best` but for what [`spared`](super::spared) says.
//!
//! In: a map without holes, of a part of the image; beyond its borders it is repeated. Out: the rows of
//! a box inside that part. Bands of rows are done by a thread each; the answer does not depend on them.

use raster::{BoundingBox, DisparityMap, DisparityRange, Plane};
use rayon::prelude::*;

use super::{outside, spared};
use crate::kernels::level::Level;
use crate::kernels::median::{self, median_of_5_rows, rows_around};
use crate::profile::Work;
use crate::selection::fixed_point::{FixedPoint, row_in_pixels};

/// A map in fixed point, and where it lies in the image.
#[derive(Clone, Copy)]
pub(crate) struct Steps<'a> {
    pub steps: &'a Plane<u16>,
    pub numbers: FixedPoint,
    /// The image's column and row at which it begins.
    pub first: (usize, usize),
    /// The disparities that were searched.
    pub range: DisparityRange,
}

/// What becomes of disparities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Smoothing {
    /// Nothing.
    None,
    /// Their medians.
    All,
    /// Medians but where nearer matches are [`spared`].
    Sparing,
}

/// Its memory: a row for each band.
#[derive(Default)]
pub(crate) struct Medians(Vec<Vec<u16>>);

impl Medians {
    /// Writes the medians of a box of the image into `answer`, in pixels, or what `smoothing` says. Its reasons, which
    /// say what is matched, and its confidence are told what now lies outside the right image, or at an end of the range.
    /// A band has so many rows.
    pub fn of_box(
        &mut self,
        level: Level,
        smoothing: Smoothing,
        map: Steps<'_>,
        bounds: BoundingBox,
        height: usize,
        answer: &mut DisparityMap,
    ) -> Work {
        let Steps { steps, numbers, first: (x0, y0), range } = map;
        let (dx, dy) = (bounds.x0 - x0, bounds.y0 - y0);
        let (width, same) = (answer.values.columns(), numbers.steps(spared::SAME));
        let bands = bounds.rows().div_ceil(height).max(rayon::current_num_threads());
        self.0.resize_with(bands, Vec::new);
        let of_box = bounds.y0 * width..(bounds.y1 + 1) * width;
        let values = answer.values.samples_mut()[of_box.clone()].par_chunks_mut(height * width);
        let reasons = answer.reasons.samples_mut()[of_box.clone()].par_chunks_mut(height * width);
        let confidence = answer.confidence.samples_mut()[of_box].par_chunks_mut(height * width);
        let known = reasons.zip(confidence);
        let bands = self.0.par_iter_mut().zip(values).zip(known);
        bands.enumerate().for_each(|(i, ((medians, values), (reasons, confidence)))| {
            medians.resize(steps.columns(), 0);
            let known = reasons.chunks_exact_mut(width).zip(confidence.chunks_exact_mut(width));
            let rows = values.chunks_exact_mut(width).zip(known);
            for (y, (row, (reasons, confidence))) in (dy + i * height..).zip(rows) {
                match smoothing {
                    Smoothing::None => medians.copy_from_slice(steps.row(y)),
                    _ => median_of_5_rows(level, rows_around(steps, y), medians),
                }
                let part = bounds.x0..=bounds.x1;
                let (row, reasons) = (&mut row[part.clone()], &mut reasons[part.clone()]);
                let medians = &mut medians[dx..][..row.len()];
                if smoothing == Smoothing::Sparing {
                    let near = rows_around(steps, y);
                    spared::spare_in_steps(level, near, dx, same, reasons, medians);
                }
                row_in_pixels(level, numbers, medians, row);
                outside::mark(level, width, bounds.x0, range, row, reasons, &mut confidence[part]);
            }
        });
        let operations = match smoothing {
            Smoothing::None => 0,
            Smoothing::All => median::OPERATIONS,
            Smoothing::Sparing => median::OPERATIONS + spared::OPERATIONS,
        };
        let pixel = Work::bytes(2 + 4 + 2 + 8) + Work::operations(operations);
        pixel * (bounds.columns() * bounds.rows())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::SearchSpace;
    use raster::Reason;

    #[test]
    fn a_box_has_the_medians_of_the_map_around_it_whatever_the_bands() {
        let (columns, rows) = (40, 23);
        let part = BoundingBox::new(3, 5, 30, 20).unwrap();
        let range = DisparityRange::new(-4, 20).unwrap();
        let space = SearchSpace::new(columns, part, range);
        let numbers = FixedPoint::new(&space);
        // Some are alike, and some are matched.
        let scramble = |x: usize, y: usize| (x * 7919 + y * 104_729 + x * y * 31) % 61 / 12 * 1200;
        let steps = Plane::from_fn(part.columns(), part.rows(), |x, y| scramble(x, y) as u16);
        let reason = |x: usize, y: usize| {
            [Reason::Matched, Reason::MismatchedFilled][(x * 3 + y * 5) % 7 / 5]
        };
        let map = Steps { steps: &steps, numbers, first: (part.x0, part.y0), range };
        let median = |x: usize, y: usize| {
            let near = |at: usize, by: usize, end: usize| (at + by).saturating_sub(2).min(end - 1);
            let mut window: Vec<u16> = (0..25)
                .map(|i| {
                    let row = steps.row(near(y, i / 5, part.rows()));
                    row[near(x, i % 5, part.columns())]
                })
                .collect();
            window.sort_unstable();
            window[12]
        };
        let spared = |x: usize, y: usize| {
            let own = steps.row(y)[x];
            let near = |at: usize, by: usize, end: usize| (at + by).saturating_sub(1).min(end - 1);
            let rows = (0..3).map(|i| steps.row(near(y, i, part.rows())));
            let all = rows.flat_map(|row| (0..3).map(move |i| row[near(x, i, part.columns())]));
            let is_matched = reason(x + part.x0, y + part.y0) == Reason::Matched;
            (is_matched && all.filter(|&other| other == own).count() > 3).then_some(own)
        };
        let mut count = 0;
        for bounds in [part, BoundingBox::new(7, 6, 29, 18).unwrap()] {
            let all = [Smoothing::None, Smoothing::All, Smoothing::Sparing];
            for (smoothing, height) in all.into_iter().flat_map(|s| [(s, 1), (s, 5), (s, 99)]) {
                let mut answer = DisparityMap::empty(columns, rows);
                answer.reasons = Plane::from_fn(columns, rows, reason);
                let mut medians = Medians::default();
                medians.of_box(Level::detect(), smoothing, map, bounds, height, &mut answer);
                for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                    let expected = bounds.contains(x, y).then(|| {
                        let (x, y) = (x - part.x0, y - part.y0);
                        let median = median(x, y);
                        numbers.pixels(match (smoothing, spared(x, y)) {
                            (Smoothing::None, _) => steps.row(y)[x],
                            (Smoothing::Sparing, Some(own)) if own > median => {
                                count += 1;
                                own
                            }
                            _ => median,
                        })
                    });
                    let found = answer.values.row(y)[x];
                    assert_eq!(Some(found).filter(|v| !v.is_nan()), expected, "({x}, {y})");
                }
            }
        }
        assert!(count > 100, "{count} pixels are spared");
    }
}
