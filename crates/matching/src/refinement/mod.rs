//! Outliers out, occlusions filled, edges sharpened, confidence.
//!
//! | file | what it does |
//! | --- | --- |
//! | `groups` | speckles: groups of pixels that are too small (Hirschmüller 2008) |
//! | `row_fill`, `plane_fill`, `plane_fit` | holes: from one end to the other, or the background along its plane |
//! | `choice` | pixels take the plane around them that a learned network expects to be off by the least |
//! | `plane_smoothing` | staircases: the plane that the neighbours lie on, where the images allow it |
//! | `least_squares` | the fraction of a pixel (Lucas & Kanade 1981) |
//! | `columns_between`, `rows_between` | what lies between the matched ones |
//! | `median`, `median_in_steps` | what stands alone |
//! | `spared` | small things that are near: kept from the median |
//! | `outside`, `blank` | what lies outside the right image, and what shows nothing: reasons |
//! | `repetition` | what repeats along the rows: confidence |

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
pub(crate) mod plane_smoothing;
pub(crate) mod repetition;
pub(crate) mod row_fill;
pub(crate) mod rows_between;
pub(crate) mod spared;

use raster::{DisparityRange, Plane};

use crate::cost::MatchedRows;

/// A map of the left image: its disparities, and where it lies.
pub(crate) struct Map<'a> {
    /// In pixels, none missing.
    pub values: &'a mut Plane<f32>,
    /// The column of the image at which it begins.
    pub first: usize,
    pub rows: MatchedRows,
    /// In which its disparities stay.
    pub range: DisparityRange,
}
