//! `hazcam explain`: what a matcher does, in a few lines with its sources, or which matchers there are.

use std::process::ExitCode;

use matching::Preset;

use crate::ui::Ui;

/// Say what a matcher does, step by step, with its sources, or which matchers there are
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  hazcam explain\n  hazcam explain best")]
pub struct Args {
    /// Which matcher [default: all, in a line or two each]
    #[arg(value_name = "MATCHER", value_parser = super::choice(Preset::ALL.map(Preset::name)))]
    matcher: Option<String>,
}

/// Prints the explanation that stands in the matcher's own documentation.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let text = match args.matcher {
        Some(matcher) => matcher.parse::<Preset>()?.explanation().trim_end().to_owned(),
        None => list(),
    };
    ui.print(&format!("{text}\n"))?;
    Ok(ExitCode::SUCCESS)
}

/// What each matcher is, by the first line of its explanation, when to choose it, and where more is said.
fn list() -> String {
    let matchers = Preset::ALL.map(|preset| {
        let title = preset.explanation().lines().next().unwrap_or_default();
        format!("{title}\n  {}\n", when(preset))
    });
    format!("{}\n`hazcam explain MATCHER` says more, step by step.", matchers.concat())
}

/// When to choose it.
fn when(preset: Preset) -> &'static str {
    match preset {
        Preset::Fast => "Where time matters most: many frames a second, or large images.",
        Preset::Balanced => {
            "For most uses, and what `hazcam match` takes: good answers in real time."
        }
        Preset::Best => "Where accuracy matters most, and seconds do not.",
    }
}
