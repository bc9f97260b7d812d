//! What the machine has.

/// Bytes of memory, with what it swaps to, where that can be told.
#[cfg(target_os = "linux")]
pub(crate) fn memory() -> Option<usize> {
    let told = rustix::system::sysinfo();
    let units = (told.totalram as usize).checked_add(told.totalswap as usize)?;
    units.checked_mul(told.mem_unit as usize)
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn memory() -> Option<usize> {
    None
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    #[test]
    fn memory_is_what_the_kernel_says_elsewhere_too() {
        let told = std::fs::read_to_string("/proc/meminfo").unwrap();
        let of = |name: &str| {
            let line = told.lines().find_map(|line| line.strip_prefix(name)).unwrap();
            line.trim().trim_end_matches(" kB").parse::<usize>().unwrap() * 1024
        };
        assert_eq!(super::memory(), Some(of("MemTotal:") + of("SwapTotal:")));
    }
}
