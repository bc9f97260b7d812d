//! Why a file with tests, thresholds and points cannot be used.

use std::path::PathBuf;

/// Why a file with tests, thresholds and points cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct SchemeError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong in it.
    pub problem: String,
}
