//! `hazcam board rename` and `remove`: the instructor's hand on the board.

use std::path::Path;
use std::process::ExitCode;

use arena::board::Board;

use crate::ui::Ui;

/// Give somebody another name, which stays with the owner that --owner names
#[derive(clap::Args)]
pub struct RenameArgs {
    /// The secret ID on the board
    from: String,
    /// The new one, 4 to 32 printable characters, no space at an end
    to: String,
}

/// Take somebody off the board
#[derive(clap::Args)]
pub struct RemoveArgs {
    /// The secret ID on the board
    secret_id: String,
}

/// Gives somebody another name.
pub fn rename(path: &Path, args: &RenameArgs, ui: &Ui) -> anyhow::Result<ExitCode> {
    Board::open(path)?.rename(&args.from, &args.to)?;
    ui.note(format_args!("`{}` is now called `{}`", args.from, args.to));
    Ok(ExitCode::SUCCESS)
}

/// Takes somebody off the board.
pub fn remove(path: &Path, args: &RemoveArgs, ui: &Ui) -> anyhow::Result<ExitCode> {
    Board::open(path)?.remove(&args.secret_id)?;
    ui.note(format_args!("`{}` is removed", args.secret_id));
    Ok(ExitCode::SUCCESS)
}
