//! The machine that a record was made on.

use std::borrow::Cow;
use std::fmt;
use std::fs;

use serde::{Deserialize, Serialize};

/// What a reader must know of a machine to judge a time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// The processor's name, as the system tells it.
    pub cpu: Option<String>,
    /// How many threads can run at once.
    pub cores: usize,
    /// The vector instructions that hazcam's presets use here.
    pub level: Option<String>,
    /// The architecture.
    pub architecture: Cow<'static, str>,
    /// The operating system.
    pub system: Cow<'static, str>,
}

impl Machine {
    /// The machine that this runs on. `level` names the vector instructions in use.
    pub fn this(level: Option<String>) -> Self {
        Self {
            cpu: cpu_name(),
            cores: std::thread::available_parallelism().map_or(1, |n| n.get()),
            level,
            architecture: std::env::consts::ARCH.into(),
            system: std::env::consts::OS.into(),
        }
    }
}

/// In a line: the processor, its cores, its vector instructions.
impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cpu = self.cpu.as_deref().unwrap_or(&self.architecture);
        let level = self.level.as_deref().unwrap_or("vector level unknown");
        write!(f, "{cpu}, {} cores, {level}", self.cores)
    }
}

/// The name in Linux's `/proc/cpuinfo`; elsewhere unknown.
fn cpu_name() -> Option<String> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
