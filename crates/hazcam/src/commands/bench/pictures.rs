//! Pictures of a scene and of what a matcher made of it.

use std::path::Path;

use arena::dataset::CaseData;
use arena::engine::Answer;
use formats::picture::{self, ColourMap};
use raster::Plane;

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
    let within = |x: usize, y: usize, value: f32| match data.bounds.contains(x, y) {
        true => value,
        false => f32::NAN,
    };
    let (columns, rows) = answer.disparity.size();
    let inside =
        |plane: &Plane<f32>| Plane::from_fn(columns, rows, |x, y| within(x, y, plane.row(y)[x]));
    let estimate = inside(&answer.disparity);
    picture::write_png_rgb(folder.join(format!("{engine}.png")), &turbo(&estimate, data))?;
    if let Some(truth) = &data.truth {
        let seen_by_both = data.regions.iter().find(|region| region.name == "non-occluded");
        let errors =
            picture::log_error(&estimate, &inside(truth), seen_by_both.map(|region| &region.mask))?;
        picture::write_png_rgb(folder.join(format!("{engine}-error.png")), &errors)?;
    }
    Ok(())
}
