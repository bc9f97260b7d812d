//! What matching costs are computed from.

pub(crate) mod alignment;
pub(crate) mod census;
pub(crate) mod descriptor;
pub(crate) mod gradient;
pub(crate) mod grey;
pub(crate) mod prefilter;
