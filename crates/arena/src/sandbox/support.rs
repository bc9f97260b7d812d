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
    } else if let Err(why) = try_filter() {
        missing.push(format!("seccomp filters ({why})"));
    }
    missing
}

/// Applies a filter that allows everything to a thread that then ends: whether it can be done is
/// known only by doing it, since containers forbid what their kernel offers.
#[cfg(target_os = "linux")]
fn try_filter() -> Result<(), String> {
    let program = super::syscalls::allow_everything().map_err(|error| error.to_string())?;
    std::thread::spawn(move || seccompiler::apply_filter(&program))
        .join()
        .map_err(|_| "it could not be tried".to_owned())?
        .map_err(|error| error.to_string())
}
