//! What came of asking an engine once.

use super::exchange::Answer;
use super::status::Status;
use super::usage::Usage;

/// What came of one pair.
#[derive(Debug, Clone, PartialEq)]
pub struct Attempt {
    /// How it ended.
    pub status: Status,
    /// What was used between sending the job and its end.
    pub usage: Usage,
    /// The answer; there is one exactly when the status is [`Status::Done`].
    pub answer: Option<Answer>,
    /// How long the engine itself says that the matching took, in seconds, if it does.
    pub claimed_seconds: Option<f64>,
    /// What it said besides messages, of its output and of its errors the last 16 KiB.
    pub log: String,
}

impl Attempt {
    /// One that gave none, and said nothing.
    pub(super) fn without_answer(status: Status, usage: Usage) -> Self {
        Self { status, usage, answer: None, claimed_seconds: None, log: String::new() }
    }
}
