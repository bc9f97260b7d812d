//! What can be left out of a preset, to see what it gives.

use std::fmt;
use std::str::FromStr;

use crate::{MatchError, Preset};

/// A part of `balanced` and `best` that can be left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Ingredient {
    /// Vertical disparity found and taken out of the right image.
    VerticalAlignment,
    /// Both images smoothed where they are noisy.
    NoiseSmoothing,
    /// Differences of grey steps in the cost.
    Gradient,
    /// A large penalty that falls with the grey step.
    AdaptiveP2,
    /// Learned descriptors in the cost.
    Descriptors,
    /// Descriptors that do not count where there is nothing but noise.
    NoiseCheck,
    /// Paths that follow fitted planes.
    SurfacePrior,
    /// The last of the runs that follow planes.
    LastSurfaceRun,
    /// The fraction of a pixel.
    SubPixel,
    /// Winners that another disparity comes near to taken out.
    Uniqueness,
    /// The check against the right view.
    LeftRightCheck,
    /// Small groups taken out.
    SpeckleFilter,
    /// Holes inside a surface run from one end to the other.
    Interpolation,
    /// The background continued along its plane.
    PlaneFill,
    /// Planes from the neighbourhood, chosen by learned judges.
    LearnedChoice,
    /// The same in the right view, before.
    RightChoices,
    /// All rounds of choices but the first.
    FurtherChoices,
    /// Pixels moved onto the plane of their neighbours.
    PlaneSmoothing,
    /// Fractions of a pixel mended by least squares on the images.
    LeastSquares,
    /// The median of 5 x 5 pixels.
    Median,
    /// Nearer matches that medians spare.
    NearDetail,
    /// Confidence by the margin of the paths' sums.
    PathMargin,
}

use Ingredient::*;

/// In the order of the stages.
const BALANCED: [Ingredient; 17] = [
    VerticalAlignment,
    NoiseSmoothing,
    Gradient,
    AdaptiveP2,
    SubPixel,
    Uniqueness,
    LeftRightCheck,
    SpeckleFilter,
    Interpolation,
    PlaneFill,
    LearnedChoice,
    FurtherChoices,
    PlaneSmoothing,
    LeastSquares,
    Median,
    NearDetail,
    PathMargin,
];

/// All of them but `Interpolation`, since what it closes judges close better, and `NoiseSmoothing`: descriptors
/// and judges see more in the noise than in what smoothing leaves.
const BEST: [Ingredient; 20] = [
    VerticalAlignment,
    Gradient,
    AdaptiveP2,
    Descriptors,
    NoiseCheck,
    SurfacePrior,
    LastSurfaceRun,
    SubPixel,
    Uniqueness,
    LeftRightCheck,
    SpeckleFilter,
    PlaneFill,
    LearnedChoice,
    RightChoices,
    FurtherChoices,
    PlaneSmoothing,
    LeastSquares,
    Median,
    NearDetail,
    PathMargin,
];

impl Ingredient {
    /// What can be left out of a preset, in the order of its stages; nothing of `fast`.
    pub fn of(preset: Preset) -> &'static [Ingredient] {
        match preset {
            Preset::Fast => &[],
            Preset::Balanced => &BALANCED,
            Preset::Best => &BEST,
        }
    }

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        self.told().0
    }

    /// What it is, in one line.
    pub fn explanation(self) -> &'static str {
        self.told().1
    }

    /// What stands in its place when it is left out.
    pub fn instead(self) -> &'static str {
        self.told().2
    }

    fn told(self) -> (&'static str, &'static str, &'static str) {
        match self {
            VerticalAlignment => (
                "vertical-alignment",
                "vertical disparity that rectification left is found and taken out of the right image",
                "rows as they are",
            ),
            NoiseSmoothing => (
                "noise-smoothing",
                "both images are smoothed by a mask of 3 x 3 where they are noisy",
                "images as they are",
            ),
            Gradient => {
                ("gradient", "differences of grey steps beside the census", "the census alone")
            }
            AdaptiveP2 => (
                "adaptive-p2",
                "P2 falls where the grey value steps beyond noise",
                "P2 is the same everywhere, as large as on flat grey",
            ),
            Descriptors => (
                "descriptors",
                "learned descriptors in the costs, counting more for pixels that found no match",
                "census and gradient alone",
            ),
            NoiseCheck => (
                "noise-check",
                "descriptors do not count where grey varies no more than noise does",
                "they count everywhere",
            ),
            SurfacePrior => (
                "surface-prior",
                "two more runs of the paths, along the surfaces found",
                "one run, parallel to the image",
            ),
            LastSurfaceRun => (
                "last-surface-run",
                "the second of these runs",
                "one run along the surfaces of the first",
            ),
            SubPixel => (
                "sub-pixel",
                "the fraction of a pixel from three sums of the paths",
                "whole disparities from the paths",
            ),
            Uniqueness => (
                "uniqueness",
                "winners whose sum another disparity's comes within 2 of go out",
                "winners stay however close the next",
            ),
            LeftRightCheck => (
                "left-right-check",
                "winners that the right view does not confirm go out",
                "all winners stay",
            ),
            SpeckleFilter => (
                "speckle-filter",
                "groups that weigh less than 20 sure pixels go out",
                "groups of any size stay",
            ),
            Interpolation => (
                "interpolation",
                "a hole between two ends of one surface runs from one to the other",
                "every hole belongs to the smaller end",
            ),
            PlaneFill => (
                "plane-fill",
                "occluded pixels continue the plane of the background",
                "they take its disparity as it is",
            ),
            LearnedChoice => (
                "learned-choice",
                "pixels take one of 24 planes around them (in best 32), chosen by a learned judge",
                "the filled map as it is",
            ),
            RightChoices => (
                "right-choices",
                "the right view chooses first, by two judges: what it says at a match is a hint",
                "the hint is the right view of the paths",
            ),
            FurtherChoices => (
                "further-choices",
                "more rounds of choices, by judges taught after the first: four, in best five",
                "one round",
            ),
            PlaneSmoothing => (
                "plane-smoothing",
                "pixels move onto the plane that their neighbours lie on, unless the images speak against it",
                "the map as paths and choices leave it",
            ),
            LeastSquares => (
                "least-squares",
                "fractions of a pixel are mended where the images say so, by least squares",
                "fractions as the paths and choices leave them",
            ),
            Median => ("median", "a median of 5 x 5 pixels at the end", "none"),
            NearDetail => (
                "near-detail",
                "medians spare matches that are nearer by half a pixel, with three neighbours beside them",
                "medians of all pixels",
            ),
            PathMargin => (
                "path-margin",
                "confidence: how far the winner's sum lies below any other, times the judge's certainty",
                "1 / (1 + difference of the two views' disparities)",
            ),
        }
    }
}

impl fmt::Display for Ingredient {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Ingredient {
    type Err = MatchError;

    fn from_str(text: &str) -> Result<Self, MatchError> {
        let others = BEST.into_iter().filter(|ingredient| !BALANCED.contains(ingredient));
        let all: Vec<Ingredient> = BALANCED.into_iter().chain(others).collect();
        let named = all.iter().find(|ingredient| ingredient.name() == text);
        named.copied().ok_or_else(|| MatchError::Option {
            field: "without",
            value: format!("`{text}`"),
            allowed: format!("it must be one of {}", names(&all)),
        })
    }
}

fn names(ingredients: &[Ingredient]) -> String {
    ingredients.iter().map(|ingredient| ingredient.name()).collect::<Vec<_>>().join(", ")
}

/// Errors when something is to be left out that the preset does not have.
pub(crate) fn check(preset: Preset, without: &[Ingredient]) -> Result<(), MatchError> {
    let own = Ingredient::of(preset);
    let Some(stranger) = without.iter().find(|ingredient| !own.contains(ingredient)) else {
        return Ok(());
    };
    let allowed = match own {
        [] => format!("nothing can be left out of `{preset}`"),
        own => format!("`{preset}` is made without it; it has {}", names(own)),
    };
    Err(MatchError::Option { field: "without", value: format!("`{stranger}`"), allowed })
}

/// A set of ingredients, small enough to be handed to every stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Ingredients(u32);

impl Ingredients {
    /// What a preset is made with when some of it is left out.
    pub fn of(preset: Preset, without: &[Ingredient]) -> Self {
        let used = Ingredient::of(preset).iter().filter(|own| !without.contains(own));
        Self(used.fold(0, |set, ingredient| set | 1 << *ingredient as u16))
    }

    pub fn has(self, ingredient: Ingredient) -> bool {
        self.0 & 1 << ingredient as u16 != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back_and_what_is_shared_comes_in_the_same_order() {
        for ingredient in BALANCED.into_iter().chain(BEST) {
            assert_eq!(ingredient.name().parse(), Ok(ingredient));
        }
        let both = |one: &Ingredient| BALANCED.contains(one) && BEST.contains(one);
        assert!(BALANCED.into_iter().filter(both).eq(BEST.into_iter().filter(both)));
        let error = "salt".parse::<Ingredient>().unwrap_err().to_string();
        assert!(
            error.contains("`salt`, but it must be one of vertical-alignment, noise-smoothing, "),
            "{error}"
        );
    }

    #[test]
    fn a_set_holds_what_is_not_left_out() {
        let set = Ingredients::of(Preset::Balanced, &[Median]);
        assert!(set.has(Gradient) && !set.has(Median) && !set.has(SurfacePrior));
        let set = Ingredients::of(Preset::Best, &[SurfacePrior]);
        assert!(set.has(RightChoices) && set.has(Descriptors) && !set.has(SurfacePrior));
    }

    #[test]
    fn only_what_a_preset_has_can_be_left_out() {
        assert_eq!(check(Preset::Best, &BEST), Ok(()));
        let error = |preset| check(preset, &[Median, SurfacePrior]).unwrap_err().to_string();
        let balanced = error(Preset::Balanced);
        assert!(balanced.contains("`surface-prior`, but `balanced` is made without it"));
        assert!(error(Preset::Fast).contains("nothing can be left out of `fast`"));
    }
}
