//! What goes wrong, as the exceptions of `hazcam.errors`.

use std::fmt::Display;
use std::io;

use camera::CameraError;
use formats::FormatError;
use matching::MatchError;
use pyo3::prelude::*;
use score::ScoreError;

pyo3::import_exception!(hazcam.errors, HazcamError);
pyo3::import_exception!(hazcam.errors, ArgumentError);
pyo3::import_exception!(hazcam.errors, ArgumentTypeError);
pyo3::import_exception!(hazcam.errors, FrameMemoryError);
pyo3::import_exception!(hazcam.errors, FileAccessError);
pyo3::import_exception!(hazcam.errors, MissingFileError);
pyo3::import_exception!(hazcam.errors, FileContentError);

/// An argument that is of the right kind but has a value that is not allowed.
pub fn wrong_value(name: &str, value: impl Display, allowed: impl Display) -> PyErr {
    ArgumentError::new_err(format!("`{name}` is {value}, but {allowed}"))
}

/// An argument that is of the wrong kind.
pub fn wrong_type(name: &str, value: impl Display, allowed: impl Display) -> PyErr {
    ArgumentTypeError::new_err(format!("`{name}` is {value}, but {allowed}"))
}

/// What an option of the command line is called in Python.
fn name_in_python(option: &str) -> String {
    match option {
        "matcher" => "preset".into(),
        other => other.replace('-', "_"),
    }
}

/// A matcher that cannot be built, or cannot answer.
pub fn of_matching(error: MatchError) -> PyErr {
    match error {
        MatchError::Option { field, value, allowed } => {
            wrong_value(&name_in_python(field), value, allowed)
        }
        MatchError::Memory { .. } | MatchError::MachineMemory { .. } => {
            FrameMemoryError::new_err(error.to_string())
        }
        MatchError::Bounds(error) => about("box", error),
        other => ArgumentError::new_err(other.to_string()),
    }
}

/// What is wrong with an argument, in words that do not name it.
pub fn about(name: &str, problem: impl Display) -> PyErr {
    ArgumentError::new_err(format!("`{name}`: {problem}"))
}

/// A map that cannot be scored.
pub fn of_scoring(error: ScoreError) -> PyErr {
    match error {
        ScoreError::Parameter { field, value, allowed } => {
            wrong_value(&name_in_python(field), value, allowed)
        }
        other => ArgumentError::new_err(other.to_string()),
    }
}

/// A camera that is none.
pub fn of_camera(error: CameraError) -> PyErr {
    let names = [("focal", "focal_px"), ("baseline", "baseline_m"), ("offset", "doffs")];
    let names = [&names[..], &[("principal column", "cx"), ("principal row", "cy")]].concat();
    match names.into_iter().find(|(words, _)| error.field.starts_with(words)) {
        Some((_, name)) => about(name, error),
        None => ArgumentError::new_err(error.to_string()),
    }
}

/// A file that cannot be read or written.
pub fn of_file(error: FormatError) -> PyErr {
    let message = error.to_string();
    match error {
        FormatError::Read { path, source } if source.kind() == io::ErrorKind::NotFound => {
            MissingFileError::new_err((source.raw_os_error(), message, path.into_os_string()))
        }
        FormatError::Read { path, source } => {
            FileAccessError::new_err((source.raw_os_error(), message, path.into_os_string()))
        }
        FormatError::Write { path, os_error, .. } => {
            let kind = os_error.map(|number| io::Error::from_raw_os_error(number).kind());
            let about = (os_error, message, path.into_os_string());
            match kind {
                Some(io::ErrorKind::NotFound) => MissingFileError::new_err(about),
                _ => FileAccessError::new_err(about),
            }
        }
        FormatError::Malformed { .. }
        | FormatError::TooLarge { .. }
        | FormatError::WrongKind { .. } => FileContentError::new_err(message),
        // What was asked for cannot be done, whatever the files.
        _ => ArgumentError::new_err(message),
    }
}
