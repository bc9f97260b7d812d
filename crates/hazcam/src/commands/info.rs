//! `hazcam info`: what files hold.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::cli::ERROR;
use crate::ui::Ui;

/// Say what files hold: pictures, disparity maps, NumPy arrays, calibrations
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  hazcam info left.png disparity.pfm calib.txt
  hazcam info --json cones_disp_02.png

Exit status: 0 every file was understood, 2 some were not.")]
pub struct Args {
    /// Files to look into
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,

    /// Print a JSON array
    #[arg(long)]
    json: bool,
}

/// Prints what it finds in each file; one that cannot be read does not hide the others.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let mut status = ExitCode::SUCCESS;
    let mut found = Vec::new();
    for path in &args.files {
        match formats::inspect(path) {
            Ok(info) if args.json => found.push(info),
            Ok(info) => ui.print(&format!("{info}\n"))?,
            Err(error) => {
                ui.error(&error.into());
                status = ExitCode::from(ERROR);
            }
        }
    }
    if args.json {
        ui.print(&(serde_json::to_string_pretty(&found)? + "\n"))?;
    }
    Ok(status)
}
