//! Starting, watching and killing a process with everything that it started.

use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};
use std::{fmt, io};

use crate::interrupt;

/// How a process ended, in words.
pub(crate) struct Exit(pub ExitStatus);

impl fmt::Display for Exit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        #[cfg(unix)]
        {
            use std::os::unix::process::ExitStatusExt;
            if let Some(number) = self.0.signal() {
                return match nix::sys::signal::Signal::try_from(number) {
                    Ok(signal) => write!(f, "it was ended by the signal {}", signal.as_str()),
                    Err(_) => write!(f, "it was ended by the signal {number}"),
                };
            }
        }
        match self.0.code() {
            Some(code) => f.write_str(&exited_with(code)),
            None => write!(f, "it ended without an answer ({})", self.0),
        }
    }
}

/// The words for a process that exited with this status.
pub(crate) fn exited_with(code: i32) -> String {
    format!("it exited with status {code} without an answer")
}

/// Starts a process at the head of a process group of its own, which a signal that ends this process ends too
/// (`interrupt`).
pub(crate) fn start(command: &mut Command) -> io::Result<Child> {
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    interrupt::start(command)
}

/// Whether the process has ended. It is not waited for, so that its clocks can still be read.
#[cfg(unix)]
pub(crate) fn has_exited(child: &mut Child) -> bool {
    use rustix::process::{Pid, WaitId, WaitIdOptions, waitid};
    let options = WaitIdOptions::EXITED | WaitIdOptions::NOWAIT | WaitIdOptions::NOHANG;
    // An error means that it has been waited for already.
    !matches!(waitid(WaitId::Pid(Pid::from_child(child)), options), Ok(None))
}

/// Whether the process has ended.
#[cfg(not(unix))]
pub(crate) fn has_exited(child: &mut Child) -> bool {
    !matches!(child.try_wait(), Ok(None))
}

/// Waits until the process has ended, at most this long. True when it has.
pub(crate) fn wait_for_exit(child: &mut Child, at_most: Duration) -> bool {
    let started = Instant::now();
    let mut pause = Duration::from_millis(1);
    while !has_exited(child) {
        if started.elapsed() >= at_most {
            return false;
        }
        std::thread::sleep(pause);
        pause = (pause * 2).min(Duration::from_millis(20));
    }
    true
}

/// Kills the process and its whole group, and waits for the process. The exit status of a process
/// that had ended before is its own.
pub(crate) fn kill_group(child: &mut Child) -> Option<ExitStatus> {
    // The group outlives its head, and its number cannot be given to another process before the
    // head has been waited for: so the group goes first.
    kill_group_of(child.id());
    let _ = child.kill();
    interrupt::forget(child);
    child.wait().ok()
}

/// Kills the group of a process that nobody has waited for.
pub(crate) fn kill_group_of(head: u32) {
    #[cfg(unix)]
    {
        use nix::sys::signal::{Signal, killpg};
        let _ = killpg(nix::unistd::Pid::from_raw(head as i32), Signal::SIGKILL);
    }
    #[cfg(not(unix))]
    let _ = head;
}
