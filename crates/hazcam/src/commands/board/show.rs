//! `hazcam board show`: the ranking on the terminal, or for programs.

use std::path::Path;
use std::process::ExitCode;

use arena::board::{Board, standings, table};

use crate::ui::Ui;

/// Print the ranking
#[derive(clap::Args)]
pub struct Args {
    /// How to print it
    #[arg(long, default_value = "text")]
    #[arg(value_parser = crate::commands::choice(["text", "json", "csv", "markdown"]))]
    format: String,
}

/// Prints it.
pub fn run(path: &Path, args: &Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let board = Board::open(path)?;
    let standings = standings(board.entries()?, &board.holdout()?.0.test);
    let text = match args.format.as_str() {
        "json" => format!("{}\n", serde_json::to_string_pretty(&standings)?),
        "csv" => table(&standings).to_csv(),
        "markdown" => table(&standings).to_markdown(),
        _ if standings.is_empty() => "There are no entries yet.\n".into(),
        _ => table(&standings).to_text(),
    };
    ui.print(&text)?;
    Ok(ExitCode::SUCCESS)
}
