//! Pictures of a scene and of what a matcher made of it, flat and as points in space.

use std::path::Path;

use arena::dataset::CaseData;
use arena::engine::Answer;
use formats::picture::{self, ColourMap};
use formats::{View, write_view};
use raster::Plane;

/// What a page tells the depths' uncertainty for, in pixels.
const DISPARITY_ERROR: f64 = 0.5;

/// The colours of a scene's disparities, the same for the truth and all matchers.
fn colour_range(data: &CaseData) -> (f32, f32) {
    let of_truth = data.truth.as_ref().and_then(picture::value_range);
    of_truth.unwrap_or((data.range.min() as f32, data.range.max() as f32))
}

fn turbo(values: &Plane<f32>, data: &CaseData) -> Plane<[u8; 3]> {
    let (min, max) = colour_range(data);
    picture::disparity(values, min, max, ColourMap::Turbo)
}

/// `left.png`, and `truth.png` where there is truth.
pub fn write_scene(folder: &Path, data: &CaseData) -> anyhow::Result<()> {
    formats::write_image(folder.join("left.png"), &data.left)?;
    if let Some(truth) = &data.truth {
        picture::write_png_rgb(folder.join("truth.png"), &turbo(truth, data))?;
    }
    Ok(())
}

/// `ENGINE.png` with the disparities inside the box, and `ENGINE-error.png` where there is truth.
pub fn write_answer(
    folder: &Path,
    engine: &str,
    data: &CaseData,
    answer: &Answer,
) -> anyhow::Result<()> {
    let estimate = inside(&answer.disparity, data);
    picture::write_png_rgb(folder.join(format!("{engine}.png")), &turbo(&estimate, data))?;
    if let Some(truth) = &data.truth {
        let seen_by_both = data.regions.iter().find(|region| region.name == "non-occluded");
        let errors = picture::log_error(
            &estimate,
            &inside(truth, data),
            seen_by_both.map(|region| &region.mask),
        )?;
        picture::write_png_rgb(folder.join(format!("{engine}-error.png")), &errors)?;
    }
    Ok(())
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

/// What lies inside the box; nothing is known of the rest.
fn inside(plane: &Plane<f32>, data: &CaseData) -> Plane<f32> {
    Plane::from_fn(plane.columns(), plane.rows(), |x, y| match data.bounds.contains(x, y) {
        true => plane.row(y)[x],
        false => f32::NAN,
    })
}
