//! What the programs in `training/` learn from. Nobody else needs this.

use raster::{BoundingBox, DisparityRange, Image, Plane};

use crate::matcher::Frame;
use crate::refinement::choice::Lesson;
pub use crate::refinement::choice::{Known, Pixel};
use crate::{MatchError, Preset, presets};

/// What a preset, `balanced` or `best`, knows of pixels of a pair of images of equal size when the judges that it has so far
/// have spoken. `pick` says which when it has seen the disparities up to there, those of every so many-th
/// pixel of every so many-th row, and how many: it picks among these. Pixels without a choice are left out.
pub fn choices(
    preset: Preset,
    left: &Image,
    right: &Image,
    range: DisparityRange,
    pick: impl FnMut(&Plane<f32>, usize) -> Vec<Pixel> + Send + 'static,
) -> Result<Vec<(Pixel, Known)>, MatchError> {
    let (columns, rows) = left.size();
    let frame = Frame { left, right, bounds: BoundingBox::whole(columns, rows), range };
    Ok(presets::teach(preset, &frame, Lesson::new(pick))?.known)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fast_has_nothing_to_learn() {
        let image = Image::Grey8(Plane::filled(9, 9, 7));
        let range = DisparityRange::new(0, 3).unwrap();
        let refused = choices(Preset::Fast, &image, &image, range, |_, _| Vec::new());
        assert!(refused.unwrap_err().to_string().contains("balanced or best"));
    }
}
