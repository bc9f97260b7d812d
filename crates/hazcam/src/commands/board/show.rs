//! `hazcam board show`: the ranking on the terminal, or for programs.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

use arena::board::{Board, Standing, standings, table};

use crate::ui::Ui;

/// Print the ranking
#[derive(clap::Args)]
pub struct Args {
    /// How to print it
    #[arg(long, default_value = "text")]
    #[arg(value_parser = crate::commands::choice(["text", "json", "csv", "markdown"]))]
    format: String,

    /// Say whose each entry is, and what is doubtful about it, for a list of marks: not for publishing
    #[arg(long)]
    owners: bool,
}

/// Prints it.
pub fn run(path: &Path, args: &Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let board = Board::open(path)?;
    let standings = standings(board.entries()?, &board.holdout()?.0.test);
    let owners = args.owners.then(|| board.owners()).transpose()?;
    let owners = owners.as_ref();
    let table = || table(&standings, owners);
    let text = match args.format.as_str() {
        "json" => format!("{}\n", serde_json::to_string_pretty(&listed(&standings, owners)?)?),
        "csv" => table().to_csv(),
        "markdown" => table().to_markdown(),
        _ if standings.is_empty() => "There are no entries yet.\n".into(),
        _ => table().to_text(),
    };
    ui.print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// The standings for programs: without owners also without doubts, and without the names of
/// hand-ins, which tell them.
fn listed(
    standings: &[Standing],
    owners: Option<&BTreeMap<String, String>>,
) -> serde_json::Result<serde_json::Value> {
    let mut listed = serde_json::to_value(standings)?;
    for (one, standing) in listed.as_array_mut().into_iter().flatten().zip(standings) {
        let entry = &mut one["entry"];
        match owners {
            Some(owners) => entry["owner"] = owners.get(&standing.entry.secret_id).cloned().into(),
            None => {
                let report = entry["report"].as_object_mut();
                report.and_then(|report| report.remove("entrant"));
                one.as_object_mut().and_then(|one| one.remove("doubts"));
            }
        }
    }
    Ok(listed)
}
