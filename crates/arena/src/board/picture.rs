//! Pictures of answers, small enough that a page can hold those of a whole class.

use formats::picture::{self, ColourMap};
use raster::{BoundingBox, Plane};

use crate::grade::{Scene, TestResult};

/// Wider pictures lose every other column and row until they are not.
const WIDEST: usize = 640;

/// Steps of colour: what is the same compresses well, and nobody sees more on a screen.
const STEPS: f32 = 96.0;

/// The disparities and errors of one answer within the box, as PNG.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// The test's name.
    pub test: String,
    /// Disparities in turbo, from the smallest to the largest of the truth.
    pub disparity: Vec<u8>,
    /// KITTI's colours for errors.
    pub error: Vec<u8>,
}

impl Picture {
    /// Draws the answer to a test, if there is one.
    pub fn of(result: &TestResult, scene: &Scene) -> Option<Self> {
        let estimate = cropped(result.disparity.as_ref()?, scene);
        let truth = cropped(&scene.truth, scene);
        let non_occluded = scene.non_occluded.as_ref().map(|mask| cropped(mask, scene));
        let errors = picture::log_error(&estimate, &truth, non_occluded.as_ref());
        Some(Self {
            test: result.name.clone(),
            disparity: picture::png_rgb(&turbo(&estimate, &truth)).ok()?,
            error: picture::png_rgb(&smaller(&errors.ok()?)).ok()?,
        })
    }
}

/// The true disparities of a test's scene within its box, as PNG.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneTruth {
    /// The test's name.
    pub test: String,
    /// In the colours of [`Picture::disparity`].
    pub truth: Vec<u8>,
}

impl SceneTruth {
    /// Draws the truth of the scene that the test of this name is on.
    pub fn of(test: &str, scene: &Scene) -> Option<Self> {
        let truth = cropped(&scene.truth, scene);
        let truth = picture::png_rgb(&turbo(&truth, &truth)).ok()?;
        Some(Self { test: test.to_owned(), truth })
    }
}

/// Disparities of the box in the range of the box's truth.
fn turbo(disparity: &Plane<f32>, truth: &Plane<f32>) -> Plane<[u8; 3]> {
    let (min, max) = picture::value_range(truth).unwrap_or((0.0, 1.0));
    let step = ((max - min) / STEPS).max(f32::MIN_POSITIVE);
    let stepped = smaller(disparity).map(|value| ((value - min) / step).round() * step + min);
    picture::disparity(&stepped, min, max, ColourMap::Turbo)
}

/// The part within the scene's box.
fn cropped<T: Copy>(plane: &Plane<T>, scene: &Scene) -> Plane<T> {
    let BoundingBox { x0, y0, x1, y1 } = scene.bounds;
    plane.view().part(x0..x1 + 1, y0..y1 + 1).to_plane()
}

fn smaller<T: Copy>(plane: &Plane<T>) -> Plane<T> {
    let every = plane.columns().div_ceil(WIDEST).max(1);
    let (columns, rows) = (plane.columns().div_ceil(every), plane.rows().div_ceil(every));
    Plane::from_fn(columns, rows, |x, y| plane.row(y * every)[x * every])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_pictures_are_thinned_and_others_left_alone() {
        let wide = Plane::from_fn(1242, 3, |x, _| x);
        assert_eq!(smaller(&wide).size(), (621, 2));
        assert_eq!(smaller(&wide).row(1)[620], 1240);
        let narrow = Plane::from_fn(640, 3, |x, y| x + y);
        assert_eq!(smaller(&narrow), narrow);
    }
}
