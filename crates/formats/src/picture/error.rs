//! Pictures of an estimate against the truth.

use raster::Plane;

use super::{BLACK, SizesDiffer};

/// Truth, but no estimate: a green that no error is shown in.
pub const HOLE: [u8; 3] = [0, 200, 0];

/// Where each of [`LOG_ERROR_COLOURS`] begins, in units of the error that KITTI calls wrong.
pub const LOG_ERROR_STEPS: [f32; 10] = [0.0, 0.0625, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// KITTI's colours for errors: five blues for right, five warm ones for wrong.
pub const LOG_ERROR_COLOURS: [[u8; 3]; 10] = [
    [49, 54, 149],
    [69, 117, 180],
    [116, 173, 209],
    [171, 217, 233],
    [224, 243, 248],
    [254, 224, 144],
    [253, 174, 97],
    [244, 109, 67],
    [215, 48, 39],
    [165, 0, 38],
];

/// What each colour of [`log_error`] stands for: the ranges of [`LOG_ERROR_STEPS`], then [`HOLE`].
pub fn log_error_legend() -> Vec<([u8; 3], String)> {
    let ends = LOG_ERROR_STEPS[1..].iter().map(|to| format!("to {to}"));
    let ranges = LOG_ERROR_STEPS.iter().zip(ends.chain(["and more".to_owned()]));
    let ranges = ranges.map(|(from, to)| format!("{from} {to}"));
    LOG_ERROR_COLOURS.into_iter().zip(ranges).chain([(HOLE, "no answer".to_owned())]).collect()
}

/// The error picture of KITTI 2015 (Menze & Geiger, CVPR 2015): `n = min(err / 3, 20 err / d)`,
/// which is 1 where D1 begins to count a pixel as wrong (3 px and 5 % of the true `d`), in ten
/// steps of doubling width. No truth is black, no estimate is [`HOLE`].
///
/// `non_occluded` (from [`read_mask`](crate::read_mask)) shows every pixel that the right camera
/// does not see at half the brightness.
pub fn log_error(
    estimate: &Plane<f32>,
    truth: &Plane<f32>,
    non_occluded: Option<&Plane<bool>>,
) -> Result<Plane<[u8; 3]>, SizesDiffer> {
    picture(estimate, truth, non_occluded, |estimate, truth| {
        let error = (estimate - truth).abs();
        // A truth of 0 makes the second term infinite, or NaN where the error is 0 as well, and
        // `min` then takes the first.
        let n = (error / 3.0).min(20.0 * error / truth.abs());
        let above = LOG_ERROR_STEPS.iter().filter(|&&step| n >= step).count();
        LOG_ERROR_COLOURS[above.max(1) - 1]
    })
}

/// Black, hole or the colour of `(estimate, truth)`, darker where occluded.
fn picture(
    estimate: &Plane<f32>,
    truth: &Plane<f32>,
    non_occluded: Option<&Plane<bool>>,
    colour: impl Fn(f32, f32) -> [u8; 3],
) -> Result<Plane<[u8; 3]>, SizesDiffer> {
    check("estimate", estimate.size(), "truth", truth.size())?;
    if let Some(mask) = non_occluded {
        check("mask", mask.size(), "truth", truth.size())?;
    }
    let picture = estimate.samples().iter().zip(truth.samples()).enumerate().map(|(at, pair)| {
        let full = match pair {
            (_, truth) if !truth.is_finite() => return BLACK,
            (estimate, _) if !estimate.is_finite() => HOLE,
            (&estimate, &truth) => colour(estimate, truth),
        };
        match non_occluded {
            Some(mask) if !mask.samples()[at] => full.map(|channel| channel / 2),
            _ => full,
        }
    });
    let (columns, rows) = truth.size();
    Ok(Plane::new(columns, rows, picture.collect()).expect("one colour a pixel"))
}

fn check(
    first: &'static str,
    first_size: (usize, usize),
    second: &'static str,
    second_size: (usize, usize),
) -> Result<(), SizesDiffer> {
    if first_size == second_size {
        Ok(())
    } else {
        Err(SizesDiffer { first, second, first_size, second_size })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(values: &[f32]) -> Plane<f32> {
        Plane::new(values.len(), 1, values.to_vec()).unwrap()
    }

    #[test]
    fn the_step_is_the_smaller_of_three_pixels_and_five_percent() {
        // At d = 100, 5 % is 5 px: an error of 5 is n = min(5/3, 1) = 1, of 4.9 below.
        // At d = 10, 5 % is half a pixel: n = min(3/3, 6) = 1.
        let truth = row(&[100.0, 100.0, 10.0, 10.0, 50.0, 50.0, 0.0, 0.0]);
        let estimate = row(&[105.0, 95.1, 13.0, 7.1, 50.0, 150.0, 0.0, 1.5]);
        let picture = log_error(&estimate, &truth, None).unwrap();
        let step = |n: usize| LOG_ERROR_COLOURS[n];
        // 100 px wrong at d = 50: n = min(33, 40), past 16. 1.5 px at d = 0: n = 0.5.
        let expected = [step(5), step(4), step(5), step(4), step(0), step(9), step(0), step(5 - 1)];
        assert_eq!(picture.samples(), expected);
    }

    #[test]
    fn holes_missing_truth_and_occlusion_show() {
        let truth = row(&[f32::NAN, 10.0, 10.0, 10.0]);
        let estimate = row(&[10.0, f32::NAN, 10.0, f32::NAN]);
        let mask = Plane::new(4, 1, vec![false, true, false, false]).unwrap();
        let picture = log_error(&estimate, &truth, Some(&mask)).unwrap();
        assert_eq!(picture.samples(), [BLACK, HOLE, [24, 27, 74], [0, 100, 0]]);
    }

    #[test]
    fn the_legend_has_every_colour_once() {
        let legend = log_error_legend();
        let words: Vec<&str> = legend.iter().map(|(_, words)| words.as_str()).collect();
        assert_eq!(words[..2], ["0 to 0.0625", "0.0625 to 0.125"]);
        assert_eq!(words[9..], ["16 and more", "no answer"]);
        assert_eq!((legend[9].0, legend[10].0), (LOG_ERROR_COLOURS[9], HOLE));
    }

    #[test]
    fn sizes_must_agree() {
        let error = log_error(&row(&[1.0]), &row(&[1.0, 2.0]), None).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the estimate is 1 x 1 but the truth is 2 x 1: they must have one size"
        );
        let mask = Plane::filled(3, 1, true);
        assert!(log_error(&row(&[1.0]), &row(&[1.0]), Some(&mask)).is_err());
    }
}
