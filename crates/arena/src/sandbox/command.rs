//! The command that starts a program confined.

use std::path::Path;
use std::process::Command;

use super::Policy;

/// Wraps `command`, so that it runs under `policy`: `helper` is a binary whose command
/// `sandbox-exec POLICY PROGRAM ARGUMENTS...` calls [`super::enter`].
///
/// The program's environment is exactly what was set on `command`, nothing is inherited: secrets
/// like to live in environments.
pub fn confine(command: &Command, policy: &Policy, helper: &Path) -> Command {
    let mut wrapped = Command::new(helper);
    let policy = serde_json::to_string(policy).expect("a policy is plain data");
    wrapped.arg("sandbox-exec").arg(policy).arg(command.get_program()).args(command.get_args());
    wrapped.env_clear();
    wrapped.envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))));
    if let Some(folder) = command.get_current_dir() {
        wrapped.current_dir(folder);
    }
    wrapped
}
