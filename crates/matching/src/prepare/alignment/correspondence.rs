//! A corner of the left image and where it stands in the right one, to a fraction of a pixel.
//!
//! 1. Of four windows of a cell that with the strongest corner is taken: the least eigenvalue of the
//!    sums of products of its gradients (Shi & Tomasi, *Good Features to Track*, 1994).
//! 2. It is looked for along its row by normalised cross-correlation, and some rows above and below
//!    where that finds nothing.
//! 3. From the best place on it is tracked in both directions (Lucas & Kanade 1981), in windows that
//!    are normalised too, so that cameras may differ in exposure and gain.

use std::ops::Range;

use raster::{DisparityRange, View};

use super::model::VerticalDisparity;
use crate::kernels::level::at_every_level;

/// Columns and rows of a window; its middle has 7 columns before it and 5 rows above it.
const WIDE: usize = 16;
const TALL: usize = 11;
const BEFORE: usize = 7;
const ABOVE: usize = 5;
/// A track stays nearer than this to where it began, in pixels.
const FARTHEST: f32 = 3.0;
const AROUND: usize = 3;
/// How far a window's middle stays away from the ends of the images.
pub(super) const MARGIN: usize = 13;
/// The weakest corner: the least eigenvalue per pixel, of central differences in grey levels.
const WEAKEST: f32 = 1.0;
/// Rows at which a corner is looked for, one set after the other until it is found.
const ROWS: [&[i64]; 2] = [&[0], &[-2, 2]];
/// Correlation at whole pixels: what is found, and what is enough not to look on. What the best place
/// lacks of 1, at least this, must be less than this part of what the next best one does, which lies more
/// than so many columns away.
const FOUND: f32 = 0.7;
const CLEAR: f32 = 0.9;
const APART: usize = 3;
const UNIQUE: f32 = 0.7;
const LACKING: f32 = 0.01;
/// Correlation at the end of the track.
const TRACKED: f32 = 0.9;
const STEPS: usize = 8;
/// A last step below this ends the track, one above this many pixels means that it was lost.
const STILL: f32 = 0.01;
const LOST: f32 = 0.1;
/// Windows with less variance than this per pixel are flat.
const FLAT: f32 = 1.0;

// To either side: the window, as far as it moves, one sample more to look between them, and one more
// to smooth.
const _: () =
    assert!(MARGIN >= WIDE - 1 - BEFORE + AROUND + 2 && MARGIN >= TALL - 1 - ABOVE + AROUND + 2);
const _: () = assert!(MARGIN > BEFORE + AROUND && MARGIN > ABOVE + AROUND);

type Lanes = [f32; WIDE];
type Window = [Lanes; TALL];

/// Where a corner stands in the right image, and how much lower than in the left one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Correspondence {
    pub column: f32,
    pub row: f32,
    pub down: f64,
}

/// Scratch memory: how alike the places of a row are.
#[derive(Debug, Default)]
pub(super) struct Scores(Vec<f32>);

impl Scores {
    pub fn bytes(range: DisparityRange) -> usize {
        size_of::<f32>() * range.count().next_multiple_of(WIDE)
    }
}

/// A place of an image.
#[derive(Clone, Copy)]
struct Place {
    x: usize,
    y: usize,
}

at_every_level! {
    /// The corner of a cell of the left image, [`MARGIN`] inside it, and its match.
    pub(super) fn correspond(
        images: [View<'_, u8>; 2],
        cell: (Range<usize>, Range<usize>),
        range: DisparityRange,
        expected: Option<&VerticalDisparity>,
        scores: &mut Scores,
    ) -> Option<Correspondence> {
        let [left, right] = images;
        let corner = corner(left, cell)?;
        let window = normalised(window(left, corner))?;
        let expected = expected.map_or(0.0, |vertical| vertical.at(corner.x as f64, corner.y as f64));
        let row = corner.y as i64 + expected.round() as i64;
        let start = find(&window, right, (corner.x as i64, row), range, scores)?;
        let (along, down) = track(left, corner, right, start)?;
        let column = start.x as f32 + along;
        let row = start.y as f32 + down;
        Some(Correspondence { column, row, down: f64::from(row - corner.y as f32) })
    }
}

/// The samples of a window.
#[inline(always)]
fn window(image: View<'_, u8>, Place { x, y }: Place) -> Window {
    let mut window = [[0.0; WIDE]; TALL];
    for (j, samples) in window.iter_mut().enumerate() {
        let row = &image.row(y + j - ABOVE)[x - BEFORE..][..WIDE];
        for l in 0..WIDE {
            samples[l] = f32::from(row[l]);
        }
    }
    window
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

/// A window with mean 0 and squares that add to 1; none of a flat one.
#[inline(always)]
fn normalised(mut window: Window) -> Option<Window> {
    const PIXELS: f32 = (WIDE * TALL) as f32;
    let mut sums = [0.0; WIDE];
    for samples in &window {
        for l in 0..WIDE {
            sums[l] += samples[l];
        }
    }
    let mean = sum(sums) / PIXELS;
    let mut squares = [0.0; WIDE];
    for samples in &mut window {
        for l in 0..WIDE {
            samples[l] -= mean;
            squares[l] += samples[l] * samples[l];
        }
    }
    let squares = sum(squares);
    if squares < FLAT * PIXELS {
        return None;
    }
    let scale = 1.0 / squares.sqrt();
    for samples in &mut window {
        for l in 0..WIDE {
            samples[l] *= scale;
        }
    }
    Some(window)
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

/// Where a normalised window is found in the right image: `x` is its column in the left one, `row` the
/// first row to look at.
#[inline(always)]
fn find(
    wanted: &Window,
    right: View<'_, u8>,
    (x, row): (i64, i64),
    range: DisparityRange,
    scores: &mut Scores,
) -> Option<Place> {
    let last = right.columns() - 1 - MARGIN;
    let first = (x - i64::from(range.max())).max(MARGIN as i64);
    let end = (x - i64::from(range.min())).min(last as i64) + 1;
    if first >= end {
        return None;
    }
    let (first, count) = (first as usize, (end - first) as usize);
    let mut best = (FOUND, None);
    for rows in ROWS {
        for apart in rows {
            let y = row + apart;
            if y < MARGIN as i64 || y > (right.rows() - 1 - MARGIN) as i64 {
                continue;
            }
            let y = y as usize;
            let scores = correlate(wanted, right, y, first, count, scores);
            let mut top = (f32::NEG_INFINITY, 0);
            for (s, &score) in scores.iter().enumerate() {
                if score > top.0 {
                    top = (score, s);
                }
            }
            let mut next = 0.0;
            for (s, &score) in scores.iter().enumerate() {
                if s.abs_diff(top.1) > APART && score > next {
                    next = score;
                }
            }
            if top.0 > best.0 {
                let is_unique = (1.0 - top.0).max(LACKING) < UNIQUE * (1.0 - next);
                best = (top.0, is_unique.then_some(Place { x: first + top.1, y }));
            }
        }
        if best.0 >= CLEAR {
            break;
        }
    }
    best.1
}

/// The correlation of a normalised window with those of the right image whose middles are at row `y`
/// from column `first` on.
#[inline(always)]
fn correlate<'a>(
    wanted: &Window,
    right: View<'_, u8>,
    y: usize,
    first: usize,
    count: usize,
    scores: &'a mut Scores,
) -> &'a [f32] {
    const PIXELS: f32 = (WIDE * TALL) as f32;
    let scores = &mut scores.0;
    scores.resize(count.next_multiple_of(WIDE), 0.0);
    for (block, scores) in scores.chunks_exact_mut(WIDE).enumerate() {
        let start = first + block * WIDE - BEFORE;
        let mut products = [0.0; WIDE];
        // Of columns, then of windows.
        let (mut sums, mut squares) = ([0.0; 2 * WIDE], [0.0; 2 * WIDE]);
        for (j, wanted) in wanted.iter().enumerate() {
            let mut row = [0.0; 2 * WIDE];
            let samples = &right.row(y + j - ABOVE)[start..];
            // The last block may reach beyond the end of the image.
            for (to, from) in row.iter_mut().zip(samples) {
                *to = f32::from(*from);
            }
            for i in 0..2 * WIDE {
                sums[i] += row[i];
                squares[i] += row[i] * row[i];
            }
            for i in 0..WIDE {
                for l in 0..WIDE {
                    products[l] += wanted[i] * row[i + l];
                }
            }
        }
        let (mut sum, mut square) = ([0.0; WIDE], [0.0; WIDE]);
        for i in 0..WIDE {
            for l in 0..WIDE {
                sum[l] += sums[i + l];
                square[l] += squares[i + l];
            }
        }
        for l in 0..WIDE {
            let variance = square[l] - sum[l] * sum[l] * (1.0 / PIXELS);
            let score = products[l] / if variance > 0.0 { variance } else { 1.0 }.sqrt();
            scores[l] = if variance > FLAT * PIXELS { score } else { 0.0 };
        }
    }
    &scores[..count]
}

/// Rows and columns of a window that is smoothed, with room around it to move by [`AROUND`].
const RICH_WIDE: usize = 2 * WIDE;
const RICH_TALL: usize = TALL + 2 * AROUND + 1;
type Rich = [[f32; RICH_WIDE]; RICH_TALL];

/// The surroundings of a place by weights 1 2 1 in both directions: place `(AROUND + j, AROUND + i)`
/// belongs to a window's row `j` and column `i`.
#[inline(always)]
fn smoothed(image: View<'_, u8>, Place { x, y }: Place) -> Rich {
    const USED: usize = WIDE + 2 * AROUND + 1;
    let mut rich = [[0.0; RICH_WIDE]; RICH_TALL];
    let first = x - BEFORE - AROUND;
    for (j, out) in rich.iter_mut().enumerate() {
        let v = y + j - ABOVE - AROUND;
        let [above, row, below] = [v - 1, v, v + 1].map(|v| &image.row(v)[first - 1..][..USED + 2]);
        let mut sums = [0.0; RICH_WIDE + 2];
        for i in 0..USED + 2 {
            sums[i] = f32::from(above[i]) + 2.0 * f32::from(row[i]) + f32::from(below[i]);
        }
        for i in 0..USED {
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
    let mut window = [[0.0; WIDE]; TALL];
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

/// How far from `start` the window around `corner` is found, to the right and down.
#[inline(always)]
fn track(
    left: View<'_, u8>,
    corner: Place,
    right: View<'_, u8>,
    start: Place,
) -> Option<(f32, f32)> {
    let rich = smoothed(left, corner);
    let wanted = normalised(between(&rich, 0.0, 0.0))?;
    let (mut along, mut down) = ([[0.0; WIDE]; TALL], [[0.0; WIDE]; TALL]);
    let [mut xx, mut yy, mut xy] = [[0.0; WIDE]; 3];
    for j in 0..TALL {
        let [above, row, below] = [AROUND + j - 1, AROUND + j, AROUND + j + 1].map(|j| &rich[j]);
        for l in 0..WIDE {
            let i = AROUND + l;
            along[j][l] = 0.5 * (row[i + 1] - row[i - 1]);
            down[j][l] = 0.5 * (below[i] - above[i]);
            xx[l] += along[j][l] * along[j][l];
            yy[l] += down[j][l] * down[j][l];
            xy[l] += along[j][l] * down[j][l];
        }
    }
    let [xx, yy, xy] = [xx, yy, xy].map(sum);
    let determinant = xx * yy - xy * xy;
    if determinant <= 1e-3 * xx * yy {
        return None;
    }
    // Windows are normalised: gradients are those of a window whose squares add to this.
    let scale = spread(&rich);
    let rich = smoothed(right, start);
    let (mut x, mut y) = (0.0f32, 0.0f32);
    let (mut last, mut alike) = (f32::INFINITY, 0.0);
    for _ in 0..STEPS {
        let there = normalised(between(&rich, x, y))?;
        let [mut products, mut off_along, mut off_down] = [[0.0; WIDE]; 3];
        for j in 0..TALL {
            for l in 0..WIDE {
                let off = there[j][l] - wanted[j][l];
                products[l] += there[j][l] * wanted[j][l];
                off_along[l] += off * along[j][l];
                off_down[l] += off * down[j][l];
            }
        }
        alike = sum(products);
        let (off_along, off_down) = (sum(off_along) * scale, sum(off_down) * scale);
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
    (last < LOST && alike > TRACKED).then_some((x, y))
}

/// The root of the sum of squares of a window about its mean.
#[inline(always)]
fn spread(rich: &Rich) -> f32 {
    let (mut sums, mut squares) = ([0.0; WIDE], [0.0; WIDE]);
    for row in &rich[AROUND..AROUND + TALL] {
        for l in 0..WIDE {
            let sample = row[AROUND + l];
            sums[l] += sample;
            squares[l] += sample * sample;
        }
    }
    let mean = sum(sums) / (WIDE * TALL) as f32;
    (sum(squares) - mean * sum(sums)).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::kernels::level::Level;
    use raster::Plane;

    const CELL: (Range<usize>, Range<usize>) = (40..70, 30..60);

    /// A pattern that is seen moved by so many columns and rows, and brighter.
    fn seen(along: f64, down: f64, gain: f64) -> Plane<u8> {
        Plane::from_fn(120, 90, |x, y| {
            let (x, y) = (x as f64 - along, y as f64 - down);
            let waves = (0.31 * x + 0.11 * y).sin()
                + (0.23 * y - 0.17 * x).sin()
                + (0.083 * x * x / 40.0 + 0.29 * y).cos();
            (gain * (110.0 + 30.0 * waves)).clamp(0.0, 255.0) as u8
        })
    }

    fn found(level: Level, images: &[Plane<u8>; 2]) -> Option<Correspondence> {
        let range = DisparityRange::new(-5, 25).unwrap();
        let views = images.each_ref().map(Plane::view);
        correspond(level, views, CELL, range, None, &mut Scores::default())
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

    #[test]
    fn correlation_is_its_definition() {
        let images = [seen(0.0, 0.0, 1.0), seen(-6.0, 0.0, 1.0)];
        let place = Place { x: 60, y: 40 };
        let wanted = normalised(window(images[0].view(), place)).unwrap();
        let mut scores = Scores::default();
        let (first, count) = (MARGIN, 120 - 2 * MARGIN);
        let scores = correlate(&wanted, images[1].view(), 40, first, count, &mut scores).to_vec();
        for (s, score) in scores.iter().enumerate() {
            let there = Place { x: first + s, y: 40 };
            let there = normalised(window(images[1].view(), there)).unwrap();
            let products = there.iter().flatten().zip(wanted.iter().flatten());
            let expected: f32 = products.map(|(a, b)| a * b).sum();
            assert!((score - expected).abs() < 1e-3, "{s}: {score} {expected}");
        }
    }
}
