//! Twins of a pair: the same things as other cameras would have seen them.
//!
//! Scenes with truth are few, and a judge comes to know them. Seen upside down, in a mirror, or from
//! farther away, edges, holes and surfaces are new to it.

use arena::dataset::{Case, CaseData};
use raster::{BoundsError, DisparityRange, Image, Plane};
use scenes::Random;

use crate::Failure;

/// How much smaller twins are: by chance between two factors.
const SMALLER: [(f64, f64); 2] = [(0.65, 0.9), (0.4, 0.65)];

/// A pair with truth, what it is called, and how much of a lesson it is worth.
pub struct Twin {
    pub name: String,
    pub data: CaseData,
    pub worth: f64,
}

/// The pair of a scene and its twins.
pub fn family(case: &Case, data: &CaseData, random: &mut Random) -> Result<Vec<Twin>, Failure> {
    let mirrored = case.truth_right(data)?.map(|truth| mirrored(data, &truth));
    // Whoever has no mirror image would be half as often among the lessons.
    let worth = if mirrored.is_some() { 1.0 } else { 2.0 };
    let mirrored = mirrored.map(|data| (format!("{} in a mirror", case.id), data));
    let mut family = Vec::new();
    for (name, data) in [(case.id.clone(), data.clone())].into_iter().chain(mirrored) {
        let truth = data.truth.as_ref().expect("scenes to learn from have truth");
        let mut add = |how: String, data| {
            family.push(Twin { name: format!("{name} {how}"), data, worth: worth / 2.0 });
        };
        add("upside down".into(), upside_down(&data, truth));
        for (least, most) in SMALLER {
            let factor = random.between(least, most);
            add(format!("at {factor:.2} of its size"), smaller(&data, truth, factor)?);
        }
        family.push(Twin { name, data, worth });
    }
    Ok(family)
}

/// A pair with its truth, upside down.
fn upside_down(data: &CaseData, truth: &Plane<f32>) -> CaseData {
    fn flipped(plane: &Plane<f32>) -> Plane<f32> {
        let last = plane.rows() - 1;
        Plane::from_fn(plane.columns(), plane.rows(), |x, y| plane.row(last - y)[x])
    }
    let image = |image: &Image| grey(&flipped(&image.to_grey_f32()));
    pair(image(&data.left), image(&data.right), data.range, flipped(truth))
}

/// A pair in a mirror, where the right camera is the left one; `truth` is that of the right image.
fn mirrored(data: &CaseData, truth: &Plane<f32>) -> CaseData {
    fn reversed(plane: &Plane<f32>) -> Plane<f32> {
        let last = plane.columns() - 1;
        Plane::from_fn(plane.columns(), plane.rows(), |x, y| plane.row(y)[last - x])
    }
    let image = |image: &Image| grey(&reversed(&image.to_grey_f32()));
    pair(image(&data.right), image(&data.left), data.range, reversed(truth))
}

/// A pair with its truth, by a factor below 1 smaller.
fn smaller(data: &CaseData, truth: &Plane<f32>, factor: f64) -> Result<CaseData, BoundsError> {
    let image = |image: &Image| grey(&shrunk(&image.to_grey_f32(), factor));
    let (left, right) = (image(&data.left), image(&data.right));
    let (columns, rows) = left.size();
    // Truth is not mixed: an edge stays one. That of the middle of the pixel is taken.
    let from = |place: usize, end: usize| (((place as f64 + 0.5) / factor) as usize).min(end - 1);
    let truth = Plane::from_fn(columns, rows, |x, y| {
        truth.row(from(y, truth.rows()))[from(x, truth.columns())] * factor as f32
    });
    let (min, max) = (f64::from(data.range.min()), f64::from(data.range.max()));
    let range = DisparityRange::new((min * factor).floor() as i32, (max * factor).ceil() as i32)?;
    Ok(pair(left, right, range, truth))
}

fn pair(left: Image, right: Image, range: DisparityRange, truth: Plane<f32>) -> CaseData {
    CaseData { truth: Some(truth), ..CaseData::new(left, right, range) }
}

fn grey(plane: &Plane<f32>) -> Image {
    Image::Grey8(plane.map(|grey| grey.round().clamp(0.0, 255.0) as u8))
}

/// Of every pixel the mean of the area that it covers.
fn shrunk(plane: &Plane<f32>, factor: f64) -> Plane<f32> {
    let (across, down) = (covered(plane.columns(), factor), covered(plane.rows(), factor));
    let mean = |parts: &[(usize, f32)], sample: &dyn Fn(usize) -> f32| {
        parts.iter().map(|&(place, share)| share * sample(place)).sum::<f32>()
    };
    let narrow = Plane::from_fn(across.len(), plane.rows(), |x, y| {
        mean(&across[x], &|column| plane.row(y)[column])
    });
    Plane::from_fn(across.len(), down.len(), |x, y| mean(&down[y], &|row| narrow.row(row)[x]))
}

/// Which of so many places each place of the smaller row covers, and their shares of it.
fn covered(places: usize, factor: f64) -> Vec<Vec<(usize, f32)>> {
    let one = |small: usize| {
        let (start, end) =
            (small as f64 / factor, ((small + 1) as f64 / factor).min(places as f64));
        let share = |place: usize| {
            let covered = end.min(place as f64 + 1.0) - start.max(place as f64);
            (place, (covered / (end - start)) as f32)
        };
        (start as usize..end.ceil() as usize).map(share).collect()
    };
    let small = (places as f64 * factor) as usize;
    (0..small.max(1)).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const RANGE: (i32, i32) = (-1, 9);

    /// A right image that is the left one moved by 4, with the truths of both.
    fn moved() -> (CaseData, Plane<f32>) {
        let noise = |x: usize, y: usize| ((x * 7919 + y * 104_729 + x * x * y * 31) % 251) as u8;
        let left = Image::Grey8(Plane::from_fn(40, 12, noise));
        let right = Image::Grey8(Plane::from_fn(40, 12, |x, y| noise(x + 4, y)));
        let range = DisparityRange::new(RANGE.0, RANGE.1).unwrap();
        let truth = Plane::from_fn(40, 12, |_, y| if y == 0 { f32::NAN } else { 4.0 });
        (CaseData { truth: Some(truth.clone()), ..CaseData::new(left, right, range) }, truth)
    }

    /// Whether every pixel with a truth looks as its match does.
    fn fits(data: &CaseData, most: f32) -> bool {
        let (left, right) = (data.left.to_grey_f32(), data.right.to_grey_f32());
        let truth = data.truth.as_ref().unwrap();
        let mut pixels = (0..left.rows()).flat_map(|y| (0..left.columns()).map(move |x| (x, y)));
        pixels.all(|(x, y)| {
            let column = x as f32 - truth.row(y)[x];
            let seen = column >= 0.0 && (column as usize) < left.columns();
            !seen || (left.row(y)[x] - right.row(y)[column as usize]).abs() <= most
        })
    }

    #[test]
    fn matches_are_where_the_truth_says() {
        let (data, truth) = moved();
        assert!(fits(&data, 0.0));
        for twin in [upside_down(&data, &truth), mirrored(&data, &truth)] {
            assert!(fits(&twin, 0.0));
            assert!(twin.left != data.left && twin.range == data.range);
        }
        let flipped = upside_down(&data, &truth).truth.unwrap();
        assert!(flipped.row(11)[7].is_nan() && flipped.row(0)[7] == 4.0);
        let half = smaller(&data, &truth, 0.5).unwrap();
        assert!(fits(&half, 1.0));
        assert_eq!((half.left.size(), half.truth.unwrap().row(3)[9]), ((20, 6), 2.0));
        assert_eq!((half.range.min(), half.range.max()), (-1, 5));
    }

    #[test]
    fn a_smaller_pixel_is_the_mean_of_what_it_covers() {
        let ramp = Plane::from_fn(10, 4, |x, y| 10.0 * x as f32 + y as f32);
        let small = shrunk(&ramp, 0.4);
        assert_eq!(small.size(), (4, 1));
        // Columns 2.5 to 5 and rows 0 to 2.5: means of 32.5 (to 0.5 + 30 + 40) and 0.8.
        let expected = 10.0 * (0.5 * 2.0 + 3.0 + 4.0) / 2.5 + (1.0 + 0.5 * 2.0) / 2.5;
        assert!((small.row(0)[1] - expected).abs() < 1e-4, "{}", small.row(0)[1]);
    }
}
