//! Limits that the kernel enforces on one process (`setrlimit(2)`).

use serde::{Deserialize, Serialize};

/// Limits that the kernel enforces on one process. They cannot be raised again by it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limits {
    /// CPU time of all threads from its start, in seconds. At the limit the process gets `SIGXCPU`,
    /// one second later it is killed. A safety net: who measures a job kills it earlier.
    pub cpu_seconds: u64,
    /// Address space in bytes: what it may map, whether used or not.
    pub memory_bytes: u64,
    /// The largest file that it may write, in bytes.
    pub file_bytes: u64,
    /// Open files at a time.
    pub open_files: u64,
}

impl Default for Limits {
    /// Ten minutes, 4 GiB, files of 64 MiB, 64 open files.
    fn default() -> Self {
        Self { cpu_seconds: 600, memory_bytes: 4 << 30, file_bytes: 64 << 20, open_files: 64 }
    }
}

#[cfg(target_os = "linux")]
impl Limits {
    /// Applies them to this process, for good.
    pub(super) fn apply(&self) -> std::io::Result<()> {
        use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
        let seconds = self.cpu_seconds.max(1);
        for (resource, soft, hard) in [
            (Resource::Core, 0, 0),
            (Resource::Cpu, seconds, seconds.saturating_add(1)),
            (Resource::As, self.memory_bytes, self.memory_bytes),
            (Resource::Fsize, self.file_bytes, self.file_bytes),
            (Resource::Nofile, self.open_files, self.open_files),
            (Resource::Memlock, 0, 0),
            (Resource::Msgqueue, 0, 0),
        ] {
            // A limit that is lower already stays: raising it would need a privilege.
            let lower = |new: u64, old: Option<u64>| Some(old.map_or(new, |old| old.min(new)));
            let old = getrlimit(resource);
            let maximum = lower(hard, old.maximum);
            setrlimit(resource, Rlimit { current: lower(soft, maximum), maximum })?;
        }
        Ok(())
    }
}
