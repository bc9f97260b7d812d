//! A corner of the left image and where it stands in the right one, to a fraction of a pixel.
//!
//! 1. Of four windows of a cell that with the strongest corner is taken: the least eigenvalue of the
//!    sums of products of its gradients (Shi & Tomasi, *Good Features to Track*, 1994).
//! 2. It is looked for along its row by normalised cross-correlation, and in rows above and below
//!    where that finds nothing: beside it, or far away too ([`Reach`]).
//! 3. From the best place on it is tracked along and across its row (Lucas & Kanade 1981), in windows
//!    that are normalised too, so that cameras may differ in exposure and gain.

use std::ops::Range;

use raster::{DisparityRange, View};

use super::correlation::{
    ABOVE, BEFORE, FLAT_WINDOW, Pattern, Place, Scores, TALL, WIDE, correlate, largest,
};
use crate::kernels::aligned::Line;
use crate::kernels::level::at_every_level;
use crate::kernels::products::Products;
use crate::profile::Work;

/// A track stays nearer than this to where it began, in pixels.
const FARTHEST: f32 = 3.0;
/// Samples to each side of a window that it may move over.
const AROUND: usize = 3;
const _: () = assert!(FARTHEST <= AROUND as f32);
/// How far a window's middle stays away from the ends of the images.
pub(super) const MARGIN: usize = 13;
/// The weakest corner: the least eigenvalue per pixel, of central differences in grey levels.
const WEAKEST: f32 = 1.0;
/// The row up and down in which a corner is looked for where its own does not show it: a track goes farther than one.
const NEAR: usize = 2;
/// So many rows up and down are looked through far away: all of them, since of fine texture nothing is alike one row off.
const FAR: usize = 24;
/// Correlation at whole pixels that counts as found, and one that is enough not to look on.
const FOUND: f32 = 0.7;
const CLEAR: f32 = 0.9;
/// What the best place lacks of a correlation of 1, but at least [`LACKING`], must be less than this part
/// of what the next best one lacks, which lies more than [`APART`] columns away.
const UNIQUE: f32 = 0.7;
const LACKING: f32 = 0.01;
const APART: usize = 3;
/// ... or more than so many rows.
const ROWS_APART: usize = 4;
/// Correlation at the end of the track.
const TRACKED: f32 = 0.9;
const STEPS: usize = 8;
/// What smoothing leaves of the variance of noise that differs from pixel to pixel, in the difference of two
/// windows: 9/64 in one at whole pixels, and 64/81 of that, on the average, in one between them.
const NOISE_LEFT: f32 = 9.0 / 64.0 * (1.0 + 64.0 / 81.0);
/// A last step below this ends the track, one above this many pixels means that it was lost.
const STILL: f32 = 0.01;
const LOST: f32 = 0.1;

// To either side: the window, as far as it moves, one sample more to look between them, and one more
// to smooth.
const _: () =
    assert!(MARGIN >= WIDE - 1 - BEFORE + AROUND + 2 && MARGIN >= TALL - 1 - ABOVE + AROUND + 2);
const _: () = assert!(MARGIN > BEFORE + AROUND && MARGIN > ABOVE + AROUND);

/// How far from its own row a corner is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reach {
    /// In its row, and where that does not show it clearly [`NEAR`] it.
    Near,
    /// In all rows up to [`FAR`] away, which takes ten times as long and more.
    Far,
}

impl Reach {
    /// How far away the rows are, up and down.
    #[inline(always)]
    fn rows(self) -> impl Iterator<Item = usize> {
        let (last, step) = match self {
            Self::Near => (NEAR, NEAR),
            Self::Far => (FAR, 1),
        };
        (0..=last).step_by(step)
    }
}

type Lanes = Line<[f32; WIDE]>;
pub(super) type Window = Line<[[f32; WIDE]; TALL]>;

const NONE: Lanes = Line([0.0; WIDE]);
pub(super) const EMPTY: Window = Line([[0.0; WIDE]; TALL]);

/// The column in which a corner stands in the right image, its row in the left one, how many rows lower it
/// stands in the right one, and by how much it does not look alike: as if by noise of this standard
/// deviation, in grey levels of the left image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Correspondence {
    pub column: f32,
    pub row: f32,
    pub down: f64,
    pub noise: f32,
}

/// What it takes to look for a corner in a cell: the pixels of four windows and those around them, and
/// per pixel two differences, three products and three sums of 32 bits.
pub(super) fn looked() -> Work {
    Work::bytes(4 * (WIDE + 2) * (TALL + 2)) + Work::operations(4 * 8 * 4 * WIDE * TALL)
}

/// What it takes to find a corner at the least: along each row all columns of its windows are read, each
/// place takes a product and a sum of 32 bits per pixel.
pub(super) fn work(columns: usize, range: DisparityRange, reach: Reach) -> Work {
    let places = range.count().min(columns);
    let rows = if reach == Reach::Far { 2 * FAR + 1 } else { 1 };
    (Work::bytes(TALL * (places + WIDE)) + Work::operations(4 * 2 * WIDE * TALL) * places) * rows
}

at_every_level! {
    /// The corner of a cell of the left image, [`MARGIN`] inside it, and its match.
    pub(super) fn correspond[products](
        images: [View<'_, u8>; 2],
        cell: (Range<usize>, Range<usize>),
        searched: (DisparityRange, Reach),
        scores: &mut Scores,
    ) -> Option<Correspondence> {
        let [left, right] = images;
        let corner = corner(left, cell)?;
        let pattern = Pattern::of(left, corner)?;
        let start = find(products, &pattern, right, corner, searched, scores)?;
        let (along, down, noise) = track(left, corner, right, start)?;
        let column = start.x as f32 + along;
        let down = start.y as f32 + down - corner.y as f32;
        Some(Correspondence { column, row: corner.y as f32, down: f64::from(down), noise })
    }
}

/// The sum of lanes, always in the same order.
#[inline(always)]
fn sum(mut lanes: Lanes) -> f32 {
    let mut half = WIDE / 2;
    while half > 0 {
        for l in 0..half {
            lanes[l] += lanes[l + half];
        }
        half /= 2;
    }
    lanes[0]
}

/// A window with mean 0 and squares that add to 1, and what it was multiplied by; none of a flat one.
#[inline(always)]
pub(super) fn normalised(mut window: Window) -> Option<(Window, f32)> {
    const PIXELS: f32 = super::correlation::PIXELS as f32;
    let mut sums = NONE;
    for samples in window.iter() {
        for l in 0..WIDE {
            sums[l] += samples[l];
        }
    }
    let mean = sum(sums) / PIXELS;
    let mut squares = NONE;
    for samples in window.iter_mut() {
        for l in 0..WIDE {
            samples[l] -= mean;
            squares[l] += samples[l] * samples[l];
        }
    }
    let squares = sum(squares);
    if squares < FLAT_WINDOW as f32 / PIXELS {
        return None;
    }
    let scale = 1.0 / squares.sqrt();
    for samples in window.iter_mut() {
        for l in 0..WIDE {
            samples[l] *= scale;
        }
    }
    Some((window, scale))
}

/// The strongest corner of four places of a cell.
#[inline(always)]
fn corner(image: View<'_, u8>, (x, y): (Range<usize>, Range<usize>)) -> Option<Place> {
    let mut strongest = (WEAKEST, None);
    for j in [1, 3] {
        for i in [1, 3] {
            let place = Place { x: x.start + i * x.len() / 4, y: y.start + j * y.len() / 4 };
            let strength = strength(image, place);
            if strength > strongest.0 {
                strongest = (strength, Some(place));
            }
        }
    }
    strongest.1
}

#[inline(always)]
fn strength(image: View<'_, u8>, Place { x, y }: Place) -> f32 {
    let [mut xx, mut yy, mut xy] = [[0i32; WIDE]; 3];
    for v in y - ABOVE..y - ABOVE + TALL {
        let [above, row, below] = [v - 1, v, v + 1].map(|v| image.row(v));
        let first = x - BEFORE;
        let (above, below) = (&above[first..][..WIDE], &below[first..][..WIDE]);
        let (before, after) = (&row[first - 1..][..WIDE], &row[first + 1..][..WIDE]);
        for l in 0..WIDE {
            let along = i32::from(after[l]) - i32::from(before[l]);
            let down = i32::from(below[l]) - i32::from(above[l]);
            xx[l] += along * along;
            yy[l] += down * down;
            xy[l] += along * down;
        }
    }
    // Differences are those of pixels two apart.
    let mean = |sums: [i32; WIDE]| sums.iter().sum::<i32>() as f32 / (4 * WIDE * TALL) as f32;
    let [xx, yy, xy] = [xx, yy, xy].map(mean);
    0.5 * (xx + yy - ((xx - yy) * (xx - yy) + 4.0 * xy * xy).sqrt())
}

/// Where the window of a corner is found in the right image.
#[inline(always)]
fn find(
    products: impl Products,
    wanted: &Pattern,
    right: View<'_, u8>,
    corner: Place,
    (range, reach): (DisparityRange, Reach),
    scores: &mut Scores,
) -> Option<Place> {
    let last = right.columns() - 1 - MARGIN;
    let x = corner.x as i64;
    let first = (x - i64::from(range.max())).max(MARGIN as i64);
    let end = (x - i64::from(range.min())).min(last as i64) + 1;
    if first >= end {
        return None;
    }
    let (first, count) = (first as usize, (end - first) as usize);
    let inside = MARGIN..right.rows() - MARGIN;
    // The best place, and how good the next one of its row is.
    let mut best = (FOUND, None, 0.0);
    // How good the best place of each row is, from the farthest row above on.
    let mut tops = [0.0; 2 * FAR + 1];
    for apart in reach.rows() {
        let both = [FAR - apart, FAR + apart];
        for down in both.into_iter().skip(usize::from(apart == 0)) {
            let y = (corner.y + down).wrapping_sub(FAR);
            if !inside.contains(&y) {
                continue;
            }
            let scores = correlate(products, wanted, right, y, first, count, scores);
            let top = largest(scores);
            tops[down] = top;
            if top > best.0 {
                let place = scores.iter().position(|&score| score == top).unwrap_or(0);
                let others = [
                    &scores[..place.saturating_sub(APART)],
                    &scores[(place + APART + 1).min(count)..],
                ];
                let next = others.map(largest).into_iter().fold(0.0, f32::max);
                best = (top, Some(Place { x: first + place, y }), next);
            }
        }
        if reach == Reach::Near && best.0 >= CLEAR {
            break;
        }
    }
    let (top, place, next) = best;
    let place = place?;
    let row = place.y + FAR - corner.y;
    let far = tops.iter().enumerate().filter(|(other, _)| row.abs_diff(*other) > ROWS_APART);
    let next = far.fold(next, |next, (_, &top)| next.max(top));
    ((1.0 - top).max(LACKING) < UNIQUE * (1.0 - next)).then_some(place)
}

/// Rows and columns of a window that is smoothed, with room around it to move by [`AROUND`].
const RICH_WIDE: usize = 2 * WIDE;
const RICH_TALL: usize = TALL + 2 * AROUND + 1;
type Rich = Line<[[f32; RICH_WIDE]; RICH_TALL]>;

/// The surroundings of a place by weights 1 2 1 in both directions: place `(AROUND + j, AROUND + i)`
/// belongs to a window's row `j` and column `i`.
#[inline(always)]
fn smoothed(image: View<'_, u8>, Place { x, y }: Place) -> Rich {
    const USED: usize = WIDE + 2 * AROUND + 1;
    let mut rich = Line([[0.0; RICH_WIDE]; RICH_TALL]);
    let first = x - BEFORE - AROUND;
    // All of them before any is read: what was only just written is slow to be had from elsewhere.
    let mut sums = Line([[0.0; RICH_WIDE + WIDE]; RICH_TALL]);
    for (j, sums) in sums.iter_mut().enumerate() {
        let v = y + j - ABOVE - AROUND;
        let [above, row, below] = [v - 1, v, v + 1].map(|v| &image.row(v)[first - 1..][..USED + 2]);
        for i in 0..USED + 2 {
            sums[i] = f32::from(above[i]) + 2.0 * f32::from(row[i]) + f32::from(below[i]);
        }
    }
    for (out, sums) in rich.iter_mut().zip(&*sums) {
        for i in 0..RICH_WIDE {
            out[i] = (sums[i] + 2.0 * sums[i + 1] + sums[i + 2]) * (1.0 / 16.0);
        }
    }
    rich
}

/// The window between samples, moved by a fraction right and down.
#[inline(always)]
fn between(rich: &Rich, along: f32, down: f32) -> Window {
    let (whole_along, whole_down) = (along.floor(), down.floor());
    let (s, t) = (along - whole_along, down - whole_down);
    let i = (AROUND as f32 + whole_along) as usize;
    let j = (AROUND as f32 + whole_down) as usize;
    let mut window = EMPTY;
    for (row, out) in window.iter_mut().enumerate() {
        let [upper, lower] = [j + row, j + row + 1].map(|j| &rich[j]);
        let [a, b] = [i, i + 1].map(|i| &upper[i..][..WIDE]);
        let [c, d] = [i, i + 1].map(|i| &lower[i..][..WIDE]);
        for l in 0..WIDE {
            let (above, below) = (a[l] + s * (b[l] - a[l]), c[l] + s * (d[l] - c[l]));
            out[l] = above + t * (below - above);
        }
    }
    window
}

/// How far from `start` the window around `corner` is found, to the right and down, and the noise by which
/// they differ.
#[inline(always)]
fn track(
    left: View<'_, u8>,
    corner: Place,
    right: View<'_, u8>,
    start: Place,
) -> Option<(f32, f32, f32)> {
    let rich = smoothed(left, corner);
    let (wanted, scale) = normalised(between(&rich, 0.0, 0.0))?;
    let (mut along, mut down) = (EMPTY, EMPTY);
    for j in 0..TALL {
        let [above, row, below] = [AROUND + j - 1, AROUND + j, AROUND + j + 1].map(|j| &rich[j]);
        for l in 0..WIDE {
            let i = AROUND + l;
            along[j][l] = 0.5 * scale * (row[i + 1] - row[i - 1]);
            down[j][l] = 0.5 * scale * (below[i] - above[i]);
        }
    }
    let (along, down) = (seen(along, &wanted), seen(down, &wanted));
    let [xx, yy, xy] =
        [(&along, &along), (&down, &down), (&along, &down)].map(|(a, b)| products(a, b));
    let determinant = xx * yy - xy * xy;
    if determinant <= 1e-3 * xx * yy {
        return None;
    }
    let rich = smoothed(right, start);
    let (mut x, mut y) = (0.0f32, 0.0f32);
    let (mut last, mut alike) = (f32::INFINITY, 0.0);
    for _ in 0..STEPS {
        let (mut off, _) = normalised(between(&rich, x, y))?;
        alike = products(&off, &wanted);
        for j in 0..TALL {
            for l in 0..WIDE {
                off[j][l] -= wanted[j][l];
            }
        }
        let (off_along, off_down) = (products(&off, &along), products(&off, &down));
        let step_x = (yy * off_along - xy * off_down) / determinant;
        let step_y = (xx * off_down - xy * off_along) / determinant;
        (x, y) = (x - step_x, y - step_y);
        if !(x.abs() < FARTHEST && y.abs() < FARTHEST) {
            return None;
        }
        last = step_x.abs() + step_y.abs();
        if last < STILL {
            break;
        }
    }
    // Both have squares that add to 1.
    let difference = 2.0 * (1.0 - alike).max(0.0) / (scale * scale * (WIDE * TALL) as f32);
    (last < LOST && alike > TRACKED).then_some((x, y, (difference / NOISE_LEFT).sqrt()))
}

/// The sum of products of two windows.
#[inline(always)]
fn products(a: &Window, b: &Window) -> f32 {
    let mut sums = NONE;
    for j in 0..TALL {
        for l in 0..WIDE {
            sums[l] += a[j][l] * b[j][l];
        }
    }
    sum(sums)
}

/// What is left of a change of a window when the window is normalised again: nothing of its mean, nothing
/// of what is like the window itself.
#[inline(always)]
fn seen(mut change: Window, window: &Window) -> Window {
    let like = products(&change, window);
    let mean = products(&change, &Line([[1.0; WIDE]; TALL])) * (1.0 / (WIDE * TALL) as f32);
    for j in 0..TALL {
        for l in 0..WIDE {
            change[j][l] -= like * window[j][l] + mean;
        }
    }
    change
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::kernels::level::Level;
    use raster::Plane;

    const CELL: (Range<usize>, Range<usize>) = (40..70, 30..60);

    /// A pattern that is seen moved by so many columns and rows, and brighter.
    pub fn seen(along: f64, down: f64, gain: f64) -> Plane<u8> {
        Plane::from_fn(120, 90, |x, y| {
            let (x, y) = (x as f64 - along, y as f64 - down);
            let waves = (0.31 * x + 0.11 * y).sin()
                + (0.23 * y - 0.17 * x).sin()
                + (0.083 * x * x / 40.0 + 0.29 * y).cos();
            (gain * (110.0 + 30.0 * waves)).clamp(0.0, 255.0) as u8
        })
    }

    fn found(level: Level, images: &[Plane<u8>; 2]) -> Option<Correspondence> {
        let searched = (DisparityRange::new(-5, 25).unwrap(), Reach::Near);
        let views = images.each_ref().map(Plane::view);
        correspond(level, views, CELL, searched, &mut Scores::default())
    }

    #[test]
    fn a_corner_is_found_to_a_tenth_of_a_pixel_at_every_level_alike() {
        for (along, down, gain) in
            [(-7.0, 0.0, 1.0), (-11.4, 0.6, 0.8), (3.3, -1.7, 1.1), (-20.0, 2.8, 1.0)]
        {
            let images = [seen(0.0, 0.0, 1.0), seen(along, down, gain)];
            let first = found(Level::available()[0], &images).expect("it is there");
            assert!((first.down - down).abs() < 0.1, "{down}: {first:?}");
            // The places of the cell that are looked at.
            let columns = [47, 62].map(|x| f64::from(x) + along);
            let off = columns.map(|column| (f64::from(first.column) - column).abs());
            assert!(off[0].min(off[1]) < 0.1, "{along}: {first:?}");
            for level in Level::available() {
                eprintln!("level {}", level.name());
                assert_eq!(found(level, &images), Some(first));
            }
        }
    }

    #[test]
    fn what_is_flat_repeats_or_is_not_there_is_not_found() {
        let left = seen(0.0, 0.0, 1.0);
        let level = Level::detect();
        let flat = Plane::filled(120, 90, 100);
        assert_eq!(found(level, &[left.clone(), flat.clone()]), None);
        assert_eq!(found(level, &[flat.clone(), flat]), None);
        let stripes =
            Plane::from_fn(120, 90, |x, y| if (x / 4 + y / 4) % 2 == 0 { 50 } else { 90 });
        assert_eq!(found(level, &[stripes.clone(), stripes]), None);
        let mut chance = Chance(3);
        let noise = Plane::from_fn(120, 90, |_, _| chance.bits(8) as u8);
        assert_eq!(found(level, &[left, noise]), None);
        // An edge along the row can be anywhere.
        let edge = Plane::from_fn(120, 90, |_, y| if y < 45 { 50 } else { 90 });
        assert_eq!(found(level, &[edge.clone(), edge]), None);
    }
}
