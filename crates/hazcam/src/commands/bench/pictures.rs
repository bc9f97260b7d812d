//! A scene and pictures of what a matcher made of it, flat and as points in space.

use std::path::Path;

use arena::dataset::CaseData;
use arena::engine::Answer;
use arena::record::{Sight, sights};
use camera::DISPARITY_ERROR;
use formats::picture::{self, ColourMap};
use formats::{View, write_view};
use raster::{Image, Plane};

/// The colours of a scene's disparities, the same for the truth and all matchers.
fn colour_range(data: &CaseData) -> (f32, f32) {
    let of_truth = data.truth.as_ref().and_then(picture::value_range);
    of_truth.unwrap_or((data.range.min() as f32, data.range.max() as f32))
}

fn turbo(values: &Plane<f32>, data: &CaseData) -> Plane<[u8; 3]> {
    let (min, max) = colour_range(data);
    picture::disparity(values, min, max, ColourMap::Turbo)
}

/// The scene itself as MiddEval3 lays it out: `im0.png` and `im1.png`, and where they are known `disp0GT.pfm`,
/// `mask0nocc.png` and `calib.txt`.
pub fn write_pair(folder: &Path, data: &CaseData) -> anyhow::Result<()> {
    formats::write_image(folder.join("im0.png"), &data.left)?;
    formats::write_image(folder.join("im1.png"), &data.right)?;
    if let Some(truth) = &data.truth {
        formats::write_disparity(folder.join("disp0GT.pfm"), truth)?;
    }
    if let Some(seen_by_both) = seen_by_both(data) {
        let mask = seen_by_both.map(|&both| if both { 255 } else { 128 });
        formats::write_image(folder.join("mask0nocc.png"), &Image::Grey8(mask))?;
    }
    if let Some(camera) = &data.camera {
        let (size, range) = (data.left.size(), data.range);
        formats::write_calibration(folder.join("calib.txt"), camera, size, range)?;
    }
    Ok(())
}

/// `left.png`.
pub fn write_left(folder: &Path, data: &CaseData) -> anyhow::Result<()> {
    Ok(formats::write_image(folder.join("left.png"), &data.left)?)
}

/// `truth.png` where there is truth.
pub fn write_truth(folder: &Path, data: &CaseData) -> anyhow::Result<()> {
    if let Some(truth) = &data.truth {
        picture::write_png_rgb(folder.join("truth.png"), &turbo(truth, data))?;
    }
    Ok(())
}

/// `ENGINE.png` with the disparities inside the box, `ENGINE-error.png` where there is truth, and `ENGINE-obstacles.png`
/// where obstacles were laid.
pub fn write_answer(
    folder: &Path,
    engine: &str,
    data: &CaseData,
    answer: &Answer,
) -> anyhow::Result<()> {
    let estimate = inside(&answer.disparity, data);
    picture::write_png_rgb(folder.join(format!("{engine}.png")), &turbo(&estimate, data))?;
    if let Some(truth) = &data.truth {
        let errors = picture::log_error(&estimate, &inside(truth, data), seen_by_both(data))?;
        picture::write_png_rgb(folder.join(format!("{engine}-error.png")), &errors)?;
    }
    if let Some(sights) = sights(answer, data) {
        let obstacles = over(&data.left, &sights);
        picture::write_png_rgb(folder.join(format!("{engine}-obstacles.png")), &obstacles)?;
    }
    Ok(())
}

/// Obstacles over the left image: green where they are seen, red where they are missed, yellow what looks nearer than it is.
fn over(left: &Image, sights: &Plane<Option<Sight>>) -> Plane<[u8; 3]> {
    let left = picture::image(left);
    Plane::from_fn(left.columns(), left.rows(), |x, y| {
        let pixel = left.row(y)[x];
        let colour: [u8; 3] = match sights.row(y)[x] {
            None => return pixel,
            Some(Sight::Seen) => [0, 160, 0],
            Some(Sight::Missed) => [255, 0, 0],
            Some(Sight::FalseAlarm) => [255, 220, 0],
        };
        std::array::from_fn(|i| (u16::from(pixel[i]) / 3 + 2 * u16::from(colour[i]) / 3) as u8)
    })
}

/// A page of the points inside the box.
pub fn write_page(
    page: &Path,
    title: &str,
    data: &CaseData,
    answer: &Answer,
) -> anyhow::Result<()> {
    let estimate = inside(&answer.disparity, data);
    let mut view = View::new(title, &estimate).with_image(&data.left)?;
    if let Some(camera) = data.camera {
        view = view.with_camera(camera, DISPARITY_ERROR);
    }
    if let Some(confidence) = &answer.confidence {
        view = view.with_confidence(confidence, 0.0)?;
    }
    if let Some(reasons) = &answer.reasons {
        view = view.with_reasons(reasons)?;
    }
    if let Some(truth) = &data.truth {
        view = view.with_truth(truth)?;
    }
    write_view(page, &view)?;
    Ok(())
}

/// Which pixels both cameras see, if that is known.
fn seen_by_both(data: &CaseData) -> Option<&Plane<bool>> {
    let region = data.regions.iter().find(|region| region.name == "non-occluded");
    region.map(|region| &region.mask)
}

/// What lies inside the box; nothing is known of the rest.
fn inside(plane: &Plane<f32>, data: &CaseData) -> Plane<f32> {
    Plane::from_fn(plane.columns(), plane.rows(), |x, y| match data.bounds.contains(x, y) {
        true => plane.row(y)[x],
        false => f32::NAN,
    })
}
