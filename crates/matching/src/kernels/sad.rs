//! One row of window sums of absolute differences, with the winners of both views.
//!
//! ```text
//! A(x, y, k) = |L(x, y) - R(x - min - k, y)|
//! C(x, y, k) = sum of A(x', y', k) over |x' - x| <= r, |y' - y| <= r inside the image
//! ```
//!
//! In: the filtered rows that enter and leave the window. Out: per column the least sum of the
//! left view, its index, its neighbours, and what confirms it in the right view.
//!
//! For one disparity after the other, all columns side by side in memory:
//!
//! 1. `V`, the sums down the window's columns, is slid by one row. Differences are at most
//!    [`LARGEST_DIFFERENCE`], so `V` fits a byte: 8 operations for 64 columns.
//! 2. `C` is the sum of nine neighbours of `V`, by way of sums of three.
//! 3. The left view's least sum and its index, the right view's least sum: column `x` of the left
//!    is column `x - min - k` of the right, so both are a comparison with a row of minima.
//!
//! Everything is an operation on whole rows, nothing depends on the column before, and no vector
//! is ever folded into one number. (With the disparities of a column side by side, as OpenCV has
//! them, `C` would be slid along with less work, but finding the least of a vector and its place
//! costs as much as that saves.) Loads and stores are what it waits for, so four disparities are
//! compared together.

use std::ops::Range;

use super::aligned::{Aligned, LINE};
use super::level::at_every_level;
use crate::cost::SearchSpace;

/// Half the window: it is `2 RADIUS + 1` pixels wide and high.
pub(crate) const RADIUS: usize = 4;
/// No difference of the filtered images may be larger: sums down a column must fit a byte.
pub(crate) const LARGEST_DIFFERENCE: u8 = u8::MAX / (2 * RADIUS as u8 + 1);
/// Sums from here on stand for "cannot be tried": no sum over the window comes near.
pub(crate) const OUT: u16 = 0x8000;

// Sums along a row are built by three times three.
const _: () = assert!(2 * RADIUS + 1 == 9);

/// Columns are handled in groups of this many. (Loops over shorter arrays are unrolled before the
/// compiler looks for vectors in them, and it does not find them again.)
const GROUP: usize = 64;

/// Disparities that are compared together.
const STEP: usize = 4;

/// Operations on bytes per pixel and disparity: two differences of three each that are added and taken
/// away; four additions of 16 bits along the row; two minima, a comparison and a choice of 16 bits.
pub(crate) const OPERATIONS: usize = 2 * (3 + 1) + 4 * 2 + 4 * 2;

/// How rows lie in memory: place `p` belongs to left column `first - RADIUS + p`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Answered columns, filled up to whole groups.
    answered: usize,
    /// Disparities, filled up to whole steps.
    count: usize,
    /// Places of a row of bytes: all columns that support an answered one, in whole groups.
    pub left: usize,
    /// Samples of a right row.
    pub right: usize,
    /// Places of columns inside the image, as far as windows reach.
    inside: (usize, usize),
}

impl Layout {
    /// The layout of a search space.
    pub fn new(space: &SearchSpace) -> Self {
        let answered = space.columns().next_multiple_of(GROUP);
        let count = space.count.next_multiple_of(STEP);
        let left = (space.columns() + 2 * RADIUS).next_multiple_of(GROUP);
        let end = (space.width - space.first).min(space.columns() + RADIUS) + RADIUS;
        let inside = (RADIUS.saturating_sub(space.first), end);
        Self { answered, count, left, right: left + count - 1, inside }
    }

    /// Samples between the left place `p` and the right one at index `k`, in a right row:
    /// `p + shift(k)`.
    pub fn shift(&self, k: usize) -> usize {
        self.count - 1 - k
    }
}

/// A filtered row of both images. Place `p` of `left` and place `p + shift(k)` of `right` are
/// compared at index `k`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowPair<'a> {
    pub left: &'a [u8],
    pub right: &'a [u8],
}

/// What won in one row: per answered column of the left image, and per column of the right one.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub(crate) struct Winners {
    /// Index of the disparity with the least sum, the smallest of several.
    pub index: Vec<u16>,
    /// That least sum; 32768 or more where nothing could be tried.
    pub least: Vec<u16>,
    /// The sums of the disparities before and after the winner, 32768 or more at the range's ends.
    pub before: Vec<u16>,
    pub after: Vec<u16>,
    /// The least of the winner's sum and those of `(x - 1, k - 1)` and `(x + 1, k + 1)`, which
    /// match the same right pixel.
    pub confirming: Vec<u16>,
    /// Place `x + shift(k)` holds the least sum of the right column that answered column `x`
    /// matches at index `k`.
    pub right: Vec<u16>,
}

/// The memory of the kernel: sums of a band of rows.
#[derive(Debug, Default)]
pub(crate) struct Sad {
    /// `V`: per disparity a row.
    columns: Aligned<u8>,
    /// Sums of three neighbours in `V` of one disparity.
    threes: Aligned<u16>,
    /// `C`: per disparity a row, and one more before the first and after the last. Where a
    /// disparity cannot be tried, and in the room before and between rows, stands [`OUT`].
    costs: Aligned<u16>,
    pub winners: Winners,
}

fn refill<T: Clone>(buffer: &mut Vec<T>, length: usize, value: T) {
    buffer.clear();
    buffer.resize(length, value);
}

impl Sad {
    /// The memory for a search space.
    pub fn bytes(space: &SearchSpace, layout: &Layout) -> usize {
        let row = layout.answered + GROUP;
        // The sums of whole rows, then those of one: of three columns, and five of winners; the
        // right view's are longer.
        let sums = space.count * layout.left + size_of::<u16>() * (layout.count + 2) * row;
        sums + size_of::<u16>() * (layout.left + 6 * row + layout.count + 4 * GROUP) + 3 * LINE
    }

    /// Begins a band of rows with an empty window.
    pub fn begin(&mut self, space: &SearchSpace, layout: &Layout) {
        self.columns.refill(space.count * layout.left + 2 * GROUP, 0);
        self.threes.refill(layout.left + 2 * GROUP, 0);
        self.costs.refill(GROUP + (layout.count + 2) * (layout.answered + GROUP), OUT);
        let winners = &mut self.winners;
        for buffer in [
            &mut winners.index,
            &mut winners.least,
            &mut winners.before,
            &mut winners.after,
            &mut winners.confirming,
        ] {
            refill(buffer, layout.answered + GROUP, 0);
        }
        refill(&mut winners.right, layout.answered + GROUP + layout.count - 1, OUT);
    }
}

at_every_level! {
    /// Slides the window down by one row.
    pub(crate) fn slide_down(
        sad: &mut Sad,
        space: &SearchSpace,
        layout: &Layout,
        entering: RowPair<'_>,
        leaving: RowPair<'_>,
    ) {
        for (k, columns) in sad.columns.chunks_exact_mut(layout.left).take(space.count).enumerate()
        {
            slide_columns(columns, layout.shift(k), layout, entering, leaving);
        }
    }

    /// Slides the window down by one row, and finds what wins there.
    pub(crate) fn match_row(
        sad: &mut Sad,
        space: &SearchSpace,
        layout: &Layout,
        entering: RowPair<'_>,
        leaving: RowPair<'_>,
    ) {
        let Sad { columns, threes, costs, winners } = sad;
        let stride = layout.answered + GROUP;
        winners.least.fill(OUT);
        winners.index.fill(0);
        winners.right.fill(OUT);
        for k0 in (0..space.count).step_by(STEP) {
            let last = (k0 + STEP).min(space.count) - 1;
            // Only groups in which some column has one of these disparities for a candidate.
            let start = columns_with_candidate(space, k0).0 / GROUP * GROUP;
            let end = columns_with_candidate(space, last).1;
            let groups = start..end.next_multiple_of(GROUP);
            for k in k0..=last {
                let columns = &mut columns[k * layout.left..][..layout.left + 2 * GROUP];
                let slid = &mut columns[..layout.left];
                slide_columns(slid, layout.shift(k), layout, entering, leaving);
                let row = GROUP + (k + 1) * stride;
                let costs = &mut costs[row + groups.start..row + groups.end];
                let (first, end) = columns_with_candidate(space, k);
                sum_along(columns, threes, groups.start..end, costs);
                blank(costs, groups.start, first..end);
            }
            let until = (end + STEP - 1).next_multiple_of(GROUP);
            compare(costs, stride, k0, groups.start..until, layout, winners);
        }
        look_around(costs, stride, space.columns(), winners);
    }
}

/// The answered columns, counted from the first, at which disparity `k` is tried: from the first up
/// to but without the last of two. There is at least one.
fn columns_with_candidate(space: &SearchSpace, k: usize) -> (usize, usize) {
    let (first, disparity) = (space.first as i64, i64::from(space.min) + k as i64);
    let from = (disparity - first).max(0);
    let end = (space.width as i64 + disparity - first).min(space.columns() as i64);
    (from as usize, end as usize)
}

// The loops below work on whole groups, and on copies of what they change: the compiler then knows
// that nothing overlaps.

/// The group at a place.
#[inline(always)]
fn group<T>(samples: &[T], at: usize) -> &[T; GROUP] {
    samples[at..].first_chunk().expect("a whole group")
}

/// The group at a place.
#[inline(always)]
fn group_mut<T>(samples: &mut [T], at: usize) -> &mut [T; GROUP] {
    samples[at..].first_chunk_mut().expect("a whole group")
}

/// `V` of one disparity, one row further down.
#[inline(always)]
fn slide_columns<'a>(
    columns: &mut [u8],
    shift: usize,
    layout: &Layout,
    entering: RowPair<'a>,
    leaving: RowPair<'a>,
) {
    let length = columns.len();
    let left = |row: RowPair<'a>| row.left[..length].as_chunks().0.iter();
    let right = |row: RowPair<'a>| row.right[shift..][..length].as_chunks().0.iter();
    let entering = left(entering).zip(right(entering));
    let leaving = left(leaving).zip(right(leaving));
    let supply = entering.zip(leaving);
    let groups = columns.as_chunks_mut::<GROUP>().0.iter_mut();
    for (columns, ((left_in, right_in), (left_out, right_out))) in groups.zip(supply) {
        let mut sums = *columns;
        let (left_in, right_in): (&[u8; GROUP], &[u8; GROUP]) = (left_in, right_in);
        let (left_out, right_out): (&[u8; GROUP], &[u8; GROUP]) = (left_out, right_out);
        for i in 0..GROUP {
            let gain = left_in[i].max(right_in[i]) - left_in[i].min(right_in[i]);
            let loss = left_out[i].max(right_out[i]) - left_out[i].min(right_out[i]);
            sums[i] = sums[i].wrapping_add(gain).wrapping_sub(loss);
        }
        *columns = sums;
    }
    // Columns outside the image add nothing to any window.
    let (first, end) = layout.inside;
    columns[..first].fill(0);
    columns[end..length.min(end + RADIUS)].fill(0);
}

/// `C` of one disparity at some answered columns, and something up to the end of `costs`.
#[inline(always)]
fn sum_along(columns: &[u8], threes: &mut [u16], answered: Range<usize>, costs: &mut [u16]) {
    let first = answered.start;
    // The last window ends further on.
    for at in (first..answered.end + 2 * 3).step_by(GROUP) {
        let (a, b, c) = (group(columns, at), group(columns, at + 1), group(columns, at + 2));
        let sums = group_mut(threes, at);
        for i in 0..GROUP {
            sums[i] = u16::from(a[i]) + u16::from(b[i]) + u16::from(c[i]);
        }
    }
    for at in (0..costs.len()).step_by(GROUP) {
        let x = first + at;
        let (a, b, c) = (group(threes, x), group(threes, x + 3), group(threes, x + 6));
        let sums = group_mut(costs, at);
        for i in 0..GROUP {
            sums[i] = a[i] + b[i] + c[i];
        }
    }
}

/// Says of the columns outside `tried` that they cannot be; `costs` begin at column `start`.
#[inline(always)]
fn blank(costs: &mut [u16], start: usize, tried: Range<usize>) {
    let (first, end) = (tried.start - start, tried.end - start);
    let before = (0..first).step_by(GROUP);
    for at in before.chain((end / GROUP * GROUP..costs.len()).step_by(GROUP)) {
        let group = group_mut(costs, at);
        for i in 0..GROUP {
            let is_tried = (first..end).contains(&(at + i));
            group[i] = if is_tried { group[i] } else { OUT };
        }
    }
}

/// Compares the costs of indices `k0 ..` with the least ones so far of both views.
#[inline(always)]
fn compare(
    costs: &[u16],
    stride: usize,
    k0: usize,
    columns: Range<usize>,
    layout: &Layout,
    winners: &mut Winners,
) {
    let shift = layout.shift(k0 + STEP - 1);
    for at in columns.step_by(GROUP) {
        let row = |j: usize| group(costs, GROUP + (k0 + j + 1) * stride + at);
        let straight = [row(0), row(1), row(2), row(3)];
        // The same right columns are as many left columns further on as disparities.
        let slanted = |j: usize| group(costs, GROUP + (k0 + j + 1) * stride + at + j + 1 - STEP);
        let slanted = [slanted(0), slanted(1), slanted(2), straight[3]];
        let least = group_mut(&mut winners.least, at);
        let index = group_mut(&mut winners.index, at);
        let right = group_mut(&mut winners.right, at + shift);
        let (mut lowest, mut places, mut opposite) = (*least, *index, *right);
        for i in 0..GROUP {
            for j in 0..STEP {
                let cost = straight[j][i];
                places[i] = if cost < lowest[i] { (k0 + j) as u16 } else { places[i] };
                lowest[i] = lowest[i].min(cost);
                opposite[i] = opposite[i].min(slanted[j][i]);
            }
        }
        (*least, *index, *right) = (lowest, places, opposite);
    }
}

/// The costs around the winners of the answered columns, in whole groups.
#[inline(always)]
fn look_around(costs: &[u16], stride: usize, columns: usize, winners: &mut Winners) {
    for at in (0..columns).step_by(GROUP) {
        let (index, least) = (group(&winners.index, at), group(&winners.least, at));
        let mut places = [0; GROUP];
        for i in 0..GROUP {
            places[i] = usize::from(index[i]) * stride + GROUP + at + i;
        }
        // One and none to the left at the disparity before, none and one to the right at that after.
        let (mut below, mut above) = ([[0; 2]; GROUP], [[0; 2]; GROUP]);
        for i in 0..GROUP {
            below[i] = two(costs, places[i] - 1);
            above[i] = two(costs, places[i] + 2 * stride);
        }
        let (mut before, mut after, mut confirming) = ([0; GROUP], [0; GROUP], [0; GROUP]);
        for i in 0..GROUP {
            before[i] = below[i][1];
            after[i] = above[i][0];
            confirming[i] = least[i].min(below[i][0]).min(above[i][1]);
        }
        *group_mut(&mut winners.before, at) = before;
        *group_mut(&mut winners.after, at) = after;
        *group_mut(&mut winners.confirming, at) = confirming;
    }
}

/// Two neighbours, in one load.
#[inline(always)]
fn two(costs: &[u16], at: usize) -> [u16; 2] {
    *costs[at..].first_chunk().expect("there is room after the last row")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::absolute_difference::repeat_border;
    use crate::kernels::level::Level;
    use raster::{BoundingBox, DisparityRange, Plane};

    /// The definition: every window summed anew, every candidate looked at.
    fn winners_by_definition(
        space: &SearchSpace,
        left: &Plane<u8>,
        right: &Plane<u8>,
        y: usize,
    ) -> Winners {
        let (width, height) = left.size();
        let cost = |x: usize, k: usize| -> u16 {
            let mut sum = 0;
            for v in y.saturating_sub(RADIUS)..=(y + RADIUS).min(height - 1) {
                for u in x.saturating_sub(RADIUS)..=(x + RADIUS).min(width - 1) {
                    let match_column = u as i64 - i64::from(space.min) - k as i64;
                    let match_column = match_column.clamp(0, width as i64 - 1) as usize;
                    sum += u16::from(left.row(v)[u].abs_diff(right.row(v)[match_column]));
                }
            }
            sum
        };
        let inside = |x: i64, k: i64| {
            x >= space.first as i64
                && x <= space.last as i64
                && (0..space.count as i64).contains(&k)
                && (0..width as i64).contains(&(x - i64::from(space.min) - k))
        };
        let cost = |x: i64, k: i64| if inside(x, k) { cost(x as usize, k as usize) } else { OUT };
        let mut winners = Winners::default();
        for x in space.first as i64..=space.last as i64 {
            let k = (0..space.count as i64).min_by_key(|&k| cost(x, k)).unwrap();
            winners.index.push(k as u16);
            winners.least.push(cost(x, k));
            winners.before.push(cost(x, k - 1));
            winners.after.push(cost(x, k + 1));
            let diagonal = [cost(x, k), cost(x - 1, k - 1), cost(x + 1, k + 1)];
            winners.confirming.push(*diagonal.iter().min().unwrap());
        }
        let shift = Layout::new(space).shift(0);
        for place in 0..space.columns() + shift {
            let x = |k: i64| space.first as i64 + place as i64 + k - shift as i64;
            let costs = (0..space.count as i64).map(|k| cost(x(k), k));
            winners.right.push(costs.min().unwrap());
        }
        winners
    }

    /// Winners of every row, by the kernel.
    fn winners_by_kernel(
        level: Level,
        space: &SearchSpace,
        left: &Plane<u8>,
        right: &Plane<u8>,
    ) -> Vec<Winners> {
        let height = left.rows();
        let layout = Layout::new(space);
        let first = space.first as i64 - RADIUS as i64;
        let least = first - i64::from(space.min) - layout.shift(0) as i64;
        let row = |image: &Plane<u8>, y: usize, from: i64, length: usize| {
            let mut row = vec![0; length];
            if y < height {
                repeat_border(image.row(y), from, &mut row);
            }
            row
        };
        let rows =
            |y: usize| [row(left, y, first, layout.left), row(right, y, least, layout.right)];
        fn pair(rows: &[Vec<u8>; 2]) -> RowPair<'_> {
            RowPair { left: &rows[0], right: &rows[1] }
        }
        let nothing = rows(usize::MAX);
        let mut sad = Sad::default();
        sad.begin(space, &layout);
        for y in 0..RADIUS {
            slide_down(level, &mut sad, space, &layout, pair(&rows(y)), pair(&nothing));
        }
        let mut all = Vec::new();
        for y in 0..height {
            let (entering, leaving) = (rows(y + RADIUS), rows(y.wrapping_sub(RADIUS + 1)));
            match_row(level, &mut sad, space, &layout, pair(&entering), pair(&leaving));
            all.push(sad.winners.clone());
        }
        all
    }

    #[test]
    fn a_disparity_is_tried_where_it_is_a_candidate() {
        for (columns, range) in
            [((0, 9), (0, 5)), ((0, 9), (-4, 3)), ((3, 4), (-500, 500)), ((0, 9), (8, 40))]
        {
            let bounds = BoundingBox::new(columns.0, 0, columns.1, 0).unwrap();
            let range = DisparityRange::new(range.0, range.1).unwrap();
            let space = SearchSpace::new(10, bounds, range);
            for (x, k) in (0..space.columns()).flat_map(|x| (0..space.count).map(move |k| (x, k))) {
                let (from, end) = columns_with_candidate(&space, k);
                let expected = space.candidates(space.first + x).contains(&k);
                assert_eq!((from..end).contains(&x), expected, "column {x}, index {k}");
                assert!(from < end);
            }
        }
    }

    #[test]
    fn the_kernel_is_its_definition_at_every_level() {
        let noise = |x: usize, y: usize, seed: usize| {
            let v = (x * 0x9E37 + y * 0x79B9 + seed * 0x7F4A).wrapping_mul(0x2545_F491_4F6C_DD1D);
            (v >> 40) as u8 % (LARGEST_DIFFERENCE + 1)
        };
        let shapes = [
            // width, height, first and last answered column, range
            (1, 1, (0, 0), (0, 0)),
            (3, 12, (0, 2), (-5, 5)),
            (40, 3, (0, 39), (0, 15)),
            (75, 11, (0, 74), (0, 63)),
            (75, 11, (9, 60), (3, 31)),
            (90, 10, (2, 88), (-20, 70)),
            (33, 9, (30, 32), (-40, 40)),
            // What supports 56 columns is a whole group, inside the image and beyond its end.
            (70, 10, (5, 60), (0, 20)),
            (61, 10, (5, 60), (0, 20)),
        ];
        for level in Level::available() {
            eprintln!("level {}", level.name());
            for (width, height, (x0, x1), (min, max)) in shapes {
                let left = Plane::from_fn(width, height, |x, y| noise(x, y, 1));
                let right = Plane::from_fn(width, height, |x, y| {
                    // Half noise, half a shifted copy; blank at the right, where sums are equal.
                    match x {
                        _ if x > 60 => 0,
                        _ if y % 2 == 0 => noise(x + 7, y, 1),
                        _ => noise(x, y, 2),
                    }
                });
                let bounds = BoundingBox::new(x0, 0, x1, 0).unwrap();
                let range = DisparityRange::new(min, max).unwrap();
                let space = SearchSpace::new(width, bounds, range);
                let found = winners_by_kernel(level, &space, &left, &right);
                for (y, found) in found.into_iter().enumerate() {
                    let expected = winners_by_definition(&space, &left, &right, y);
                    let expected_columns = space.columns();
                    let tried: Vec<bool> = expected.least.iter().map(|&v| v < OUT).collect();
                    let only = |v: &[u16]| -> Vec<u16> {
                        // Above OUT, values only say that nothing was tried.
                        v[..expected_columns].iter().map(|&v| v.min(OUT)).collect()
                    };
                    let at_winners = |v: &[u16]| -> Vec<u16> {
                        only(v).into_iter().zip(&tried).filter(|t| *t.1).map(|t| t.0).collect()
                    };
                    let what = format!("{width} x {height}, {x0}..{x1}, {min}..{max}, row {y}");
                    assert_eq!(only(&found.least), only(&expected.least), "least, {what}");
                    assert_eq!(at_winners(&found.index), at_winners(&expected.index), "{what}");
                    assert_eq!(at_winners(&found.before), at_winners(&expected.before), "{what}");
                    assert_eq!(at_winners(&found.after), at_winners(&expected.after), "{what}");
                    assert_eq!(
                        at_winners(&found.confirming),
                        at_winners(&expected.confirming),
                        "confirming, {what}"
                    );
                    let right = &found.right[..expected.right.len()];
                    let right: Vec<u16> = right.iter().map(|&v| v.min(OUT)).collect();
                    assert_eq!(right, expected.right, "right, {what}");
                }
            }
        }
    }
}
