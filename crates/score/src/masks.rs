//! Masks of the pixels where matching is hard, computed from truth and images.
//!
//! The three regions are those of Scharstein & Szeliski, *A taxonomy and evaluation of dense
//! two-frame stereo correspondence algorithms*, IJCV 2002, section 5.1, with their defaults as
//! constants. A data set's own mask, where it has one, is to be preferred: it was made from more
//! than these files.

use raster::Plane;

/// Views whose disparities differ by at most this many pixels show the same surface.
pub const SAME_SURFACE: f32 = 1.0;
/// Neighbours that differ by more than this many pixels of disparity stand across an edge.
pub const DISCONTINUITY_GAP: f32 = 2.0;
/// Width in pixels of the square around such neighbours.
pub const DISCONTINUITY_WIDTH: usize = 9;
/// Width in pixels of the square over which squared gradients are averaged.
pub const TEXTURELESS_WIDTH: usize = 3;
/// A mean squared gradient below this, in grey levels of 0 to 255 squared, is no texture.
pub const TEXTURELESS_BELOW: f32 = 4.0;

/// What the two true disparity maps say about a pixel of the left view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Seen {
    ByBoth,
    ByLeftOnly,
    Unknown,
}

/// Where left `(x, y)` lands in the right view, and whether the surface there is the same one.
fn seen(x: usize, left: f32, right_row: &[f32], tolerance: f32) -> Seen {
    if !left.is_finite() {
        return Seen::Unknown;
    }
    let landing = (x as f32 - left).round();
    if landing < 0.0 || landing >= right_row.len() as f32 {
        return Seen::ByLeftOnly;
    }
    let right = right_row[landing as usize];
    if !right.is_finite() {
        Seen::Unknown
    } else if right - left > tolerance {
        // Something nearer stands in the way.
        Seen::ByLeftOnly
    } else if left - right > tolerance {
        // The right view sees past the left surface: the maps contradict each other.
        Seen::Unknown
    } else {
        Seen::ByBoth
    }
}

fn where_seen(left: &Plane<f32>, right: &Plane<f32>, tolerance: f32, what: Seen) -> Plane<bool> {
    assert_eq!(left.size(), right.size(), "the two true maps of a pair have one size");
    Plane::from_fn(left.columns(), left.rows(), |x, y| {
        seen(x, left.row(y)[x], right.row(y), tolerance) == what
    })
}

/// True where a left pixel is hidden in the right view: its match lies outside the right image, or
/// on a surface that is nearer by more than `tolerance` pixels of disparity.
///
/// Both maps are true disparities of their own view, `x_right = x_left - d` in either, NaN where
/// unknown. Where either is unknown, or the right view contradicts the left by seeing past it, the
/// pixel is neither occluded nor [`non_occluded`].
///
/// Panics when the maps differ in size.
pub fn occluded(left: &Plane<f32>, right: &Plane<f32>, tolerance: f32) -> Plane<bool> {
    where_seen(left, right, tolerance, Seen::ByLeftOnly)
}

/// True where both views see the surface of a left pixel; see [`occluded`].
///
/// Panics when the maps differ in size.
pub fn non_occluded(left: &Plane<f32>, right: &Plane<f32>, tolerance: f32) -> Plane<bool> {
    where_seen(left, right, tolerance, Seen::ByBoth)
}

/// True within `width / 2` rows and columns of a pair of neighbours (left and right, above and
/// below) whose true disparities differ by more than `gap` pixels. Unknown neighbours make no edge.
pub fn discontinuity(truth: &Plane<f32>, gap: f32, width: usize) -> Plane<bool> {
    let (columns, rows) = truth.size();
    let mut edge = Plane::filled(columns, rows, false);
    for y in 0..rows {
        for x in 0..columns {
            // NaN differs from nothing by more than the gap.
            let here = truth.row(y)[x];
            if x + 1 < columns && (here - truth.row(y)[x + 1]).abs() > gap {
                edge.row_mut(y)[x..=x + 1].fill(true);
            }
            if y + 1 < rows && (here - truth.row(y + 1)[x]).abs() > gap {
                edge.row_mut(y)[x] = true;
                edge.row_mut(y + 1)[x] = true;
            }
        }
    }
    let reach = width / 2;
    let around = |at: usize, end: usize| at.saturating_sub(reach)..(at + reach + 1).min(end);
    let wide =
        Plane::from_fn(columns, rows, |x, y| edge.row(y)[around(x, columns)].contains(&true));
    Plane::from_fn(columns, rows, |x, y| around(y, rows).any(|y| wide.row(y)[x]))
}

/// True where the squared horizontal gradient `(I(x + 1) - I(x))^2` of the left image (grey levels
/// of 0 to 255), averaged over a square of `width` pixels, is below `below`. At the image's border
/// the square shrinks to what lies inside; the last column has no gradient and takes that of the
/// column before.
pub fn textureless(left: &Plane<f32>, width: usize, below: f32) -> Plane<bool> {
    let (columns, rows) = left.size();
    let gradient = Plane::from_fn(columns, rows, |x, y| {
        let first = x.min(columns.saturating_sub(2));
        match left.row(y)[first..] {
            [a, b, ..] => (b - a) * (b - a),
            _ => 0.0,
        }
    });
    let reach = width / 2;
    let around = |at: usize, end: usize| at.saturating_sub(reach)..(at + reach + 1).min(end);
    let sums = Plane::from_fn(columns, rows, |x, y| {
        gradient.row(y)[around(x, columns)].iter().sum::<f32>()
    });
    Plane::from_fn(columns, rows, |x, y| {
        let (across, down) = (around(x, columns), around(y, rows));
        let area = (across.len() * down.len()) as f32;
        down.map(|y| sums.row(y)[x]).sum::<f32>() / area < below
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line<T>(samples: Vec<T>) -> Plane<T> {
        Plane::new(samples.len(), 1, samples).unwrap()
    }

    #[test]
    fn a_pixel_behind_something_nearer_or_outside_is_occluded() {
        // A foreground of disparity 2 over a background of 0, as each camera sees it.
        let left = line(vec![0.0, 0.0, 0.0, 2.0, 2.0, 0.0, 2.0, f32::NAN]);
        let right = line(vec![0.0, 2.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.0]);
        let hidden = occluded(&left, &right, SAME_SURFACE);
        assert_eq!(hidden.samples(), [false, true, true, false, false, false, false, false]);
        let seen = non_occluded(&left, &right, SAME_SURFACE);
        assert_eq!(seen.samples(), [true, false, false, true, true, true, true, false]);

        let outside = occluded(&line(vec![1.0]), &line(vec![1.0]), SAME_SURFACE);
        assert_eq!(outside.samples(), [true]);
        // The right view looks past the left surface: nothing can be said.
        let (left, right) = (line(vec![0.0, 1.0]), line(vec![-5.0, 0.0]));
        assert!(!occluded(&left, &right, 0.5).samples()[1]);
        assert!(!non_occluded(&left, &right, 0.5).samples()[1]);
    }

    #[test]
    fn discontinuities_reach_half_a_window_around_the_edge() {
        let mut truth = Plane::filled(9, 9, 5.0);
        truth.row_mut(4)[4] = 8.0;
        let mask = discontinuity(&truth, DISCONTINUITY_GAP, 3);
        // The edge is a cross of five pixels, widened by one on each side: no corner of the 5x5.
        let marked = |x: usize, y: usize| mask.row(y)[x];
        assert!(marked(2, 4) && marked(6, 4) && marked(4, 2) && marked(2, 3) && marked(5, 6));
        assert!(!marked(1, 4) && !marked(2, 2) && !marked(6, 6));
        assert!(discontinuity(&truth, 3.0, 3).samples().iter().all(|m| !m), "3 is not above 3");
        truth.row_mut(4)[4] = f32::NAN;
        assert!(discontinuity(&truth, 2.0, 3).samples().iter().all(|m| !m));
    }

    #[test]
    fn texture_is_a_large_mean_squared_gradient() {
        // Squared gradients 0, 0, 9, 9 (the last column repeats): means over 3 are 0, 3, 6, 9.
        let image = line(vec![10.0, 10.0, 10.0, 13.0]);
        let mask = textureless(&image, TEXTURELESS_WIDTH, TEXTURELESS_BELOW);
        assert_eq!(mask.samples(), [true, true, false, false]);
        assert_eq!(textureless(&line(vec![7.0]), 3, 4.0).samples(), [true]);
    }
}
