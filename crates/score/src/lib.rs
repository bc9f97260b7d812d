//! A disparity map against ground truth.
//!
//! Every score is a pure function of an estimate, a truth and a [`Region`]. A number without its
//! protocol cannot be compared with another, so each family of measures carries a `protocol` that
//! spells out which pixels were counted, what a hole counted as, and the thresholds.
//!
//! | family | measures | source |
//! | --- | --- | --- |
//! | [`course()`] | E_RMS, p_bad | the robotics course whose assignment named them |
//! | [`middlebury()`] | bad 0.5, 1, 2, 4; avgerr; rms; A50, A90, A95, A99; density | Scharstein et al., GCPR 2014 |
//! | [`kitti()`] | D1 with holes filled, D1 of the estimates, Out-2 to Out-5, density | Menze & Geiger, CVPR 2015; Geiger et al., CVPR 2012 |
//! | [`end_point()`] | mean and median end-point error, bias, sub-pixel error | |
//! | [`sparsification()`] | ROC and sparsification curve, AUC, AUSE of a confidence | Hu & Mordohai, PAMI 2012; Ilg et al., ECCV 2018 |
//! | [`masks`] | the pixels that both views see | |
//!
//! Conventions, everywhere:
//! * disparities and errors are in pixels of the left image, the error is `estimate - truth`;
//! * truth is *known* where it is finite; NaN and infinity say that nobody knows;
//! * an estimate that is not finite is a *hole*. Holes are counted and shown, never dropped
//!   silently: each family says what a hole counts as;
//! * shares (p_bad, bad, D1, density) run from 0 to 1;
//! * *bad* is strictly greater than the threshold.
//!
//! ```
//! use raster::Plane;
//! use score::{Region, evaluate};
//!
//! let truth = Plane::new(4, 1, vec![10.0, 20.0, f32::NAN, 40.0])?;
//! let estimate = Plane::new(4, 1, vec![10.5, 23.0, 30.0, f32::NAN])?;
//! let scores = evaluate(&estimate, &truth, &Region::whole())?;
//!
//! assert_eq!((scores.pixels, scores.holes), (3, 1));
//! let course = scores.course.unwrap();
//! assert_eq!(course.p_bad, 2.0 / 3.0); // off by 3 px, and the hole
//! assert_eq!(course.e_rms, f64::sqrt((0.25 + 9.0 + 1600.0) / 3.0));
//! assert_eq!(scores.middlebury.avgerr, Some(1.75)); // of the estimates only
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod confidence;
mod course;
mod end_point;
mod error;
mod evaluation;
mod kitti;
pub mod masks;
mod measure;
mod middlebury;
mod pixels;
mod reach;
mod region;
mod scale;
mod statistics;

pub use confidence::{CurvePoint, RankedError, Sparsification, sparsification};
pub use course::{Course, course};
pub use end_point::{EndPoint, SubPixel, end_point};
pub use error::ScoreError;
pub use evaluation::{Evaluation, Scores, evaluate};
pub use kitti::{Kitti, Out, fill_from_background, kitti};
pub use measure::{Measure, Unit};
pub use middlebury::{Bad, Middlebury, middlebury};
pub use pixels::{Pixel, Pixels};
pub use reach::share_outside;
pub use region::Region;
pub use scale::suspected_scale;
pub use statistics::{mean, median};
