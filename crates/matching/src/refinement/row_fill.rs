//! Holes filled from the background in their row, in fixed point.
//!
//! What the right camera cannot see is hidden by something nearer, so it belongs to whatever lies
//! behind: a hole takes the smaller of the two nearest values in its row. A hole at the row's end
//! has one neighbour and takes its value; when that puts the match outside the right image, the
//! pixel was outside its view, not hidden, and is marked so. A row without any value takes those of
//! the nearest row that has some.
//!
//! Where the two neighbours are of one surface (they differ by little) a hole lies between them, and
//! what it hides is told from the geometry alone: with the background's disparity `d`, a pixel whose
//! match `x - d` lies at or behind the match of the nearer surface to its right is hidden in the
//! right image; any other was seen by both cameras and its match was wrong.

use std::ops::Range;

use raster::Reason;

use super::outside::is_outside;
use crate::selection::fixed_point::{FixedPoint, HOLE};

/// Fills rows that begin with a hole from the nearest row that does not, or with `nowhere` where
/// all do, and says which.
pub(crate) fn copy_nearest_rows<T: Copy>(
    samples: &mut [T],
    columns: usize,
    is_hole: impl Fn(T) -> bool,
    nowhere: T,
    mut filled: impl FnMut(usize, &[T]),
) {
    let rows = samples.len() / columns;
    let mut y = 0;
    while y < rows {
        let empty = |y: &usize| is_hole(samples[*y * columns]);
        if !empty(&y) {
            y += 1;
            continue;
        }
        let end = (y..rows).find(|y| !empty(y)).unwrap_or(rows);
        let (above, below) = (y.checked_sub(1), (end < rows).then_some(end));
        for to in y..end {
            let nearest = match (above, below) {
                (Some(above), Some(below)) if below - to < to - above => Some(below),
                (Some(above), _) => Some(above),
                (None, below) => below,
            };
            let place = to * columns..(to + 1) * columns;
            match nearest {
                Some(from) => {
                    samples.copy_within(from * columns..(from + 1) * columns, place.start);
                }
                None => samples[place.clone()].fill(nowhere),
            }
            filled(to, &samples[place]);
        }
        y = end;
    }
}

/// One row of disparities in fixed point, and what is known of them.
pub(crate) struct Row<'a> {
    pub disparities: &'a mut [u16],
    pub reasons: &'a mut [Reason],
    pub confidence: &'a mut [f32],
}

/// How gaps are filled.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Filling {
    /// Columns of the image.
    pub width: usize,
    /// The row's first column in the image.
    pub first: usize,
    pub numbers: FixedPoint,
    /// Neighbours that differ by no more are of one surface.
    pub same_surface: u16,
}

impl Filling {
    /// Fills all of a row between the runs that are believed. Without any, the row becomes holes.
    pub fn fill_between(&self, believed: impl Iterator<Item = Range<usize>>, mut row: Row<'_>) {
        // At once: most runs are short.
        row.reasons.fill(Reason::Matched);
        let mut done = 0;
        for run in believed {
            self.fill_gap(&mut row, done..run.start);
            done = run.end;
        }
        if done > 0 {
            let end = row.disparities.len();
            self.fill_gap(&mut row, done..end);
        } else {
            row.disparities.fill(HOLE);
            row.reasons.fill(Reason::MismatchedHole);
            row.confidence.fill(0.0);
        }
    }

    fn fill_gap(&self, row: &mut Row<'_>, gap: Range<usize>) {
        if gap.is_empty() {
            return;
        }
        let before = if gap.start > 0 { row.disparities[gap.start - 1] } else { HOLE };
        let after = row.disparities.get(gap.end).copied().unwrap_or(HOLE);
        row.confidence[gap.clone()].fill(0.0);
        row.reasons[gap.clone()].fill(Reason::MismatchedFilled);
        let one_surface = before.abs_diff(after) <= self.same_surface;
        if one_surface && before != HOLE && after != HOLE {
            continue_surface([before, after], &mut row.disparities[gap]);
            return;
        }
        let background = before.min(after);
        row.disparities[gap.clone()].fill(background);
        let value = self.numbers.pixels(background);
        if after != HOLE {
            // The match of the nearer surface, and the first column whose match lies behind it.
            let nearer = gap.end as f32 - self.numbers.pixels(after);
            let hidden = (nearer + value).ceil().max(gap.start as f32) as usize;
            row.reasons[hidden.min(gap.end)..gap.end].fill(Reason::OccludedFilled);
        }
        self.mark_outside(value, gap, row.reasons);
    }

    /// Marks filled pixels of this value whose match lies outside the right image.
    fn mark_outside(&self, value: f32, gap: Range<usize>, reasons: &mut [Reason]) {
        let place = |column: f32| (column as usize).saturating_sub(self.first);
        let inside = place((value - 0.5).ceil()).clamp(gap.start, gap.end);
        let beyond = place((self.width as f32 - 0.5 + value).floor() + 1.0).clamp(inside, gap.end);
        reasons[gap.start..inside].fill(Reason::OutsideRightFilled);
        reasons[beyond..gap.end].fill(Reason::OutsideRightFilled);
    }
}

/// Fills a gap with what lies in equal steps between its neighbours, each cut off towards the one before it: what is left
/// of a step is added up, because divisions take long.
fn continue_surface([before, after]: [u16; 2], gap: &mut [u16]) {
    let (steps, change) = (gap.len() + 1, usize::from(before.abs_diff(after)));
    let (step, left) = ((change / steps) as u16, change % steps);
    let (mut off, mut over) = (0, 0);
    for disparity in gap {
        (off, over) = (off + step, over + left);
        if over >= steps {
            (off, over) = (off + 1, over - steps);
        }
        *disparity = if after < before { before - off } else { before + off };
    }
}

/// The reason of a filled pixel.
pub(crate) fn filled(width: usize, column: usize, value: f32, hole: Reason) -> Reason {
    if is_outside(width, column, value) {
        Reason::OutsideRightFilled
    } else if hole == Reason::MismatchedHole {
        Reason::MismatchedFilled
    } else {
        Reason::OccludedFilled
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Reason::{
        Matched, MismatchedFilled, MismatchedHole, OccludedFilled, OccludedHole, OutsideRightFilled,
    };
    use raster::BoundingBox;

    #[test]
    fn negative_disparities_leave_the_right_image_on_its_other_side() {
        assert_eq!(filled(10, 8, -1.0, OccludedHole), OccludedFilled);
        assert_eq!(filled(10, 8, -2.0, OccludedHole), OutsideRightFilled);
    }

    #[test]
    fn rows_without_a_value_take_the_nearest_ones() {
        let mut rows = [-1, -1, 5, -1, -1, -1, 7, -1];
        let mut told = Vec::new();
        copy_nearest_rows(&mut rows, 1, |v| v < 0, 9, |y, row| told.push((y, row[0])));
        assert_eq!(rows, [5, 5, 5, 5, 5, 7, 7, 7]);
        assert_eq!(told, [(0, 5), (1, 5), (3, 5), (4, 5), (5, 7), (7, 7)]);
        let mut rows = [-1, -1];
        copy_nearest_rows(&mut rows, 2, |v| v < 0, 9, |_, _| ());
        assert_eq!(rows, [9, 9]);
    }

    /// How rows of 12 columns are filled that begin at `first` of 40.
    fn filling(first: usize, range: (i32, i32)) -> Filling {
        let range = raster::DisparityRange::new(range.0, range.1).unwrap();
        let bounds = BoundingBox::new(first, 0, first + 11, 0).unwrap();
        let numbers = FixedPoint::new(&crate::cost::SearchSpace::new(40, bounds, range));
        Filling { width: 40, first, numbers, same_surface: 2 * numbers.scale() }
    }

    /// Fills a row in whole disparities from 0, one step each; columns begin at `first` of 40.
    fn between(first: usize, runs: &[(usize, &[u16])]) -> (Vec<f32>, Vec<Reason>) {
        let filling = filling(first, (0, 20));
        let numbers = filling.numbers;
        let mut disparities = [13 * numbers.scale(); 12];
        for (start, run) in runs {
            for (to, from) in disparities[*start..].iter_mut().zip(*run) {
                *to = from * numbers.scale();
            }
        }
        let (mut reasons, mut confidence) = ([Reason::OutsideBox; 12], [1.0; 12]);
        let row = Row {
            disparities: &mut disparities,
            reasons: &mut reasons,
            confidence: &mut confidence,
        };
        let believed = runs.iter().map(|(start, run)| *start..start + run.len());
        filling.fill_between(believed, row);
        for (reason, sure) in reasons.iter().zip(confidence) {
            assert_eq!(sure, f32::from(u8::from(*reason == Matched)));
        }
        (disparities.iter().map(|&d| numbers.pixels(d)).collect(), reasons.to_vec())
    }

    #[test]
    fn gaps_take_the_background_and_geometry_says_what_is_hidden() {
        use Reason::MismatchedFilled as Mismatched;
        let (values, reasons) = between(20, &[(1, &[3, 3]), (8, &[6, 6])]);
        assert_eq!(values, [3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 6.0, 6.0, 6.0, 6.0]);
        // The nearer surface begins at column 8: it hides the 6 - 3 pixels before it.
        let mut expected = [Mismatched; 12];
        expected[5..8].fill(OccludedFilled);
        for x in [1, 2, 8, 9] {
            expected[x] = Matched;
        }
        assert_eq!(reasons, expected);
        // Nothing is hidden at the other side of a nearer surface.
        let (values, reasons) = between(20, &[(0, &[9, 9]), (10, &[4, 4])]);
        assert_eq!(values[2..10], [4.0; 8]);
        assert_eq!(reasons[2..10], [Mismatched; 8]);
    }

    #[test]
    fn one_surface_goes_on_between_its_parts() {
        let (values, reasons) = between(20, &[(0, &[5, 5]), (5, &[7, 7, 7, 7, 7, 7, 7])]);
        assert_eq!(values[2..5], [5.5, 6.0, 6.5]);
        assert_eq!(reasons[2..5], [MismatchedFilled; 3]);
    }

    #[test]
    fn equal_steps_are_those_of_a_division() {
        for (before, after) in [(100, 117), (117, 100), (9, 9), (0, 65534), (65534, 3)] {
            for length in (1..40).chain([1000, 70_000]) {
                let mut gap = vec![0; length];
                continue_surface([before, after], &mut gap);
                let (from, change) = (i64::from(before), i64::from(after) - i64::from(before));
                let expected =
                    (1..=length as i64).map(|i| (from + change * i / (length as i64 + 1)) as u16);
                assert!(gap.into_iter().eq(expected), "{before} to {after} over {length}");
            }
        }
    }

    #[test]
    fn the_left_strip_lies_outside_the_right_image() {
        let (values, reasons) = between(0, &[(6, &[4, 4, 4, 4, 4, 4])]);
        assert_eq!(values, [4.0; 12]);
        assert_eq!(reasons[..4], [OutsideRightFilled; 4]);
        assert_eq!(reasons[4..6], [MismatchedFilled; 2]);
        let (values, reasons) = between(0, &[]);
        assert!(values.iter().all(|v| v.is_nan()));
        assert_eq!(reasons, [MismatchedHole; 12]);
    }

    #[test]
    fn the_right_strip_lies_outside_the_right_image_at_negative_disparities() {
        let filling = filling(28, (-9, 0));
        for quarters in 0..=36 {
            let mut disparities = [quarters * (filling.numbers.scale() / 4); 12];
            let (mut reasons, mut confidence) = ([Reason::OutsideBox; 12], [1.0; 12]);
            let row = Row {
                disparities: &mut disparities,
                reasons: &mut reasons,
                confidence: &mut confidence,
            };
            filling.fill_between(std::iter::once(0..2), row);
            let value = filling.numbers.pixels(disparities[11]);
            assert_eq!(value, f32::from(quarters) / 4.0 - 9.0);
            for (x, &reason) in reasons.iter().enumerate().skip(2) {
                let outside = is_outside(40, 28 + x, value);
                let expected = if outside { OutsideRightFilled } else { MismatchedFilled };
                assert_eq!(reason, expected, "column {x} at {value}");
            }
        }
    }
}
