//! What a confined program may touch.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::Limits;

/// What every program needs to start: loader, libraries, interpreters, a few harmless devices and
/// facts about the processor. Those that a system does not have are left out.
pub const SYSTEM_PATHS: [&str; 13] = [
    "/usr",
    "/bin",
    "/lib",
    "/lib32",
    "/lib64",
    "/nix/store",
    "/etc/ld.so.cache",
    "/etc/localtime",
    "/dev/zero",
    "/dev/random",
    "/dev/urandom",
    "/proc/cpuinfo",
    "/sys/devices/system/cpu",
];

/// What a confined program may touch. All paths are absolute.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Policy {
    /// Files and folders (with all below) that it may read and execute, besides [`SYSTEM_PATHS`].
    pub readable: Vec<PathBuf>,
    /// Folders in which it may read, create, change and remove files; nothing there is executed.
    pub writable: Vec<PathBuf>,
    /// What the kernel counts.
    pub limits: Limits,
    /// Stands in what the helper says of its failure. The program has never seen it, and cannot say the same.
    pub token: String,
    /// Where its process number is written before anything is restricted, for [`super::Watch`].
    pub pid_file: PathBuf,
}

impl Policy {
    /// The first of the allowed paths under which `path` lies, if any: what must stay secret must
    /// not be within reach. Links are followed where the path exists.
    pub fn within_reach(&self, path: &Path) -> Option<&Path> {
        let target = resolved(path);
        SYSTEM_PATHS
            .iter()
            .map(Path::new)
            .chain(self.readable.iter().chain(&self.writable).map(PathBuf::as_path))
            .find(|allowed| target.starts_with(resolved(allowed)))
    }
}

fn resolved(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_below_an_allowed_folder_is_within_reach() {
        let folder = tempfile::tempdir().unwrap();
        let below = folder.path().join("truth");
        std::fs::create_dir(&below).unwrap();
        let policy = Policy {
            readable: vec![folder.path().to_owned()],
            writable: Vec::new(),
            limits: Limits::default(),
            token: "a".into(),
            pid_file: "/nonexistent/pid".into(),
        };
        assert_eq!(policy.within_reach(&below.join("a.png")), Some(folder.path()));
        assert_eq!(policy.within_reach(Path::new("/usr/share/truth.png")), Some(Path::new("/usr")));
        assert_eq!(policy.within_reach(Path::new("/nonexistent/truth.png")), None);
        // A name that only begins alike is another folder.
        let sibling = PathBuf::from(format!("{}x", folder.path().display()));
        assert_eq!(policy.within_reach(&sibling), None);
    }
}
