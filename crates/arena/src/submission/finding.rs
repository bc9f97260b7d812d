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
    /// Whether it is for whoever grades: what makes it doubtful that all of this is its author's work.
    #[serde(default)]
    pub doubtful: bool,
}

impl Finding {
    /// One that is about a file as a whole, and neither fatal nor doubtful.
    pub(crate) fn about(file: impl Into<String>, text: impl Into<String>) -> Self {
        Self { file: file.into(), line: None, text: text.into(), fatal: false, doubtful: false }
    }
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
