//! Costs summed over a support region: a fixed square `window` by running sums (McDonnell 1981). Semi-global matching
//! aggregates along its paths ([`crate::optimization`]).

pub(crate) mod window;
