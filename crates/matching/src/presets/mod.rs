//! The presets: which stages, in which order, with which parameters.

mod answer;
mod fast;
mod memory;
mod pair;
mod penalties;
mod right_choices;
mod semi_global;
mod view;
mod widened;

use raster::DisparityMap;

use crate::allowance::Allowance;
use crate::kernels::level::Level;
use crate::matcher::{Frame, Pipeline};
use crate::profile::Profile;
use crate::refinement::choice::Lesson;
use crate::{MatchError, Options, Preset};
use semi_global::SemiGlobalMatching;

/// The stages that the options ask for.
pub(crate) fn pipeline(options: &Options, level: Level) -> Box<dyn Pipeline> {
    match options.preset {
        Preset::Fast => Box::new(fast::Fast::new(level)),
        preset @ (Preset::Balanced | Preset::Best) => {
            Box::new(SemiGlobalMatching::new(preset, &options.without, level))
        }
    }
}

/// The algorithm of a preset in a few short lines with its sources.
pub(crate) fn explanation(preset: Preset) -> &'static str {
    match preset {
        Preset::Fast => include_str!("fast.md"),
        Preset::Balanced => include_str!("balanced.md"),
        Preset::Best => include_str!("best.md"),
    }
}

/// Lets `balanced` or `best` match a frame, up to where it would choose once more, and takes the lesson
/// from there.
pub(crate) fn teach(
    preset: Preset,
    frame: &Frame<'_>,
    lesson: Lesson,
) -> Result<Lesson, MatchError> {
    if preset == Preset::Fast {
        return Err(MatchError::Option {
            field: "matcher",
            value: format!("`{preset}`"),
            allowed: "nobody judges its answers: it must be balanced or best".into(),
        });
    }
    let (columns, rows) = frame.size();
    let mut stages = SemiGlobalMatching::teaching(preset, Level::detect(), lesson);
    let (mut map, mut profile) = (DisparityMap::empty(columns, rows), Profile::new());
    stages.run(frame, Allowance::unbounded(), &mut map, &mut profile);
    Ok(stages.into_lesson().expect("it was given one"))
}
