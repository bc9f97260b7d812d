//! The runner in `python/`, written to a folder from which Python can start it.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::error::SubmissionError;
use super::finding::Finding;
use super::python::Python;
use super::secret_id::is_secret_id;
use crate::engine::Status;

/// Its files, relative to the folder.
const FILES: [(&str, &str); 11] = [
    ("start.py", include_str!("../../python/start.py")),
    ("hazcam_runner/__init__.py", include_str!("../../python/hazcam_runner/__init__.py")),
    ("hazcam_runner/arrays.py", include_str!("../../python/hazcam_runner/arrays.py")),
    ("hazcam_runner/channel.py", include_str!("../../python/hazcam_runner/channel.py")),
    ("hazcam_runner/explaining.py", include_str!("../../python/hazcam_runner/explaining.py")),
    ("hazcam_runner/hints.py", include_str!("../../python/hazcam_runner/hints.py")),
    ("hazcam_runner/inspecting.py", include_str!("../../python/hazcam_runner/inspecting.py")),
    ("hazcam_runner/loading.py", include_str!("../../python/hazcam_runner/loading.py")),
    ("hazcam_runner/main.py", include_str!("../../python/hazcam_runner/main.py")),
    ("hazcam_runner/older.py", include_str!("../../python/hazcam_runner/older.py")),
    ("hazcam_runner/programs.py", include_str!("../../python/hazcam_runner/programs.py")),
];

/// The runner, ready to be started.
#[derive(Debug, Clone)]
pub struct Runner {
    python: Python,
    folder: PathBuf,
}

/// What the runner sees in a submission without running its matchers.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Inspection {
    /// What `secret_id()` returned, if it is of use.
    pub secret_id: Option<String>,
    /// What its author should know.
    pub findings: Vec<Finding>,
}

/// What comes before the findings in the message of the runner.
const FINDINGS: &str = "FINDINGS: ";

impl Inspection {
    /// What the runner told: the name that it gave itself is the secret ID, its answer to the one
    /// job the findings. Anything else is a finding of its own, unless it is the grader's fault, as tests will tell.
    pub(crate) fn told(secret_id: Option<String>, status: &Status) -> Self {
        if matches!(status, Status::Absent { .. }) {
            return Self::default();
        }
        let message = status.message().unwrap_or_default();
        let findings = message
            .strip_prefix(FINDINGS)
            .and_then(|json| serde_json::from_str(json).ok())
            .unwrap_or_else(|| {
                let text = format!("looking at it failed: {}", message);
                vec![Finding::about("secret_id.py", text)]
            });
        // It comes from the submission's process, so it is checked here again.
        Self { secret_id: secret_id.filter(|id| is_secret_id(id)), findings }
    }
}

impl Runner {
    /// Writes the runner's files to `folder`.
    pub fn install(python: Python, folder: &Path) -> Result<Self, SubmissionError> {
        for (name, content) in FILES {
            let path = folder.join(name);
            let written = match path.parent() {
                Some(parent) => fs::create_dir_all(parent),
                None => Ok(()),
            };
            written
                .and_then(|()| fs::write(&path, content))
                .map_err(|source| SubmissionError::Write { path, source })?;
        }
        Ok(Self { python, folder: folder.to_owned() })
    }

    /// The interpreter.
    pub fn python(&self) -> &Python {
        &self.python
    }

    /// What a sandbox must let it read.
    pub fn readable(&self) -> Vec<PathBuf> {
        let mut paths = self.python.paths().to_vec();
        paths.push(self.folder.clone());
        paths
    }

    pub(super) fn command(&self, arguments: &[&OsStr]) -> Command {
        let mut command = self.python.command();
        // No byte code beside the sources, nothing held back in buffers, UTF-8 whatever the locale.
        command.args(["-B", "-u", "-X", "utf8"]).arg(self.folder.join("start.py")).args(arguments);
        command
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_runner_tells_is_checked() {
        let status = |message: &str| Status::Failed { message: message.into() };
        let findings = r#"FINDINGS: [{"file":"a.py","line":2,"text":"t","fatal":true}]"#;
        let told = Inspection::told(Some("abc".into()), &status(findings));
        assert_eq!((told.secret_id, told.findings.len()), (None, 1));
        let told = Inspection::told(Some("abcd".into()), &status("FINDINGS: nonsense"));
        assert_eq!(told.secret_id.as_deref(), Some("abcd"));
        assert!(told.findings[0].text.contains("failed"));
        let absent = Status::Absent { message: "no numpy".into() };
        assert_eq!(Inspection::told(None, &absent), Inspection::default());
    }
}
