//! How long something took: on the wall, and on the processor.

use std::time::{Duration, Instant};

use serde::Serialize;

/// Started now, read later.
pub struct Stopwatch {
    wall: Instant,
    cpu: Option<Duration>,
}

/// What a stopwatch shows.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Elapsed {
    /// Seconds on the wall.
    pub wall_s: f64,
    /// Seconds of processor time of this process, all threads together; none where the system
    /// does not tell.
    pub cpu_s: Option<f64>,
}

impl Stopwatch {
    /// Starts.
    pub fn start() -> Self {
        Self { wall: Instant::now(), cpu: cpu_time() }
    }

    /// The time since the start.
    pub fn elapsed(&self) -> Elapsed {
        let cpu = cpu_time().zip(self.cpu).map(|(now, then)| now.saturating_sub(then));
        Elapsed {
            wall_s: self.wall.elapsed().as_secs_f64(),
            cpu_s: cpu.map(|cpu| cpu.as_secs_f64()),
        }
    }
}

#[cfg(unix)]
fn cpu_time() -> Option<Duration> {
    use nix::time::{ClockId, clock_gettime};
    clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID).ok().map(Duration::from)
}

#[cfg(not(unix))]
fn cpu_time() -> Option<Duration> {
    None
}
