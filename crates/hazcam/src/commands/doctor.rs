//! `hazcam doctor`: what this machine offers.

use std::process::ExitCode;

use matching::Level;

use crate::ui::Ui;

/// Say what this machine offers and whether matching works on it
#[derive(clap::Args)]
pub struct Args {}

/// Prints one line per finding.
pub fn run(_args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    ui.print(&format!("vector instructions  {:?}\n", Level::chosen()))?;
    Ok(ExitCode::SUCCESS)
}
