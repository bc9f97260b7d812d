//! One row of window sums of absolute differences, with the winners of both views.
//!
//! ```text
//! A(x, y, k) = |L(x, y) - R(x - min - k, y)|
//! C(x, y, k) = sum of A(x', y', k) over |x' - x| <= r, |y' - y| <= r inside the image
//! ```
//!
//! In: the filtered rows that enter and leave the window. Out, in stripes: per column
//! the least sum of the left view, its index and its neighbours, and per place of the right view the index
//! that wins there ([`Winners`]).
//!
//! Columns lie in [`stripes`](super::stripes), so that neighbours are in vectors that follow each
//! other. For one disparity after the other:
//!
//! 1. `V`, the sums down the window's columns, is slid by one row. Differences are at most
//!    [`LARGEST_DIFFERENCE`], so `V` fits a byte: 7 operations for 64 columns.
//! 2. `C` is slid along the row: what enters the window is added, what leaves it taken away.
//! 3. The least sums of both views, their indices, and those beside the left view's: column `x` of the left
//!    is column `x - min - k` of the right, so both are a comparison with a row of minima. The right view
//!    compares each disparity's sum of another column, none more than three vectors back: no row of sums is kept
//!    but that of the disparity beside the next ones.
//!
//! Everything is an operation on whole vectors that begin where a cache line does, and no vector is
//! ever folded into one number. (With the disparities of a column side by side, as OpenCV has them,
//! `C` is slid along as well, but finding the least of a vector and its place costs more.) What is not needed
//! any more is not kept: sums of all disparities, to be looked up around the winners, would go through the
//! second-level cache. Four disparities are compared together, so that minima are loaded and stored less often.

mod memory;

use self::memory::{BEFORE, BEYOND, UNTRIED};
pub(crate) use self::memory::{Sad, Winners};
use super::level::at_every_level;
use super::stripes::{LANES, Layout};

/// Half the window: it is `2 RADIUS + 1` pixels wide and high.
pub(crate) const RADIUS: usize = 4;
/// No difference of the filtered images may be larger: sums down a column must fit a byte.
pub(crate) const LARGEST_DIFFERENCE: u8 = u8::MAX / (2 * RADIUS as u8 + 1);
/// Sums from here on stand for "cannot be tried": no sum over the window comes near.
pub(crate) const OUT: u16 = 0x1000;

/// So many disparities are compared together; at the end of the range some of them are not tried.
pub(crate) const TOGETHER: usize = 4;

/// Operations on bytes per pixel and disparity: two differences of two each that are added and taken
/// away, and what lies outside left out; of 16 bits two halves of what enters and leaves, an addition, a
/// subtraction and a flip along the row; a minimum, a comparison and three choices for the left view, a
/// minimum, a comparison and a choice for the right one.
pub(crate) const OPERATIONS: usize = 2 * (2 + 1) + 1 + (2 + 3) * 2 + (5 + 3) * 2;

/// A filtered row of both images, in stripes. Vector `j` of `left` and vector `j + shift(k)` of `right` are
/// compared at index `k`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowPair<'a> {
    pub left: &'a [u8],
    pub right: &'a [u8],
}

at_every_level! {
    /// Slides the window down by one row.
    pub(crate) fn slide_down(
        sad: &mut Sad,
        layout: &Layout,
        entering: RowPair<'_>,
        leaving: RowPair<'_>,
    ) {
        for k in (0..layout.count()).step_by(TOGETHER) {
            slide_columns(sad, layout, k, entering, leaving);
        }
    }

    /// Slides the window down by one row, and finds what wins there.
    pub(crate) fn match_row(
        sad: &mut Sad,
        layout: &Layout,
        entering: RowPair<'_>,
        leaving: RowPair<'_>,
    ) {
        // Indices stay: where a sum is the least so far, its own is written. The first group finds the sums before
        // it where its own will stand.
        for row in [&mut sad.least, &mut sad.right_least, &mut sad.last] {
            row.fill(OUT);
        }
        for k in (0..layout.count()).step_by(TOGETHER) {
            match_some(sad, layout, k, entering, leaving);
        }
        gather_right(sad, layout);
    }
}

// The innermost loops below go through one whole vector, of arguments that are known not to overlap: the
// compiler then makes vectors of them whatever the link-time optimisation. What has to be unrolled, or taken
// from an array of slices, or called as a closure inside them, it may see through too late.

/// The vector at a place.
#[inline(always)]
fn group<T>(samples: &[T], at: usize) -> &[T; LANES] {
    samples[at..].first_chunk().expect("a whole group")
}

/// The vector at a place.
#[inline(always)]
fn group_mut<T>(samples: &mut [T], at: usize) -> &mut [T; LANES] {
    samples[at..].first_chunk_mut().expect("a whole group")
}

/// So many vectors from a place on.
#[inline(always)]
fn groups<T>(samples: &[T], at: usize, count: usize) -> &[[T; LANES]] {
    &samples[at..].as_chunks().0[..count]
}

/// So many vectors from a place on.
#[inline(always)]
fn groups_mut<T>(samples: &mut [T], at: usize, count: usize) -> &mut [[T; LANES]] {
    &mut samples[at..].as_chunks_mut().0[..count]
}

/// A vector of pairs of each disparity that is compared together.
type Pairs = [[[u8; 2]; LANES / 2]; TOGETHER];
/// A vector of sums of each of them.
type Sums = [[u16; LANES]; TOGETHER];
/// The same, of all but the last of them.
type SumsBeforeLast = [[u16; LANES]; TOGETHER - 1];

/// So many such vectors of pairs from a place on.
#[inline(always)]
fn pairs_side_by_side(samples: &[u8], at: usize, count: usize) -> &[Pairs] {
    &samples[at..].as_chunks().0.as_chunks().0.as_chunks().0[..count]
}

/// Where the vectors of all disparities that are compared together stand of which one alone would begin at a
/// byte.
#[inline(always)]
fn place_of_all(byte: usize) -> usize {
    byte / LANES * TOGETHER * LANES + byte % LANES
}

/// The lane with the even number, then that with the odd one.
#[inline(always)]
fn halves(pair: [u8; 2]) -> [u16; 2] {
    let both = u16::from_le_bytes(pair);
    [both & 0xFF, both >> 8]
}

/// `V` of indices `k ..`, one row further down.
#[inline(always)]
fn slide_columns(
    sad: &mut Sad,
    layout: &Layout,
    k: usize,
    entering: RowPair<'_>,
    leaving: RowPair<'_>,
) {
    let count = layout.stripe();
    let columns = &mut sad.columns[BEFORE + k * layout.left()..];
    let columns: &mut [[[u8; LANES]; TOGETHER]] = columns.as_chunks_mut().0.as_chunks_mut().0;
    let columns = &mut columns[..count];
    let left_in = groups(entering.left, 0, count);
    let left_out = groups(leaving.left, 0, count);
    let inside = groups(&sad.inside, 0, count);
    // What the last index is compared with comes first.
    let right = layout.shift(k + TOGETHER - 1) * LANES;
    let right_in = groups(entering.right, right, count + TOGETHER - 1);
    let right_out = groups(leaving.right, right, count + TOGETHER - 1);
    for j in 0..count {
        for n in 0..TOGETHER {
            let right = j + TOGETHER - 1 - n;
            let (gain, loss) = ([&left_in[j], &right_in[right]], [&left_out[j], &right_out[right]]);
            slide_vector(&mut columns[j][n], gain[0], gain[1], loss[0], loss[1], &inside[j]);
        }
    }
}

/// Of two samples, both at most [`LARGEST_DIFFERENCE`]: the signed difference fits a byte, which is one operation
/// less than for any two bytes.
#[inline(always)]
fn difference(left: u8, right: u8) -> u8 {
    (left as i8).wrapping_sub(right as i8).unsigned_abs()
}

/// `V` of a vector: a difference enters, another one leaves.
#[inline(always)]
fn slide_vector(
    sums: &mut [u8; LANES],
    left_in: &[u8; LANES],
    right_in: &[u8; LANES],
    left_out: &[u8; LANES],
    right_out: &[u8; LANES],
    inside: &[u8; LANES],
) {
    for i in 0..LANES {
        let gain = difference(left_in[i], right_in[i]);
        let loss = difference(left_out[i], right_out[i]);
        sums[i] = sums[i].wrapping_add(gain).wrapping_sub(loss) & inside[i];
    }
}

/// Slides the window of indices `k ..` down by one row, sums up along it and compares.
#[inline(always)]
fn match_some(
    sad: &mut Sad,
    layout: &Layout,
    k: usize,
    entering: RowPair<'_>,
    leaving: RowPair<'_>,
) {
    slide_columns(sad, layout, k, entering, leaving);
    let length = layout.left();
    // With the vectors before the first, and a margin.
    let columns = &sad.columns[BEFORE + k * length - TOGETHER * LANES..]
        [..TOGETHER * (length + LANES) + LANES];
    let right = layout.shift(k + TOGETHER - 1);
    let outside = groups(&sad.outside, right * LANES, TOGETHER).first_chunk().expect("as many");
    let tried = layout.tried().saturating_sub(k);
    let first_sums = first_sums(columns, layout, tried, outside);
    let [before_last @ .., of_last] = first_sums;
    // Of the last four vectors, the latest in front; where the next one will stand.
    let recent: &mut [[u16; LANES]] = sad.recent.as_chunks_mut().0;
    let recent: &mut [SumsBeforeLast; TOGETHER] =
        recent.as_chunks_mut().0.first_chunk_mut().expect("four");
    let [mut latest, mut second, mut third, mut next] = recent.each_mut();
    *latest = before_last;
    (second[0], second[1], third[0]) = ([OUT; LANES], [OUT; LANES], [OUT; LANES]);
    let last = groups_mut(&mut sad.last, 0, layout.stripe() + 1);
    last[0] = of_last;
    let rights = layout.stripe() + TOGETHER - 1;
    let right_least = groups_mut(&mut sad.right_least, right * LANES, rights);
    let right_index = groups_mut(&mut sad.right_index, right * LANES, rights);
    for (range, enters) in layout.windows_ends() {
        let (first, count) = (range.start, range.len());
        let enter = pairs_side_by_side(columns, place_of_all(LANES + enters), count);
        let leave = pairs_side_by_side(columns, place_of_all(first * LANES), count);
        let outside = groups(&sad.outside_flips, (right + first) * LANES, count + TOGETHER - 1);
        let beyond = groups(&sad.beyond_flips, first * LANES, count);
        let least = groups_mut(&mut sad.least, first * LANES, count);
        let index = groups_mut(&mut sad.index, first * LANES, count);
        let before = groups_mut(&mut sad.before, first * LANES, count);
        let after = groups_mut(&mut sad.after, first * LANES, count);
        let last = &mut last[first..][..count + 1];
        let right_least = &mut right_least[first..][..count];
        let right_index = &mut right_index[first..][..count];
        for j in 0..count {
            let [from_last, to_last] = last[j..].first_chunk_mut().expect("one before each");
            slide_along(
                latest,
                from_last,
                &enter[j],
                &leave[j],
                &beyond[j],
                outside[j..].first_chunk().expect("one more than disparities"),
                next,
                to_last,
                &mut least[j],
                &mut index[j],
                &mut before[j],
                &mut after[j],
                k,
            );
            compare_right(
                [&third[0], &second[1], &latest[2], to_last],
                &mut right_least[j],
                &mut right_index[j],
                k,
            );
            (latest, second, third, next) = (next, latest, second, third);
        }
    }
    // Beyond the last vector.
    let out = &[OUT; LANES];
    for (j, costs) in (layout.stripe()..).zip([
        [&third[0], &second[1], &latest[2], out],
        [&second[0], &latest[1], out, out],
        [&latest[0], out, out, out],
    ]) {
        compare_right(costs, &mut right_least[j], &mut right_index[j], k);
    }
}

/// The sums of the windows before those of the first vector, of columns with a vector before it. Whatever that
/// holds is in these sums, and leaves with the next step: until then none of them is to count. Only so many
/// disparities are `tried`.
#[inline(always)]
fn first_sums(columns: &[u8], layout: &Layout, tried: usize, outside: &Sums) -> Sums {
    let mut sums = [[0; LANES]; TOGETHER];
    for n in 0..TOGETHER {
        // What the last index is compared with comes first.
        let outside = &outside[TOGETHER - 1 - n];
        let untried = if n < tried { 0 } else { UNTRIED };
        for l in 0..LANES {
            sums[n][l] = BEYOND | outside[l] | untried;
        }
    }
    for at in layout.first_vectors() {
        let vectors = pairs_side_by_side(columns, place_of_all(at), 1);
        add_pairs(&vectors[0], &mut sums);
    }
    sums
}

/// Adds vectors to sums.
#[inline(always)]
fn add_pairs(vectors: &Pairs, sums: &mut Sums) {
    let half = LANES / 2;
    for n in 0..TOGETHER {
        for i in 0..half {
            let entering = halves(vectors[n][i]);
            sums[n][i] += entering[0];
            sums[n][half + i] += entering[1];
        }
    }
}

/// `C` of the windows one column further on, of indices `k ..`: what enters is added, what leaves taken away.
/// Where it begins or ends that a disparity cannot be tried, its mark flips. The sums are compared with the
/// least ones so far of the left view; where those of the last index are put stand those of the index before `k`.
#[inline(always)]
fn slide_along(
    from: &SumsBeforeLast,
    from_last: &[u16; LANES],
    enter: &Pairs,
    leave: &Pairs,
    beyond: &[u16; LANES],
    outside: &Sums,
    to: &mut SumsBeforeLast,
    to_last: &mut [u16; LANES],
    least: &mut [u16; LANES],
    index: &mut [u16; LANES],
    before: &mut [u16; LANES],
    after: &mut [u16; LANES],
    k: usize,
) {
    let half = LANES / 2;
    for i in 0..half {
        for odd in 0..2 {
            let l = odd * half + i;
            let mut cost_before = to_last[l];
            let (mut lowest, mut place) = (least[l], index[l]);
            let (mut below, mut above) = (before[l], after[l]);
            let mut is_before = place == (k as u16).wrapping_sub(1);
            for n in 0..TOGETHER {
                let (gain, loss) = (halves(enter[n][i])[odd], halves(leave[n][i])[odd]);
                let is_last = n == TOGETHER - 1;
                let from = if is_last { from_last[l] } else { from[n][l] };
                let cost = from.wrapping_add(gain).wrapping_sub(loss);
                // What the last index is compared with comes first.
                let cost = cost ^ beyond[l] ^ outside[TOGETHER - 1 - n][l];
                if is_last {
                    to_last[l] = cost;
                } else {
                    to[n][l] = cost;
                }
                let is_less = (cost as i16) < lowest as i16;
                above = if is_before { cost } else { above };
                below = if is_less { cost_before } else { below };
                place = if is_less { (k + n) as u16 } else { place };
                lowest = (lowest as i16).min(cost as i16) as u16;
                (cost_before, is_before) = (cost, is_less);
            }
            (least[l], index[l]) = (lowest, place);
            (before[l], after[l]) = (below, above);
        }
    }
}

/// Compares the sums of indices `k ..` with the least ones so far of the right view: what matches the same
/// right columns stands one vector further on at every index.
#[inline(always)]
fn compare_right(
    costs: [&[u16; LANES]; TOGETHER],
    least: &mut [u16; LANES],
    index: &mut [u16; LANES],
    k: usize,
) {
    for l in 0..LANES {
        let (mut lowest, mut place) = (least[l], index[l]);
        for n in 0..TOGETHER {
            let cost = costs[n][l];
            place = if (cost as i16) < lowest as i16 { (k + n) as u16 } else { place };
            lowest = (lowest as i16).min(cost as i16) as u16;
        }
        (least[l], index[l]) = (lowest, place);
    }
}

/// Right columns lie in several places, as many disparities as there are: gathers the winners of them all
/// in the last one, where the smaller indices are already.
#[inline(always)]
fn gather_right(sad: &mut Sad, layout: &Layout) {
    let length = layout.left();
    let Sad { right_least: least, right_index: index, .. } = sad;
    let half = LANES / 2;
    // The last lane has no next one.
    let mut nothing = [0; LANES];
    nothing[LANES - 1] = OUT;
    for at in (0..least.len() - length).step_by(LANES) {
        // The next lane: of even ones the odd one, of odd ones the even one after it.
        let (mut cost, mut place) = ([0; LANES], [0; LANES]);
        cost[..half].copy_from_slice(&least[at + half..][..half]);
        cost[half..].copy_from_slice(&least[at + 1..][..half]);
        place[..half].copy_from_slice(&index[at + half..][..half]);
        place[half..].copy_from_slice(&index[at + 1..][..half]);
        let (mut lowest, mut places) = (*group(least, at + length), *group(index, at + length));
        for l in 0..LANES {
            let (here, there) = (cost[l] | nothing[l], lowest[l]);
            // Written without a condition, of which the compiler would make a jump.
            let is_less = u16::from(here < there).wrapping_neg();
            places[l] ^= (places[l] ^ place[l]) & is_less;
            lowest[l] = here.min(there);
        }
        *group_mut(least, at + length) = lowest;
        *group_mut(index, at + length) = places;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::SearchSpace;
    use crate::kernels::border::repeat_border;
    use crate::kernels::level::Level;
    use raster::{BoundingBox, DisparityRange, Plane};

    /// The definition of [`Winners::columns`]: every window summed anew, every candidate looked at.
    fn winners_by_definition(
        space: &SearchSpace,
        left: &Plane<u8>,
        right: &Plane<u8>,
        y: usize,
    ) -> Vec<[u16; 5]> {
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
        let columns = (space.first as i64..=space.last as i64).map(|x| {
            let k = (0..space.count as i64).min_by_key(|&k| cost(x, k)).unwrap();
            // The same right column is as many left columns further on as disparities.
            let opposite = (0..space.count as i64).min_by_key(|&other| cost(x + other - k, other));
            let sums = [cost(x, k), cost(x, k - 1), cost(x, k + 1)];
            [k as u16, sums[0], sums[1], sums[2], opposite.unwrap() as u16]
        });
        columns.collect()
    }

    /// Winners of every row, by the kernel.
    fn winners_by_kernel(
        level: Level,
        space: &SearchSpace,
        left: &Plane<u8>,
        right: &Plane<u8>,
    ) -> Vec<Vec<[u16; 5]>> {
        let height = left.rows();
        let layout = Layout::new(space);
        let first = space.first as i64 - RADIUS as i64;
        let least = first - i64::from(space.min) - layout.shift(0) as i64;
        let extended = |image: &Plane<u8>, y: usize, from: i64, length: usize| {
            let mut row = vec![0; length];
            if y < height {
                repeat_border(image.row(y), from, &mut row);
            }
            row
        };
        let rows = |y: usize| {
            let [mut left_row, mut right_row] = [vec![0; layout.left()], vec![0; layout.right()]];
            layout.spread(&extended(left, y, first, layout.left()), &mut left_row);
            let extended = extended(right, y, least, layout.left() + layout.count() - 1);
            layout.spread_right(&extended, &mut right_row);
            [left_row, right_row]
        };
        fn pair(rows: &[Vec<u8>; 2]) -> RowPair<'_> {
            RowPair { left: &rows[0], right: &rows[1] }
        }
        let nothing = rows(usize::MAX);
        let mut sad = Sad::default();
        sad.begin(&layout);
        for y in 0..RADIUS {
            slide_down(level, &mut sad, &layout, pair(&rows(y)), pair(&nothing));
        }
        let mut all = Vec::new();
        for y in 0..height {
            let (entering, leaving) = (rows(y + RADIUS), rows(y.wrapping_sub(RADIUS + 1)));
            match_row(level, &mut sad, &layout, pair(&entering), pair(&leaving));
            all.push(sad.winners().columns(&layout));
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
            // What supports 56 columns is a whole vector, inside the image and beyond its end.
            (70, 10, (5, 60), (0, 20)),
            (61, 10, (5, 60), (0, 20)),
            // Stripes that are shorter than a window, as long, and longer.
            (330, 3, (0, 329), (0, 19)),
            (520, 3, (3, 515), (-7, 13)),
            (700, 2, (0, 699), (-3, 90)),
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
                    assert_eq!(found.len(), expected.len());
                    for (x, (found, expected)) in (x0..).zip(found.iter().zip(&expected)) {
                        let what = format!("{width} x {height}, {min}..{max}, {x} {y}");
                        // Sums from OUT on only say that nothing was tried; where none was, no more counts.
                        let [sums, of] =
                            [found, expected].map(|v| [v[1], v[2], v[3]].map(|v| v.min(OUT)));
                        assert_eq!(sums[0], of[0], "the least sum, {what}");
                        if of[0] < OUT {
                            assert_eq!(
                                (found[0], sums, found[4]),
                                (expected[0], of, expected[4]),
                                "{what}"
                            );
                        }
                    }
                }
            }
        }
    }
}
