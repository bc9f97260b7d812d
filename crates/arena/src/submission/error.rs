//! Why a submission cannot be taken.

use std::io;
use std::path::PathBuf;

/// Why a submission cannot be taken, or cannot be looked at on this machine.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SubmissionError {
    /// The file or folder cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The copy cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is neither a folder nor an archive.
    #[error("{} is {found}: hand in a folder, or an archive (.zip, .tar, .tar.gz)", path.display())]
    WrongKind {
        /// The file.
        path: PathBuf,
        /// What it looks like.
        found: &'static str,
    },
    /// The archive ends early or is damaged.
    #[error("{} is damaged: {problem}; pack it again", path.display())]
    Damaged {
        /// The archive.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// An entry is not allowed.
    #[error("{}: `{entry}` {problem}", path.display())]
    Entry {
        /// The submission.
        path: PathBuf,
        /// The entry's name in it.
        entry: String,
        /// What is wrong with it, and what to do.
        problem: String,
    },
    /// It is too large.
    #[error("{} is too large: {problem}", path.display())]
    TooLarge {
        /// The submission.
        path: PathBuf,
        /// What is too many or too large, and the limit.
        problem: String,
    },
    /// None of the course's files is in it.
    #[error(
        "{} holds none of secret_id.py, stereo_disparity_fast.py, stereo_disparity_best.py{hint}",
        path.display()
    )]
    NoModules {
        /// The submission.
        path: PathBuf,
        /// What is there instead.
        hint: String,
    },
    /// The course's files are in several folders beside each other.
    #[error(
        "{} holds files of the course in several folders, {} and {} among them: hand in one folder with all three files; \
         those of a class are graded one by one",
        path.display(),
        one.display(),
        other.display()
    )]
    Several {
        /// What was handed in.
        path: PathBuf,
        /// The folder of one of them, within it.
        one: PathBuf,
        /// Another one.
        other: PathBuf,
    },
    /// There is no Python that can be used.
    #[error("{0}")]
    Python(String),
}

impl SubmissionError {
    /// Whether the submission is what is wrong, and not the grader's disk, Python or rights.
    pub fn is_entrants_fault(&self) -> bool {
        match self {
            Self::WrongKind { .. }
            | Self::Damaged { .. }
            | Self::Entry { .. }
            | Self::TooLarge { .. }
            | Self::Several { .. }
            | Self::NoModules { .. } => true,
            Self::Read { .. } | Self::Write { .. } | Self::Python(_) => false,
        }
    }
}
