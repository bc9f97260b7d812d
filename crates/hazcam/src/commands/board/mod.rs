//! `hazcam board`: a leaderboard in one file.
//!
//! [`add`] grades and enters, [`show`] prints, [`export`] writes a page; [`edit`] renames and
//! removes.

mod add;
mod edit;
mod export;
mod show;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Subcommand;

use crate::arguments::or_variable;
use crate::ui::Ui;

/// Rank entrants on a hold-out that none of them has: a leaderboard in one file
///
/// `add` grades an entrant as `grade` does, runs it on the board's hold-out as well, and keeps the
/// results with pictures. The hold-out is a scene rendered from a seed that the board draws when it
/// is begun and keeps to itself, or a pair of your own (--holdout). Several `add` may run at once.
#[derive(clap::Args)]
#[command(after_help = "\
Rank: E_RMS and p_bad on the hold-out, each divided by the threshold of the hold-out's test (5 px and
0.11, as in Part 2, unless --holdout says others), and the mean of the two; lower wins, ties go to the
earlier entry. The first three get 5, 3 and 2 points on top of the 50 of the tests.

Examples:
  export HAZCAM_DATA=~/rob501
  for handin in handins/*.tar; do hazcam board add \"$handin\"; done
  hazcam board add --matcher opencv-bm:opencv-sgbm --baseline
  hazcam board show
  hazcam board export board.html")]
pub struct Args {
    /// The board's file. Keep it to yourself: it holds the hold-out
    #[arg(long, global = true, value_name = "FILE", default_value = BOARD)]
    #[arg(env = VARIABLE, hide_env_values = true)]
    board: PathBuf,

    #[command(subcommand)]
    command: Command,
}

/// The board's file where none is named, and what names one.
const BOARD: &str = "board.sqlite";
const VARIABLE: &str = "HAZCAM_BOARD";

/// Where the board lies for commands that are not told.
pub fn place() -> PathBuf {
    or_variable(None, VARIABLE).unwrap_or_else(|| BOARD.into())
}

#[derive(Subcommand)]
enum Command {
    Add(Box<add::Args>),
    Show(show::Args),
    Export(export::Args),
    Rename(edit::RenameArgs),
    Remove(edit::RemoveArgs),
}

/// Does what the subcommand says.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let board = &args.board;
    match args.command {
        Command::Add(args) => add::run(board, &args, ui),
        Command::Show(args) => show::run(board, &args, ui),
        Command::Export(args) => export::run(board, &args, ui),
        Command::Rename(args) => edit::rename(board, &args, ui),
        Command::Remove(args) => edit::remove(board, &args, ui),
    }
}
