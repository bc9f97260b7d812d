//! Files and folders that are made beside the place of what is written and are gone once it is there: nobody is to find
//! them. They go when they are dropped, and [`remove_passing_files`] takes those that a process still has when a signal
//! ends it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{Builder, NamedTempFile, TempDir, TempPath};

use crate::atomic::folder_of;

/// How their names begin.
pub(crate) const PREFIX: &str = ".hazcam-";

/// Those that there are.
static PASSING: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn passing() -> MutexGuard<'static, Vec<PathBuf>> {
    PASSING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all that this process is writing, and lets it begin nothing more: for one that is about to end by a signal.
/// What was written before stays.
pub fn remove_passing_files() {
    let passing = passing();
    for path in &*passing {
        // It is one or the other, or gone.
        let _ = fs::remove_file(path).or_else(|_| fs::remove_dir_all(path));
    }
    // Never unlocked.
    std::mem::forget(passing);
}

/// One of [`PASSING`] until it is dropped.
struct Known(PathBuf);

impl Known {
    /// What `make` makes. Nobody removes the others meanwhile, so that none is made after that.
    fn new<T>(
        make: impl FnOnce() -> io::Result<T>,
        path: impl Fn(&T) -> &Path,
    ) -> io::Result<(T, Self)> {
        let mut passing = passing();
        let made = make()?;
        let path = path(&made).to_owned();
        passing.push(path.clone());
        Ok((made, Self(path)))
    }
}

impl Drop for Known {
    fn drop(&mut self) {
        passing().retain(|path| *path != self.0);
    }
}

/// A folder.
pub(crate) struct PassingFolder {
    // Removed first, then forgotten.
    folder: TempDir,
    _known: Known,
}

impl PassingFolder {
    /// In the folder of `target`.
    pub fn beside(target: &Path) -> io::Result<Self> {
        let make = || Builder::new().prefix(PREFIX).tempdir_in(folder_of(target));
        let (folder, known) = Known::new(make, TempDir::path)?;
        Ok(Self { folder, _known: known })
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// A file, until it is put in its place.
pub(crate) struct PassingFile {
    file: TempPath,
    _known: Known,
}

impl PassingFile {
    /// In the folder of `target`, with the rights that any new file gets.
    pub fn beside(target: &Path) -> io::Result<(fs::File, Self)> {
        let mut builder = Builder::new();
        builder.prefix(PREFIX).suffix(".part");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let make = || builder.tempfile_in(folder_of(target));
        let (named, known) = Known::new(make, NamedTempFile::path)?;
        let (content, file) = named.into_parts();
        Ok((content, Self { file, _known: known }))
    }

    /// Renames it.
    pub fn put_in_place(self, target: &Path) -> io::Result<()> {
        self.file.persist(target).map_err(|failure| failure.error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_known_as_long_as_they_are_there() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        let known = || {
            let passing = passing();
            passing.iter().filter(|path| path.starts_with(&folder)).cloned().collect::<Vec<_>>()
        };
        let beside = PassingFolder::beside(&target).unwrap();
        let (_, file) = PassingFile::beside(&target).unwrap();
        assert_eq!(known(), [beside.path().to_owned(), file.file.to_path_buf()]);
        drop(beside);
        file.put_in_place(&target).unwrap();
        assert!(known().is_empty());
        let names: Vec<_> = fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
        assert_eq!(names, [target]);
    }
}
