//! Which system calls a confined program may make (seccomp).
//!
//! A list of what is allowed, not of what is forbidden: calls that future kernels add are refused
//! without anybody having to remember. What is not on the list fails with `ENOSYS`, as on a kernel
//! that does not have it, and programs fall back to something older (`clone3` to `clone`); what is
//! refused on purpose fails with `EPERM`, so that the message says "not permitted".
//!
//! Some calls depend on their arguments: `clone` may make threads and no processes, `kill` and
//! `tgkill` reach the process itself and nobody else, `prctl`, `ioctl` and `fcntl` do a few harmless
//! things, limits may be read and not set, folders must be readable by their owner. Modes, owners,
//! times and attributes of files cannot be changed at all, because Landlock does not guard them.

use std::collections::BTreeMap;

use libc::{c_int, c_long};
use seccompiler::{
    BackendError, BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition,
    SeccompFilter, SeccompRule,
};

/// Allowed whatever the arguments.
const ALLOWED: &[c_long] = &[
    // Memory.
    libc::SYS_brk,
    libc::SYS_madvise,
    libc::SYS_mincore,
    libc::SYS_mmap,
    libc::SYS_mprotect,
    libc::SYS_mremap,
    libc::SYS_msync,
    libc::SYS_munmap,
    // Files that are open.
    libc::SYS_close,
    libc::SYS_close_range,
    libc::SYS_copy_file_range,
    libc::SYS_dup,
    libc::SYS_dup3,
    libc::SYS_fadvise64,
    libc::SYS_fallocate,
    libc::SYS_fdatasync,
    libc::SYS_flock,
    libc::SYS_fstat,
    libc::SYS_fstatfs,
    libc::SYS_fsync,
    libc::SYS_ftruncate,
    libc::SYS_getdents64,
    libc::SYS_lseek,
    libc::SYS_pread64,
    libc::SYS_preadv,
    libc::SYS_preadv2,
    libc::SYS_pwrite64,
    libc::SYS_pwritev,
    libc::SYS_pwritev2,
    libc::SYS_read,
    libc::SYS_readahead,
    libc::SYS_readv,
    libc::SYS_sendfile,
    libc::SYS_write,
    libc::SYS_writev,
    // Files by name: Landlock decides which.
    libc::SYS_chdir,
    libc::SYS_faccessat,
    libc::SYS_faccessat2,
    libc::SYS_fchdir,
    libc::SYS_getcwd,
    libc::SYS_newfstatat,
    libc::SYS_openat,
    libc::SYS_openat2,
    libc::SYS_readlinkat,
    libc::SYS_renameat,
    libc::SYS_renameat2,
    libc::SYS_statfs,
    libc::SYS_statx,
    libc::SYS_truncate,
    libc::SYS_unlinkat,
    // Waiting.
    libc::SYS_clock_nanosleep,
    libc::SYS_epoll_create1,
    libc::SYS_epoll_ctl,
    libc::SYS_epoll_pwait,
    libc::SYS_epoll_pwait2,
    libc::SYS_eventfd2,
    libc::SYS_futex,
    libc::SYS_nanosleep,
    libc::SYS_pipe2,
    libc::SYS_ppoll,
    libc::SYS_pselect6,
    libc::SYS_sched_yield,
    libc::SYS_wait4,
    libc::SYS_waitid,
    // Time.
    libc::SYS_clock_getres,
    libc::SYS_clock_gettime,
    libc::SYS_getitimer,
    libc::SYS_gettimeofday,
    libc::SYS_setitimer,
    libc::SYS_timer_create,
    libc::SYS_timer_delete,
    libc::SYS_timer_getoverrun,
    libc::SYS_timer_gettime,
    libc::SYS_timer_settime,
    libc::SYS_times,
    // Signals to itself.
    libc::SYS_restart_syscall,
    libc::SYS_rt_sigaction,
    libc::SYS_rt_sigpending,
    libc::SYS_rt_sigprocmask,
    libc::SYS_rt_sigreturn,
    libc::SYS_rt_sigsuspend,
    libc::SYS_rt_sigtimedwait,
    libc::SYS_sigaltstack,
    // Threads, and facts about itself and the machine.
    libc::SYS_capget,
    libc::SYS_execve,
    libc::SYS_exit,
    libc::SYS_exit_group,
    libc::SYS_get_robust_list,
    libc::SYS_getcpu,
    libc::SYS_getegid,
    libc::SYS_geteuid,
    libc::SYS_getgid,
    libc::SYS_getgroups,
    libc::SYS_getpgid,
    libc::SYS_getpid,
    libc::SYS_getppid,
    libc::SYS_getpriority,
    libc::SYS_getrandom,
    libc::SYS_getresgid,
    libc::SYS_getresuid,
    libc::SYS_getrusage,
    libc::SYS_getsid,
    libc::SYS_gettid,
    libc::SYS_getuid,
    // More rules of its own for Landlock, which take rights and give none.
    libc::SYS_landlock_create_ruleset,
    libc::SYS_landlock_restrict_self,
    libc::SYS_membarrier,
    libc::SYS_rseq,
    libc::SYS_sched_get_priority_max,
    libc::SYS_sched_get_priority_min,
    libc::SYS_sched_getaffinity,
    libc::SYS_sched_getparam,
    libc::SYS_sched_getscheduler,
    libc::SYS_set_robust_list,
    libc::SYS_set_tid_address,
    libc::SYS_sysinfo,
    libc::SYS_uname,
];

/// Older names of allowed calls, which newer processors never had.
#[cfg(target_arch = "x86_64")]
const ALLOWED_HERE: &[c_long] = &[
    libc::SYS_access,
    libc::SYS_alarm,
    libc::SYS_arch_prctl,
    libc::SYS_dup2,
    libc::SYS_epoll_create,
    libc::SYS_epoll_wait,
    libc::SYS_eventfd,
    libc::SYS_getdents,
    libc::SYS_getpgrp,
    libc::SYS_getrlimit,
    libc::SYS_lstat,
    libc::SYS_open,
    libc::SYS_pause,
    libc::SYS_pipe,
    libc::SYS_poll,
    libc::SYS_readlink,
    libc::SYS_rename,
    libc::SYS_rmdir,
    libc::SYS_select,
    libc::SYS_stat,
    libc::SYS_time,
    libc::SYS_unlink,
];
#[cfg(not(target_arch = "x86_64"))]
const ALLOWED_HERE: &[c_long] = &[];

/// Refused with `EPERM`: what a program may well try, and should get a fitting message for.
const REFUSED: &[c_long] = &[
    libc::SYS_accept,
    libc::SYS_accept4,
    libc::SYS_bind,
    libc::SYS_connect,
    libc::SYS_fchmod,
    libc::SYS_fchmodat,
    libc::SYS_fchown,
    libc::SYS_fchownat,
    libc::SYS_linkat,
    libc::SYS_listen,
    // By it a program could be made that no folder holds, and executed in spite of Landlock.
    libc::SYS_memfd_create,
    libc::SYS_mknodat,
    libc::SYS_mount,
    libc::SYS_pidfd_open,
    libc::SYS_pidfd_send_signal,
    libc::SYS_process_vm_readv,
    libc::SYS_process_vm_writev,
    libc::SYS_ptrace,
    libc::SYS_rt_sigqueueinfo,
    libc::SYS_rt_tgsigqueueinfo,
    libc::SYS_sched_setaffinity,
    libc::SYS_sched_setscheduler,
    libc::SYS_setpgid,
    libc::SYS_setpriority,
    libc::SYS_setrlimit,
    libc::SYS_setsid,
    libc::SYS_shmget,
    libc::SYS_socket,
    libc::SYS_socketpair,
    libc::SYS_symlinkat,
    libc::SYS_tkill,
    libc::SYS_unshare,
    libc::SYS_utimensat,
];

/// As [`REFUSED`], older names.
#[cfg(target_arch = "x86_64")]
const REFUSED_HERE: &[c_long] = &[
    libc::SYS_chmod,
    libc::SYS_chown,
    libc::SYS_fork,
    libc::SYS_lchown,
    libc::SYS_link,
    libc::SYS_mknod,
    libc::SYS_symlink,
    libc::SYS_utime,
    libc::SYS_utimes,
    libc::SYS_vfork,
];
#[cfg(not(target_arch = "x86_64"))]
const REFUSED_HERE: &[c_long] = &[];

/// Refused with `EPERM` for some of their arguments, allowed for the others.
const JUDGED_BY_ARGUMENTS: &[c_long] = &[
    libc::SYS_clone,
    libc::SYS_kill,
    libc::SYS_mkdirat,
    libc::SYS_prlimit64,
    libc::SYS_tgkill,
    libc::SYS_umask,
];

/// As [`JUDGED_BY_ARGUMENTS`], older names.
#[cfg(target_arch = "x86_64")]
const JUDGED_BY_ARGUMENTS_HERE: &[c_long] = &[libc::SYS_mkdir];
#[cfg(not(target_arch = "x86_64"))]
const JUDGED_BY_ARGUMENTS_HERE: &[c_long] = &[];

/// Names, memory labels and questions.
const PRCTL_OPTIONS: &[c_int] = &[
    libc::PR_CAPBSET_READ,
    libc::PR_GET_DUMPABLE,
    libc::PR_GET_NAME,
    libc::PR_GET_NO_NEW_PRIVS,
    libc::PR_SET_NAME,
    libc::PR_SET_VMA,
];

/// Whether something is a terminal and how wide, and flags of open files.
const IOCTL_REQUESTS: &[u64] =
    &[libc::TCGETS, libc::TIOCGWINSZ, libc::FIOCLEX, libc::FIONBIO, libc::FIONCLEX, libc::FIONREAD];

/// Copies of descriptors, flags and locks.
const FCNTL_COMMANDS: &[c_int] = &[
    libc::F_DUPFD,
    libc::F_DUPFD_CLOEXEC,
    libc::F_GETFD,
    libc::F_GETFL,
    libc::F_GETLK,
    libc::F_GETPIPE_SZ,
    libc::F_GET_SEALS,
    libc::F_OFD_GETLK,
    libc::F_OFD_SETLK,
    libc::F_OFD_SETLKW,
    libc::F_SETFD,
    libc::F_SETFL,
    libc::F_SETLK,
    libc::F_SETLKW,
];

/// Refused with `EPERM`: by these the kernel sends a signal when something happens to an open file,
/// to any process and any signal, `SIGKILL` to the grader among them. A pipe of one's own makes it
/// happen. Only Landlock of version 6 stops such signals.
const FCNTL_REFUSED: &[c_int] =
    &[libc::F_NOTIFY, libc::F_SETLEASE, F_SETOWN, F_SETOWN_EX, F_SETSIG];

/// `libc` has not all of these everywhere; the numbers are those of the kernel's generic header.
const F_SETOWN: c_int = 8;
const F_SETSIG: c_int = 10;
const F_SETOWN_EX: c_int = 15;

/// A rule for calls whose argument number `index` compares so; its lower 32 bits count, which is
/// all that the kernel looks at in the calls where it is used.
fn when(index: u8, operator: SeccompCmpOp, value: u64) -> Result<SeccompRule, BackendError> {
    let argument = SeccompCmpArgLen::Dword;
    SeccompRule::new(vec![SeccompCondition::new(index, argument, operator, value)?])
}

type Rules = BTreeMap<c_long, Vec<SeccompRule>>;

/// Everything that does not fail with `ENOSYS`: what is refused with `EPERM` is among it.
fn known() -> Result<Rules, BackendError> {
    let equal = |index, value| when(index, SeccompCmpOp::Eq, value);
    let judged = [JUDGED_BY_ARGUMENTS, JUDGED_BY_ARGUMENTS_HERE].concat();
    let mut rules: Rules = [ALLOWED, ALLOWED_HERE, &judged, REFUSED, REFUSED_HERE]
        .concat()
        .into_iter()
        .map(|call| (call, Vec::new()))
        .collect();
    let options = PRCTL_OPTIONS.iter().map(|&option| equal(0, option as u64));
    rules.insert(libc::SYS_prctl, options.collect::<Result<_, _>>()?);
    let requests = IOCTL_REQUESTS.iter().map(|&request| equal(1, request));
    rules.insert(libc::SYS_ioctl, requests.collect::<Result<_, _>>()?);
    let commands = [FCNTL_COMMANDS, FCNTL_REFUSED].concat();
    let commands = commands.into_iter().map(|command| equal(1, command as u64));
    rules.insert(libc::SYS_fcntl, commands.collect::<Result<_, _>>()?);
    Ok(rules)
}

fn refused(own_pid: u32) -> Result<Rules, BackendError> {
    let mut rules: Rules =
        [REFUSED, REFUSED_HERE].concat().into_iter().map(|call| (call, Vec::new())).collect();
    let thread = libc::CLONE_THREAD as u64;
    rules.insert(libc::SYS_clone, vec![when(0, SeccompCmpOp::MaskedEq(thread), 0)?]);
    for call in [libc::SYS_kill, libc::SYS_tgkill] {
        rules.insert(call, vec![when(0, SeccompCmpOp::Ne, own_pid.into())?]);
    }
    let commands = FCNTL_REFUSED.iter();
    let commands = commands.map(|&command| when(1, SeccompCmpOp::Eq, command as u64));
    rules.insert(libc::SYS_fcntl, commands.collect::<Result<_, _>>()?);
    // A new limit is a pointer: none is zero in all of its 64 bits.
    let some = SeccompCondition::new(2, SeccompCmpArgLen::Qword, SeccompCmpOp::Ne, 0)?;
    rules.insert(libc::SYS_prlimit64, vec![SeccompRule::new(vec![some])?]);
    // A folder that its owner cannot list would hide what is in it, from the watch and from whoever
    // removes it.
    let missing =
        |index| [0o100, 0o200, 0o400].map(|bit| when(index, SeccompCmpOp::MaskedEq(bit), 0));
    let masked = [0o100, 0o200, 0o400].map(|bit| when(0, SeccompCmpOp::MaskedEq(bit), bit));
    rules.insert(libc::SYS_mkdirat, missing(2).into_iter().collect::<Result<_, _>>()?);
    for &call in JUDGED_BY_ARGUMENTS_HERE {
        rules.insert(call, missing(1).into_iter().collect::<Result<_, _>>()?);
    }
    rules.insert(libc::SYS_umask, masked.into_iter().collect::<Result<_, _>>()?);
    Ok(rules)
}

/// The filters for this process, in the order in which they are to be applied. A call must pass
/// both.
pub(super) fn compile() -> Result<[BpfProgram; 2], BackendError> {
    let fail = |error: c_int| SeccompAction::Errno(error as u32);
    let target = std::env::consts::ARCH.try_into()?;
    let refused = refused(std::process::id())?;
    let refused = SeccompFilter::new(refused, SeccompAction::Allow, fail(libc::EPERM), target)?;
    let known = SeccompFilter::new(known()?, fail(libc::ENOSYS), SeccompAction::Allow, target)?;
    // Applying a filter takes calls that are unknown, so that filter comes last.
    Ok([refused.try_into()?, known.try_into()?])
}

/// A filter without any effect.
pub(super) fn allow_everything() -> Result<BpfProgram, BackendError> {
    let target = std::env::consts::ARCH.try_into()?;
    let never = SeccompAction::Errno(libc::EPERM as u32);
    SeccompFilter::new(Rules::new(), SeccompAction::Allow, never, target)?.try_into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_call_is_both_allowed_and_refused() {
        for call in [REFUSED, REFUSED_HERE, JUDGED_BY_ARGUMENTS, JUDGED_BY_ARGUMENTS_HERE].concat()
        {
            assert!(!ALLOWED.contains(&call) && !ALLOWED_HERE.contains(&call), "number {call}");
        }
    }

    #[test]
    fn the_filters_compile() {
        assert!(compile().unwrap().iter().all(|program| !program.is_empty()));
    }
}
