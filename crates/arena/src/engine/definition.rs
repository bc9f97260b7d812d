//! What an engine is: a few lines of TOML.
//!
//! ```toml
//! name = "mine"                       # lower case letters, digits, `.`, `-`, `_`
//! description = "My matcher, 9 x 9 census"
//! kind = "protocol"                   # or "robust-vision"; "protocol" unless stated
//! command = ["{folder}/mine", "--window", "9"]
//!
//! [environment]                       # optional
//! MINE_TABLES = "{folder}/tables"
//! ```
//! `{folder}` stands for the folder of the definition, `{python}` for Python 3 and `{hazcam}` for
//! this program. The built-in definitions lie in the crate's folder `engines`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// Which convention a program follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// One process for many jobs (`PROTOCOL.md`).
    #[default]
    Protocol,
    /// One process per pair: `METHOD im0.png im1.png NDISP OUTDIR`.
    RobustVision,
}

/// An engine, as defined by a TOML file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Definition {
    /// What it is called in tables, files and on the command line.
    pub name: String,
    /// What it is, in one line.
    #[serde(default)]
    pub description: String,
    /// Which convention it follows.
    #[serde(default)]
    pub kind: Kind,
    /// Program and arguments.
    pub command: Vec<String>,
    /// Variables added to its environment.
    #[serde(default)]
    pub environment: BTreeMap<String, String>,
    /// The folder that `{folder}` stands for; `None` for a built-in engine, whose files are laid
    /// out in its scratch folder.
    #[serde(skip)]
    pub folder: Option<PathBuf>,
}

/// A definition that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DefinitionError {
    /// The file or folder cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is no definition.
    #[error("{origin} defines no engine: {problem}")]
    Invalid {
        /// The file.
        origin: String,
        /// What is wrong, and what is allowed.
        problem: String,
    },
    /// Two files of a folder define engines of one name.
    #[error("{} and {} both define `{name}`: give each its own name", one.display(), other.display())]
    SameName {
        /// The name.
        name: String,
        /// One of them.
        one: PathBuf,
        /// The other one.
        other: PathBuf,
    },
    /// A file defines an engine that would be taken for one of those that come along.
    #[error("{} defines `{name}`, which is an engine that comes with hazcam: give it a name of its own", path.display())]
    Taken {
        /// The name.
        name: String,
        /// The file.
        path: PathBuf,
    },
    /// No engine has this name.
    #[error("there is no engine `{name}`; there are {known}")]
    Unknown {
        /// The name asked for.
        name: String,
        /// All known names.
        known: String,
    },
}

impl Definition {
    /// Reads a definition from a TOML file.
    pub fn read(path: &Path) -> Result<Self, DefinitionError> {
        let failed = |source| DefinitionError::Read { path: path.to_owned(), source };
        let text = fs::read_to_string(path).map_err(failed)?;
        let mut definition = Self::parse(&text, &path.display().to_string())?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        definition.folder =
            Some(fs::canonicalize(folder.unwrap_or(Path::new("."))).map_err(failed)?);
        Ok(definition)
    }

    /// Reads a definition from a text; `origin` names it in errors.
    pub fn parse(text: &str, origin: &str) -> Result<Self, DefinitionError> {
        let invalid = |problem: String| DefinitionError::Invalid { origin: origin.into(), problem };
        let definition: Self =
            toml::from_str(text).map_err(|error| invalid(error.to_string().trim_end().into()))?;
        let name_is_plain =
            |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || ".-_".contains(c);
        if definition.name.is_empty()
            || definition.name.starts_with('.')
            || !definition.name.chars().all(name_is_plain)
        {
            return Err(invalid(format!(
                "the name `{}` must consist of lower case letters, digits, `-`, `_` and `.`, and \
                 not begin with a dot",
                definition.name
            )));
        }
        let name = definition.name.as_str();
        if OTHERS.contains(&name) || name.ends_with("-error") {
            return Err(invalid(format!(
                "the name `{name}` is that of another picture beside those of engines: {} and what \
                 ends in `-error` cannot be names",
                OTHERS.join(", ")
            )));
        }
        if definition.command.first().is_none_or(String::is_empty) {
            return Err(invalid("`command` must name a program".into()));
        }
        Ok(definition)
    }
}

/// Pictures of a scene lie beside those of engines, which are called as these are.
const OTHERS: [&str; 5] = ["left", "truth", "im0", "im1", "mask0nocc"];

/// The embedded definitions, in the order of tables.
const BUILT_IN: &[(&str, &str)] = &[
    ("fast.toml", include_str!("../../engines/fast.toml")),
    ("balanced.toml", include_str!("../../engines/balanced.toml")),
    ("best.toml", include_str!("../../engines/best.toml")),
    ("opencv-bm.toml", include_str!("../../engines/opencv-bm.toml")),
    ("opencv-bm-9x9.toml", include_str!("../../engines/opencv-bm-9x9.toml")),
    ("opencv-sgbm.toml", include_str!("../../engines/opencv-sgbm.toml")),
    ("opencv-3way.toml", include_str!("../../engines/opencv-3way.toml")),
    ("opencv-hh.toml", include_str!("../../engines/opencv-hh.toml")),
    ("opencv-3way-1x1.toml", include_str!("../../engines/opencv-3way-1x1.toml")),
    ("opencv-wls.toml", include_str!("../../engines/opencv-wls.toml")),
];

/// The files that built-in engines need beside them.
pub(crate) const BUILT_IN_FILES: &[(&str, &str)] =
    &[("opencv_engine.py", include_str!("../../engines/opencv_engine.py"))];

/// All known engines.
#[derive(Debug, Clone, Default)]
pub struct Engines {
    definitions: Vec<Definition>,
}

impl Engines {
    /// The built-in ones: hazcam's presets and OpenCV's matchers.
    pub fn built_in() -> Self {
        let definitions = BUILT_IN
            .iter()
            .map(|(file, text)| Definition::parse(text, file))
            .collect::<Result<_, _>>()
            .expect("the embedded definitions are tested");
        Self { definitions }
    }

    /// Adds every `.toml` file of a folder, by name. The name of a known engine, and two of one name, are errors: tables
    /// would say one thing and mean another.
    pub fn add_folder(&mut self, folder: &Path) -> Result<(), DefinitionError> {
        let failed = |source| DefinitionError::Read { path: folder.to_owned(), source };
        let mut files = Vec::new();
        for entry in fs::read_dir(folder).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            if path.extension().is_some_and(|extension| extension == "toml") {
                files.push(path);
            }
        }
        files.sort();
        let mut added: Vec<(PathBuf, Definition)> = Vec::new();
        for file in files {
            let definition = Definition::read(&file)?;
            let name = definition.name.clone();
            if let Some((one, _)) = added.iter().find(|(_, other)| other.name == name) {
                return Err(DefinitionError::SameName { name, one: one.clone(), other: file });
            }
            if self.iter().any(|known| known.name == name) {
                return Err(DefinitionError::Taken { name, path: file });
            }
            added.push((file, definition));
        }
        self.definitions.extend(added.into_iter().map(|(_, definition)| definition));
        Ok(())
    }

    /// The engine of this name.
    pub fn named(&self, name: &str) -> Result<&Definition, DefinitionError> {
        self.iter().find(|known| known.name == name).ok_or_else(|| DefinitionError::Unknown {
            name: name.into(),
            known: self.iter().map(|known| known.name.as_str()).collect::<Vec<_>>().join(", "),
        })
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &Definition> {
        self.definitions.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_embedded_definition_is_sound_and_named_as_its_file() {
        let engines = Engines::built_in();
        assert_eq!(engines.iter().count(), BUILT_IN.len());
        for ((file, _), definition) in BUILT_IN.iter().zip(engines.iter()) {
            assert_eq!(*file, format!("{}.toml", definition.name));
            assert!(!definition.description.is_empty());
        }
    }

    #[test]
    fn a_folder_adds_and_replaces_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("mine.toml");
        fs::write(&file, "name = 'mine'\nkind = 'robust-vision'\ncommand = ['{folder}/m']")
            .unwrap();
        fs::write(folder.path().join("readme.md"), "not a definition").unwrap();
        let mut engines = Engines::built_in();
        engines.add_folder(folder.path()).unwrap();
        assert_eq!(engines.iter().count(), BUILT_IN.len() + 1);
        let mine = engines.named("mine").unwrap();
        assert_eq!(mine.kind, Kind::RobustVision);
        assert_eq!(mine.folder, Some(fs::canonicalize(folder.path()).unwrap()));
        let error = engines.named("nine").unwrap_err().to_string();
        assert!(error.contains("`nine`") && error.ends_with("opencv-wls, mine"), "{error}");
        fs::write(folder.path().join("z.toml"), "name = 'fast'\ncommand = ['true']").unwrap();
        let error = Engines::built_in().add_folder(folder.path()).unwrap_err().to_string();
        assert!(error.contains("z.toml defines `fast`"), "{error}");
    }

    #[test]
    fn what_is_wrong_with_a_definition_is_said() {
        for (text, words) in [
            ("command = ['x']", "missing field `name`"),
            ("name = 'x'", "missing field `command`"),
            ("name = 'x'\ncommand = []", "must name a program"),
            ("name = '../x'\ncommand = ['x']", "`../x` must consist of"),
            ("name = 'truth'\ncommand = ['x']", "that of another picture"),
            ("name = 'im1'\ncommand = ['x']", "that of another picture"),
            ("name = 'x-error'\ncommand = ['x']", "that of another picture"),
            ("name = 'x'\ncommand = ['x']\ncolour = true", "unknown field `colour`"),
            ("name = 'x'\ncommand = ['x']\nkind = 'magic'", "unknown variant `magic`"),
        ] {
            let error = Definition::parse(text, "x.toml").unwrap_err().to_string();
            assert!(error.starts_with("x.toml") && error.contains(words), "{error}");
        }
    }
}
