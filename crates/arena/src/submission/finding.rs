//! Something noticed about a submission.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Something noticed about a submission, in words that its author can act on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// The file, relative to the submission.
    pub file: String,
    /// The line, counted from 1, where it is about one.
    pub line: Option<u64>,
    /// What it is, perhaps over several lines.
    pub text: String,
    /// Whether the tests of that module need not be run.
    pub fatal: bool,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}, line {line}: {}", self.file, self.text),
            None => write!(f, "{}: {}", self.file, self.text),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finding_names_file_and_line() {
        let text = r#"{"file":"a.py","line":3,"text":"TabError","fatal":true}"#;
        let mut finding: Finding = serde_json::from_str(text).unwrap();
        assert_eq!(finding.to_string(), "a.py, line 3: TabError");
        finding.line = None;
        assert_eq!(finding.to_string(), "a.py: TabError");
    }
}
