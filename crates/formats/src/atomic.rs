//! Files appear whole or not at all: written beside their place, then renamed into it.
//!
//! This guards against errors half-way, a full disk, and a process that ends: what is passing then goes if
//! somebody calls [`remove_passing_files`](crate::remove_passing_files), as the command does for signals. It does not
//! call `fsync`: after a power failure a file may be the old one, the new one, or empty, as the
//! file system decides.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::FormatError;
use crate::passing::{PREFIX, PassingFile};

/// Writes a file so that nobody ever sees a part of it.
///
/// `content` writes to a temporary file in the same folder, which takes the place of `path` when
/// all went well and is removed otherwise. A symbolic link is followed, also one to a file that is
/// yet to be made; a file that was there hands on its permissions. What is not a regular file
/// (`/dev/stdout`, a pipe) cannot be renamed into place and is written directly.
///
/// Errors: [`FormatError::Write`] when the folder is missing or not writable, `path` is a folder or a
/// write-protected file, or `content` fails.
pub fn write_atomically(
    path: impl AsRef<Path>,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FormatError> {
    let path = path.as_ref();
    let failed = |error| failed(path, error);
    let Place { target, permissions } = match Place::of(path)? {
        Some(place) => place,
        None => {
            let file = fs::OpenOptions::new().write(true).open(path).map_err(failed)?;
            return write_through(file, content).map(drop).map_err(failed);
        }
    };
    let (file, passing) = PassingFile::beside(&target).map_err(failed)?;
    if let Some(permissions) = permissions {
        file.set_permissions(permissions).map_err(failed)?;
    }
    drop(write_through(file, content).map_err(failed)?);
    passing.put_in_place(&target).map_err(failed)
}

/// Where a file goes that is renamed into its place.
pub(crate) struct Place {
    /// Its path behind all links.
    pub target: PathBuf,
    /// Those of the file that is there now.
    pub permissions: Option<fs::Permissions>,
}

impl Place {
    /// The place that `path` names, `None` for what cannot be replaced, such as a pipe.
    pub fn of(path: &Path) -> Result<Option<Self>, FormatError> {
        let refused = |problem: &str| {
            let (path, problem) = (path.to_owned(), problem.to_owned());
            Err(FormatError::Write { path, problem, os_error: None, source: None })
        };
        let permissions = match fs::metadata(path) {
            Ok(found) if found.is_dir() => return refused("it is a folder; name a file in it"),
            // To rename a file into its place would not ask.
            Ok(found) if found.is_file() && is_protected(path, &found) => {
                return refused("it is write-protected; make it writable, or name another file");
            }
            Ok(found) if found.is_file() => Some(found.permissions()),
            Ok(_) => return Ok(None),
            Err(_) => None,
        };
        let target = destination(path).map_err(|error| failed(path, error))?;
        Ok(Some(Self { target, permissions }))
    }
}

/// Whether a file must not be written, by anybody or by whoever runs this.
fn is_protected(path: &Path, found: &fs::Metadata) -> bool {
    let opened = fs::OpenOptions::new().write(true).open(path);
    let is_denied = opened.is_err_and(|error| error.kind() == io::ErrorKind::PermissionDenied);
    found.permissions().readonly() || is_denied
}

/// The path of the file that writing to `path` makes or replaces: its folder without links and
/// `..`, and the last name behind all links, also where there is no such file yet.
///
/// Errors when the folder does not exist, `path` names no file, or links go round in a circle.
pub fn destination(path: &Path) -> io::Result<PathBuf> {
    if let Ok(found) = fs::canonicalize(path) {
        return Ok(found);
    }
    in_its_folder(&behind_links(path)?)
}

/// What the last of all links names.
///
/// Errors when links go round in a circle.
fn behind_links(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&path) {
            Ok(next) => path = folder_of(&path).join(next),
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other(format!("more than {MOST_LINKS} links, one to the other")))
}

/// The path of a file by its folder without links and `..`; the file itself may be a link, or not be there.
///
/// Errors when the folder does not exist or `path` names no file.
pub(crate) fn in_its_folder(path: &Path) -> io::Result<PathBuf> {
    let name = path.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    Ok(fs::canonicalize(folder_of(path))?.join(name))
}

/// As many links as Linux follows.
const MOST_LINKS: usize = 40;

/// The error in words about `path`: the system's own are about the temporary file.
pub(crate) fn failed(path: &Path, error: io::Error) -> FormatError {
    let os_error = number_of(&error);
    let (problem, source) = match explain(path, &error) {
        Some(problem) => (problem, None),
        None => {
            let error = without_path(error);
            (error.to_string(), Some(error))
        }
    };
    FormatError::Write { path: path.to_owned(), problem, os_error, source }
}

/// The system's number for an error, also of one about a temporary file.
fn number_of(error: &io::Error) -> Option<i32> {
    let within = || error.get_ref()?.source()?.downcast_ref::<io::Error>()?.raw_os_error();
    error.raw_os_error().or_else(within)
}

/// What the system said, where a temporary file's path was put behind it: nobody has heard of that.
fn without_path(error: io::Error) -> io::Error {
    let text = error.to_string();
    match text.split_once(" at path ") {
        Some((said, path)) if path.contains(PREFIX) => io::Error::new(error.kind(), said),
        _ => error,
    }
}

fn write_through(
    file: fs::File,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<fs::File> {
    let mut writer = BufWriter::new(file);
    content(&mut writer)?;
    writer.into_inner().map_err(|e| e.into_error())
}

pub(crate) fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Says which folder is at fault, if one is: that of the file behind all links.
fn explain(path: &Path, error: &io::Error) -> Option<String> {
    let path = behind_links(path).ok()?;
    let folder = folder_of(&path);
    if path.file_name().is_none() {
        Some("it names no file".to_owned())
    } else if !folder.exists() {
        Some(format!("the folder {} does not exist; create it first", folder.display()))
    } else if !folder.is_dir() {
        Some(format!("{} is not a folder", folder.display()))
    } else {
        let why = match error.kind() {
            io::ErrorKind::PermissionDenied => "permission denied",
            io::ErrorKind::ReadOnlyFilesystem => "its file system is read-only",
            _ => return None,
        };
        Some(format!("the folder {} cannot be written to ({why}); name another", folder.display()))
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

    #[test]
    fn a_folder_that_cannot_be_written_is_named_and_never_a_temporary_file() {
        // As whoever may write everywhere cannot make them happen, in the words of `tempfile`.
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let (place, told) = (folder.path().display(), path.display());
        let message = |kind, said: &str| {
            let said = format!("{said} at path \"{place}/{PREFIX}x.part\"");
            failed(&path, io::Error::new(kind, said)).to_string()
        };
        for (kind, why) in [
            (io::ErrorKind::PermissionDenied, "permission denied"),
            (io::ErrorKind::ReadOnlyFilesystem, "its file system is read-only"),
        ] {
            assert_eq!(
                message(kind, "no"),
                format!(
                    "cannot write {told}: the folder {place} cannot be written to ({why}); name \
                     another"
                )
            );
        }
        let full = message(io::ErrorKind::StorageFull, "No space left on device");
        assert_eq!(full, format!("cannot write {told}: No space left on device"));
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
    fn links_to_files_that_are_yet_to_be_made_are_followed() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("deep")).unwrap();
        symlink("deep/second", at("first")).unwrap();
        symlink("../target", at("deep/second")).unwrap();
        write_atomically(at("first"), |w| w.write_all(b"new")).unwrap();
        assert_eq!(fs::read(at("target")).unwrap(), b"new");
        for link in [at("first"), at("deep/second")] {
            assert!(fs::symlink_metadata(link).unwrap().is_symlink());
        }
        symlink("round", at("round")).unwrap();
        write_atomically(at("round"), |_| Ok(())).unwrap_err();
        symlink("missing/file", at("lost")).unwrap();
        let error = write_atomically(at("lost"), |_| Ok(())).unwrap_err().to_string();
        let folder_at_fault = format!("the folder {} does not exist", at("missing").display());
        assert!(error.contains(&folder_at_fault), "{error}");
        assert_eq!(names(folder.path()), ["deep", "first", "lost", "round", "target"]);
    }

    #[test]
    fn one_file_has_one_destination_however_it_is_spelled() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("deep")).unwrap();
        let spelled = |text: &str| destination(&folder.path().join(text)).unwrap();
        assert_eq!(spelled("a.pfm"), spelled("deep/../a.pfm"));
        assert_ne!(spelled("a.pfm"), spelled("deep/a.pfm"));
        destination(&folder.path().join("no/a.pfm")).unwrap_err();
    }

    #[cfg(unix)]
    #[test]
    fn a_new_file_has_the_rights_of_any_new_file_and_an_old_one_keeps_its_own_and_is_asked() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        write_atomically(&ours, |_| Ok(())).unwrap();
        fs::write(&plain, "").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(&ours), mode(&plain));
        for rights in [0o600, 0o664, 0o755] {
            fs::set_permissions(&ours, fs::Permissions::from_mode(rights)).unwrap();
            write_atomically(&ours, |w| w.write_all(b"new")).unwrap();
            assert_eq!(mode(&ours), rights);
        }
        fs::set_permissions(&ours, fs::Permissions::from_mode(0o444)).unwrap();
        let error = write_atomically(&ours, |w| w.write_all(b"newer")).unwrap_err().to_string();
        assert!(error.contains("it is write-protected"), "{error}");
        assert_eq!(fs::read(&ours).unwrap(), b"new");
    }
}
