//! Several files appear together or not at all: each is written to a passing folder beside its
//! place, and only when all are whole are they renamed into their places.
//!
//! What fails while they are written leaves every earlier file as it was. Renaming within a folder
//! that was just written to hardly ever fails; if it does, the files before it have been replaced.

use std::fs;
use std::path::{Path, PathBuf};

use crate::FormatError;
use crate::atomic::{Place, failed};
use crate::passing::PassingFolder;

/// Writes a file to the path that it is given, which ends with the name of the file's own.
pub type Writer<'a> = dyn Fn(&Path) -> Result<(), FormatError> + 'a;

/// Writes all files, or leaves everything as it was. As for [`write_atomically`], links are
/// followed, files that were there hand on their permissions, and what is not a regular file is
/// written directly, once all others are whole.
///
/// Errors name the file's own path.
///
/// [`write_atomically`]: crate::write_atomically
pub fn write_all_or_none<'a>(
    files: impl IntoIterator<Item = (&'a Path, &'a Writer<'a>)>,
) -> Result<(), FormatError> {
    let (mut whole, mut direct) = (Vec::new(), Vec::new());
    for (path, write) in files {
        match Place::of(path)? {
            Some(place) => whole.push(Passing::write(path, place, write)?),
            None => direct.push((path, write)),
        }
    }
    for (path, write) in direct {
        write(path)?;
    }
    whole.iter().try_for_each(Passing::put_in_place)
}

/// Writes a file as [`write_all_or_none`] does, but takes it away again: whatever would stop the
/// real writing stops a program so before it has worked. Leaves nothing behind.
pub fn try_to_write(path: &Path, write: &Writer<'_>) -> Result<(), FormatError> {
    if let Some(place) = Place::of(path)? {
        return Passing::write(path, place, write).map(drop);
    }
    // Beside a device or a pipe there is no place for files. Where there is none for temporary ones either, time tells.
    let name = name_of(path)?;
    match PassingFolder::beside(&std::env::temp_dir().join(name)) {
        Ok(folder) => write(&folder.path().join(name)).map_err(|error| error.about(path)),
        Err(_) => Ok(()),
    }
}

/// A whole file that is not in its place yet.
struct Passing<'a> {
    path: &'a Path,
    target: PathBuf,
    /// Holds the file alone.
    folder: PassingFolder,
    name: &'a std::ffi::OsStr,
}

impl<'a> Passing<'a> {
    fn write(path: &'a Path, place: Place, write: &Writer<'_>) -> Result<Self, FormatError> {
        let name = name_of(path)?;
        let folder = PassingFolder::beside(&place.target).map_err(|error| failed(path, error))?;
        let file = folder.path().join(name);
        write(&file).map_err(|error| error.about(path))?;
        if let Some(permissions) = place.permissions {
            fs::set_permissions(&file, permissions).map_err(|error| failed(path, error))?;
        }
        Ok(Self { path, target: place.target, folder, name })
    }

    fn put_in_place(&self) -> Result<(), FormatError> {
        fs::rename(self.folder.path().join(self.name), &self.target)
            .map_err(|error| failed(self.path, error))
    }
}

fn name_of(path: &Path) -> Result<&std::ffi::OsStr, FormatError> {
    path.file_name().ok_or_else(|| failed(path, std::io::ErrorKind::InvalidInput.into()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::write_atomically;

    fn says(text: &'static str) -> Box<Writer<'static>> {
        Box::new(move |path| write_atomically(path, |file| file.write_all(text.as_bytes())))
    }

    fn fails() -> Box<Writer<'static>> {
        Box::new(|path| {
            write_atomically(path, |_| Err(std::io::Error::other("the disk is on fire")))
        })
    }

    fn entries(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn one_failure_leaves_all_earlier_files_and_makes_no_new_one() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b, new] = ["a", "b", "new"].map(|name| folder.path().join(name));
        let write = |writers: [Box<Writer<'_>>; 3]| {
            write_all_or_none([&*new, &*a, &*b].into_iter().zip(writers.iter().map(|w| &**w)))
        };
        for path in [&a, &b] {
            fs::write(path, "old").unwrap();
        }
        let error = write([says("new"), says("new"), fails()]).unwrap_err();
        assert_eq!(error.path(), Some(&*b), "{error}");
        assert!(error.to_string().contains("the disk is on fire"), "{error}");
        assert_eq!((fs::read(&a).unwrap(), fs::read(&b).unwrap()), (b"old".into(), b"old".into()));
        assert_eq!(entries(folder.path()), 2);

        write([says("1"), says("2"), says("3")]).unwrap();
        let found = [new, a, b].map(|path| fs::read_to_string(path).unwrap());
        assert_eq!(found, ["1", "2", "3"]);
        assert_eq!(entries(folder.path()), 3);
    }

    #[cfg(unix)]
    #[test]
    fn links_permissions_and_pipes_are_as_with_one_file() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let [link, target] = ["link", "target"].map(|name| folder.path().join(name));
        symlink(&target, &link).unwrap();
        fs::write(&target, "old").unwrap();
        fs::set_permissions(&target, fs::Permissions::from_mode(0o600)).unwrap();
        let null = Path::new("/dev/null");
        write_all_or_none([(null, &*says("gone")), (&*link, &*says("new"))]).unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"new");
        assert_eq!(fs::metadata(&target).unwrap().permissions().mode() & 0o777, 0o600);
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert!(!fs::metadata(null).unwrap().is_file());
    }

    #[cfg(unix)]
    #[test]
    fn what_fails_beside_a_device_leaves_all_earlier_files() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "old").unwrap();
        let null = Path::new("/dev/null");
        let error = write_all_or_none([(&*path, &*says("new")), (null, &*fails())]).unwrap_err();
        assert_eq!(error.path(), Some(null), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(entries(folder.path()), 1);
    }

    #[test]
    fn a_trial_leaves_nothing_and_finds_what_stands_in_the_way() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        try_to_write(&path, &*says("trial")).unwrap();
        let error = try_to_write(&path, &*fails()).unwrap_err();
        assert_eq!(error.path(), Some(&*path), "{error}");
        let missing = folder.path().join("no/a");
        let error = try_to_write(&missing, &*says("trial")).unwrap_err().to_string();
        assert!(error.ends_with("no does not exist; create it first"), "{error}");
        let error = try_to_write(folder.path(), &*says("trial")).unwrap_err().to_string();
        assert!(error.contains("it is a folder"), "{error}");
        assert_eq!(entries(folder.path()), 0);
    }
}
