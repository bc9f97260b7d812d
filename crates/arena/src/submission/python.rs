//! The Python that runs submissions, and where it keeps its files.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde::Deserialize;

use super::error::SubmissionError;
use crate::engine::from_here;

/// Prints what has to be readable for Python to work, as JSON.
const ASK: &str = "\
import json, site, sys
print(json.dumps({
    'executable': sys.executable,
    'version': sys.version.split()[0],
    'paths': [p for p in [sys.prefix, sys.base_prefix, sys.exec_prefix] + sys.path if p],
    'user_base': site.getuserbase(),
    'new_enough': sys.version_info >= (3, 8),
}))
";

/// An interpreter that can run submissions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Python {
    /// Its full path.
    pub executable: PathBuf,
    /// Its version, such as `3.11.7`.
    pub version: String,
    /// Files and folders that it reads: its libraries and installed packages.
    paths: Vec<PathBuf>,
    /// Where packages are that its user installed without being root.
    user_base: PathBuf,
}

#[derive(Deserialize)]
struct Told {
    executable: PathBuf,
    version: String,
    paths: Vec<PathBuf>,
    user_base: PathBuf,
    new_enough: bool,
}

impl Python {
    /// Asks the interpreter `program` (`python3` unless somebody knows better) about itself.
    pub fn find(program: &Path) -> Result<Self, SubmissionError> {
        let shown = program.display();
        let remedy = "install Python 3.8 or newer with numpy and scipy, or name it with --python";
        let output = Command::new(from_here(program))
            .args(["-B", "-c", ASK])
            // Not from a folder in which a module of that name may lie.
            .current_dir("/")
            .env_remove("PYTHONPATH")
            .env_remove("PYTHONHOME")
            .stdin(Stdio::null())
            .output()
            .map_err(|error| {
                SubmissionError::Python(format!("{shown} cannot be started ({error}): {remedy}"))
            })?;
        let told: Told = match serde_json::from_slice(&output.stdout) {
            Ok(told) if output.status.success() => told,
            _ => {
                let problem = format!("{shown} does not work as a Python interpreter: {remedy}");
                return Err(SubmissionError::Python(problem));
            }
        };
        if !told.new_enough {
            let problem = format!("{shown} is Python {}, which is too old: {remedy}", told.version);
            return Err(SubmissionError::Python(problem));
        }
        let mut paths: Vec<PathBuf> = told.paths.into_iter().filter(|path| path.exists()).collect();
        // What the executable is a link to, and, in a virtual environment, what it links through.
        paths.extend(told.executable.canonicalize());
        paths.push(told.executable.clone());
        paths.sort();
        paths.dedup();
        let Told { executable, version, user_base, .. } = told;
        Ok(Self { executable, version, paths, user_base })
    }

    /// A command that starts it, in which packages that its user installed are found although the
    /// home will be another one.
    pub(super) fn command(&self) -> Command {
        let mut command = Command::new(&self.executable);
        command.env("PYTHONUSERBASE", &self.user_base);
        command
    }

    /// Files and folders that it must be able to read.
    pub fn paths(&self) -> &[PathBuf] {
        &self.paths
    }
}
