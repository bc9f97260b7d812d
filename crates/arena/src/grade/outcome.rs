//! How a test ended.

use std::fmt;

use serde::{Deserialize, Serialize};

/// How a test ended, in the two-letter manner of programming contests.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Outcome {
    /// There is a valid answer; whether it passes is another matter.
    Ok,
    /// Run-time error: an exception, a non-zero exit, a missing file or function.
    Re,
    /// Time out: past the limit of CPU or wall time, or not ready in time.
    To,
    /// Memory limit.
    Ml,
    /// Ended by a signal: a crash in native code, or killed for a file too large.
    Sg,
    /// The answer is no disparity map: shape, type, values, or the protocol broken.
    Bad,
    /// The grader's fault: nothing is said about the entrant.
    Xx,
}

impl Outcome {
    /// The code, in capitals.
    pub fn code(self) -> &'static str {
        match self {
            Self::Ok => "OK",
            Self::Re => "RE",
            Self::To => "TO",
            Self::Ml => "ML",
            Self::Sg => "SG",
            Self::Bad => "BAD",
            Self::Xx => "XX",
        }
    }

    /// What the code stands for.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Ok => "answered",
            Self::Re => "run-time error",
            Self::To => "time limit",
            Self::Ml => "memory limit",
            Self::Sg => "ended by a signal",
            Self::Bad => "invalid answer",
            Self::Xx => "the grader failed",
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.code())
    }
}
