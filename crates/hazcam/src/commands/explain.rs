//! `hazcam explain`: what a matcher does, in a few lines with its sources.

use std::process::ExitCode;

use matching::Preset;

use crate::ui::Ui;

/// Say what a matcher does, step by step, with its sources
#[derive(clap::Args)]
#[command(after_help = "Example:\n  hazcam explain best")]
pub struct Args {
    /// Which matcher
    #[arg(value_name = "MATCHER", value_parser = super::choice(Preset::ALL.map(Preset::name)))]
    matcher: String,
}

/// Prints the explanation that stands in the matcher's own documentation.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let preset: Preset = args.matcher.parse()?;
    ui.print(&format!("{}\n", preset.explanation().trim_end()))?;
    Ok(ExitCode::SUCCESS)
}
