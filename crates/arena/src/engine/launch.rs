//! From a definition to a command that can be started.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use super::Status;
use super::definition::{BUILT_IN_FILES, Definition};

/// Variables by which numerical libraries learn how many threads they may use.
pub(crate) const THREAD_VARIABLES: [&str; 8] = [
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "BLIS_NUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "RAYON_NUM_THREADS",
];

/// The programs that definitions may refer to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Programs {
    /// `{hazcam}`: the program that serves hazcam's own presets.
    pub hazcam: PathBuf,
    /// `{python}`: Python 3, if there is one.
    pub python: Option<PathBuf>,
}

impl Programs {
    /// Looks for Python: the variable `HAZCAM_PYTHON`, else `python3` or `python` on `PATH`.
    pub fn find(hazcam: PathBuf) -> Self {
        Self { hazcam, python: Self::find_python() }
    }

    /// The Python that [`Programs::find`] finds.
    pub fn find_python() -> Option<PathBuf> {
        let named = env::var_os("HAZCAM_PYTHON").filter(|name| !name.is_empty()).map(PathBuf::from);
        // Engines start in other folders.
        named
            .map(|named| from_here(&named))
            .or_else(|| ["python3", "python"].into_iter().find_map(on_path))
    }

    /// What is said where there is none.
    pub const NO_PYTHON: &str =
        "neither python3 nor python is on PATH, and HAZCAM_PYTHON names none";
}

/// Where a program is started from any folder: a name alone is looked for on PATH, anything else from this folder.
pub(crate) fn from_here(program: &Path) -> PathBuf {
    match program.components().count() {
        1 => program.to_owned(),
        _ => std::path::absolute(program).unwrap_or_else(|_| program.to_owned()),
    }
}

/// The first program of this name on `PATH`.
fn on_path(name: &str) -> Option<PathBuf> {
    let name = format!("{name}{}", env::consts::EXE_SUFFIX);
    env::split_paths(&env::var_os("PATH")?).map(|folder| folder.join(&name)).find(|p| p.is_file())
}

/// The command of an engine whose scratch folder is this.
pub(crate) fn command(
    definition: &Definition,
    programs: &Programs,
    scratch: &Path,
    threads: usize,
) -> Result<Command, Status> {
    let folder = match &definition.folder {
        Some(folder) => folder.clone(),
        None => lay_out_built_in_files(scratch)?,
    };
    let expand = |text: &String| -> Result<String, Status> {
        let mut text = text.clone();
        if text.contains("{python}") {
            let python = programs.python.as_ref().ok_or_else(|| Status::Absent {
                message: format!("Python is not installed: {}", Programs::NO_PYTHON),
            })?;
            // A name alone is looked for on PATH.
            if python.components().count() > 1 && !python.is_file() {
                let message = format!(
                    "{} is no program: name a Python 3 by HAZCAM_PYTHON, or unset it for the one on PATH",
                    python.display()
                );
                return Err(Status::NotReady { message });
            }
            text = text.replace("{python}", &python.to_string_lossy());
        }
        Ok(text
            .replace("{hazcam}", &programs.hazcam.to_string_lossy())
            .replace("{folder}", &folder.to_string_lossy()))
    };
    let words = definition.command.iter().map(expand).collect::<Result<Vec<_>, _>>()?;
    let Some((program, arguments)) = words.split_first() else {
        return Err(Status::NotReady { message: "its definition names no program".into() });
    };
    let mut command = Command::new(program);
    command.args(arguments);
    for variable in THREAD_VARIABLES {
        command.env(variable, threads.to_string());
    }
    for (name, value) in &definition.environment {
        command.env(name, expand(value)?);
    }
    Ok(command)
}

/// Puts the files of the built-in engines into the scratch folder, which is then `{folder}`.
fn lay_out_built_in_files(scratch: &Path) -> Result<PathBuf, Status> {
    for (name, text) in BUILT_IN_FILES {
        let path = scratch.join(name);
        fs::write(&path, text).map_err(|error| Status::NotAsked {
            message: format!("{} cannot be written: {error}", path.display()),
        })?;
    }
    Ok(scratch.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn definition(text: &str) -> Definition {
        Definition::parse(text, "test").unwrap()
    }

    #[test]
    fn placeholders_and_threads_are_filled_in() {
        let scratch = tempfile::tempdir().unwrap();
        let python = scratch.path().join("py");
        fs::write(&python, "").unwrap();
        let programs = Programs { hazcam: "/bin/hazcam".into(), python: Some(python.clone()) };
        let mut mine = definition(
            "name = 'm'\ncommand = ['{python}', '{folder}/m.py', '{hazcam}']\n\
             [environment]\nTABLES = '{folder}/t'",
        );
        mine.folder = Some("/mine".into());
        let command = command(&mine, &programs, scratch.path(), 3).unwrap();
        assert_eq!(command.get_program(), python);
        assert_eq!(command.get_args().collect::<Vec<_>>(), ["/mine/m.py", "/bin/hazcam"]);
        let set = |name: &str| {
            command.get_envs().find(|(n, _)| *n == name).and_then(|(_, value)| value).unwrap()
        };
        assert_eq!((set("TABLES"), set("OMP_NUM_THREADS")), ("/mine/t".as_ref(), "3".as_ref()));
    }

    #[test]
    fn a_python_that_is_not_there_is_named() {
        let scratch = tempfile::tempdir().unwrap();
        let programs = Programs { hazcam: "/bin/hazcam".into(), python: Some("/no/python".into()) };
        let mine = definition("name = 'm'\ncommand = ['{python}', 'm.py']");
        let status = command(&mine, &programs, scratch.path(), 1).unwrap_err().to_string();
        assert!(status.contains("/no/python is no program") && status.contains("HAZCAM_PYTHON"));
    }

    #[test]
    fn without_python_its_engines_are_absent() {
        let scratch = tempfile::tempdir().unwrap();
        let programs = Programs { hazcam: "/bin/hazcam".into(), python: None };
        let mine = definition("name = 'm'\ncommand = ['{python}', '{folder}/opencv_engine.py']");
        let status = command(&mine, &programs, scratch.path(), 1).unwrap_err();
        assert!(matches!(status, Status::Absent { .. }), "{status}");
        assert!(scratch.path().join("opencv_engine.py").exists());
    }
}
