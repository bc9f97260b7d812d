//! What memory there is for this process.

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// How a process can be bounded: by a control group, as containers and services are, where who takes more is
/// killed; by its address space; by its data. The last two are what `ulimit -v` and `-d` set, where who takes
/// more gets none.
pub(crate) const BOUNDS: usize = 3;

/// What memory there is, as far as the system tells.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Memory {
    /// Bytes of the machine, with what it swaps to.
    pub whole: Option<usize>,
    /// Bytes of each of the [`BOUNDS`] that is less.
    pub bounds: [Option<usize>; BOUNDS],
}

impl Memory {
    /// What there is now.
    #[cfg(target_os = "linux")]
    pub fn now() -> Self {
        // From files, not by calls that a sandbox may forbid.
        let [groups, limits] =
            ["cgroup", "limits"].map(|file| std::fs::read_to_string(format!("/proc/self/{file}")));
        let whole = whole();
        let group = bound(Path::new("/sys/fs/cgroup"), &groups.unwrap_or_default());
        let limits = limits.unwrap_or_default();
        let bounds = [group, limit(&limits, "Max address space"), limit(&limits, "Max data size")];
        // Where nobody bounds it, a huge number may stand.
        let counts = |bound: &usize| whole.is_none_or(|whole| *bound < whole);
        Self { whole, bounds: bounds.map(|bound| bound.filter(counts)) }
    }

    #[cfg(not(target_os = "linux"))]
    pub fn now() -> Self {
        Self { whole: None, bounds: [None; BOUNDS] }
    }
}

/// The most bytes that this process may take, by a control group (a container, a service) or `ulimit`; `None` where
/// that is no less than the machine has, or where the system does not tell (other than Linux).
pub fn memory_bound() -> Option<usize> {
    Memory::now().bounds.into_iter().flatten().min()
}

/// What a line of `/proc/self/limits` says that a process may take now; nothing where that is unlimited.
#[cfg_attr(not(target_os = "linux"), allow(dead_code))]
fn limit(limits: &str, name: &str) -> Option<usize> {
    let line = limits.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_ascii_whitespace().next()?.parse().ok()
}

/// Bytes that this process has taken of each of the [`BOUNDS`], of that of a group without the files that it only
/// reads; 0 where that cannot be told. Nothing is allocated.
pub(crate) fn taken() -> [usize; BOUNDS] {
    let mut text = [0; 128];
    let read = File::open("/proc/self/statm").and_then(|mut file| file.read(&mut text));
    let text = std::str::from_utf8(&text[..read.unwrap_or(0)]).unwrap_or_default();
    let mut pages = [0usize; 6];
    for (pages, number) in pages.iter_mut().zip(text.split_ascii_whitespace()) {
        *pages = number.parse().unwrap_or(0);
    }
    // All its pages, those that are there, and those of these that are shared; its code, nothing, and its data.
    let [all, there, shared, _, _, data] = pages;
    let taken = [there.saturating_sub(shared), all, data];
    // Where a sandbox hides this file it also hides how large a page is.
    if all == 0 { taken } else { taken.map(|pages| pages * page_size()) }
}

#[cfg(target_os = "linux")]
fn page_size() -> usize {
    rustix::param::page_size()
}

#[cfg(not(target_os = "linux"))]
fn page_size() -> usize {
    0
}

#[cfg(target_os = "linux")]
fn whole() -> Option<usize> {
    let told = rustix::system::sysinfo();
    let units = (told.totalram as usize).checked_add(told.totalswap as usize)?;
    units.checked_mul(told.mem_unit as usize)
}

/// The least bound of some control groups and of those that these lie in: `groups` are lines as in
/// `/proc/self/cgroup`, of either version, `root` is where the groups are mounted.
#[cfg_attr(not(target_os = "linux"), allow(dead_code))]
fn bound(root: &Path, groups: &str) -> Option<usize> {
    let bounds = groups.lines().filter_map(|line| {
        let mut fields = line.splitn(3, ':').skip(1);
        let (controllers, group) = (fields.next()?, fields.next()?);
        let (folder, file) = match controllers {
            "" => (root.to_owned(), "memory.max"),
            _ if controllers.split(',').any(|controller| controller == "memory") => {
                (root.join("memory"), "memory.limit_in_bytes")
            }
            _ => return None,
        };
        // Where there is no bound, a word or a huge number stands instead.
        let of_group = |group: &Path| {
            std::fs::read_to_string(folder.join(group).join(file)).ok()?.trim().parse().ok()
        };
        Path::new(group.trim_start_matches('/')).ancestors().filter_map(of_group).min()
    });
    bounds.min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn memory_is_what_the_kernel_says_elsewhere_too() {
        let told = std::fs::read_to_string("/proc/meminfo").unwrap();
        let of = |name: &str| {
            let line = told.lines().find_map(|line| line.strip_prefix(name)).unwrap();
            line.trim().trim_end_matches(" kB").parse::<usize>().unwrap() * 1024
        };
        assert_eq!(whole(), Some(of("MemTotal:") + of("SwapTotal:")));
        let Memory { whole: told, bounds } = Memory::now();
        assert_eq!(told, whole());
        assert!(bounds.iter().all(|&bound| bound < told));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn what_is_taken_is_told() {
        let before = taken();
        // More than other tests in this process may give back meanwhile.
        let more = std::hint::black_box(vec![1u8; 256 << 20]);
        let now = taken();
        for (now, before) in now.into_iter().zip(before) {
            assert!(now > before + (128 << 20), "{before}, {now} with {}", more.len());
        }
    }

    #[test]
    fn limits_are_those_that_hold_now() {
        let limits = "Limit                     Soft Limit           Hard Limit           Units     \n\
                      Max data size             unlimited            unlimited            bytes     \n\
                      Max address space         307200000            unlimited            bytes     \n";
        assert_eq!(limit(limits, "Max address space"), Some(307_200_000));
        assert_eq!(limit(limits, "Max data size"), None);
        assert_eq!(limit("", "Max data size"), None);
    }

    #[test]
    fn the_least_bound_of_all_groups_around_counts() {
        let root = tempfile::tempdir().unwrap();
        let write = |file: &str, text: &str| {
            let path = root.path().join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        write("memory.max", "900\n");
        write("robot.slice/memory.max", "300\n");
        write("robot.slice/camera.service/memory.max", "max\n");
        write("other.slice/memory.max", "5\n");
        let of = |groups: &str| bound(root.path(), groups);
        assert_eq!(of("0::/robot.slice/camera.service\n"), Some(300));
        assert_eq!(of("0::/robot.slice/gone\n"), Some(300));
        assert_eq!(of("0::/\n"), Some(900));
        assert_eq!(of("3:cpuset:/other.slice\nnonsense\n"), None);
        assert_eq!(of(""), None);
        // The first version, which has a tree of its own for memory.
        write("memory/docker/memory.limit_in_bytes", "200\n");
        write("memory/memory.limit_in_bytes", "9223372036854771712\n");
        assert_eq!(of("4:memory:/docker\n0::/robot.slice\n"), Some(200));
        assert_eq!(of("4:cpu,memory:/\n"), Some(9_223_372_036_854_771_712));
    }
}
