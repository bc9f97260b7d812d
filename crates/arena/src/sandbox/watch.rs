//! Watches what the kernel counts for nobody: threads of one process, and the disk space of its
//! files, those in its folder and those that it removed and still holds open.
//!
//! Both can grow fast but not without end between two looks: every thread takes its stack from the
//! address space, every file is bounded by the limit of file size. A process past a limit is
//! killed; since it could start no other, it leaves nothing behind.
//!
//! **What remains.** A file that was removed and closed while it is mapped into memory takes space
//! that nobody without privileges can measure: `/proc/PID/maps` names it and not its blocks. What it
//! takes is given back when the process ends, by its limit of CPU or wall time at the latest.

use std::fmt;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// How often it looks.
const PERIOD: Duration = Duration::from_millis(20);

/// Threads that a confined program may have at a time. One is meant to compute; interpreters and
/// libraries keep a few more.
const THREADS: u64 = 64;

/// Files and folders that its folder may hold.
const ENTRIES: u64 = 4096;

/// What a process was killed for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Excess {
    /// It had this many threads.
    Threads(u64),
    /// Its files took this many bytes, of the number that is allowed.
    Bytes(u64, u64),
    /// Its folder held at least this many files and folders.
    Entries(u64),
    /// Its folder could not be looked through: paths too long, or folders that hide their content.
    Hidden(ErrorKind),
}

impl fmt::Display for Excess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Threads(count) => write!(f, "it had {count} threads; {THREADS} are allowed"),
            Self::Bytes(bytes, limit) => write!(
                f,
                "it had written {} MiB of files; {} MiB are allowed",
                bytes.div_ceil(1 << 20),
                limit >> 20
            ),
            Self::Entries(count) => {
                write!(f, "it had created {count} files; {ENTRIES} are allowed")
            }
            Self::Hidden(why) => write!(f, "it had created folders that cannot be read ({why})"),
        }
    }
}

/// A thread that watches one confined process from its start until it is stopped.
pub struct Watch {
    stop: Sender<()>,
    thread: JoinHandle<Option<Excess>>,
}

impl Watch {
    /// Watches the process whose number will appear in `pid_file`, and `folder`, which may hold
    /// `bytes` on top of what it holds now.
    pub fn start(pid_file: PathBuf, folder: PathBuf, bytes: u64) -> Self {
        let (stop, stopped) = channel();
        let thread = std::thread::spawn(move || {
            let before = content(&folder).bytes;
            let mut process = None;
            while stopped.recv_timeout(PERIOD) == Err(RecvTimeoutError::Timeout) {
                if process.is_none() {
                    process = process::Watched::from_file(&pid_file);
                }
                let Some(process) = &process else { continue };
                // Before the folder: a file that is removed between the two is missed once, and
                // counted the next time, instead of twice now.
                let removed = process.removed_bytes();
                let mut content = content(&folder);
                content.bytes = content.bytes.saturating_add(removed).saturating_sub(before);
                if let Some(excess) = excess(process.threads(), content, bytes) {
                    process.kill();
                    return Some(excess);
                }
            }
            None
        });
        Self { stop, thread }
    }

    /// Stops watching. What the process was killed for, if it was.
    pub fn stop(self) -> Option<Excess> {
        let _ = self.stop.send(());
        self.thread.join().ok().flatten()
    }
}

fn excess(threads: Option<u64>, content: Content, bytes: u64) -> Option<Excess> {
    match threads {
        Some(threads) if threads > THREADS => Some(Excess::Threads(threads)),
        _ if content.bytes > bytes => Some(Excess::Bytes(content.bytes, bytes)),
        _ if content.entries > ENTRIES => Some(Excess::Entries(content.entries)),
        _ => content.hidden.map(Excess::Hidden),
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Content {
    bytes: u64,
    entries: u64,
    hidden: Option<ErrorKind>,
}

/// What a folder holds, links not followed. Counting ends one entry past [`ENTRIES`], so that it
/// takes no longer than it must.
fn content(folder: &Path) -> Content {
    let mut total = Content::default();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let entries = match std::fs::read_dir(folder) {
            Ok(entries) => entries,
            // Removed or replaced in the meantime.
            Err(error)
                if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) =>
            {
                continue;
            }
            Err(error) => {
                total.hidden = Some(error.kind());
                continue;
            }
        };
        for entry in entries.flatten() {
            total.entries += 1;
            if total.entries > ENTRIES {
                return total;
            }
            let Ok(metadata) = entry.metadata() else { continue };
            match metadata.is_dir() {
                true => folders.push(entry.path()),
                false => total.bytes += allocated(&metadata),
            }
        }
    }
    total
}

/// The disk space of a file, holes not counted.
#[cfg(unix)]
fn allocated(metadata: &std::fs::Metadata) -> u64 {
    use std::os::unix::fs::MetadataExt;
    metadata.blocks() * 512
}

#[cfg(not(unix))]
fn allocated(metadata: &std::fs::Metadata) -> u64 {
    metadata.len()
}

#[cfg(target_os = "linux")]
mod process {
    use std::collections::BTreeSet;
    use std::os::fd::OwnedFd;
    use std::os::unix::fs::MetadataExt;
    use std::path::Path;

    use rustix::process::{Pid, PidfdFlags, Signal, pidfd_open, pidfd_send_signal};

    /// A process, held by a descriptor: its number may be given to another when it has ended.
    pub(super) struct Watched {
        pid: i32,
        descriptor: OwnedFd,
    }

    impl Watched {
        /// The process that wrote its number into this file; `None` until it has.
        pub fn from_file(file: &Path) -> Option<Self> {
            let pid = std::fs::read_to_string(file).ok()?.trim().parse().ok()?;
            let descriptor = pidfd_open(Pid::from_raw(pid)?, PidfdFlags::empty()).ok()?;
            Some(Self { pid, descriptor })
        }

        /// How many threads it has, while it lives.
        pub fn threads(&self) -> Option<u64> {
            let status = std::fs::read_to_string(format!("/proc/{}/status", self.pid)).ok()?;
            status.lines().find_map(|line| line.strip_prefix("Threads:"))?.trim().parse().ok()
        }

        /// The disk space of files that it holds open and that have no name any more, each once
        /// however often it is open.
        pub fn removed_bytes(&self) -> u64 {
            removed_bytes(&format!("/proc/{}/fd", self.pid))
        }

        pub fn kill(&self) {
            let _ = pidfd_send_signal(&self.descriptor, Signal::KILL);
        }
    }

    fn removed_bytes(descriptors: &str) -> u64 {
        let mut seen = BTreeSet::new();
        // Descriptors that are closed in the meantime, and a process that has ended, hold nothing.
        std::fs::read_dir(descriptors)
            .into_iter()
            .flatten()
            .flatten()
            .filter_map(|entry| std::fs::metadata(entry.path()).ok())
            .filter(|file| file.is_file() && file.nlink() == 0)
            .filter(|file| seen.insert((file.dev(), file.ino())))
            .map(|file| super::allocated(&file))
            .sum()
    }

    #[cfg(test)]
    mod tests {
        use std::io::Write;

        use super::removed_bytes;

        #[test]
        fn a_removed_file_counts_once_while_it_is_open() {
            let folder = tempfile::tempdir().unwrap();
            // Stands for the folder of descriptors: other tests have files open as well.
            let descriptors = folder.path().join("fd");
            std::fs::create_dir(&descriptors).unwrap();
            let named = tempfile::NamedTempFile::new_in(&folder).unwrap();
            let nameless = tempfile::tempfile_in(&folder).unwrap();
            for mut file in [named.as_file(), &nameless] {
                file.write_all(&vec![1; 3 << 20]).unwrap();
            }
            nameless.sync_all().unwrap();
            let copy = nameless.try_clone().unwrap();
            for file in [named.as_file(), &nameless, &copy] {
                let number = std::os::fd::AsRawFd::as_raw_fd(file);
                let target = format!("/proc/self/fd/{number}");
                std::os::unix::fs::symlink(target, descriptors.join(number.to_string())).unwrap();
            }
            let bytes = removed_bytes(descriptors.to_str().unwrap());
            assert!((3 << 20..4 << 20).contains(&bytes), "{bytes}");
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod process {
    use std::path::Path;

    /// No process is ever confined here, so none is watched.
    pub(super) enum Watched {}

    impl Watched {
        pub fn from_file(_file: &Path) -> Option<Self> {
            None
        }

        pub fn threads(&self) -> Option<u64> {
            match *self {}
        }

        pub fn removed_bytes(&self) -> u64 {
            match *self {}
        }

        pub fn kill(&self) {
            match *self {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_counts_files_below_and_follows_no_link() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("below")).unwrap();
        std::fs::write(folder.path().join("below/file"), vec![1; 100_000]).unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink("/usr", folder.path().join("link")).unwrap();
        let content = content(folder.path());
        assert_eq!(content.entries, if cfg!(unix) { 3 } else { 2 });
        assert!((100_000..200_000).contains(&content.bytes), "{content:?}");
    }

    #[test]
    fn each_limit_has_its_message() {
        let text = |threads, bytes, entries| {
            let content = Content { bytes, entries, hidden: None };
            excess(Some(threads), content, 1 << 20).map(|e| e.to_string())
        };
        assert_eq!(text(64, 1 << 20, 4096), None);
        assert!(text(65, 0, 0).unwrap().contains("65 threads; 64"));
        assert!(text(1, 3 << 20, 0).unwrap().contains("3 MiB of files; 1 MiB"));
        assert!(text(1, 0, 4097).unwrap().contains("4097 files"));
        let hidden = Content { hidden: Some(ErrorKind::InvalidFilename), ..Content::default() };
        let text = excess(Some(1), hidden, 1).unwrap().to_string();
        assert!(text.contains("folders that cannot be read (invalid filename)"), "{text}");
    }
}
