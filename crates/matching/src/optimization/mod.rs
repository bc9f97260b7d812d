//! A disparity per pixel that is also smooth.
//!
//! | file | what it does |
//! | --- | --- |
//! | `semi_global` | the sums of eight paths (Hirschmüller 2008), row by row, from costs that are made when they are needed |
//! | `bands` | how much of that is kept and how much made again, within a bound of memory |
//! | `surface_prior` | planes along which the paths go free of charge (Scharstein et al. 2017) |

pub(crate) mod bands;
pub(crate) mod semi_global;
pub(crate) mod surface_prior;
