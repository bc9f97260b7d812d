//! A leaderboard: entrants ranked by a pair of images that none of them has.
//!
//! A [`Board`] is one SQLite file. It holds the [`Holdout`] by which it ranks, fixed when the board
//! is begun, and for each entrant the latest [`Entry`]: the report of all tests, the result on the
//! hold-out, versions and machine, and pictures.
//!
//! **Rank.** E_RMS and p_bad weigh equally: each is divided by the hold-out's threshold, and the
//! mean of the two is the *holdout score*,
//! ```text
//! score = (E_RMS / max_e_rms + p_bad / max_p_bad) / 2
//! ```
//! so 1 is just at both thresholds, and lower is better. Ties go to the earlier entry.
//! Who has no answer there is listed last and has no place.
//!
//! **Bonus.** The first three get 5, 3 and 2 points on top of those of the tests: 55 at most.
//! Baselines are shown where they would stand, and take neither a place nor a bonus.
//!
//! **Names.** Everybody is known by a secret ID. An owner (a student's number, say; on no page)
//! has one entry: a later one takes its place, whatever its ID; where the owner was only guessed from
//! a file's name, one with the same ID ([`Owner`]). An ID that somebody else has, or that looks like it, is refused.
//!
//! **Tests.** All points are for the same tests on the same scenes ([`tests_fingerprint`]); others are refused.

mod entry;
mod error;
mod fingerprint;
mod holdout;
mod listing;
mod picture;
mod schema;
mod standing;
mod store;

pub use entry::{Entry, Owner, is_owner};
pub use error::BoardError;
pub use fingerprint::tests_fingerprint;
pub use holdout::Holdout;
pub use listing::table;
pub use picture::{Picture, SceneTruth};
pub use standing::{BONUS, Standing, holdout_score, standings};
pub use store::{Added, Board};
