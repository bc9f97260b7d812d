//! Why nothing can be scored.

use raster::BoundsError;

/// An estimate cannot be scored against this truth.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScoreError {
    /// Two planes that describe the same left image differ in size.
    #[error(
        "the {what} is {columns} x {rows} but the estimate is {estimate_columns} x \
         {estimate_rows}: both must have the size of the left image; was one of them made at \
         another resolution?"
    )]
    SizesDiffer {
        /// What was compared with the estimate: truth, mask, confidence.
        what: &'static str,
        /// Its columns.
        columns: usize,
        /// Its rows.
        rows: usize,
        /// Columns of the estimate.
        estimate_columns: usize,
        /// Rows of the estimate.
        estimate_rows: usize,
    },
    /// The box is not inside the image.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// No pixel of the region has a known truth.
    #[error(
        "the truth has no known disparity in {region}: nothing can be scored; check the truth's \
         file and encoding, the box and the mask"
    )]
    NoTruth {
        /// The region in words.
        region: String,
    },
    /// A confidence is not a number.
    #[error(
        "the confidence at column {x}, row {y} is not a number although there is an estimate: \
         give every estimate a confidence, larger where it is surer"
    )]
    Confidence {
        /// Column of the pixel.
        x: usize,
        /// Row of the pixel.
        y: usize,
    },
    /// No scored pixel has an estimate, so nothing can be ranked.
    #[error("no scored pixel of {region} has an estimate: there is nothing to rank by confidence")]
    NoEstimate {
        /// The region in words.
        region: String,
    },
    /// A parameter of a measure is not allowed.
    #[error("`{field}` is {value}, but {allowed}")]
    Parameter {
        /// The parameter's name.
        field: &'static str,
        /// What it was given.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
}
