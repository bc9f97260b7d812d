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

/// What Linux's `/proc/cpuinfo` says of the first processor; elsewhere unknown.
fn cpu_name() -> Option<String> {
    name_in(&fs::read_to_string("/proc/cpuinfo").ok()?)
}

/// Its name and, where they are told, the numbers of its family and model: a virtual machine's name may be that of
/// several generations, one of which is twice as fast as another.
fn name_in(text: &str) -> Option<String> {
    let told = |what: &str| {
        let mut lines = text.lines().filter_map(|line| line.split_once(':'));
        lines.find(|(key, _)| key.trim() == what).map(|(_, value)| value.trim())
    };
    let name = told("model name")?;
    Some(match (told("cpu family"), told("model")) {
        (Some(family), Some(model)) => format!("{name} (family {family}, model {model})"),
        _ => name.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_processor_is_told_from_another_generation_of_its_name() {
        let text = "processor\t: 0\nvendor_id\t: AuthenticAMD\ncpu family\t: 25\nmodel\t\t: 17\n\
                    model name\t: AMD EPYC\nstepping\t: 1\nprocessor\t: 1\nmodel\t\t: 99\n";
        assert_eq!(name_in(text).unwrap(), "AMD EPYC (family 25, model 17)");
        assert_eq!(
            name_in("model name : ARMv7 Processor rev 4\n").unwrap(),
            "ARMv7 Processor rev 4"
        );
        assert_eq!(name_in("processor : 0\n"), None);
    }
}
