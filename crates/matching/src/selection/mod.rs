//! The winner, its fraction of a pixel, and the check against the right view.

pub(crate) mod both_views;
pub(crate) mod confirm;
pub(crate) mod cross_check;
pub(crate) mod fixed_point;
pub(crate) mod unseen;
pub(crate) mod winner;
