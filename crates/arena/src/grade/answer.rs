//! Reads and scores an answer. It was written by a program that is not trusted.

use raster::Plane;
use score::{Pixels, Region};
use serde::{Deserialize, Serialize};

use super::outcome::Outcome;
use super::scene::Scene;
use super::verdict::Failure;
use crate::engine::exchange;
use crate::engine::protocol::Job;

/// A share of pixels that equal the truth to the last bit above which no matcher comes by itself.
const SUSPICIOUS: f64 = 0.9;
/// ... and of those that are off by at most so many pixels, as where something was added to the truth. Of a flat wall,
/// rendered without noise, `best` finds 98 of 100 as well; of the course's scenes 12 to 23.
const NEARLY_ALL: f64 = 0.999;
const NEARLY: f64 = 0.05;

/// The course's two numbers for one answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    /// Root mean square error in pixels.
    pub e_rms: f64,
    /// Share of pixels off by more than 2 px.
    pub p_bad: f64,
    /// Pixels counted: those of the box with known, nonzero truth.
    pub pixels: usize,
    /// Pixels of the box whose value was outside of the range, and was brought to its nearer end.
    pub clipped: usize,
    /// The share of the pixels counted that equal the truth to the last bit.
    pub identical: f64,
    /// The share that is off by at most 0.05 px; 0 in entries of older boards.
    #[serde(default)]
    pub nearly: f64,
    /// What was counted, and how.
    pub protocol: String,
}

impl Scores {
    /// Whether the answer looks as if it had been copied from the truth.
    pub fn looks_copied(&self) -> bool {
        self.identical > SUSPICIOUS || self.nearly > NEARLY_ALL
    }
}

/// Reads the answer to `job`, brings it into `[0, max_disparity]`, and scores it.
pub(super) fn read(
    job: &Job,
    scene: &Scene,
    max_disparity: u32,
) -> Result<(Plane<f32>, Scores), Failure> {
    // Its author does not know the folder.
    let folder = job.disparity.parent().map(|folder| format!("{}/", folder.display()));
    let folder = folder.unwrap_or_default();
    let bad = |message: String| Failure::new(Outcome::Bad, message.replace(&folder, ""));
    check_sole_name(job).map_err(bad)?;
    let answer = exchange::read_answer(job).map_err(bad)?;
    score(answer.disparity, scene, max_disparity)
}

/// Brings disparities into `[0, max_disparity]` and scores them.
pub(super) fn score(
    mut disparity: Plane<f32>,
    scene: &Scene,
    max_disparity: u32,
) -> Result<(Plane<f32>, Scores), Failure> {
    let clipped = clip(&mut disparity, scene, max_disparity as f32)
        .map_err(|message| Failure::new(Outcome::Bad, message))?;
    let failed = |message: String| Failure::new(Outcome::Xx, message);
    let region = Region::whole().within(Some(scene.bounds));
    let pixels = Pixels::select(&disparity, &scene.truth, &region)
        .map_err(|error| failed(format!("scene {}: {error}", scene.id)))?;
    let course = score::course(&pixels).ok_or_else(|| {
        failed(format!("scene {}: its truth is zero everywhere in the box", scene.id))
    })?;
    let within = |most: f64| {
        let is_within = |truth: f64, estimate: f64| (estimate - truth).abs() <= most;
        let counted = pixels.iter().filter(|pixel| pixel.truth != 0.0);
        let found =
            counted.filter(|pixel| pixel.estimate.is_some_and(|own| is_within(pixel.truth, own)));
        found.count() as f64 / course.pixels as f64
    };
    let scores = Scores {
        e_rms: course.e_rms,
        p_bad: course.p_bad,
        pixels: course.pixels,
        clipped,
        identical: within(0.0),
        nearly: within(NEARLY),
        protocol: course.protocol,
    };
    Ok((disparity, scores))
}

/// Errors when the answer is a second name of another file: an answer must be the engine's own.
#[cfg(unix)]
fn check_sole_name(job: &Job) -> Result<(), String> {
    use std::os::unix::fs::MetadataExt;
    match std::fs::symlink_metadata(&job.disparity) {
        Ok(found) if found.is_file() && found.nlink() > 1 => {
            Err("the answer is a link to another file".into())
        }
        _ => Ok(()),
    }
}

#[cfg(not(unix))]
fn check_sole_name(_job: &Job) -> Result<(), String> {
    Ok(())
}

/// Brings the values of the box into the range and counts how many were outside of it. A value that
/// is no number is an error where it would be scored; elsewhere it stays.
fn clip(disparity: &mut Plane<f32>, scene: &Scene, max: f32) -> Result<usize, String> {
    let (mut clipped, mut broken, mut first) = (0, 0usize, None);
    let bounds = scene.bounds;
    for y in bounds.y0..=bounds.y1 {
        let truth = scene.truth.row(y);
        let row = disparity.row_mut(y);
        for x in bounds.x0..=bounds.x1 {
            let value = row[x];
            if !value.is_finite() {
                if truth[x].is_finite() && truth[x] != 0.0 {
                    broken += 1;
                    first.get_or_insert((x, y));
                }
            } else if !(0.0..=max).contains(&value) {
                row[x] = value.clamp(0.0, max);
                clipped += 1;
            }
        }
    }
    match first {
        Some((x, y)) => Err(format!(
            "{broken} pixels of the box that are scored, as their truth is known, are no finite numbers (NaN, infinite \
             or masked), the first in column {x}, row {y}; give every pixel of the box a disparity from 0 to {max}"
        )),
        None => Ok(clipped),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::{BoundingBox, Image};

    /// 4 x 2 pixels, the box is all but the last column; truth 0 and NaN are unknown.
    fn scene() -> Scene {
        let image = Image::Grey8(Plane::filled(4, 2, 0));
        Scene {
            id: "tiny".into(),
            left: image.clone(),
            right: image,
            truth: Plane::new(4, 2, vec![1.0, 2.0, f32::NAN, 9.0, 3.0, 0.0, 4.0, 9.0]).unwrap(),
            non_occluded: None,
            bounds: BoundingBox::new(0, 0, 2, 1).unwrap(),
            secrets: Vec::new(),
        }
    }

    fn scored(samples: Vec<f32>) -> Result<Scores, Failure> {
        score(Plane::new(4, 2, samples).unwrap(), &scene(), 8).map(|(_, scores)| scores)
    }

    #[test]
    fn values_outside_of_the_range_are_clipped_and_counted() {
        // Scored: 1, 2, 3, 4. Estimates 1, 2, -5 -> 0, 20 -> 8; outside of the box nothing counts.
        let scores = scored(vec![1.0, 2.0, 99.0, f32::NAN, -5.0, 0.0, 20.0, 1e9]).unwrap();
        assert_eq!((scores.pixels, scores.clipped), (4, 3));
        assert_eq!(scores.e_rms, ((9.0 + 16.0) / 4.0f64).sqrt());
        assert_eq!((scores.p_bad, scores.identical, scores.nearly), (0.5, 0.5, 0.5));
        assert!(!scores.looks_copied());
        // The truth with something added to it, so that no bit is the same.
        let moved = |by: f32| {
            scored([1.0, 2.0, 0.0, 0.0, 3.0, 0.0, 4.0, 0.0].map(|d| d + by).to_vec()).unwrap()
        };
        assert_eq!((moved(0.04).identical, moved(0.04).nearly), (0.0, 1.0));
        assert!(moved(0.04).looks_copied() && !moved(0.06).looks_copied());
    }

    #[test]
    fn no_number_is_bad_only_where_it_counts() {
        let nan = f32::NAN;
        assert!(scored(vec![1.0, 2.0, nan, nan, 3.0, nan, 4.0, nan]).unwrap().looks_copied());
        let failure = scored(vec![1.0, nan, 0.0, 0.0, 3.0, 0.0, f32::INFINITY, 0.0]).unwrap_err();
        assert_eq!(failure.outcome, Outcome::Bad);
        let message = failure.message;
        assert!(message.starts_with("2 pixels of the box that are scored"), "{message}");
        assert!(message.contains("masked), the first in column 1, row 0;"), "{message}");
    }

    #[cfg(unix)]
    #[test]
    fn an_answer_must_be_a_file_of_its_own() {
        use crate::engine::Pair;
        let folder = tempfile::tempdir().unwrap();
        let scene = scene();
        let range = raster::DisparityRange::new(0, 8).unwrap();
        let pair = Pair { left: &scene.left, right: &scene.right, bounds: scene.bounds, range };
        let job = exchange::write_job(folder.path(), 1, &pair, 1).unwrap();
        let other = folder.path().join("truth.npy");
        formats::npy::write(&other, &Plane::filled(4, 2, 1.0f32)).unwrap();
        std::fs::hard_link(&other, &job.disparity).unwrap();
        let message = read(&job, &scene, 8).unwrap_err().message;
        assert!(message.contains("link to another file"), "{message}");
        std::fs::remove_file(&other).unwrap();
        assert!(read(&job, &scene, 8).is_ok());
        // What is wrong with it is told without the folder that the grader chose.
        std::fs::write(&job.disparity, b"").unwrap();
        let message = read(&job, &scene, 8).unwrap_err().message;
        let name = job.disparity.file_name().unwrap().to_str().unwrap();
        assert!(message.starts_with(&format!("{name} is empty")), "{message}");
    }
}
