//! `hazcam sandbox-exec`: confines this process and becomes another program. Started by
//! `hazcam grade`, not by people.

use std::ffi::OsString;
use std::io::{self, Write};
use std::process::ExitCode;

use anyhow::Context;
use arena::sandbox::{self, Policy};

use crate::ui::Ui;

/// Confine this process and run a program in its place
#[derive(clap::Args)]
pub struct Args {
    /// What the program may touch, as JSON
    policy: String,
    /// The program's full path
    program: OsString,
    /// Its arguments
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

/// Comes back only when the program could not be started.
pub fn run(args: Args, _ui: &Ui) -> anyhow::Result<ExitCode> {
    let policy: Policy = serde_json::from_str(&args.policy).context("the policy is malformed")?;
    let error = sandbox::enter(&policy, &args.program, &args.arguments);
    // The status says it too, should nobody read this.
    let _ = writeln!(io::stderr(), "{}", sandbox::failure(&policy.token, error));
    Ok(ExitCode::from(sandbox::EXIT_STATUS))
}
