//! The helper's side: restricts its own process and becomes the program.

use std::ffi::OsString;
use std::fmt::Display;
use std::hash::{BuildHasher, RandomState};
use std::io;
use std::sync::OnceLock;

use super::Policy;

/// The exit status of a helper that could not confine or start the program.
pub const EXIT_STATUS: u8 = 125;

/// What its message on standard error says, with a [`Policy`]'s token.
pub fn failure(token: &str, error: impl Display) -> String {
    format!("sandbox failed {token}: {error}")
}

/// The token of this process.
pub fn token() -> &'static str {
    static TOKEN: OnceLock<String> = OnceLock::new();
    // Where the system gives no random number, a hasher has keys that are as secret.
    TOKEN.get_or_init(|| {
        let number = getrandom::u64().unwrap_or_else(|_| RandomState::new().hash_one(()));
        format!("{number:016x}")
    })
}

/// Restricts this process to `policy` and replaces it by `program`. Comes back only on failure;
/// some of the restrictions may be in force then, so the caller should end.
///
/// Call it before any thread is started: restrictions belong to a thread and are handed down.
#[cfg(target_os = "linux")]
pub fn enter(policy: &Policy, program: &OsString, arguments: &[OsString]) -> io::Error {
    use std::os::unix::process::CommandExt;
    match restrict(policy) {
        Ok(()) => {
            let error = std::process::Command::new(program).args(arguments).exec();
            with_context(error, &format!("cannot start {}", program.to_string_lossy()))
        }
        Err(error) => error,
    }
}

/// Fails: only Linux has what is needed.
#[cfg(not(target_os = "linux"))]
pub fn enter(_policy: &Policy, _program: &OsString, _arguments: &[OsString]) -> io::Error {
    io::Error::other("programs can be confined on Linux only")
}

#[cfg(target_os = "linux")]
fn restrict(policy: &Policy) -> io::Result<()> {
    use rustix::process::{Signal, set_parent_process_death_signal};
    set_parent_process_death_signal(Some(Signal::KILL))?;
    // Whoever started hazcam may have left files open; they are not for the program.
    close_fds::CloseFdsBuilder::new().cloexecfrom(3);
    std::fs::write(&policy.pid_file, std::process::id().to_string())
        .map_err(|e| with_context(e, &policy.pid_file.display().to_string()))?;
    let filters =
        super::syscalls::compile().map_err(|e| with_context(io::Error::other(e), "seccomp"))?;
    policy.limits.apply().map_err(|e| with_context(e, "limits"))?;
    super::capabilities::drop_all().map_err(|e| with_context(e, "capabilities"))?;
    super::filesystem::restrict(policy).map_err(|e| with_context(e, "Landlock"))?;
    for filter in &filters {
        seccompiler::apply_filter(filter)
            .map_err(|e| with_context(io::Error::other(e), "seccomp"))?;
    }
    Ok(())
}

#[cfg(target_os = "linux")]
fn with_context(error: io::Error, what: &str) -> io::Error {
    io::Error::new(error.kind(), format!("{what}: {error}"))
}
