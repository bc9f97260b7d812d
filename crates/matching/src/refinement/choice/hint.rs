//! What a judge is told of a candidate: where each number stands among its [`Hints`].
//!
//! The order is that of the weights: whoever changes it trains the judges again.

use crate::kernels::products::Lanes;

/// All that is known of a candidate, of each pixel of a block.
pub(super) type Hints = [Lanes; OF_EACH];

/// How far it lies from what the pixel has.
pub(super) const APART: usize = 0;
/// Of where it comes from: confidence, the difference of grey to there, how much the grey changes on the way.
pub(super) const CONFIDENCE: usize = 1;
pub(super) const SHADE: usize = 2;
pub(super) const CHANGES: usize = 3;
/// How badly the census of the window fits.
pub(super) const CENSUS: usize = 4;
/// Whether the match lies outside the right image.
pub(super) const OUTSIDE: usize = 5;
/// The hints so far make the context, in which all candidates are scored.
pub(super) const IN_CONTEXT: usize = OUTSIDE + 1;
/// How far it lies from what the pixel has, without sign.
pub(super) const FAR: usize = 6;
/// Of where it comes from: whether filled, whether in doubt, how steep its plane is.
pub(super) const FILLED: usize = 7;
pub(super) const DOUBT: usize = 8;
pub(super) const STEEP: usize = 9;
/// How badly grey steps of the window fit, and the census of the pixel.
pub(super) const GREY_STEPS: usize = 10;
pub(super) const CENSUS_HERE: usize = 11;
/// How far the right view's disparity at the match lies from it, with sign and without.
pub(super) const RIGHT_APART: usize = 12;
pub(super) const RIGHT_FAR: usize = 13;
/// How far it lies from the smallest and from the largest one.
pub(super) const ABOVE_SMALLEST: usize = 14;
pub(super) const BELOW_LARGEST: usize = 15;
/// The share of candidates that say the same: of all, of those of the same shade, of the confident ones, of those
/// that no edge parts from the pixel.
pub(super) const VOTES: usize = 16;
pub(super) const VOTES_OF_SHADE: usize = 17;
pub(super) const VOTES_OF_CONFIDENT: usize = 18;
pub(super) const VOTES_WITHOUT_EDGE: usize = 19;

/// So many there are.
pub(super) const OF_EACH: usize = VOTES_WITHOUT_EDGE + 1;
