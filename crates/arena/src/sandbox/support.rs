//! What this system lacks for a sandbox.

/// The parts of the sandbox that this system lacks, each in a few words with its reason. Empty
/// when programs can be confined.
pub fn missing_parts() -> Vec<String> {
    #[cfg(target_os = "linux")]
    return linux_lacks();
    #[cfg(not(target_os = "linux"))]
    return vec!["Landlock and seccomp, which only Linux has".to_owned()];
}

#[cfg(target_os = "linux")]
fn linux_lacks() -> Vec<String> {
    let mut missing = Vec::new();
    if let Err(why) = super::filesystem::forbid_everything() {
        missing.push(format!("Landlock of Linux 6.2 or newer ({why})"));
    }
    if let Err(why) = super::syscalls::compile() {
        missing.push(format!("seccomp filters ({why})"));
    } else if !kernel_has_seccomp_filters() {
        missing.push("seccomp filters (the kernel was built without them)".to_owned());
    }
    missing
}

/// The kernel shows how many filters a process has if, and only if, it has filters at all.
#[cfg(target_os = "linux")]
fn kernel_has_seccomp_filters() -> bool {
    std::fs::read_to_string("/proc/self/status")
        .is_ok_and(|status| status.lines().any(|line| line.starts_with("Seccomp_filters:")))
}
