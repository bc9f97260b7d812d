//! The presets: which stages, in which order, with which parameters.

mod fast;
mod memory;
mod semi_global;

use crate::kernels::level::Level;
use crate::matcher::Pipeline;
use crate::{MatchError, Options, Preset};
use semi_global::{Finish, SemiGlobalMatching};

/// The stages that the options ask for.
pub(crate) fn pipeline(options: &Options) -> Result<Box<dyn Pipeline>, MatchError> {
    let semi_global = |finish| -> Result<Box<dyn Pipeline>, MatchError> {
        Ok(Box::new(SemiGlobalMatching::new(finish, Level::chosen()?, options.memory)))
    };
    match options.preset {
        Preset::Fast => Ok(Box::new(fast::Fast::new(Level::chosen()?))),
        Preset::Balanced => semi_global(Finish::Median),
        Preset::Best => semi_global(Finish::SupportWeights),
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
