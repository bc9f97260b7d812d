//! Costs summed over a support region.

pub(crate) mod window;
