//! What matching costs are computed from: images whose rows agree, and what is made of them.

pub(crate) mod alignment;
pub(crate) mod census;
pub(crate) mod descriptor;
pub(crate) mod gradient;
pub(crate) mod grey;
pub(crate) mod noise;
pub(crate) mod prefilter;
