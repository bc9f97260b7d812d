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
//! The row is done in tiles of columns that stay in the first-level cache. In each, four loops
//! follow each other, with the disparities of one column side by side in memory:
//!
//! 1. `V`, the sums down the window's columns, is slid by one row. Differences are at most
//!    [`LARGEST_DIFFERENCE`], so `V` fits a byte: 8 operations for 64 pixel-disparities.
//! 2. `C` is slid by one column: one column of `V` enters, one leaves.
//! 3. The right view's least sum is `min_k C(x' + min + k, k)`, along the diagonal. Eight columns
//!    are folded together before they meet the row's minima, whose places in memory shift by one
//!    from column to column: done one by one, each load would wait for the store before it.
//! 4. The left view's winner: the least sum first, then the first place where it stands.

use std::ops::Range;

use super::level::at_every_level;
use crate::cost::SearchSpace;

/// Half the window: it is `2 RADIUS + 1` pixels wide and high.
pub(crate) const RADIUS: usize = 4;
/// No difference of the filtered images may be larger: sums down a column must fit a byte.
pub(crate) const LARGEST_DIFFERENCE: u8 = u8::MAX / (2 * RADIUS as u8 + 1);
/// Sums from here on stand for "cannot be tried": no sum over the window comes near.
pub(crate) const OUT: u16 = 0x8000;

/// Disparities are handled in groups of this many.
const GROUP: usize = 32;
/// Columns of a tile.
const TILE: usize = 32;
/// Columns that are folded before they meet the right view's minima.
const FOLD: usize = 8;
/// Room between the costs of two columns, so that a fold may look past both ends of a column.
const PAD: usize = FOLD;
/// Costs of the tile before that are still needed: the last column's winner looks one column on.
const CARRIED: usize = 2;

/// A filtered row of both images: the left columns that support the answered ones, and the right
/// row as [`reverse_row`](crate::cost::absolute_difference::reverse_row) writes it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowPair<'a> {
    pub left: &'a [u8],
    pub reversed: &'a [u8],
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
    /// The least sum of right column `last - min - i` at place `i`.
    pub right: Vec<u16>,
}

/// The memory of the kernel: sums of a band of rows.
#[derive(Debug, Default)]
pub(crate) struct Sad {
    /// `V`: per supporting column all disparities.
    columns: Vec<u8>,
    /// `C` of a tile: per column all disparities and `PAD` times [`OUT`].
    costs: Vec<u16>,
    /// A column of `V` outside the image.
    nothing: Vec<u8>,
    /// A column of `C` over an empty window: [`OUT`] where no disparity is searched.
    empty: Vec<u16>,
    /// A column of `C` of which a part can be tried.
    part: Vec<u16>,
    pub winners: Winners,
}

fn refill<T: Clone>(buffer: &mut Vec<T>, length: usize, value: T) {
    buffer.clear();
    buffer.resize(length, value);
}

impl Sad {
    /// Begins a band of rows with an empty window.
    pub fn begin(&mut self, space: &SearchSpace, supporting: usize) {
        let lanes = space.lanes;
        assert!(lanes > 0 && lanes.is_multiple_of(GROUP), "{lanes} lanes are not whole groups");
        refill(&mut self.columns, supporting * lanes, 0);
        refill(&mut self.costs, PAD + (CARRIED + TILE + 1) * (lanes + PAD), OUT);
        refill(&mut self.nothing, lanes, 0);
        refill(&mut self.empty, lanes, OUT);
        self.empty[..space.count].fill(0);
        refill(&mut self.part, lanes, OUT);
        let winners = &mut self.winners;
        for buffer in [
            &mut winners.index,
            &mut winners.least,
            &mut winners.before,
            &mut winners.after,
            &mut winners.confirming,
        ] {
            refill(buffer, space.columns(), 0);
        }
        refill(&mut winners.right, space.columns() + lanes + PAD, OUT);
    }
}

at_every_level! {
    /// Slides the window down by one row.
    pub(crate) fn slide_down(sad: &mut Sad, lanes: usize, entering: RowPair<'_>, leaving: RowPair<'_>) {
        let supporting = entering.left.len();
        slide_columns(&mut sad.columns, 0..supporting, lanes, entering, leaving);
    }

    /// Slides the window down by one row, and finds what wins there. `margin` supporting columns
    /// stand before the first answered one.
    pub(crate) fn match_row(
        sad: &mut Sad,
        space: &SearchSpace,
        margin: usize,
        entering: RowPair<'_>,
        leaving: RowPair<'_>,
    ) {
        let Sad { columns, costs, nothing, empty, part, winners } = sad;
        let nothing: &[u8] = nothing;
        let (lanes, total, supporting) = (space.lanes, space.columns(), entering.left.len());
        let stride = lanes + PAD;
        let column = |c: usize| PAD + c * stride..PAD + c * stride + lanes;

        winners.right.fill(OUT);
        let mut slid = supporting.min(margin + RADIUS);
        slide_columns(columns, 0..slid, lanes, entering, leaving);
        // The window around the column before the first one: from there it slides.
        let before = &mut costs[column(CARRIED - 1)];
        before.copy_from_slice(empty);
        for c in 0..slid {
            slide_window(before, &columns[c * lanes..][..lanes], nothing);
        }

        let mut done = 0;
        while done < total {
            let size = TILE.min(total - done);
            let upto = supporting.min(margin + done + size + RADIUS);
            slide_columns(columns, slid..upto, lanes, entering, leaving);
            slid = upto;
            for i in 0..size {
                let (front, back) = costs.split_at_mut(PAD + (CARRIED + i) * stride);
                let sums = &mut back[..lanes];
                sums.copy_from_slice(&front[PAD + (CARRIED + i - 1) * stride..][..lanes]);
                let centre = margin + done + i;
                let supply = |c: usize| &columns[c * lanes..][..lanes];
                let entering =
                    if centre + RADIUS < supporting { supply(centre + RADIUS) } else { nothing };
                let leaving = if centre > RADIUS { supply(centre - RADIUS - 1) } else { nothing };
                slide_window(sums, entering, leaving);
            }
            let folds = size / FOLD;
            for fold in 0..folds {
                let first = CARRIED + fold * FOLD;
                let place = total - (done + (fold + 1) * FOLD);
                let minima = &mut winners.right[place..][..stride];
                fold_into_right_view(&costs[first * stride..], stride, minima);
            }
            for i in folds * FOLD..size {
                let minima = &mut winners.right[total - 1 - (done + i)..][..lanes];
                lessen(minima, &costs[column(CARRIED + i)]);
            }
            // The winner of a column looks at both its neighbours: it is found one column late.
            for i in 0..size {
                if done + i > 0 {
                    let at = CARRIED + i - 1;
                    find_winner(costs, at, space, done + i - 1, part, winners);
                }
            }
            done += size;
            if done < total {
                costs.copy_within(size * stride..PAD + (size + CARRIED) * stride, 0);
            } else {
                costs[column(CARRIED + size)].fill(OUT);
                find_winner(costs, CARRIED + size - 1, space, total - 1, part, winners);
            }
        }
    }
}

/// `V` of supporting columns `range`, one row further down.
#[inline(always)]
fn slide_columns(
    columns: &mut [u8],
    range: Range<usize>,
    lanes: usize,
    entering: RowPair<'_>,
    leaving: RowPair<'_>,
) {
    let last = entering.left.len() - 1;
    let columns = &mut columns[range.start * lanes..range.end * lanes];
    for (c, column) in range.zip(columns.chunks_exact_mut(lanes)) {
        let (l_in, l_out) = (entering.left[c], leaving.left[c]);
        let r_in = &entering.reversed[last - c..][..lanes];
        let r_out = &leaving.reversed[last - c..][..lanes];
        let groups = column.as_chunks_mut::<GROUP>().0.iter_mut();
        let right = r_in.as_chunks::<GROUP>().0.iter().zip(r_out.as_chunks::<GROUP>().0);
        for (sums, (r_in, r_out)) in groups.zip(right) {
            for i in 0..GROUP {
                let (gain, loss) = (l_in.abs_diff(r_in[i]), l_out.abs_diff(r_out[i]));
                sums[i] = sums[i].wrapping_add(gain).wrapping_sub(loss);
            }
        }
    }
}

/// `C` one column further: one column of `V` enters the window, one leaves it.
#[inline(always)]
fn slide_window(sums: &mut [u16], entering: &[u8], leaving: &[u8]) {
    let entering = entering.as_chunks::<GROUP>().0;
    let leaving = leaving.as_chunks::<GROUP>().0;
    let groups = sums.as_chunks_mut::<GROUP>().0.iter_mut();
    for (sums, (gain, loss)) in groups.zip(entering.iter().zip(leaving)) {
        for i in 0..GROUP {
            let gained = sums[i].wrapping_add(u16::from(gain[i]));
            sums[i] = gained.wrapping_sub(u16::from(loss[i]));
        }
    }
}

/// Folds `FOLD` columns of costs along the diagonal, then into the right view's minima. Before
/// every column, and after the last, stand `PAD` places that cannot win.
#[inline(always)]
fn fold_into_right_view(costs: &[u16], stride: usize, minima: &mut [u16]) {
    // Place `i` belongs to index `i - (FOLD - 1) + j` of column `j`.
    let diagonal: [&[u16]; FOLD] =
        std::array::from_fn(|j| &costs[PAD + j * stride + j - (FOLD - 1)..][..stride]);
    let (groups, rest) = minima.as_chunks_mut::<GROUP>();
    for (g, minima) in groups.iter_mut().enumerate() {
        for costs in diagonal {
            let costs: &[u16; GROUP] = costs.as_chunks().0[g..].first().expect("as long");
            for i in 0..GROUP {
                minima[i] = minima[i].min(costs[i]);
            }
        }
    }
    let done = groups.len() * GROUP;
    for costs in diagonal {
        lessen(rest, &costs[done..]);
    }
}

#[inline(always)]
fn lessen(minima: &mut [u16], costs: &[u16]) {
    for (least, &cost) in minima.iter_mut().zip(costs) {
        *least = cost.min(*least);
    }
}

/// Finds what wins at answered column `x`, whose costs stand at place `at` of the tile.
#[inline(always)]
fn find_winner(
    costs: &[u16],
    at: usize,
    space: &SearchSpace,
    x: usize,
    part: &mut [u16],
    winners: &mut Winners,
) {
    let stride = space.lanes + PAD;
    let here = PAD + at * stride;
    let all = &costs[here..][..space.lanes];
    let candidates = space.candidates(space.first + x);
    let tried = if candidates == (0..space.count) {
        all
    } else {
        part.fill(OUT);
        part[candidates.clone()].copy_from_slice(&all[candidates]);
        part
    };
    let (index, least) = least_of(tried);
    let k = usize::from(index);
    winners.index[x] = index;
    winners.least[x] = least;
    winners.before[x] = if k > 0 { tried[k - 1] } else { OUT };
    winners.after[x] = if k + 1 < tried.len() { tried[k + 1] } else { OUT };
    let behind = if x > 0 { costs[here + k - 1 - stride] } else { OUT };
    winners.confirming[x] = least.min(behind).min(costs[here + k + 1 + stride]);
}

/// The first index of the least cost, and that cost.
#[inline(always)]
fn least_of(costs: &[u16]) -> (u16, u16) {
    let groups = costs.as_chunks::<GROUP>().0;
    let mut least = [u16::MAX; GROUP];
    for group in groups {
        for i in 0..GROUP {
            least[i] = least[i].min(group[i]);
        }
    }
    let least = least.into_iter().fold(u16::MAX, u16::min);
    let mut first = [u16::MAX; GROUP];
    let mut base = 0;
    for group in groups {
        for i in 0..GROUP {
            let index = if group[i] == least { base + i as u16 } else { u16::MAX };
            first[i] = first[i].min(index);
        }
        base += GROUP as u16;
    }
    (first.into_iter().fold(u16::MAX, u16::min), least)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::absolute_difference::reverse_row;
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
        for i in 0..space.columns() + space.count - 1 {
            let right = space.last as i64 - i64::from(space.min) - i as i64;
            let costs = (0..space.count as i64).map(|k| cost(right + i64::from(space.min) + k, k));
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
        let (width, height) = left.size();
        let c0 = space.first.saturating_sub(RADIUS);
        let c1 = (space.last + RADIUS).min(width - 1);
        let reversed: Vec<Vec<u8>> = (0..height)
            .map(|y| {
                let mut row = vec![0; c1 - c0 + 1 + space.lanes];
                reverse_row(right.row(y), c1 as i64 - i64::from(space.min), &mut row);
                row
            })
            .collect();
        let nothing = vec![0; c1 - c0 + 1 + space.lanes];
        let row = |y: usize| {
            if y < height {
                RowPair { left: &left.row(y)[c0..=c1], reversed: &reversed[y] }
            } else {
                RowPair { left: &nothing[..=c1 - c0], reversed: &nothing }
            }
        };
        let mut sad = Sad::default();
        sad.begin(space, c1 - c0 + 1);
        for y in 0..RADIUS {
            slide_down(level, &mut sad, space.lanes, row(y), row(usize::MAX));
        }
        let mut all = Vec::new();
        for y in 0..height {
            let (entering, leaving) = (row(y + RADIUS), row(y.wrapping_sub(RADIUS + 1)));
            match_row(level, &mut sad, space, space.first - c0, entering, leaving);
            all.push(sad.winners.clone());
        }
        all
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
                    let tried: Vec<bool> = expected.least.iter().map(|&v| v < OUT).collect();
                    let only = |v: &[u16]| -> Vec<u16> {
                        // Above OUT, values only say that nothing was tried.
                        v.iter().map(|&v| v.min(OUT)).collect()
                    };
                    let at_winners = |v: &[u16]| -> Vec<u16> {
                        only(v).into_iter().zip(&tried).filter(|t| *t.1).map(|t| t.0).collect()
                    };
                    let what = format!("{width} x {height}, {x0}..{x1}, {min}..{max}, row {y}");
                    assert_eq!(only(&found.least), expected.least, "least, {what}");
                    assert_eq!(at_winners(&found.index), at_winners(&expected.index), "{what}");
                    assert_eq!(at_winners(&found.before), at_winners(&expected.before), "{what}");
                    assert_eq!(at_winners(&found.after), at_winners(&expected.after), "{what}");
                    assert_eq!(
                        at_winners(&found.confirming),
                        at_winners(&expected.confirming),
                        "confirming, {what}"
                    );
                    for (i, &least) in expected.right.iter().enumerate() {
                        // Columns outside the right image are of no interest.
                        let column = space.last as i64 - i64::from(space.min) - i as i64;
                        if (0..width as i64).contains(&column) {
                            assert_eq!(found.right[i].min(OUT), least, "right {column}, {what}");
                        }
                    }
                }
            }
        }
    }
}
