//! What can go wrong, grouped by who must act: the system, the maker of the file, the one who chose
//! the file, or the one who wrote the arguments.

use std::io;
use std::path::{Path, PathBuf};

/// A file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The system refuses to open or read the file.
    #[error("cannot read {}: {}", path.display(), why(source))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The system refuses to write the file. Nothing is left behind.
    #[error("cannot write {}: {problem}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What stands in the way, and the remedy.
        problem: String,
        /// The system's number for that, where it has one.
        os_error: Option<i32>,
        /// What the system said, where `problem` says no more than that.
        source: Option<io::Error>,
    },
    /// The content breaks the rules of its own format: cut off, damaged, or not made to the rules.
    #[error("{} is damaged ({format}{}): {problem}", path.display(), at(*offset))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The format that the content begins like.
        format: &'static str,
        /// Where, in bytes from the start of the file.
        offset: Option<u64>,
        /// What is wrong, and what is allowed.
        problem: String,
    },
    /// The file claims a size that is refused before any memory is taken.
    #[error("{} is too large ({format}): {claim}; the limit is {limit}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The format.
        format: &'static str,
        /// What the file claims to hold.
        claim: String,
        /// What is allowed.
        limit: String,
    },
    /// The file is sound, but it is not what is needed here.
    #[error("{} is {found}, but {needed}", path.display())]
    WrongKind {
        /// The file.
        path: PathBuf,
        /// What it is.
        found: String,
        /// What is needed, and the remedy.
        needed: String,
    },
    /// The extension of a file to be written names no known format.
    #[error(
        "cannot tell the format of {} from {}: use one of {known}",
        path.display(),
        extension_of(path)
    )]
    UnknownExtension {
        /// The file.
        path: PathBuf,
        /// The known extensions, each with its format.
        known: &'static str,
    },
    /// A pixel has a value that the format cannot hold.
    #[error(
        "cannot write {}: the pixel at column {x}, row {y} is {}, but {allowed}",
        path.display(),
        *value as f32
    )]
    Unrepresentable {
        /// The file.
        path: PathBuf,
        /// Column of the pixel.
        x: usize,
        /// Row of the pixel.
        y: usize,
        /// Its value.
        value: f64,
        /// What the format can hold, and the remedy.
        allowed: &'static str,
    },
    /// A text (an option's value) cannot be understood.
    #[error("`{text}` is not {what}: {allowed}")]
    Text {
        /// The text.
        text: String,
        /// What it should be.
        what: &'static str,
        /// What is allowed.
        allowed: String,
    },
}

/// The offset as a part of a sentence.
fn at(offset: Option<u64>) -> String {
    offset.map(|byte| format!(", near byte {byte}")).unwrap_or_default()
}

/// The extension as a part of a sentence.
fn extension_of(path: &Path) -> String {
    match path.extension() {
        Some(extension) => format!("its extension `.{}`", extension.display()),
        None => "its name, which has no extension".to_owned(),
    }
}

/// The file of an error, borrowed as the error is.
macro_rules! file_of {
    ($error:expr) => {
        match $error {
            FormatError::Read { path, .. }
            | FormatError::Write { path, .. }
            | FormatError::Malformed { path, .. }
            | FormatError::TooLarge { path, .. }
            | FormatError::WrongKind { path, .. }
            | FormatError::UnknownExtension { path, .. }
            | FormatError::Unrepresentable { path, .. } => Some(path),
            FormatError::Text { .. } => None,
        }
    };
}

/// What the system said, behind what to do about a folder: errors end with the words of their cause.
fn why(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::IsADirectory => format!("it is a folder, name a file in it: {error}"),
        _ => error.to_string(),
    }
}

impl FormatError {
    /// The file that the error is about, if it is about a file.
    pub fn path(&self) -> Option<&Path> {
        file_of!(self).map(PathBuf::as_path)
    }

    /// Nothing is written of what has no pixels; `subject` is that with its verb.
    pub(crate) fn no_pixels(path: &Path, subject: &str) -> Self {
        let problem = format!("{subject} no pixels: at least 1 x 1 is needed");
        Self::Write { path: path.to_owned(), problem, os_error: None, source: None }
    }

    /// The same error about another file: the one that was meant, where a passing one was written.
    pub(crate) fn about(mut self, file: &Path) -> Self {
        if let Some(path) = file_of!(&mut self) {
            *path = file.to_owned();
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_the_file_the_place_and_the_remedy() {
        let error = FormatError::Malformed {
            path: "left.png".into(),
            format: "PNG",
            offset: Some(33),
            problem: "the file ends inside a row".into(),
        };
        assert_eq!(
            error.to_string(),
            "left.png is damaged (PNG, near byte 33): the file ends inside a row"
        );
        let error = FormatError::UnknownExtension { path: "d.exr".into(), known: ".pfm, .npy" };
        assert_eq!(
            error.to_string(),
            "cannot tell the format of d.exr from its extension `.exr`: use one of .pfm, .npy"
        );
        assert_eq!(error.path(), Some(Path::new("d.exr")));
        let error = FormatError::UnknownExtension { path: "d".into(), known: ".pfm" };
        assert!(error.to_string().contains("no extension"));
    }
}
