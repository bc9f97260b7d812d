//! Where the left image repeats along its rows: a lattice, panes, tiles. What stands a period beside a pixel matches it
//! as well as the pixel itself does, in both views, and semi-global paths keep to the period that they began with: their
//! margin knows nothing of the others. So it is not believed there.
//!
//! A window `W` of 16 x 16 pixels, of which every second one in every fourth row counts, is compared with what lies `t`
//! columns beside it:
//!
//! ```text
//! A(t) = sum over W of min(|L(x + t, y) - L(x, y)|, 63)
//! ```
//!
//! It repeats with the least period `t` with `A(t) < 1/4 min(max of A(s) for s < t, 7/5 D)`, where `D` is what `W`
//! differs by from its mean, 7/5 of which is about what it differs by from another window with the same grey values in
//! other places. So what stands beside an edge, alike on both sides, does not repeat, nor does a slope; and what differs by
//! little more than noise shows no period at all. What would stand beyond the ends of the image repeats as the other side
//! does. An image of fewer than 16 columns or rows has no window.

use raster::{BoundingBox, DisparityRange, Plane, View};
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;

/// A cell is the middle of its window: windows overlap by half.
const CELL: usize = 8;
const ACROSS: usize = 2 * CELL;
/// So many cells are compared together, which are windows but one.
const TOGETHER: usize = 64;
const WINDOWS: usize = TOGETHER - 1;
/// At so many periods cells are compared before windows are: what was just written cannot be read at another place for a
/// while.
const PERIODS: usize = 8;
/// Rows of a window and its cell; of these every fourth one counts, of its columns every second one.
const DOWN: usize = 16;
const ROWS: usize = 4;
const EVERY: usize = 2;
const SAMPLES: usize = ACROSS / EVERY * ROWS;

/// So many times less than by what other windows differ by.
const ALIKE: u16 = 4;
/// The differences of a row of a cell, of at most so many grey values, are one byte.
const BOUND: u8 = u8::MAX / (CELL / EVERY) as u8;
/// Which window of some that are compared together it is.
const PLACES: [u16; TOGETHER] = {
    let mut places = [0; TOGETHER];
    let mut i = 0;
    while i < TOGETHER {
        places[i] = i as u16;
        i += 1;
    }
    places
};
/// Windows that differ by no more than so many grey values a pixel show no texture.
const TEXTURE: u16 = 4;
/// How sure a pixel can be. Of the tuning scenes' pixels that repeat, 6 % of those that were sure (.5) are wrong, as are
/// others that are this sure.
const MOST: f32 = 0.2;
const NEVER: u16 = u16::MAX;

/// The periods with which an image repeats, by cells.
#[derive(Default)]
pub(crate) struct Repetition {
    /// The first cell's place among those of the image, and how many there are in all.
    first: (usize, usize),
    all: (usize, usize),
    /// The least period to the right and to the left, [`NEVER`] where there is none.
    periods: [Plane<u16>; 2],
    /// Of each thread.
    workers: Vec<Phases>,
}

/// The samples of a column in the rows that count.
type Column = [u8; ROWS];

/// Columns of an image, of which every 8th lies beside the next: the first ones of all cells, the second ones, and so on.
/// Sums over the columns of a cell then are sums of vectors.
#[derive(Default)]
struct Phases {
    columns: Vec<Column>,
    /// Columns of a phase, and how many lie before the first one of the image.
    stride: usize,
    margin: usize,
}

/// The cells of places from `first` to `last`, where a window takes up so much and there are so many windows.
fn cells(
    first: usize,
    last: usize,
    margin: usize,
    size: usize,
    windows: usize,
) -> std::ops::Range<usize> {
    let cell = |place: usize| (place.saturating_sub(margin) / size).min(windows - 1);
    cell(first)..cell(last) + 1
}

/// Of so many windows, the first of which is that of cell `first` of an image, how many have a counterpart a period to
/// the right within the image, and how many of the first ones have none to the left.
#[inline(always)]
fn counterparts(width: usize, first: usize, cells: usize, period: usize) -> (usize, usize) {
    let inside = cells.min(((width - period) / CELL).saturating_sub(first + 1));
    let outside = cells.min(period.div_ceil(CELL).saturating_sub(first));
    (inside, outside)
}

impl Repetition {
    /// What it takes for a part of an image of so many columns, and a range.
    pub fn bytes(width: usize, part: BoundingBox, range: DisparityRange) -> usize {
        let reach = range.count() - 1;
        let (across, down) = (part.columns().div_ceil(CELL) + 1, part.rows().div_ceil(DOWN) + 1);
        let phases = rayon::current_num_threads() * Phases::bytes(width, reach);
        2 * size_of::<u16>() * across * down + phases
    }

    /// Looks for periods in a part of the left image, such as let one mistake disparities of the range that is searched,
    /// if any is, for each other.
    pub fn find(
        &mut self,
        level: Level,
        left: View<'_, u8>,
        part: BoundingBox,
        range: Option<DisparityRange>,
    ) -> Work {
        let (width, height) = (left.columns(), left.rows());
        self.all = ((width / CELL).saturating_sub(1), height / DOWN);
        let Some(range) = range.filter(|_| self.all.0 > 0 && self.all.1 > 0) else {
            self.periods.iter_mut().for_each(|periods| periods.reshape(0, 0, NEVER));
            return Work::default();
        };
        let across = cells(part.x0, part.x1, CELL / 2, CELL, self.all.0);
        let down = cells(part.y0, part.y1, 0, DOWN, self.all.1);
        self.first = (across.start, down.start);
        let (columns, rows) = (across.len(), down.len());
        self.periods.iter_mut().for_each(|periods| periods.reset(columns, rows, NEVER));
        let (threads, reach) = (rayon::current_num_threads(), range.count() - 1);
        self.workers.resize_with(threads, Phases::default);
        let share = rows.div_ceil(threads);
        let [right, left_hand] = self
            .periods
            .each_mut()
            .map(|periods| periods.samples_mut().par_chunks_mut(share * columns));
        let parts = right.zip(left_hand).zip(&mut self.workers).enumerate();
        parts.for_each(|(i, ((right, left_hand), phases))| {
            let rows = right.chunks_mut(columns).zip(left_hand.chunks_mut(columns));
            for (cell, (right, left_hand)) in (down.start + i * share..).zip(rows) {
                let seen = std::array::from_fn(|row| left.row(DOWN * cell + DOWN / ROWS * row));
                phases.take(&seen, reach);
                periods_of_row(level, width, across.start, reach, phases, right, left_hand);
            }
        });
        let compared = |period| {
            let (inside, outside) = counterparts(width, across.start, columns, period);
            inside + columns - outside
        };
        // Of every sample of a cell a difference, its bound, the sum.
        let compared = (1..=reach.min(width)).map(compared).sum::<usize>() * CELL / EVERY * ROWS;
        Work::bytes(width * rows * ROWS) + Work::operations(3 * compared * rows)
    }

    /// Lowers the confidence of a row of disparities, which begins at a column of row `y` of the image, where a period
    /// leads to another disparity within the range.
    pub fn doubt(
        &self,
        range: DisparityRange,
        (first, y): (usize, usize),
        disparities: impl Fn(usize) -> f32,
        confidence: &mut [f32],
    ) {
        let (min, max) = (range.min() as f32, range.max() as f32);
        if self.periods[0].rows() == 0 || confidence.is_empty() {
            return;
        }
        let last = first + confidence.len() - 1;
        let row = cells(y, y, 0, DOWN, self.all.1).start - self.first.1;
        let [right, left] = self.periods.each_ref().map(|periods| periods.row(row));
        // Mostly nothing repeats.
        let all = right.iter().zip(left).fold(NEVER, |all, (right, left)| all & right & left);
        if all == NEVER {
            return;
        }
        for cell in cells(first, last, CELL / 2, CELL, self.all.0) {
            let periods = [right, left].map(|periods| periods[cell - self.first.0]);
            if periods == [NEVER; 2] {
                continue;
            }
            let [right, left] = periods.map(f32::from);
            // Windows at the ends stand for what lies beyond their middle too.
            let start = if cell == 0 { 0 } else { CELL * cell + CELL / 2 };
            let end =
                if cell + 1 == self.all.0 { usize::MAX } else { CELL * cell + CELL / 2 + CELL };
            for x in start.max(first)..end.min(last + 1) {
                // What stands a period to the right is seen at a disparity that is as much smaller.
                let disparity = disparities(x - first);
                let is_one_of_several =
                    (disparity - right >= min - 0.5) | (disparity + left <= max + 0.5);
                let confidence = &mut confidence[x - first];
                if is_one_of_several && *confidence > MOST {
                    *confidence = MOST;
                }
            }
        }
    }
}

impl Phases {
    /// The margin and the stride for an image of so many columns.
    fn sizes(width: usize, reach: usize) -> (usize, usize) {
        let margin = reach.min(width) / CELL + 2;
        (margin, width.div_ceil(CELL) + 2 * margin + TOGETHER)
    }

    fn bytes(width: usize, reach: usize) -> usize {
        size_of::<Column>() * CELL * Self::sizes(width, reach).1
    }

    /// Takes rows that are compared so many columns beside themselves. What lies beyond their ends is 0.
    fn take(&mut self, rows: &[&[u8]; ROWS], reach: usize) {
        (self.margin, self.stride) = Self::sizes(rows[0].len(), reach);
        self.columns.clear();
        self.columns.resize(CELL * self.stride, [0; ROWS]);
        for x in 0..rows[0].len() {
            let place = x % CELL * self.stride + self.margin + x / CELL;
            self.columns[place] = rows.map(|row| row[x]);
        }
    }

    /// A column of so many cells from one on, which stands so far to the right of their beginnings.
    #[inline(always)]
    fn at(&self, cell: usize, columns: isize) -> &[Column; TOGETHER] {
        let (phase, cells) = (columns & (CELL as isize - 1), columns >> CELL.ilog2());
        let place = phase as usize * self.stride + self.margin + cell;
        let columns = &self.columns[place.wrapping_add_signed(cells)..];
        columns.first_chunk().expect("there is a margin of as many")
    }
}

at_every_level! {
    /// The least periods of a row of cells, of which `first` is the first one of the image.
    fn periods_of_row(
        width: usize,
        first: usize,
        reach: usize,
        phases: &Phases,
        right: &mut [u16],
        left: &mut [u16],
    ) {
        let last = reach.min(width);
        for (chunk, (right, left)) in right.chunks_mut(WINDOWS).zip(left.chunks_mut(WINDOWS)).enumerate() {
            let (first, cells) = (first + chunk * WINDOWS, right.len());
            let expected = expect(phases, first);
            let mut found = [[NEVER; TOGETHER]; 2];
            for (side, found) in [1, -1].into_iter().zip(&mut found) {
                let mut most = [0; TOGETHER];
                let mut sums = [[0; TOGETHER + 1]; PERIODS];
                for least in (1..=last).step_by(PERIODS) {
                    let periods = least..(least + PERIODS).min(last + 1);
                    for (sums, period) in sums.iter_mut().zip(periods.clone()) {
                        *sums = differences(phases, first, side * period as isize);
                    }
                    for (sums, period) in sums.iter().zip(periods) {
                        // The first ones are compared with the right, the last ones with the left.
                        let (inside, outside) = counterparts(width, first, cells, period);
                        let some = if side > 0 { 0..inside } else { outside..cells };
                        look(period, some, sums, &expected, &mut most, found);
                    }
                }
            }
            right.copy_from_slice(&found[0][..cells]);
            left.copy_from_slice(&found[1][..cells]);
            for (cell, (right, left)) in (first..).zip(right.iter_mut().zip(left)) {
                let (before, behind) = (CELL * cell, width - CELL * cell - ACROSS);
                match (*right, *left) {
                    (NEVER, period) if usize::from(period) > behind => *right = period,
                    (period, NEVER) if usize::from(period) > before => *left = period,
                    _ => {}
                }
            }
        }
    }
}

/// By what the windows of cells from one on may be expected to differ from others.
#[inline(always)]
fn expect(phases: &Phases, first: usize) -> [u16; TOGETHER] {
    let columns = || (0..CELL as isize).step_by(EVERY);
    let cells =
        || columns().flat_map(|column| [phases.at(first, column), phases.at(first + 1, column)]);
    let mut sums = [0; TOGETHER];
    for columns in cells() {
        for (sum, column) in sums.iter_mut().zip(columns) {
            *sum += sum_of(column);
        }
    }
    let means = sums.map(|sum| ((sum + SAMPLES as u16 / 2) / SAMPLES as u16) as u8);
    let mut apart = [0; TOGETHER];
    for columns in cells() {
        for ((apart, column), &mean) in apart.iter_mut().zip(columns).zip(&means) {
            *apart += sum_of(&column.map(|sample| sample.abs_diff(mean)));
        }
    }
    apart.map(|apart| (7 * u32::from(apart) / 5) as u16)
}

/// What the 8 columns of every cell from one on differ by from those that stand so many columns to the right of them, and
/// nothing after them.
#[inline(always)]
fn differences(phases: &Phases, first: usize, away: isize) -> [u16; TOGETHER + 1] {
    let mut apart = [[0; ROWS]; TOGETHER];
    for column in (0..CELL as isize).step_by(EVERY) {
        let columns = [phases.at(first, column), phases.at(first, column + away)];
        let [ones, others] = columns.map(|columns| columns.as_flattened());
        for ((all, one), other) in apart.as_flattened_mut().iter_mut().zip(ones).zip(others) {
            let apart = one.abs_diff(*other);
            *all += if apart < BOUND { apart } else { BOUND };
        }
    }
    let mut sums = [0; TOGETHER + 1];
    for (sum, apart) in sums.iter_mut().zip(&apart) {
        *sum = sum_of(apart);
    }
    sums
}

/// The sum of four bytes, two at a time: what loops make of one byte after the other is slow.
#[inline(always)]
fn sum_of(bytes: &Column) -> u16 {
    let all = u32::from_ne_bytes(*bytes);
    let pairs = (all & 0x00ff_00ff) + (all >> 8 & 0x00ff_00ff);
    (pairs + (pairs >> 16)) as u16
}

/// Compares what those windows that have a counterpart differ by at a period with what they differed by at shorter ones.
/// Who has none has none at longer ones.
#[inline(always)]
fn look(
    period: usize,
    with_counterpart: std::ops::Range<usize>,
    sums: &[u16; TOGETHER + 1],
    expected: &[u16; TOGETHER],
    most: &mut [u16; TOGETHER],
    found: &mut [u16; TOGETHER],
) {
    let (from, to) = (with_counterpart.start as u16, with_counterpart.end as u16);
    for i in 0..TOGETHER {
        let differ = sums[i] + sums[i + 1];
        let usual = if most[i] < expected[i] { most[i] } else { expected[i] };
        let repeats = (usual > TEXTURE * SAMPLES as u16)
            & (ALIKE * differ < usual)
            & (PLACES[i] >= from)
            & (PLACES[i] < to);
        let period = if repeats { period as u16 } else { NEVER };
        found[i] = if period < found[i] { period } else { found[i] };
        most[i] = if differ > most[i] { differ } else { most[i] };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    /// The least period of a window of an image to one side, by the formula.
    fn period(image: &Plane<u8>, cell: (usize, usize), reach: usize, side: i64) -> u16 {
        let at = |x: i64, y: usize| i64::from(image.row(y)[x as usize]);
        let (x0, y0) = ((CELL * cell.0) as i64, DOWN * cell.1);
        let window = || {
            (0..ROWS).flat_map(|row| {
                (0..ACROSS as i64).step_by(EVERY).map(move |x| (x0 + x, y0 + DOWN / ROWS * row))
            })
        };
        let sum: i64 = window().map(|(x, y)| at(x, y)).sum();
        let mean = (sum + SAMPLES as i64 / 2) / SAMPLES as i64;
        let expected = 7 * window().map(|(x, y)| (at(x, y) - mean).abs()).sum::<i64>() / 5;
        let mut most = 0;
        for period in 1..=reach as i64 {
            let other = x0 + side * period;
            if other < 0 || other + ACROSS as i64 > image.columns() as i64 {
                break;
            }
            let differ: i64 =
                window().map(|(x, y)| (at(x, y) - at(x + side * period, y)).abs().min(63)).sum();
            let usual = expected.min(most);
            if usual > 4 * SAMPLES as i64 && 4 * differ < usual {
                return period as u16;
            }
            most = most.max(differ);
        }
        NEVER
    }

    /// The periods of a window to the right and to the left.
    fn definition(image: &Plane<u8>, cell: (usize, usize), reach: usize) -> [u16; 2] {
        let [right, left] = [1, -1].map(|side| period(image, cell, reach, side));
        let is_beyond = |first: i64| first < 0 || first + 16 > image.columns() as i64;
        let x = 8 * cell.0 as i64;
        match (right != NEVER, left != NEVER) {
            (false, true) if is_beyond(x + i64::from(left)) => [left; 2],
            (true, false) if is_beyond(x - i64::from(right)) => [right; 2],
            _ => [right, left],
        }
    }

    /// Noise on the left, tiles of 11 columns in the middle, a slope and an edge on the right.
    fn picture(columns: usize, rows: usize) -> Plane<u8> {
        let mut chance = Chance(5);
        let noise = Plane::from_fn(columns, rows, |_, _| (200.0 * chance.share()) as u8);
        Plane::from_fn(columns, rows, |x, y| match x {
            40..120 => noise.row(y % 7)[40 + x % 11] + noise.row(y)[x] / 40,
            120..150 => (6 * (x - 120)) as u8,
            150.. => 200 - noise.row(y)[x] / 50,
            _ => noise.row(y)[x],
        })
    }

    fn found(level: Level, image: &Plane<u8>, part: BoundingBox, range: (i32, i32)) -> Repetition {
        let mut repetition = Repetition::default();
        let range = DisparityRange::new(range.0, range.1).unwrap();
        repetition.find(level, image.view(), part, Some(range));
        repetition
    }

    #[test]
    fn periods_are_their_definition_at_every_level() {
        for (columns, rows) in [(190, 70), (77, 17), (16, 16), (15, 40), (40, 15)] {
            let image = picture(columns, rows);
            for part in [
                BoundingBox { x0: 0, y0: 0, x1: columns - 1, y1: rows - 1 },
                BoundingBox { x0: columns / 3, y0: rows / 2, x1: columns / 2, y1: rows - 1 },
            ] {
                for (level, reach) in
                    Level::available().into_iter().flat_map(|level| [(level, 30), (level, 250)])
                {
                    eprintln!("{columns} x {rows}, level {}", level.name());
                    let repetition = found(level, &image, part, (-3, reach - 3));
                    let (right, left) = (&repetition.periods[0], &repetition.periods[1]);
                    let mut any = 0;
                    for y in 0..right.rows() {
                        for x in 0..right.columns() {
                            let cell = (repetition.first.0 + x, repetition.first.1 + y);
                            let expected = definition(&image, cell, reach as usize);
                            assert_eq!([right.row(y)[x], left.row(y)[x]], expected, "{cell:?}");
                            any += usize::from(expected.contains(&11));
                        }
                    }
                    assert!(columns < 190 || part.x0 > 0 || any > 20, "{any}");
                    assert_eq!(right.rows() > 0, columns >= 16 && rows >= 16);
                }
            }
        }
    }

    #[test]
    fn what_has_another_match_a_period_away_is_not_sure() {
        let (columns, rows) = (190, 40);
        let image = picture(columns, rows);
        let (level, all) =
            (Level::detect(), BoundingBox { x0: 0, y0: 0, x1: columns - 1, y1: rows - 1 });
        let confidence = |range: (i32, i32), disparity: f32, first: usize| {
            let repetition = found(level, &image, all, range);
            let mut confidence = vec![0.9; columns - first];
            let range = DisparityRange::new(range.0, range.1).unwrap();
            repetition.doubt(range, (first, 20), |_| disparity, &mut confidence);
            confidence
        };
        for first in [0, 33] {
            // Of the tiles all but those of the last window, whose counterparts are no tiles, are in doubt.
            let told = confidence((0, 30), 15.0, first);
            for (x, told) in (first..).zip(told) {
                let expected = if (48..108).contains(&x) { Some(MOST) } else { None };
                let expected = if (36..48).contains(&x) || (108..132).contains(&x) {
                    continue;
                } else {
                    expected
                };
                assert_eq!(told, expected.unwrap_or(0.9), "column {x}");
            }
        }
        // No other disparity is within the range.
        assert!(confidence((0, 10), 5.0, 0).iter().all(|&told| told == 0.9));
        // One to the right alone, one to the left alone.
        assert_eq!([confidence((0, 16), 14.0, 0)[80], confidence((0, 16), 3.0, 0)[80]], [MOST; 2]);
        assert_eq!(confidence((0, 16), 8.0, 0)[80], 0.9);
        // Where nothing is searched, nothing of the frame before is left.
        let mut searched = found(level, &image, all, (0, 30));
        searched.find(level, image.view(), all, None);
        let mut same = vec![0.9; columns];
        searched.doubt(DisparityRange::new(0, 30).unwrap(), (0, 3), |_| 15.0, &mut same);
        assert!(same.iter().all(|&told| told == 0.9));
        // Nothing is made surer.
        let repetition = found(level, &image, all, (0, 30));
        let mut little = vec![0.1; columns];
        repetition.doubt(DisparityRange::new(0, 30).unwrap(), (0, 3), |_| 15.0, &mut little);
        assert!(little.iter().all(|&told| told == 0.1));
    }
}
