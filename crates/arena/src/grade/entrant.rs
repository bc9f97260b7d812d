//! Who is graded.

use std::collections::BTreeMap;

use crate::engine::Definition;
use crate::submission::{Part, Submission};

/// Who is graded: a course submission, or an engine for each part.
#[derive(Debug, Clone)]
pub enum Entrant {
    /// A course submission that could be taken.
    Submission(Submission),
    /// A submission that could not be taken, and why: every test fails with this message.
    Refused(String),
    /// A submission that the grader failed to take, and why: every test ends as its fault.
    NotTaken(String),
    /// An engine for each part.
    Engines(BTreeMap<Part, Definition>),
}

impl Entrant {
    /// One engine for part 1, one for part 2.
    pub fn engines(fast: Definition, best: Definition) -> Self {
        Self::Engines(BTreeMap::from([(Part::Fast, fast), (Part::Best, best)]))
    }
}
