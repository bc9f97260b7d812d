//! What a process uses, read from outside: CPU time, wall time, peak memory.
//!
//! **CPU time** is `clock_getcpuclockid(pid)`, which counts user and system time of all threads of
//! the process, ended ones included, in nanoseconds; plus the time of children that it has waited
//! for (`/proc/PID/stat`, fields 16 and 17, in clock ticks), plus the same two for every child
//! that still runs. A child that its parent neither waits for nor keeps is not counted.
//! **Peak memory** is `VmHWM` of the process alone, reset before a job by writing 5 to
//! `/proc/PID/clear_refs`. The clock goes on answering for a process that has ended until its
//! parent waits for it, which is why callers measure before they wait.
//!
//! On systems other than Linux only wall time is known; the other two are `None` and never 0.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

/// What was used between two moments.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Usage {
    /// User and system time in seconds; `None` where the system does not tell.
    pub cpu_seconds: Option<f64>,
    /// Elapsed time in seconds.
    pub wall_seconds: f64,
    /// Largest resident set in bytes; `None` where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
}

/// Measures one process from a moment on.
#[derive(Debug)]
pub(crate) struct Meter {
    pid: u32,
    started: Instant,
    cpu_before: Duration,
    cpu: Option<Duration>,
    peak_memory: Option<u64>,
    /// When it was last seen to have computed something, and its CPU time then.
    busy: (Instant, Duration),
}

/// Who uses less CPU time is idle: to wake now and then and look costs less.
const COMPUTING: Duration = Duration::from_millis(100);

impl Meter {
    /// From the birth of a process that was started this moment.
    pub fn from_birth(pid: u32, started: Instant) -> Self {
        let busy = (started, Duration::ZERO);
        Self { pid, started, cpu_before: Duration::ZERO, cpu: None, peak_memory: None, busy }
    }

    /// From now on.
    pub fn from_now(pid: u32) -> Self {
        system::reset_peak_memory(pid);
        let cpu_before = system::cpu_time(pid).unwrap_or_default();
        let started = Instant::now();
        let busy = (started, Duration::ZERO);
        Self { pid, started, cpu_before, cpu: None, peak_memory: None, busy }
    }

    /// Reads the clocks. What cannot be read any more keeps its last value, so that a killed
    /// process still shows what it had used.
    pub fn sample(&mut self) -> Usage {
        let wall = self.started.elapsed();
        if let Some(cpu) = system::cpu_time(self.pid) {
            let cpu = cpu.saturating_sub(self.cpu_before);
            self.cpu = Some(cpu);
            if cpu >= self.busy.1 + COMPUTING {
                self.busy = (Instant::now(), cpu);
            }
        }
        if let Some(bytes) = system::peak_memory(self.pid) {
            self.peak_memory = Some(bytes);
        }
        Usage {
            cpu_seconds: self.cpu.map(|cpu| cpu.as_secs_f64()),
            wall_seconds: wall.as_secs_f64(),
            peak_memory_bytes: self.peak_memory,
        }
    }

    /// How long it has computed nothing to speak of, as seen by looking now and then; `None` where the system does not
    /// tell.
    pub fn idle(&self) -> Option<Duration> {
        self.cpu.map(|_| self.busy.0.elapsed())
    }
}

/// Whether CPU time and memory of another process can be known on this system.
pub fn measures_cpu_time() -> bool {
    system::cpu_time(std::process::id()).is_some()
}

#[cfg(target_os = "linux")]
mod system {
    use std::fs;
    use std::time::Duration;

    use nix::time::clock_getcpuclockid;
    use nix::unistd::{Pid, SysconfVar, sysconf};

    pub fn cpu_time(pid: u32) -> Option<Duration> {
        let own = clock(pid)? + waited_children(pid).unwrap_or_default();
        Some(own + children(pid).into_iter().filter_map(cpu_time).sum::<Duration>())
    }

    fn clock(pid: u32) -> Option<Duration> {
        let clock = clock_getcpuclockid(Pid::from_raw(i32::try_from(pid).ok()?)).ok()?;
        clock.now().ok().map(Duration::from)
    }

    /// The time of children that ended and were waited for.
    fn waited_children(pid: u32) -> Option<Duration> {
        let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        // The second field is the program's name in brackets and may hold spaces and brackets.
        let after_name = &stat[stat.rfind(')')? + 1..];
        let mut fields = after_name.split_ascii_whitespace().skip(13);
        let (user, system): (u64, u64) =
            (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
        let per_second = sysconf(SysconfVar::CLK_TCK).ok()??;
        Some(Duration::from_secs_f64((user + system) as f64 / per_second as f64))
    }

    /// Children that still run. Empty where the kernel does not list them.
    fn children(pid: u32) -> Vec<u32> {
        let Ok(tasks) = fs::read_dir(format!("/proc/{pid}/task")) else { return Vec::new() };
        tasks
            .flatten()
            .filter_map(|task| fs::read_to_string(task.path().join("children")).ok())
            .flat_map(|list| {
                list.split_ascii_whitespace().filter_map(|p| p.parse().ok()).collect::<Vec<_>>()
            })
            .collect()
    }

    pub fn peak_memory(pid: u32) -> Option<u64> {
        let status = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
        let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
        Some(kibibytes * 1024)
    }

    pub fn reset_peak_memory(pid: u32) {
        // Where the kernel refuses, the peak since the start is shown instead: never less.
        let _ = fs::write(format!("/proc/{pid}/clear_refs"), "5");
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    use std::time::Duration;

    pub fn cpu_time(_pid: u32) -> Option<Duration> {
        None
    }

    pub fn peak_memory(_pid: u32) -> Option<u64> {
        None
    }

    pub fn reset_peak_memory(_pid: u32) {}
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::process::{Command, Stdio};

    #[test]
    fn work_done_shows_in_the_clock() {
        let mut meter = Meter::from_now(std::process::id());
        let mut sum = 0u64;
        let worked = loop {
            sum = (0..200_000u64).fold(sum, |a, b| std::hint::black_box(a ^ b));
            let usage = meter.sample();
            if usage.cpu_seconds.unwrap() > 0.01 {
                break usage;
            }
        };
        assert!(worked.wall_seconds > 0.0 && worked.peak_memory_bytes.unwrap() > 1 << 16);
    }

    #[test]
    fn an_ended_process_keeps_its_clock_until_it_is_waited_for() {
        let started = Instant::now();
        let mut child = Command::new("/bin/sh")
            // The inner shell is a child of the child: its time counts once it is waited for.
            .args(["-c", "/bin/sh -c 'i=0; while [ $i -lt 30000 ]; do i=$((i+1)); done'; exit 0"])
            .stdin(Stdio::null())
            .spawn()
            .unwrap();
        let pid = nix::unistd::Pid::from_raw(child.id() as i32);
        use nix::sys::wait::{Id, WaitPidFlag, waitid};
        waitid(Id::Pid(pid), WaitPidFlag::WEXITED | WaitPidFlag::WNOWAIT).unwrap();
        let mut meter = Meter::from_birth(child.id(), started);
        assert!(meter.sample().cpu_seconds.unwrap() > 0.0);
        child.wait().unwrap();
        assert!(meter.sample().cpu_seconds.unwrap() > 0.0, "the last value is kept");
    }
}
