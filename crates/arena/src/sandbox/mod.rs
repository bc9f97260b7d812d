//! Runs a program that is not trusted: a student's submission, a competitor's matcher.
//!
//! **What is kept from it.** It reads the system's libraries and what its [`Policy`] lists, writes
//! only in its own folders, has no network, starts no process, signals nobody but itself, and runs
//! into limits of CPU time, memory, file size, open files, threads and total disk space. It holds
//! for root as for anybody else: capabilities are dropped for good. What it may read it may also become, by `execve`:
//! Python's runner forbids that to itself before it reads a submission.
//!
//! **How.** Everything here is unprivileged and irrevocable:
//!
//! | part | kernel | what it stops |
//! | --- | --- | --- |
//! | Landlock | 6.2 or newer (version 3: with truncation) | files outside of what is listed |
//! | seccomp | any of that age | system calls that are not on the list in `syscalls`: sockets, fork, signals to others, changing modes and owners, ... |
//! | rlimits | any | CPU time, address space, file size, descriptors, core dumps |
//! | [`Watch`] | | threads and the total size of files, which the kernel counts for nobody |
//!
//! Where the kernel lacks a part, [`missing_parts`] names it, and callers refuse to run anything
//! unless they are told to do without.
//!
//! **Why a helper process.** A process must restrict *itself*, between `fork` and `exec`; doing so
//! in a forked copy of a program with threads needs `unsafe`, and few of the calls involved may be
//! made there. So [`confine`] starts the same binary once more with a hidden command that calls
//! [`enter`]: it restricts itself while it is still alone, and then becomes the program.

mod command;
mod enter;
mod limits;
mod policy;
mod support;
mod watch;

#[cfg(target_os = "linux")]
mod capabilities;
#[cfg(target_os = "linux")]
mod filesystem;
#[cfg(target_os = "linux")]
mod syscalls;

pub use command::confine;
pub use enter::{EXIT_STATUS, enter, failure, token};
pub use limits::Limits;
pub use policy::{Policy, SYSTEM_PATHS};
pub use support::missing_parts;
pub use watch::{Excess, Watch};
