//! Which files can be reached (Landlock).
//!
//! Version 3 of Landlock (Linux 6.2) is the least: before it, a file that may be read could still
//! be truncated. What later versions add is used where it is there: TCP is refused (version 4,
//! seccomp refuses all sockets anyway), so are device controls (5), and signals and abstract Unix
//! sockets cannot leave the sandbox (6).

use std::io;
use std::path::Path;

use landlock::{
    ABI, Access, AccessFs, AccessNet, BitFlags, CompatLevel, Compatible, PathBeneath, PathFd,
    Ruleset, RulesetAttr, RulesetCreated, RulesetCreatedAttr, RulesetStatus, Scope,
};

use super::{Policy, SYSTEM_PATHS};

/// The least version of Landlock.
const NEEDED: ABI = ABI::V3;

/// A ruleset that forbids everything; an error says that the kernel cannot.
pub(super) fn forbid_everything() -> Result<RulesetCreated, String> {
    Ruleset::default()
        .set_compatibility(CompatLevel::HardRequirement)
        .handle_access(AccessFs::from_all(NEEDED))
        .map_err(|error| error.to_string())?
        .set_compatibility(CompatLevel::BestEffort)
        .handle_access(AccessFs::from_all(ABI::V5))
        .and_then(|ruleset| ruleset.handle_access(AccessNet::from_all(ABI::V4)))
        .and_then(|ruleset| ruleset.scope(Scope::from_all(ABI::V6)))
        .and_then(Ruleset::create)
        .map_err(|error| error.to_string())
}

/// Restricts this process, for good.
pub(super) fn restrict(policy: &Policy) -> io::Result<()> {
    let read = AccessFs::from_read(NEEDED);
    // No links, pipes, sockets or devices, and nothing that could be executed.
    let write = AccessFs::ReadFile
        | AccessFs::ReadDir
        | AccessFs::WriteFile
        | AccessFs::Truncate
        | AccessFs::MakeReg
        | AccessFs::MakeDir
        | AccessFs::RemoveFile
        | AccessFs::RemoveDir
        | AccessFs::Refer;
    let mut rules = forbid_everything().map_err(io::Error::other)?;
    for path in SYSTEM_PATHS.map(Path::new) {
        match path.exists() {
            true => rules = allow(rules, path, read)?,
            false => continue,
        }
    }
    rules = allow(rules, Path::new("/dev/null"), AccessFs::ReadFile | AccessFs::WriteFile)?;
    for path in &policy.readable {
        rules = allow(rules, path, read)?;
    }
    for path in &policy.writable {
        rules = allow(rules, path, write)?;
    }
    let status = rules.restrict_self().map_err(io::Error::other)?;
    match status.ruleset {
        RulesetStatus::NotEnforced => Err(io::Error::other("Landlock was not enforced")),
        RulesetStatus::PartiallyEnforced | RulesetStatus::FullyEnforced => Ok(()),
    }
}

fn allow(
    rules: RulesetCreated,
    path: &Path,
    access: BitFlags<AccessFs>,
) -> io::Result<RulesetCreated> {
    let failed = |why: String| io::Error::other(format!("{}: {why}", path.display()));
    let folder = path.metadata().map_err(|error| failed(error.to_string()))?.is_dir();
    // Rights that only folders have are an error on a file.
    let access = if folder { access } else { access & AccessFs::from_file(NEEDED) };
    let opened = PathFd::new(path).map_err(|error| failed(error.to_string()))?;
    rules.add_rule(PathBeneath::new(opened, access)).map_err(|error| failed(error.to_string()))
}
