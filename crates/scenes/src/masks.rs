//! Where matching is known to be hard. Discontinuities and textureless areas are those of
//! Scharstein & Szeliski, *A taxonomy and evaluation of dense two-frame stereo correspondence
//! algorithms*, IJCV 47 (2002), section 5.1, with the parameters of their evaluation. Thin things
//! are what is narrower than the usual windows of matchers.

use raster::Plane;

/// Neighbours whose disparities differ by more than this many pixels are a depth discontinuity.
pub const DISCONTINUITY_GAP: f32 = 2.0;
/// Side in pixels of the square window by which discontinuities are widened.
pub const DISCONTINUITY_WINDOW: usize = 9;
/// Mean squared horizontal gradient, in (grey levels of 255 per pixel) squared, below which a
/// window has no texture.
pub const TEXTURELESS_THRESHOLD: f32 = 4.0;
/// Side in pixels of the square window over which gradients are averaged.
pub const TEXTURELESS_WINDOW: usize = 3;
/// A thing up to this many pixels wide (or high) before something farther is thin.
pub const THIN_WIDTH: usize = 6;

/// Pixels within a [`DISCONTINUITY_WINDOW`] of a pixel whose disparity differs from one of its
/// four neighbours' by more than [`DISCONTINUITY_GAP`].
pub(crate) fn discontinuity(truth: &Plane<f32>) -> Plane<bool> {
    let (columns, rows) = truth.size();
    let steps = Plane::from_fn(columns, rows, |x, y| {
        let here = truth.row(y)[x];
        let differs = |x: usize, y: usize| (truth.row(y)[x] - here).abs() > DISCONTINUITY_GAP;
        x > 0 && differs(x - 1, y)
            || x + 1 < columns && differs(x + 1, y)
            || y > 0 && differs(x, y - 1)
            || y + 1 < rows && differs(x, y + 1)
    });
    let counts = window_sums(&steps.map(|&s| u32::from(s) as f32), DISCONTINUITY_WINDOW / 2);
    counts.map(|&(sum, _)| sum > 0.0)
}

/// Pixels whose squared horizontal gradient, averaged over a [`TEXTURELESS_WINDOW`], is below
/// [`TEXTURELESS_THRESHOLD`]. `grey` is on the scale 0 to 255; the gradient at `x` is
/// `grey(x + 1) - grey(x)`, and 0 in the last column.
pub(crate) fn textureless(grey: &Plane<f32>) -> Plane<bool> {
    let squares = Plane::from_fn(grey.columns(), grey.rows(), |x, y| {
        let row = grey.row(y);
        let step = row.get(x + 1).map_or(0.0, |next| next - row[x]);
        step * step
    });
    window_sums(&squares, TEXTURELESS_WINDOW / 2)
        .map(|&(sum, count)| sum < TEXTURELESS_THRESHOLD * count as f32)
}

/// Pixels of things at most [`THIN_WIDTH`] pixels wide or high, with something farther by more than
/// [`DISCONTINUITY_GAP`] on both sides in their row, or in their column.
pub(crate) fn thin(truth: &Plane<f32>) -> Plane<bool> {
    let (columns, rows) = truth.size();
    Plane::from_fn(columns, rows, |x, y| {
        let here = truth.row(y)[x];
        let is_farther = |x: usize, y: usize| here - truth.row(y)[x] > DISCONTINUITY_GAP;
        // Pixels to the first farther one; with the pixel itself counted once on each side, both
        // together are one more than the width.
        let fits = |before: Option<usize>, after: Option<usize>| {
            before.zip(after).is_some_and(|(before, after)| before + after <= THIN_WIDTH + 1)
        };
        let reach = 1..=THIN_WIDTH;
        let left = reach.clone().find(|&n| x >= n && is_farther(x - n, y));
        let right = reach.clone().find(|&n| x + n < columns && is_farther(x + n, y));
        let above = reach.clone().find(|&n| y >= n && is_farther(x, y - n));
        let below = reach.clone().find(|&n| y + n < rows && is_farther(x, y + n));
        fits(left, right) || fits(above, below)
    })
}

/// Sum and number of the samples at most `reach` columns and rows away; windows are cut at the
/// border.
fn window_sums(plane: &Plane<f32>, reach: usize) -> Plane<(f32, usize)> {
    let (columns, rows) = plane.size();
    let along = |at: usize, length: usize| at.saturating_sub(reach)..(at + reach + 1).min(length);
    let sums =
        Plane::from_fn(columns, rows, |x, y| plane.row(y)[along(x, columns)].iter().sum::<f32>());
    Plane::from_fn(columns, rows, |x, y| {
        let sum = along(y, rows).map(|y| sums.row(y)[x]).sum();
        (sum, along(x, columns).len() * along(y, rows).len())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_widened_to_nine_columns() {
        // Disparity 1 up to column 9, 4 from column 10: both columns 9 and 10 see the step.
        let truth = Plane::from_fn(20, 3, |x, _| if x < 10 { 1.0 } else { 4.0 });
        let mask = discontinuity(&truth);
        for y in 0..3 {
            for x in 0..20 {
                assert_eq!(mask.row(y)[x], (5..=14).contains(&x), "{x} {y}");
            }
        }
        // A gap of exactly 2 is none.
        let truth = Plane::from_fn(20, 3, |x, _| if x < 10 { 1.0 } else { 3.0 });
        assert!(discontinuity(&truth).samples().iter().all(|&d| !d));
    }

    #[test]
    fn six_pixels_are_thin_and_seven_are_not() {
        for (width, expected) in [(1, true), (6, true), (7, false)] {
            let near = 10..10 + width;
            let row = Plane::from_fn(30, 1, |x, _| if near.contains(&x) { 9.0 } else { 3.0 });
            let column = Plane::from_fn(1, 30, |_, y| row.row(0)[y]);
            for mask in [thin(&row), thin(&column)] {
                let set: Vec<usize> = (0..30).filter(|&i| mask.samples()[i]).collect();
                let all: Vec<usize> = near.clone().filter(|_| expected).collect();
                assert_eq!(set, all, "{width}");
            }
        }
        // What reaches the border may go on beyond it.
        let cut = Plane::from_fn(30, 1, |x, _| if x < 3 { 9.0 } else { 3.0 });
        assert!(thin(&cut).samples().iter().all(|&set| !set));
    }

    #[test]
    fn a_ramp_of_two_levels_per_pixel_is_texture() {
        for (slope, blank) in [(1.9, true), (2.1, false)] {
            let grey = Plane::from_fn(9, 9, |x, _| slope * x as f32);
            // Away from the last column, whose gradient counts as 0.
            assert_eq!(textureless(&grey).row(4)[4], blank, "{slope}");
        }
        assert!(textureless(&Plane::filled(1, 1, 9.0)).samples()[0]);
    }
}
