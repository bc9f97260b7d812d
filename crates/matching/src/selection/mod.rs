//! The winner, its fraction of a pixel, and the check against the right view.

pub(crate) mod cross_check;
pub(crate) mod winner;
