//! Masks of pixels, computed from the truths of both views. A data set's own mask, where it has one,
//! is to be preferred: it was made from more than these.

use raster::Plane;

/// Views whose disparities differ by at most this many pixels show the same surface.
pub const SAME_SURFACE: f32 = 1.0;

/// True where both views see the surface of a left pixel: its match lies inside the right image, on
/// a surface whose disparity differs by at most `tolerance` pixels. One that is nearer by more hides
/// it; where the right view sees past the left surface, the maps contradict each other.
///
/// Both maps are true disparities of their own view, `x_right = x_left - d` in either, NaN where
/// unknown; where either is unknown, so is whether both views see the pixel, and the answer is no.
///
/// Panics when the maps differ in size.
pub fn non_occluded(left: &Plane<f32>, right: &Plane<f32>, tolerance: f32) -> Plane<bool> {
    assert_eq!(left.size(), right.size(), "the two true maps of a pair have one size");
    let columns = left.columns();
    Plane::from_fn(columns, left.rows(), |x, y| {
        let here = left.row(y)[x];
        let landing = (x as f32 - here).round();
        // Nothing that is NaN lies in a range or below a tolerance.
        (0.0..columns as f32).contains(&landing)
            && (right.row(y)[landing as usize] - here).abs() <= tolerance
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(samples: &[f32]) -> Plane<f32> {
        Plane::new(samples.len(), 1, samples.to_vec()).unwrap()
    }

    #[test]
    fn a_pixel_behind_something_nearer_or_outside_is_not_seen_by_both() {
        // A foreground of disparity 2 over a background of 0, as each camera sees it.
        let left = line(&[0.0, 0.0, 0.0, 2.0, 2.0, 0.0, 2.0, f32::NAN]);
        let right = line(&[0.0, 2.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.0]);
        let seen = non_occluded(&left, &right, SAME_SURFACE);
        assert_eq!(seen.samples(), [true, false, false, true, true, true, true, false]);

        // Between two pixels the nearer one counts: column 3 less 1.4 lands at 2, less 1.6 at 1.
        let right = line(&[0.0, 1.6, 1.4, 9.0]);
        for (d, lands) in [(1.4, 2), (1.6, 1)] {
            let left = line(&[0.0, 0.0, 0.0, d]);
            assert!(non_occluded(&left, &right, 0.1).samples()[3], "at {lands}");
        }

        // Off by as much as the tolerance it is the same surface still, to either side.
        for off in [SAME_SURFACE, -SAME_SURFACE] {
            assert_eq!(non_occluded(&line(&[0.0]), &line(&[off]), SAME_SURFACE).samples(), [true]);
        }

        for outside in [1.0, -1.0] {
            let plane = line(&[outside]);
            assert_eq!(non_occluded(&plane, &plane, SAME_SURFACE).samples(), [false]);
        }
        for unknown in [f32::NAN, f32::INFINITY] {
            let right = line(&[unknown]);
            assert_eq!(non_occluded(&line(&[0.0]), &right, SAME_SURFACE).samples(), [false]);
        }
        // The right view looks past the left surface: nothing can be said.
        let (left, right) = (line(&[0.0, 1.0]), line(&[-5.0, 0.0]));
        assert!(!non_occluded(&left, &right, 0.5).samples()[1]);
    }
}
