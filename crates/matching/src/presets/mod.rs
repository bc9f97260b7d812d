//! The presets: which stages, in which order, with which parameters.

mod fast;

use crate::matcher::Pipeline;
use crate::{Options, Preset};

/// The stages that the options ask for.
pub(crate) fn pipeline(options: &Options) -> Box<dyn Pipeline> {
    match options.preset {
        Preset::Fast | Preset::Balanced | Preset::Best => Box::new(fast::Fast::default()),
    }
}

/// The algorithm of a preset in a few short lines with its sources.
pub(crate) fn explanation(preset: Preset) -> &'static str {
    match preset {
        Preset::Fast | Preset::Balanced | Preset::Best => include_str!("fast.md"),
    }
}
