//! What a board keeps of one entrant.

use serde::{Deserialize, Serialize};

use crate::grade::{Report, TestResult};
use crate::submission::BEGINS_A_FORMULA;

/// What a board keeps of one entrant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// The name that everybody sees: 4 to 32 printable characters, no space at an end.
    pub secret_id: String,
    /// Whether the board's keeper gave it that name, which then stays with its owner.
    #[serde(default)]
    pub renamed: bool,
    /// Whether it is shown for comparison only.
    pub baseline: bool,
    /// When it was added, in UTC (`2026-01-31T12:00:00Z`). Set by the board; the same hand-in, graded again by the
    /// same tests, keeps its time.
    #[serde(default)]
    pub added: String,
    /// The [fingerprint](super::tests_fingerprint) of the scheme's tests; empty in entries of older boards, of
    /// which nobody knows.
    #[serde(default)]
    pub tests: String,
    /// The digest of the files that were handed in; `None` of engines, and in entries of older boards.
    #[serde(default)]
    pub handin: Option<String>,
    /// The scheme's tests.
    pub report: Report,
    /// The test on the hold-out.
    pub holdout: TestResult,
    /// Where it ran: processor, cores, architecture, system.
    pub machine: String,
}

impl Entry {
    /// Whether it is of files with this digest, graded by tests with this fingerprint, as far as that is known.
    pub fn is_of(&self, handin: Option<&str>, tests: &str) -> bool {
        self.handin.is_some() && (self.handin.as_deref(), &self.tests[..]) == (handin, tests)
    }

    /// CPU time of all tests and the hold-out, where it is known of all.
    pub fn cpu_seconds(&self) -> Option<f64> {
        Some(self.report.cpu_seconds()? + self.holdout.usage.cpu_seconds?)
    }
}

/// Whose an entry is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner<'a> {
    /// Somebody said so: an earlier entry is replaced whatever it is called.
    Given(&'a str),
    /// Taken from a file's name, which may be the same for everybody: an earlier entry is replaced
    /// only by one of the same secret ID.
    Guessed(&'a str),
}

impl<'a> Owner<'a> {
    /// What the owner is called.
    pub fn name(self) -> &'a str {
        match self {
            Self::Given(name) | Self::Guessed(name) => name,
        }
    }
}

impl<'a> From<&'a str> for Owner<'a> {
    fn from(name: &'a str) -> Self {
        Self::Given(name)
    }
}

/// Whether this can name an owner: 1 to 200 characters that can be seen, and no formula where the list is opened as
/// a spreadsheet: whoever names the file of a hand-in names its owner.
pub fn is_owner(text: &str) -> bool {
    (1..=200).contains(&text.chars().count())
        && !text.chars().any(char::is_control)
        && text.trim() == text
        && !text.starts_with(BEGINS_A_FORMULA)
}
