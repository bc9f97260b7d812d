//! What a judge is told of a candidate: where each number stands among its [`Hints`].
//!
//! The order is that of the weights: whoever changes it trains the judges again.

use crate::kernels::products::Lanes;

/// All that is known of a candidate, of each pixel of a block.
pub(super) type Hints = [Lanes; OF_EACH];

/// How far it lies from what the pixel has, with sign and without.
pub(super) const APART: usize = 0;
pub(super) const FAR: usize = 1;
/// Of where it comes from: confidence, whether filled, whether in doubt.
pub(super) const CONFIDENCE: usize = 2;
pub(super) const FILLED: usize = 3;
pub(super) const DOUBT: usize = 4;
/// The difference of grey to there.
pub(super) const SHADE: usize = 5;
/// How badly the match fits: census and grey steps of the window, census of the pixel.
pub(super) const CENSUS: usize = 6;
pub(super) const GREY_STEPS: usize = 7;
pub(super) const CENSUS_HERE: usize = 8;
/// How far the right view's disparity at the match lies from it, with sign and without.
pub(super) const RIGHT_APART: usize = 9;
pub(super) const RIGHT_FAR: usize = 10;
/// The share of candidates that say the same, and that of those of the same shade.
pub(super) const VOTES: usize = 11;
pub(super) const VOTES_OF_SHADE: usize = 12;
/// How far it lies from the smallest and from the largest one.
pub(super) const ABOVE_SMALLEST: usize = 13;
pub(super) const BELOW_LARGEST: usize = 14;
/// Whether the match lies outside the right image.
pub(super) const OUTSIDE: usize = 15;
/// How steep its plane is.
pub(super) const STEEP: usize = 16;
/// How much the grey changes on the way to there.
pub(super) const CHANGES: usize = 17;
/// The share of candidates that say the same among the confident ones, and among those that no edge
/// parts from the pixel.
pub(super) const VOTES_OF_CONFIDENT: usize = 18;
pub(super) const VOTES_WITHOUT_EDGE: usize = 19;

/// So many there are.
pub(super) const OF_EACH: usize = VOTES_WITHOUT_EDGE + 1;
