//! Outliers out, occlusions filled, edges sharpened, confidence.

pub(crate) mod blank;
pub(crate) mod choice;
pub(crate) mod columns_between;
pub(crate) mod groups;
pub(crate) mod least_squares;
pub(crate) mod median;
pub(crate) mod median_in_steps;
pub(crate) mod outside;
pub(crate) mod plane_fill;
pub(crate) mod plane_fit;
pub(crate) mod row_fill;
pub(crate) mod rows_between;
