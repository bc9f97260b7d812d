//! Files appear whole or not at all: written beside their place, then renamed into it.
//!
//! This guards against errors half-way, a full disk, and a process that is killed. It does not
//! call `fsync`: after a power failure a file may be the old one, the new one, or empty, as the
//! file system decides.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::FormatError;

/// Writes a file so that nobody ever sees a part of it.
///
/// `content` writes to a temporary file in the same folder, which takes the place of `path` when
/// all went well and is removed otherwise. A symbolic link is followed. What is not a regular file
/// (`/dev/stdout`, a pipe) cannot be renamed into place and is written directly.
///
/// Errors: [`FormatError::Write`] when the folder is missing or not writable, `path` is a folder,
/// or `content` fails.
pub fn write_atomically(
    path: impl AsRef<Path>,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FormatError> {
    let path = path.as_ref();
    let failed = |error: io::Error| {
        let (problem, source) = match explain(path, &error) {
            // The system's own words are about the temporary file.
            Some(problem) => (problem, None),
            None => (error.to_string(), Some(error)),
        };
        FormatError::Write { path: path.to_owned(), problem, source }
    };
    let target = match fs::metadata(path) {
        Ok(found) if found.is_dir() => {
            return Err(FormatError::Write {
                path: path.to_owned(),
                problem: "it is a folder; name a file in it".to_owned(),
                source: None,
            });
        }
        Ok(found) if found.is_file() => fs::canonicalize(path).map_err(failed)?,
        Ok(_) => {
            let file = fs::OpenOptions::new().write(true).open(path).map_err(failed)?;
            return write_through(file, content).map(drop).map_err(failed);
        }
        Err(_) => path.to_owned(),
    };
    let temporary = create_beside(&target).map_err(failed)?;
    let (file, temporary) = temporary.into_parts();
    drop(write_through(file, content).map_err(failed)?);
    temporary.persist(&target).map_err(|e| failed(e.error))
}

/// A temporary file in the folder of `target`, with the rights that any new file gets.
fn create_beside(target: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".hazcam-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder_of(target))
}

fn write_through(
    file: fs::File,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<fs::File> {
    let mut writer = BufWriter::new(file);
    content(&mut writer)?;
    writer.into_inner().map_err(|e| e.into_error())
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Says which folder is at fault, if one is.
fn explain(path: &Path, error: &io::Error) -> Option<String> {
    let folder = folder_of(path);
    if path.file_name().is_none() {
        Some("it names no file".to_owned())
    } else if !folder.exists() {
        Some(format!("the folder {} does not exist; create it first", folder.display()))
    } else if !folder.is_dir() {
        Some(format!("{} is not a folder", folder.display()))
    } else if error.kind() == io::ErrorKind::PermissionDenied {
        Some(format!("no permission to write in {}", folder.display()))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_failure_half_way_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_atomically(&path, |w| w.write_all(b"old")).unwrap();
        let error = write_atomically(&path, |w| {
            w.write_all(&[b'x'; 100_000])?;
            Err(io::Error::other("the disk is on fire"))
        })
        .unwrap_err();
        assert!(error.to_string().contains("the disk is on fire"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_missing_folder_and_a_folder_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_atomically(folder.path().join("no/a.txt"), |_| Ok(())).unwrap_err();
        assert!(error.to_string().ends_with("no does not exist; create it first"), "{error}");
        let error = write_atomically(folder.path(), |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("it is a folder"), "{error}");
        let file = folder.path().join("file");
        write_atomically(&file, |_| Ok(())).unwrap();
        let error = write_atomically(file.join("a.txt"), |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("is not a folder"), "{error}");
        assert_eq!(names(folder.path()), ["file"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let (target, link) = (folder.path().join("target"), folder.path().join("link"));
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        write_atomically(&link, |w| w.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        write_atomically("/dev/null", |w| w.write_all(b"gone")).unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }

    #[cfg(unix)]
    #[test]
    fn a_new_file_has_the_rights_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        write_atomically(&ours, |_| Ok(())).unwrap();
        fs::write(&plain, "").unwrap();
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }
}
