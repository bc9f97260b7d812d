//! `hazcam completions`: what the shell needs to complete commands and options.

use std::process::ExitCode;

use clap::Command;
use clap_complete::Shell;

use crate::ui::Ui;

/// Print the completion script of a shell
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  hazcam completions bash > ~/.local/share/bash-completion/completions/hazcam"
)]
pub struct Args {
    /// Which shell
    shell: Shell,
}

/// Prints the script.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let all = crate::cli::command();
    // What is hidden in the help would be completed.
    let shown = all.get_subcommands().filter(|command| !command.is_hide_set());
    let mut command = Command::new("hazcam")
        .version(env!("CARGO_PKG_VERSION"))
        .args(all.get_arguments())
        .subcommands(shown);
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "hazcam", &mut script);
    ui.write(&script)?;
    Ok(ExitCode::SUCCESS)
}
