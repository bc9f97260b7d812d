//! A disparity per pixel that is also smooth.

pub(crate) mod bands;
pub(crate) mod semi_global;
pub(crate) mod support_weights;
pub(crate) mod support_window;
pub(crate) mod surface_prior;
