//! One row of window sums of absolute differences, with the winners of both views.
//!
//! ```text
//! A(x, y, k) = |L(x, y) - R(x - min - k, y)|
//! V(x, y, k) = sum of A(x, y', k) over |y' - y| <= r inside the image
//! C(x, y, k) = sum of min(floor(V(x', y, k) / 4), 27) over |x' - x| <= r inside the image
//! ```
//!
//! In: the filtered rows that enter and leave the window. Out: per column the least sum of the left view, its
//! index and its neighbours, and of the right view the index that wins there ([`Winners`]).
//!
//! Columns lie in [`stripes`](super::stripes), so that neighbours are in vectors that follow each
//! other. For one disparity after the other:
//!
//! 1. `V`, the sums down the window's columns, is slid by one row. Differences are at most
//!    [`LARGEST_DIFFERENCE`], so `V` fits a byte: 6 operations for 64 columns.
//! 2. Of `V` a quarter counts, and not more than a ninth of what fits a byte: the noise of two images hides
//!    the rest, and a sum over the window is then one byte, so that all that follows is for 64 columns at once too.
//! 3. `C` is slid along the row: what enters the window is added, what leaves it taken away.
//! 4. The least sums of both views, their indices, and those beside the left view's: column `x` of the left
//!    is column `x - min - k` of the right, so both are a comparison with a row of minima. The right view
//!    compares each disparity's sum of another column, one vector further back for each: sums lie in memory so
//!    that these are next to each other.
//!
//! Nearly everything is an operation on whole vectors that begin where a cache line does, and no vector is
//! ever folded into one number. (With the disparities of a column side by side, as OpenCV has them,
//! `C` is slid along as well, but finding the least of a vector and its place costs more.) What is not needed
//! any more is not kept: sums of all disparities, to be looked up around the winners, would go through the
//! second-level cache. Eight disparities are compared together, so that minima are loaded and stored less often:
//! loads and stores take as much of the time as operations do.

mod memory;
mod order;

use std::ops::Range;

use self::memory::{BEFORE, Indices};
pub(crate) use self::memory::{Sad, Winners};
use self::order::{gather_right, tell};
use super::level::at_every_level;
use super::stripes::{LANES, Layout};

/// Half the window: it is `2 RADIUS + 1` pixels wide and high.
pub(crate) const RADIUS: usize = 4;
/// Pixels of the window's side.
const SIDE: u8 = 2 * RADIUS as u8 + 1;
/// No difference of the filtered images may be larger: sums down a column must fit a byte.
pub(crate) const LARGEST_DIFFERENCE: u8 = u8::MAX / SIDE;
/// A sum down a column counts in so many bits less.
const COARSER: u32 = 2;
/// And as so much at most: no sum over the window reaches [`OUT`]. Of columns with one more, as those get that
/// are not tried, it does, and still fits a byte.
const LARGEST_COLUMN: u8 = 27;
/// Sums from here on stand for "cannot be tried".
pub(crate) const OUT: u8 = SIDE * LARGEST_COLUMN + 1;
const _: () = assert!(SIDE * (LARGEST_COLUMN + 1) >= OUT);

/// So many disparities are compared together; at the end of the range some of them are not tried. Of sixteen the
/// compiler unrolls the loops no more, and takes the columns of a vector one by one.
pub(crate) const TOGETHER: usize = 8;
const HALF: usize = TOGETHER / 2;

/// So many indices differ in their lower byte; only where there are more, the higher one is looked at.
const BYTE: usize = 1 << u8::BITS;

/// Operations on bytes per pixel and disparity: two differences of two each that are added and taken
/// away; a quarter of two and a minimum; an addition and a subtraction along the row; for the left view
/// what lies outside left out, a minimum, a comparison and three choices, for the right one the same with one
/// choice.
pub(crate) const OPERATIONS: usize = 2 * (2 + 1) + (2 + 1) + 2 + (1 + 5) + (1 + 3);

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
        if layout.count() <= BYTE {
            match_all::<false>(sad, layout, entering, leaving);
        } else {
            match_all::<true>(sad, layout, entering, leaving);
        }
    }
}

// The innermost loops below go through one whole vector, of arguments that are known not to overlap: the
// compiler then makes vectors of them whatever the link-time optimisation. What has to be taken from an array of
// slices, or called as a closure inside them, it may see through too late. All disparities that are compared
// together are handled in one such loop: in one for each, what they share is loaded again for each.

/// The vector at a place.
#[inline(always)]
fn group(samples: &[u8], at: usize) -> &[u8; LANES] {
    samples[at..].first_chunk().expect("a whole group")
}

/// The vector at a place.
#[inline(always)]
fn group_mut(samples: &mut [u8], at: usize) -> &mut [u8; LANES] {
    samples[at..].first_chunk_mut().expect("a whole group")
}

/// So many vectors from a place on.
#[inline(always)]
fn groups(samples: &[u8], at: usize, count: usize) -> &[[u8; LANES]] {
    &samples[at..].as_chunks().0[..count]
}

/// So many vectors from a place on.
#[inline(always)]
fn groups_mut(samples: &mut [u8], at: usize, count: usize) -> &mut [[u8; LANES]] {
    &mut samples[at..].as_chunks_mut().0[..count]
}

/// A vector of each disparity that is compared together.
type Vectors = [[u8; LANES]; TOGETHER];

/// So many such vectors from a place on.
#[inline(always)]
fn side_by_side(samples: &[u8], at: usize, count: usize) -> &[Vectors] {
    &samples[at..].as_chunks().0.as_chunks().0[..count]
}

/// So many such vectors from a place on.
#[inline(always)]
fn side_by_side_mut(samples: &mut [u8], at: usize, count: usize) -> &mut [Vectors] {
    &mut samples[at..].as_chunks_mut().0.as_chunks_mut().0[..count]
}

/// Where the vectors of all disparities that are compared together stand of which one alone would begin at a
/// place.
#[inline(always)]
fn place_of_all(place: usize) -> usize {
    place / LANES * TOGETHER * LANES + place % LANES
}

/// `V` of indices `k ..`, one row further down, and what counts of it.
#[inline(always)]
fn slide_columns(
    sad: &mut Sad,
    layout: &Layout,
    k: usize,
    entering: RowPair<'_>,
    leaving: RowPair<'_>,
) {
    let count = layout.stripe();
    let columns = side_by_side_mut(&mut sad.columns, k * layout.left(), count);
    let counted = side_by_side_mut(&mut sad.counted, BEFORE, count);
    let left_in = groups(entering.left, 0, count);
    let left_out = groups(leaving.left, 0, count);
    let largest = groups(&sad.largest, 0, count);
    // What the last index is compared with comes first.
    let right = layout.shift(k + TOGETHER - 1) * LANES;
    let right_in = groups(entering.right, right, count + TOGETHER - 1);
    let right_out = groups(leaving.right, right, count + TOGETHER - 1);
    for j in 0..count {
        slide_vectors(
            &mut columns[j],
            &left_in[j],
            right_in[j..].first_chunk().expect("as many as disparities"),
            &left_out[j],
            right_out[j..].first_chunk().expect("as many as disparities"),
            &largest[j],
            &mut counted[j],
        );
    }
}

/// Of two samples, both at most [`LARGEST_DIFFERENCE`]: the signed difference fits a byte, which is one operation
/// less than for any two bytes.
#[inline(always)]
fn difference(left: u8, right: u8) -> u8 {
    (left as i8).wrapping_sub(right as i8).unsigned_abs()
}

/// `V` of a vector of each disparity: a difference enters, another one leaves.
#[inline(always)]
fn slide_vectors(
    sums: &mut Vectors,
    left_in: &[u8; LANES],
    right_in: &Vectors,
    left_out: &[u8; LANES],
    right_out: &Vectors,
    largest: &[u8; LANES],
    counted: &mut Vectors,
) {
    for l in 0..LANES {
        for n in 0..TOGETHER {
            let gain = difference(left_in[l], right_in[TOGETHER - 1 - n][l]);
            let loss = difference(left_out[l], right_out[TOGETHER - 1 - n][l]);
            let sum = sums[n][l].wrapping_add(gain).wrapping_sub(loss);
            sums[n][l] = sum;
            counted[n][l] = (sum >> COARSER).min(largest[l]);
        }
    }
}

/// Slides the window down by one row, and finds what wins there; of `MANY` disparities there are more than [`BYTE`].
#[inline(always)]
fn match_all<const MANY: bool>(
    sad: &mut Sad,
    layout: &Layout,
    entering: RowPair<'_>,
    leaving: RowPair<'_>,
) {
    // Indices stay: where a sum is the least so far, its own is written. The first group finds the sums before
    // it where its own will stand.
    for row in [&mut sad.least, &mut sad.right_least] {
        row.fill(OUT);
    }
    for sums in &mut side_by_side_mut(&mut sad.sums, 0, layout.stripe() + TOGETHER)[1..] {
        sums[TOGETHER - 1].fill(OUT);
    }
    for k in (0..layout.count()).step_by(TOGETHER) {
        slide_columns(sad, layout, k, entering, leaving);
        match_some::<MANY>(sad, layout, k);
    }
    gather_right::<MANY>(sad, layout);
    tell::<MANY>(sad, layout);
}

/// Sums `V` of indices `k ..` up along the row and compares.
#[inline(always)]
fn match_some<const MANY: bool>(sad: &mut Sad, layout: &Layout, k: usize) {
    for n in layout.tried().saturating_sub(k)..TOGETHER {
        // What makes up the number of disparities: no sum of these is to count.
        for vectors in side_by_side_mut(&mut sad.counted, BEFORE, layout.stripe()) {
            vectors[n].fill(LARGEST_COLUMN + 1);
        }
    }
    let (right, stripe) = (layout.shift(k + TOGETHER - 1), layout.stripe());
    let sums = side_by_side_mut(&mut sad.sums, 0, stripe + TOGETHER);
    begin_sums(&mut sad.counted, sums, layout);
    let counted = &sad.counted[..];
    let beyond = groups(&sad.beyond, 0, stripe);
    for (range, enters) in layout.windows_ends() {
        let (first, count) = (range.start, range.len());
        let enter = side_by_side(counted, BEFORE + place_of_all(enters), count);
        let leave = side_by_side(counted, place_of_all(first * LANES), count);
        let outside = groups(&sad.outside, (right + first) * LANES, count + TOGETHER);
        let beyond = &beyond[first..][..count];
        let least = groups_mut(&mut sad.least, first * LANES, count);
        let low = groups_mut(&mut sad.left.low, first * LANES, count);
        let high = groups_mut(&mut sad.left.high, first * LANES, count);
        let before = groups_mut(&mut sad.before, first * LANES, count);
        let after = groups_mut(&mut sad.after, first * LANES, count);
        let sums = &mut sums[first..][..count + TOGETHER];
        for j in 0..count {
            slide_along::<MANY>(
                sums[j..].first_chunk_mut().expect("one more than disparities"),
                &enter[j],
                &leave[j],
                outside[j..].first_chunk().expect("one more than disparities"),
                &beyond[j],
                &mut least[j],
                &mut low[j],
                &mut high[j],
                &mut before[j],
                &mut after[j],
                k,
            );
        }
    }
    // In the first group there is no sum but that before the first vector. In the next ones there are those of the
    // last indices alone, in the last ones those of the first.
    let sums = &sums[1..];
    let ends = sums.len() - HALF;
    let (least, found) = (&mut sad.right_least, &mut sad.right);
    compare_rights::<MANY, HALF, TOGETHER>(sums, 0..HALF, least, found, right, k);
    compare_rights::<MANY, 0, TOGETHER>(sums, HALF..ends, least, found, right, k);
    compare_rights::<MANY, 0, HALF>(sums, ends..sums.len(), least, found, right, k);
}

/// Compares some groups of sums with the right view's least ones so far, those of the indices `FROM` to `TO` of these
/// that are compared together; the first group is compared with right vector `right`.
#[inline(always)]
fn compare_rights<const MANY: bool, const FROM: usize, const TO: usize>(
    sums: &[Vectors],
    range: Range<usize>,
    least: &mut [u8],
    found: &mut Indices,
    right: usize,
    k: usize,
) {
    let (at, count) = ((right + range.start) * LANES, range.len());
    let sums = &sums[range];
    let least = groups_mut(least, at, count);
    let low = groups_mut(&mut found.low, at, count);
    let high = groups_mut(&mut found.high, at, count);
    for j in 0..count {
        compare_right::<MANY, FROM, TO>(&sums[j], &mut least[j], &mut low[j], &mut high[j], k);
    }
}

/// Readies the sums of the windows before those of the first vector, none of which is to count: what stands before
/// the vectors of what counts of the columns makes up for what the others lack of all bits, and leaves with the
/// next step.
#[inline(always)]
fn begin_sums(counted: &mut [u8], sums: &mut [Vectors], layout: &Layout) {
    let mut seen = [[0; LANES]; TOGETHER];
    for at in layout.first_vectors() {
        add(&side_by_side(counted, BEFORE + place_of_all(at), 1)[0], &mut seen);
    }
    let before = &mut side_by_side_mut(counted, 0, 1)[0];
    for n in 0..TOGETHER {
        sums[TOGETHER - 1 - n][n] = [u8::MAX; LANES];
        for l in 0..LANES {
            before[n][l] = u8::MAX - seen[n][l];
        }
    }
}

/// Adds vectors to sums.
#[inline(always)]
fn add(vectors: &Vectors, sums: &mut Vectors) {
    for n in 0..TOGETHER {
        for l in 0..LANES {
            sums[n][l] = sums[n][l].wrapping_add(vectors[n][l]);
        }
    }
}

/// The lower and the higher byte of an index.
#[inline(always)]
fn bytes(k: usize) -> [u8; 2] {
    (k as u16).to_le_bytes()
}

/// `C` of the windows one column further on, of indices `k ..`: what enters is added, what leaves taken away; of
/// columns that are not answered none is to count. The sums are compared with the least ones so far of the left
/// view, but for those whose match is outside.
///
/// What the right view compares is one vector further on at each index before the last, so there they are put. Where
/// those of the last index are put stand those of the index before `k`.
#[inline(always)]
fn slide_along<const MANY: bool>(
    sums: &mut [Vectors; TOGETHER + 1],
    enter: &Vectors,
    leave: &Vectors,
    outside: &[[u8; LANES]; TOGETHER + 1],
    beyond: &[u8; LANES],
    least: &mut [u8; LANES],
    low: &mut [u8; LANES],
    high: &mut [u8; LANES],
    before: &mut [u8; LANES],
    after: &mut [u8; LANES],
    k: usize,
) {
    for l in 0..LANES {
        // What the last index is compared with comes first.
        let mut cost_before = sums[1][TOGETHER - 1][l] | outside[TOGETHER][l];
        let (mut lowest, mut place) = (least[l], low[l]);
        let (mut below, mut above) = (before[l], after[l]);
        let [low_before, high_before] = bytes(k.wrapping_sub(1));
        let mut is_before = (place == low_before) & (!MANY | (high[l] == high_before));
        for n in 0..TOGETHER {
            let from = sums[TOGETHER - 1 - n][n][l];
            let sum = from.wrapping_add(enter[n][l]).wrapping_sub(leave[n][l]) | beyond[l];
            sums[TOGETHER - n][n][l] = sum;
            let cost = sum | outside[TOGETHER - 1 - n][l];
            above = if is_before { cost } else { above };
            let lower = lowest.min(cost);
            // Older processors have no comparison of bytes without a sign.
            let is_less = lower != lowest;
            below = if is_less { cost_before } else { below };
            place = if is_less { bytes(k + n)[0] } else { place };
            lowest = lower;
            (cost_before, is_before) = (cost, is_less);
        }
        // The higher byte is the same of all that are compared together.
        if MANY {
            high[l] = either(lowest != least[l], bytes(k)[1], high[l]);
        }
        (least[l], low[l]) = (lowest, place);
        (before[l], after[l]) = (below, above);
    }
}

/// Compares the sums of indices `k ..` with the least ones so far of the right view, of left columns that match the
/// same right ones.
#[inline(always)]
fn compare_right<const MANY: bool, const FROM: usize, const TO: usize>(
    sums: &Vectors,
    least: &mut [u8; LANES],
    low: &mut [u8; LANES],
    high: &mut [u8; LANES],
    k: usize,
) {
    for l in 0..LANES {
        let (mut lowest, mut place) = (least[l], low[l]);
        for n in FROM..TO {
            let cost = sums[n][l];
            let lower = lowest.min(cost);
            place = if lower != lowest { bytes(k + n)[0] } else { place };
            lowest = lower;
        }
        if MANY {
            high[l] = either(lowest != least[l], bytes(k)[1], high[l]);
        }
        (least[l], low[l]) = (lowest, place);
    }
}

/// One of two numbers that lie in memory, for which the compiler would make a jump of a condition.
#[inline(always)]
fn either(is_this: bool, this: u8, that: u8) -> u8 {
    that ^ (this ^ that) & u8::from(is_this).wrapping_neg()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::SearchSpace;
    use crate::kernels::border::repeat_border;
    use crate::kernels::level::Level;
    use crate::kernels::stripes::{spread_left, spread_right};
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
            for u in x.saturating_sub(RADIUS)..=(x + RADIUS).min(width - 1) {
                let match_column = u as i64 - i64::from(space.min) - k as i64;
                let match_column = match_column.clamp(0, width as i64 - 1) as usize;
                let rows = y.saturating_sub(RADIUS)..=(y + RADIUS).min(height - 1);
                let column: u16 = rows
                    .map(|v| u16::from(left.row(v)[u].abs_diff(right.row(v)[match_column])))
                    .sum();
                sum += (column / 4).min(27);
            }
            sum
        };
        let inside = |x: i64, k: i64| {
            x >= space.first as i64
                && x <= space.last as i64
                && (0..space.count as i64).contains(&k)
                && (0..width as i64).contains(&(x - i64::from(space.min) - k))
        };
        let out = u16::from(OUT);
        let cost = |x: i64, k: i64| if inside(x, k) { cost(x as usize, k as usize) } else { out };
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
        sad: &mut Sad,
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
            spread_left(level, &layout, &extended(left, y, first, layout.left()), &mut left_row);
            let extended = extended(right, y, least, layout.left() + layout.count() - 1);
            spread_right(level, &layout, &extended, &mut right_row);
            [left_row, right_row]
        };
        fn pair(rows: &[Vec<u8>; 2]) -> RowPair<'_> {
            RowPair { left: &rows[0], right: &rows[1] }
        }
        let nothing = rows(usize::MAX);
        sad.begin(&layout);
        for y in 0..RADIUS {
            slide_down(level, sad, &layout, pair(&rows(y)), pair(&nothing));
        }
        let mut all = Vec::new();
        for y in 0..height {
            let (entering, leaving) = (rows(y + RADIUS), rows(y.wrapping_sub(RADIUS + 1)));
            match_row(level, sad, &layout, pair(&entering), pair(&leaving));
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
            // More disparities than a byte tells apart; the copy is at index 255, 256 and 257.
            (400, 2, (0, 399), (-248, 30)),
            (400, 2, (0, 399), (-249, 30)),
            (400, 2, (20, 390), (-250, 30)),
            (700, 2, (0, 699), (0, 599)),
        ];
        // One memory for all: what a shape leaves behind is not to show in the next.
        let mut sad = Sad::default();
        for level in Level::available() {
            eprintln!("level {}", level.name());
            for (width, height, (x0, x1), (min, max)) in shapes {
                let left = Plane::from_fn(width, height, |x, y| noise(x, y, 1));
                let right = Plane::from_fn(width, height, |x, y| {
                    // Half noise, half a shifted copy; blank at the right, where sums are equal.
                    match x {
                        _ if (61..100).contains(&x) => 0,
                        _ if y % 2 == 0 => noise(x + 7, y, 1),
                        _ => noise(x, y, 2),
                    }
                });
                let bounds = BoundingBox::new(x0, 0, x1, 0).unwrap();
                let range = DisparityRange::new(min, max).unwrap();
                let space = SearchSpace::new(width, bounds, range);
                let found = winners_by_kernel(&mut sad, level, &space, &left, &right);
                let out = u16::from(OUT);
                for (y, found) in found.into_iter().enumerate() {
                    let expected = winners_by_definition(&space, &left, &right, y);
                    assert_eq!(found.len(), expected.len());
                    for (x, (found, expected)) in (x0..).zip(found.iter().zip(&expected)) {
                        let what = format!("{width} x {height}, {min}..{max}, {x} {y}");
                        // Sums from OUT on only say that nothing was tried; where none was, no more counts.
                        let [sums, of] =
                            [found, expected].map(|v| [v[1], v[2], v[3]].map(|v| v.min(out)));
                        assert_eq!(sums[0], of[0], "the least sum, {what}");
                        if of[0] < out {
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
