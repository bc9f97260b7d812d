//! The command that starts a program confined.

use std::io;
use std::path::Path;
use std::process::Command;

use super::Policy;

/// Wraps `command`, so that it runs under `policy`: `helper` is a binary whose command
/// `sandbox-exec POLICY PROGRAM ARGUMENTS...` calls [`super::enter`].
///
/// The program's environment is exactly what was set on `command`, nothing is inherited: secrets
/// like to live in environments.
///
/// Errors when the policy names a path that is not UTF-8, which the helper cannot be told.
pub fn confine(command: &Command, policy: &Policy, helper: &Path) -> io::Result<Command> {
    let paths = policy.readable.iter().chain(&policy.writable).chain([&policy.pid_file]);
    if let Some(path) = { paths }.find(|path| path.to_str().is_none()) {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("the name of {} is not UTF-8: rename it", path.display()),
        ));
    }
    let policy = serde_json::to_string(policy)?;
    let mut wrapped = Command::new(helper);
    wrapped.arg("sandbox-exec").arg(policy).arg(command.get_program()).args(command.get_args());
    wrapped.env_clear();
    wrapped.envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))));
    if let Some(folder) = command.get_current_dir() {
        wrapped.current_dir(folder);
    }
    Ok(wrapped)
}
