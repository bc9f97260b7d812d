//! `hazcam man`: the manual pages, made from the same text as `--help`.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;

use crate::ui::Ui;

/// Print the manual page, or write a page per command into a folder
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  hazcam man | man -l -\n  hazcam man --folder ~/.local/share/man/man1"
)]
pub struct Args {
    /// Write `hazcam.1` and one page per command here instead of printing the first
    #[arg(long, value_name = "FOLDER")]
    folder: Option<PathBuf>,
}

/// Prints or writes the pages.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    // The help template lists the commands by group; a manual page lists them by itself.
    let command = crate::cli::command();
    match args.folder {
        Some(folder) => {
            std::fs::create_dir_all(&folder)
                .and_then(|()| clap_mangen::generate_to(command, &folder))
                .with_context(|| format!("cannot write manual pages to {}", folder.display()))?;
            ui.note(format_args!("manual pages are in {}", folder.display()));
        }
        None => {
            let mut page = Vec::new();
            clap_mangen::Man::new(command).render(&mut page)?;
            ui.write(&page)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
