//! How long an engine may take.

use std::time::Duration;

/// Limits of time for one engine. What runs past them is killed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// From the start of the process until it is ready (wall time).
    pub start: Duration,
    /// One job (wall time).
    pub wall: Duration,
    /// One job (CPU time of all threads); `None` sets no limit. Without effect where the system
    /// does not tell the CPU time of another process.
    pub cpu: Option<Duration>,
    /// Without computing anything (wall time), as one that sleeps or waits for what never comes; `None` sets no limit.
    /// Without effect where CPU time is not told.
    pub idle: Option<Duration>,
}

impl Default for Limits {
    /// A minute to start, ten minutes a job, no other limit.
    fn default() -> Self {
        let (start, wall) = (Duration::from_secs(60), Duration::from_secs(600));
        Self { start, wall, cpu: None, idle: None }
    }
}
