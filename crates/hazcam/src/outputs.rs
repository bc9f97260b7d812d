//! The files that a command writes: tried before the work begins, written after it, all or none.

use std::path::{Path, PathBuf};

use anyhow::bail;
use formats::{FormatError, Writer, destination};

/// A file to write.
pub struct Output<'a> {
    /// The option that asked for it.
    pub option: &'static str,
    /// Where it goes.
    pub path: PathBuf,
    /// Writes it to a path of the same name.
    pub write: Box<Writer<'a>>,
}

impl<'a> Output<'a> {
    /// The file that an option asked for.
    pub fn new(
        option: &'static str,
        path: impl Into<PathBuf>,
        write: impl Fn(&Path) -> Result<(), FormatError> + 'a,
    ) -> Self {
        Self { option, path: path.into(), write: Box::new(write) }
    }

    /// A text that an option asked for.
    pub fn text(option: &'static str, path: impl Into<PathBuf>, text: &'a str) -> Self {
        Self::new(option, path, move |path| {
            formats::write_atomically(path, |file| file.write_all(text.as_bytes()))
        })
    }
}

/// Errors when a file would replace an input or another output, when its extension is unknown, or
/// when its folder cannot be written. What is written for it may be as small as one likes, but must
/// be of the kind that will be written in the end. Leaves nothing behind.
pub fn check(outputs: &[Output<'_>], inputs: &[&Path]) -> anyhow::Result<()> {
    let inputs: Vec<_> = inputs.iter().map(|input| place(input)).collect();
    let mut before: Vec<(&str, PathBuf)> = Vec::new();
    for Output { option, path, .. } in outputs {
        let place = place(path);
        if inputs.contains(&place) {
            bail!("{option} {} would replace an input: name another file", path.display());
        }
        if let Some((other, _)) = before.iter().find(|(_, other)| *other == place) {
            bail!("{other} and {option} both name {}: name two files", path.display());
        }
        before.push((option, place));
    }
    for Output { path, write, .. } in outputs {
        formats::try_to_write(path, write)?;
    }
    Ok(())
}

/// Whether a file lies, or would lie, in a folder or below it.
pub fn lies_in(file: &Path, folder: &Path) -> bool {
    let places = destination(file).ok().zip(folder.canonicalize().ok());
    folder.is_dir() && places.is_some_and(|(file, folder)| file.starts_with(folder))
}

/// Writes all files, or leaves everything as it was.
pub fn write_all_or_none(outputs: &[Output<'_>]) -> Result<(), FormatError> {
    formats::write_all_or_none(outputs.iter().map(|output| (&*output.path, &*output.write)))
}

/// What is the same for two spellings of one file. Where there is no folder, the spelling has to do.
fn place(path: &Path) -> PathBuf {
    destination(path).unwrap_or_else(|_| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn output<'a>(option: &'static str, path: PathBuf) -> Output<'a> {
        Output::new(option, path, |path| {
            formats::write_atomically(path, |file| file.write_all(b"new"))
        })
    }

    #[test]
    fn one_file_under_two_spellings_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("deep")).unwrap();
        let at = |name: &str| folder.path().join(name);
        let check = |names: [&str; 2], input: &str| {
            let outputs = [output("--output", at(names[0])), output("--preview", at(names[1]))];
            check(&outputs, &[&at(input)]).map_err(|error| error.to_string())
        };
        check(["a", "b"], "in").unwrap();
        let error = check(["a", "deep/../a"], "in").unwrap_err();
        assert!(error.starts_with("--output and --preview both name"), "{error}");
        let error = check(["a", "deep/../b"], "b").unwrap_err();
        assert!(error.contains("would replace an input"), "{error}");
        #[cfg(unix)]
        {
            // A link to what is not there yet is followed when it is written.
            std::os::unix::fs::symlink("a", at("link")).unwrap();
            let error = check(["a", "link"], "in").unwrap_err();
            assert!(error.starts_with("--output and --preview both name"), "{error}");
        }
        assert!(!at("a").exists() && !at("b").exists());
    }

    #[test]
    fn a_file_that_cannot_be_written_leaves_the_others_as_they_were() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "old").unwrap();
        let outputs = [output("--output", path.clone()), output("--preview", path.join("b"))];
        write_all_or_none(&outputs).unwrap_err();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        write_all_or_none(&outputs[..1]).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }
}
