//! Rows between those that were matched: where the rows above and below are of one surface a pixel lies
//! halfway between them, elsewhere it belongs to the one whose grey value is nearer to its own.

use raster::{Plane, Reason, View};
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;

/// Rows of a map: disparities in fixed point, the reasons for them, how sure they are.
#[derive(Clone, Copy)]
pub(crate) struct Matched<'a> {
    pub steps: &'a Plane<u16>,
    pub reasons: &'a Plane<Reason>,
    pub confidence: &'a Plane<f32>,
}

/// One of them.
#[derive(Clone, Copy)]
struct Row<'a> {
    steps: &'a [u16],
    reasons: &'a [Reason],
    confidence: &'a [f32],
}

/// The same of all rows of a part of the image that begins at a column and a row, where reasons and
/// confidence are those of the whole image.
pub(crate) struct All<'a> {
    pub steps: &'a mut Plane<u16>,
    pub reasons: &'a mut Plane<Reason>,
    pub confidence: &'a mut Plane<f32>,
    pub first: usize,
    pub top: usize,
}

/// Spreads every so many-th row (1 or 2) over all of them. `grey` has them all; disparities of one surface differ
/// by at most `same`.
pub(crate) fn spread(
    level: Level,
    apart: usize,
    same: u16,
    grey: View<'_, u8>,
    matched: Matched<'_>,
    all: All<'_>,
) -> Work {
    let (columns, rows) = (grey.columns(), grey.rows());
    let width = all.reasons.columns();
    let row = |y: usize| Row {
        steps: matched.steps.row(y),
        reasons: matched.reasons.row(y),
        confidence: matched.confidence.row(y),
    };
    let last = matched.steps.rows() - 1;
    all.steps.reshape(columns, rows, 0);
    let of_image = all.top * width..(all.top + rows) * width;
    let reasons = all.reasons.samples_mut()[of_image.clone()].par_chunks_exact_mut(width);
    let confidence = all.confidence.samples_mut()[of_image].par_chunks_exact_mut(width);
    let steps = all.steps.samples_mut().par_chunks_exact_mut(columns);
    let out = steps.zip(reasons).zip(confidence).enumerate();
    out.for_each(|(y, ((steps, reasons), confidence))| {
        let reasons = &mut reasons[all.first..all.first + columns];
        let confidence = &mut confidence[all.first..all.first + columns];
        let above = row(y / apart);
        if y % apart == 0 {
            steps.copy_from_slice(above.steps);
            reasons.copy_from_slice(above.reasons);
            confidence.copy_from_slice(above.confidence);
            return;
        }
        // Below the last one there is none.
        let below = row((y / apart + 1).min(last));
        let shades = [y - 1, y, (y + 1).min(rows - 1)].map(|y| grey.row(y));
        row_between(level, same, shades, [above, below], steps, reasons, confidence);
    });
    let pixel = size_of::<u16>() + size_of::<Reason>() + size_of::<f32>();
    Work::bytes(pixel * columns * (rows + matched.steps.rows()) + columns * rows)
}

at_every_level! {
    /// A row between two, with the grey values of the row above, its own and those of the row below.
    fn row_between(
        same: u16,
        grey: [&[u8]; 3],
        rows: [Row<'_>; 2],
        steps: &mut [u16],
        reasons: &mut [Reason],
        confidence: &mut [f32],
    ) {
        let n = steps.len();
        let [shade_above, own, shade_below] = grey.map(|grey| &grey[..n]);
        let [above, below] = rows.map(|row| Row {
            steps: &row.steps[..n],
            reasons: &row.reasons[..n],
            confidence: &row.confidence[..n],
        });
        let (reasons, confidence) = (&mut reasons[..n], &mut confidence[..n]);
        // Whether it is more like the pixel below. One loop per width of number, so that each fills its vectors.
        let nearer = |x: usize| own[x].abs_diff(shade_below[x]) < own[x].abs_diff(shade_above[x]);
        for x in 0..n {
            let (one, other) = (above.steps[x], below.steps[x]);
            let halfway = (one & other) + ((one ^ other) >> 1);
            let taken = if nearer(x) { other } else { one };
            steps[x] = if one.abs_diff(other) <= same { halfway } else { taken };
        }
        for x in 0..n {
            let (one, other) = (above.reasons[x], below.reasons[x]);
            reasons[x] = if nearer(x) { other } else { one };
        }
        for x in 0..n {
            let (one, other) = (above.confidence[x], below.confidence[x]);
            confidence[x] = if nearer(x) { other } else { one };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    /// Everything of a part that begins at column 2 and row 1.
    fn spread_all(
        level: Level,
        apart: usize,
        grey: &Plane<u8>,
        steps: &Plane<u16>,
    ) -> (Plane<u16>, Plane<Reason>, Plane<f32>) {
        let (columns, rows) = grey.size();
        let reasons =
            steps.map(|&s| if s % 2 == 0 { Reason::Matched } else { Reason::OccludedFilled });
        let confidence = steps.map(|&s| f32::from(s) / 1000.0);
        let matched = Matched { steps, reasons: &reasons, confidence: &confidence };
        let mut out = (
            Plane::default(),
            Plane::filled(columns + 3, rows + 2, Reason::OutsideBox),
            Plane::filled(columns + 3, rows + 2, 9.0),
        );
        let all = All {
            steps: &mut out.0,
            reasons: &mut out.1,
            confidence: &mut out.2,
            first: 2,
            top: 1,
        };
        spread(level, apart, 10, grey.view(), matched, all);
        out
    }

    #[test]
    fn a_pixel_between_lies_halfway_or_follows_its_grey_value() {
        // One surface; two of them, nearer to the lower one by grey, and as near to both.
        let steps = Plane::new(3, 2, vec![100, 100, 100, 110, 200, 201]).unwrap();
        let grey = Plane::new(3, 4, vec![9, 9, 9, 9, 60, 50, 9, 90, 91, 7, 7, 7]).unwrap();
        let (steps, reasons, confidence) = spread_all(Level::detect(), 2, &grey, &steps);
        assert_eq!(steps.row(0), [100, 100, 100]);
        assert_eq!(steps.row(1), [105, 200, 100]);
        assert_eq!(reasons.row(2), {
            use Reason::{Matched, OutsideBox};
            [OutsideBox, OutsideBox, Matched, Matched, Matched, OutsideBox]
        });
        assert_eq!(confidence.row(2), [9.0, 9.0, 0.1, 0.2, 0.1, 9.0]);
        // Below the last row there is none.
        assert_eq!(steps.row(2), steps.row(3));
    }

    #[test]
    fn all_levels_spread_alike_and_leave_what_was_matched() {
        for (columns, rows) in [(1, 1), (5, 2), (70, 7usize)] {
            let mut chance = Chance(columns as u32);
            for apart in [1, 2] {
                let grey = Plane::from_fn(columns, rows, |_, _| chance.bits(8) as u8);
                let steps =
                    Plane::from_fn(columns, rows.div_ceil(apart), |_, _| chance.bits(5) as u16);
                let expected = spread_all(Level::available()[0], apart, &grey, &steps);
                for y in 0..steps.rows() {
                    assert_eq!(expected.0.row(apart * y), steps.row(y));
                }
                for level in Level::available() {
                    eprintln!("level {}", level.name());
                    assert!(spread_all(level, apart, &grey, &steps) == expected);
                }
            }
        }
    }
}
