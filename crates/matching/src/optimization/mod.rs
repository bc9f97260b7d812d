//! A disparity per pixel that is also smooth.

pub(crate) mod bands;
pub(crate) mod semi_global;
pub(crate) mod surface_prior;
