//! What must not outlive this process when a signal ends it: engines, which are in process groups of their own and
//! never hear of it, the folders in which they work, and files that are half written.
//!
//! A process that is killed outright can do nothing. Then an engine ends when it asks for its next job, since nobody
//! writes any more; one that hangs does not, unless it is in the sandbox, which sees to that.

use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What there is of both.
static KEPT: Mutex<Kept> = Mutex::new(Kept { heads: Vec::new(), folders: Vec::new() });

struct Kept {
    /// The processes at the head of a group.
    heads: Vec<u32>,
    folders: Vec<PathBuf>,
}

fn kept() -> MutexGuard<'static, Kept> {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Starts a process at the head of a group. Whoever waits for it must [`forget`] it before: then its number may be
/// another's.
pub(crate) fn start(command: &mut Command) -> io::Result<Child> {
    // Held meanwhile, so that no signal comes between.
    let mut kept = kept();
    let child = command.spawn()?;
    kept.heads.push(child.id());
    Ok(child)
}

/// A process that is about to be killed and waited for.
pub(crate) fn forget(child: &Child) {
    kept().heads.retain(|&head| head != child.id());
}

/// A folder for temporary files, removed with everything in it when it is dropped, and by [`clean_up_on_signals`].
#[derive(Debug)]
pub struct Scratch(tempfile::TempDir);

impl Scratch {
    /// A new one, whose name begins with `prefix`.
    ///
    /// Errors when it cannot be made.
    pub fn new(prefix: &str) -> io::Result<Self> {
        let mut kept = kept();
        let mut builder = tempfile::Builder::new();
        // A hold-out is nobody else's, nor is what was handed in.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
        let folder = builder.prefix(prefix).tempdir()?;
        kept.folders.push(folder.path().to_owned());
        Ok(Self(folder))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.0.path()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        remove(self.path());
        kept().folders.retain(|folder| folder != self.path());
    }
}

/// Removes a folder, however deep what was graded there nested it.
fn remove(folder: &Path) {
    if std::fs::remove_dir_all(folder).is_err() && cfg!(unix) {
        // The library keeps a file open for each level and may run out of them; `rm` does not.
        let _ = Command::new("rm").arg("-rf").arg("--").arg(folder).status();
    }
}

/// From now on, signals that end this process (`SIGINT`, `SIGTERM`, `SIGHUP`) kill what it started and remove its
/// folders, and what it is writing, first. Those that it was told to ignore stay ignored.
///
/// Errors when signals cannot be waited for.
#[cfg(unix)]
pub fn clean_up_on_signals() -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let ignored = ignored();
    let heard =
        [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
    let mut signals = signal_hook::iterator::Signals::new(heard)?;
    let wait = move || {
        for signal in signals.forever() {
            // Held to the end: nothing new begins.
            let kept = kept();
            for &head in &kept.heads {
                crate::engine::process::kill_group_of(head);
            }
            kept.folders.iter().for_each(|folder| remove(folder));
            formats::remove_passing_files();
            let _ = signal_hook::low_level::emulate_default_handler(signal);
        }
    };
    std::thread::Builder::new().name("signals".into()).spawn(wait).map(drop)
}

/// Elsewhere than on Unix nothing is done.
#[cfg(not(unix))]
pub fn clean_up_on_signals() -> io::Result<()> {
    Ok(())
}

/// A bit for each signal that is ignored, as `nohup` and shells have it for what runs in the background; none where
/// the system does not tell.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_folder_for_temporary_files_is_nobody_elses() {
        let folder = Scratch::new("hazcam-test-").unwrap();
        let mode = std::fs::metadata(folder.path()).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o700);
    }
}
