//! `hazcam board export`: the board as a page.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::bail;
use arena::board::{Board, Picture, standings};
use arena::viewer::{BoardPage, board_page};

use crate::outputs::{self, Output};
use crate::ui::Ui;

/// Write the board as one HTML page that opens without a network
///
/// It has the ranking, accuracy over CPU time, and for every entrant and scene the disparities and
/// errors. Owners, messages of failed tests and the hold-out's pictures stay out of it.
#[derive(clap::Args)]
pub struct Args {
    /// The page
    #[arg(value_name = "FILE.html")]
    output: PathBuf,

    /// Its heading
    #[arg(long, default_value = "Dense stereo leaderboard")]
    title: String,

    /// Show the hold-out's pictures as well, when nobody enters any more
    #[arg(long)]
    reveal_holdout: bool,
}

/// Writes it.
pub fn run(path: &Path, args: &Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let board = Board::open(path)?;
    let page = |text| [Output::text("the page", &args.output, text)];
    outputs::check(&page(""), &[path])?;
    if args.output.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("html")) {
        bail!("{} is no name of a page for a browser: end it with .html", args.output.display());
    }
    let holdout = board.holdout()?.0;
    let standings = standings(board.entries()?, &holdout.test);
    let pictures: Vec<Vec<Picture>> = standings
        .iter()
        .map(|standing| board.pictures(&standing.entry.secret_id))
        .collect::<Result<_, _>>()?;
    let text = board_page(&BoardPage {
        title: &args.title,
        standings: &standings,
        pictures: &pictures,
        truths: &board.truths()?,
        holdout: &holdout,
        reveals_holdout: args.reveal_holdout,
    });
    outputs::write_all_or_none(&page(&text))?;
    ui.note(format_args!(
        "{} entries, {:.1} MB: {}",
        standings.len(),
        text.len() as f64 / 1e6,
        args.output.display()
    ));
    Ok(ExitCode::SUCCESS)
}
