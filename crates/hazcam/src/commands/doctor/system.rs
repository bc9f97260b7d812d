//! What the processor, the kernel and the disk offer.

use std::collections::BTreeMap;
use std::path::Path;
use std::thread;

use matching::Level;

use super::Finding;
use crate::arguments;

/// Processor, memory and sandbox.
pub fn look() -> Vec<Finding> {
    vec![vector_instructions(), cores(), memory(), sandbox()]
}

/// The vector instructions that kernels will use, out of those that there are.
fn vector_instructions() -> Finding {
    const TOPIC: &str = "vector instructions";
    let available: Vec<_> = Level::available().iter().map(|level| level.name()).collect();
    match Level::chosen() {
        Ok(level) => Finding::ok(TOPIC, format!("{} of {}", level.name(), available.join(", "))),
        Err(error) => Finding::wrong(TOPIC, error.to_string()),
    }
}

/// How many threads run at the same time, and how many `match` is told to use.
fn cores() -> Finding {
    let told = std::env::var("HAZCAM_THREADS").ok().filter(|told| !told.is_empty());
    let used = match told.as_deref().map(|told| (told, arguments::threads(told))) {
        Some((told, Err(why))) => {
            let problem = format!("HAZCAM_THREADS is `{told}`: {why}, or unset it");
            return Finding::wrong("cores", problem);
        }
        Some((_, Ok(threads))) => format!("; `match` uses {threads} threads (HAZCAM_THREADS)"),
        None => String::new(),
    };
    match thread::available_parallelism() {
        Ok(count) => Finding::ok("cores", format!("{count}{used}")),
        Err(error) => Finding::absent("cores", format!("the system does not say: {error}{used}")),
    }
}

/// The memory of the machine, and what is free of it.
fn memory() -> Finding {
    let gib = |kib: u64| kib as f64 / f64::from(1 << 20);
    let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    match (kibibytes(&text, "MemTotal"), kibibytes(&text, "MemAvailable")) {
        (Some(total), Some(free)) => {
            let mut found = format!("{:.1} GiB, {:.1} GiB free", gib(total), gib(free));
            // Less for this process.
            if let Some(bytes) = matching::memory_bound() {
                let bound = gib(bytes as u64 >> 10);
                found += &format!(
                    "; this process may take {bound:.2} GiB (its container, service or ulimit)"
                );
            }
            Finding::ok("memory", found)
        }
        _ => Finding::absent("memory", "this system does not say how much there is"),
    }
}

/// A line of `/proc/meminfo`.
fn kibibytes(meminfo: &str, name: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?;
    line.trim().strip_suffix(" kB")?.parse().ok()
}

/// Whether programs can be confined.
fn sandbox() -> Finding {
    let missing = arena::sandbox::missing_parts();
    match missing.is_empty() {
        true => Finding::ok("sandbox", "Landlock and seccomp"),
        false => Finding::absent(
            "sandbox",
            format!("{}; grading untrusted programs needs it", missing.join("; ")),
        ),
    }
}

/// The scenes found in the folder that `HAZCAM_DATA` names.
pub fn data() -> Finding {
    const TOPIC: &str = "data sets";
    let Some(folder) = std::env::var_os("HAZCAM_DATA").filter(|name| !name.is_empty()) else {
        return Finding::absent(
            TOPIC,
            "HAZCAM_DATA names no folder; real scenes need it, `hazcam demo` does not",
        );
    };
    let folder = Path::new(&folder);
    match arena::dataset::open(folder) {
        Ok(cases) => {
            // A case's id begins with the name of its family.
            let mut families: BTreeMap<&str, usize> = BTreeMap::new();
            for case in &cases {
                let family = case.id.split('/').next().unwrap_or_default();
                *families.entry(family).or_default() += 1;
            }
            let counts: Vec<_> =
                families.iter().map(|(family, count)| format!("{family} {count}")).collect();
            let found = format!("{}: {} scenes", folder.display(), cases.len());
            Finding::ok(TOPIC, format!("{found} ({})", counts.join(", ")))
        }
        Err(error) => Finding::absent(TOPIC, format!("HAZCAM_DATA: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_read_from_its_line() {
        let text = "MemTotal:       24576 kB\nMemAvailable:    1024 kB\nHugePages_Total:       0\n";
        assert_eq!(kibibytes(text, "MemTotal"), Some(24576));
        assert_eq!(kibibytes(text, "MemAvailable"), Some(1024));
        assert_eq!(kibibytes(text, "HugePages_Total"), None);
        assert_eq!(kibibytes("", "MemTotal"), None);
    }
}
