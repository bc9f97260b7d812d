//! `hazcam man`: the manual pages, made from the same text as `--help`.

use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use clap_mangen::Man;
use formats::write_atomically;

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

/// The heading of what follows the options.
const AFTER: &str = ".SH EXTRA\n";

/// Prints or writes the pages.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    // The help template lists the commands by group; a manual page lists them by itself.
    let mut command = crate::cli::command().disable_help_subcommand(true);
    command.build();
    match args.folder {
        Some(folder) => {
            write(&command, &folder)
                .with_context(|| format!("cannot write manual pages to {}", folder.display()))?;
            ui.note(format_args!("manual pages are in {}", folder.display()));
        }
        None => ui.write(&page(&Man::new(command))?)?,
    }
    Ok(ExitCode::SUCCESS)
}

/// Writes the pages of a command and of all below it.
fn write(command: &clap::Command, folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder)?;
    for below in command.get_subcommands().filter(|below| !below.is_hide_set()) {
        write(below, folder)?;
    }
    let man = Man::new(command.clone());
    let text = page(&man)?;
    write_atomically(folder.join(man.get_filename()), |file| file.write_all(&text))?;
    Ok(())
}

/// A page, with the text that follows the options line by line as it is: it has tables and commands.
fn page(man: &Man) -> io::Result<Vec<u8>> {
    let (mut page, mut after) = (Vec::new(), Vec::new());
    man.render(&mut page)?;
    man.render_extra_section(&mut after)?;
    let [page, after] = [page, after].map(|text| String::from_utf8_lossy(&text).into_owned());
    let Some((_, lines)) = after.split_once(AFTER) else { return Ok(page.into_bytes()) };
    let as_it_is = format!(".SH NOTES\n.nf\n{lines}.fi\n");
    Ok(page.replace(&format!("{AFTER}{lines}"), &as_it_is).into_bytes())
}
