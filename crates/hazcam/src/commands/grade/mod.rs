//! `hazcam grade`: points for a submission or a pair of engines.
//!
//! What is graded is in [`entrant`], by what and how in [`grading`], where scenes come from in
//! [`scenes`]; `hazcam board add` shares all three.

pub mod entrant;
pub mod grading;
pub mod scenes;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::bail;
use arena::grade::output::{autolab, gradescope, junit, text};
use arena::grade::{COURSE, Event, Outcome, Report};

use super::board;
use crate::cli::{ERROR, THRESHOLD_FAILED};
use crate::outputs::{self, Output};
use crate::ui::Ui;
use entrant::EntrantArguments;
use grading::{GradingArguments, Workshop};

/// Give points for a submission: six tests, each in a sandbox with a limit of CPU time
///
/// A submission is a folder or an archive with secret_id.py, stereo_disparity_fast.py and
/// stereo_disparity_best.py. Other engines, hazcam's own matchers included, take its place with
/// --matcher. Every test runs in a process of its own that cannot read the truth, reach the
/// network, start other processes or write outside of its folder.
#[derive(clap::Args)]
#[command(after_help = "\
How a test ends:
  OK   answered; the points depend on E_RMS and p_bad
  RE   run-time error: an exception, a missing file or function
  TO   out of CPU or wall time      ML   out of memory      SG   ended by a signal
  BAD  the answer is no disparity map: wrong shape, type or values
  XX   the grader failed, and not the entrant: the exit status is 2, and autolab and gradescope,
       which know no such end, get no results

The limits of CPU time are part of the scheme, 600 s on Cones and Teddy and 3000 s on KITTI: loops
in plain Python, which take 100 to 300 s on Cones, pass; what hangs is stopped. Wall time is limited
to three times as much and 10 s, and who computes nothing for a minute is stopped.

Examples:
  HAZCAM_DATA=~/rob501 hazcam grade handin.tar
  hazcam grade solution/ --format gradescope -o /autograder/results/results.json
  hazcam grade --matcher fast:best
  hazcam grade --print-scheme > mine.toml && hazcam grade solution/ --scheme mine.toml

Exit status: 0 graded, 1 fewer points than --fail-under, 2 the grader failed.")]
pub struct Args {
    #[command(flatten)]
    entrant: EntrantArguments,

    #[command(flatten)]
    grading: GradingArguments,

    /// How to show the results; with autolab the text comes first and the last line is Autolab's
    #[arg(long, default_value = "text", help_heading = "Output")]
    #[arg(value_parser = super::choice(["text", "json", "junit", "autolab", "gradescope"]))]
    format: String,

    /// Write the results to this file instead of stdout; the text then goes to stdout as well
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    output: Option<PathBuf>,

    /// End with status 1 when there are fewer points
    #[arg(long, value_name = "POINTS", value_parser = points, help_heading = "Output")]
    fail_under: Option<f64>,

    /// Print the course's tests, thresholds and points as TOML, to start your own from, and end
    #[arg(long, help_heading = "Output", exclusive = true)]
    print_scheme: bool,
}

/// The option that names the file of results.
const OUTPUT: &str = "--output";

fn points(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(points) if points.is_finite() => Ok(points),
        _ => Err("give a number of points".into()),
    }
}

/// Grades, showing each test before and after it is run.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    if args.print_scheme {
        ui.print(COURSE)?;
        return Ok(ExitCode::SUCCESS);
    }
    args.entrant.check()?;
    let shows_text = args.output.is_some() || matches!(args.format.as_str(), "text" | "autolab");
    let workshop = Workshop::open(&args.grading)?;
    args.check_output(workshop.scene_files())?;
    args.entrant.keep_from(workshop.scene_files())?;
    args.entrant
        .keep_from(&Vec::from_iter(Some(board::place()).filter(|board| board.is_file())))?;
    let (name, entrant) = args.entrant.open(&workshop)?;
    let grader = workshop.grader()?;
    args.grading.warn_if_unconfined(ui);
    let mut told = String::new();
    let mut shown = Ok(());
    // What stdout does not take must not keep the results from their file.
    let mut tell = |part: &str| {
        told.push_str(part);
        if shows_text && shown.is_ok() {
            shown = ui.print(part);
        }
    };
    tell(&text::header(&grader, &name));
    let inspection = grader.inspect(&entrant);
    tell(&text::findings(&inspection.findings));
    let report = grader.grade(&name, &entrant, inspection, &mut |event| {
        if let (Event::Begins(test), false) = (&event, shows_text) {
            ui.note(format_args!("{}: limit {} CPU s", test.name, test.cpu_seconds));
        }
        tell(&text::event(&event));
    });
    tell(&text::summary(&report));
    if report.grader_failed() && matches!(args.format.as_str(), "autolab" | "gradescope") {
        // They would take the points for the entrant's, and nothing is known of the entrant.
        bail!(
            "no results for {}, because the grader failed in {}: mend that and grade again",
            args.format,
            graders_faults(&report)
        );
    }
    let results = match (args.format.as_str(), &args.output) {
        ("text", Some(_)) => told,
        _ => results(&args.format, &report)?,
    };
    match &args.output {
        Some(path) => {
            outputs::write_all_or_none(&[Output::text(OUTPUT, path, &results)])?;
        }
        None => {
            shown?;
            ui.print(&results)?;
        }
    }
    Ok(match args.fail_under {
        _ if report.grader_failed() => ERROR.into(),
        Some(points) if report.points < points => {
            ui.fail(format_args!("{} points, under {points}", report.points));
            THRESHOLD_FAILED.into()
        }
        _ => ExitCode::SUCCESS,
    })
}

impl Args {
    /// Errors when the results could not be written, or would replace what they are made from: grading takes
    /// long.
    fn check_output(&self, scenes: &[PathBuf]) -> anyhow::Result<()> {
        let Some(path) = &self.output else { return Ok(()) };
        if self.entrant.submission().is_some_and(|folder| outputs::lies_in(path, folder)) {
            bail!("{OUTPUT} {} would lie in the submission: name another folder", path.display());
        }
        let engines = self.entrant.engine_files();
        let inputs = [self.entrant.submission(), self.grading.scheme()].into_iter().flatten();
        let files = scenes.iter().chain(&engines).map(PathBuf::as_path);
        let board = Some(board::place()).filter(|board| board.is_file());
        let inputs: Vec<&Path> = inputs.chain(files).chain(board.as_deref()).collect();
        outputs::check(&[Output::text(OUTPUT, path, "")], &inputs)
    }
}

/// The tests in which the grader failed, and why in the first: the text may not have been shown.
fn graders_faults(report: &Report) -> String {
    let failed = || report.tests.iter().filter(|test| test.outcome == Outcome::Xx);
    let names: Vec<String> = failed().map(|test| format!("`{}`", test.name)).collect();
    let why = failed().find_map(|test| test.message.as_deref()).unwrap_or("no reason is known");
    format!("{} ({why})", names.join(", "))
}

/// What the format adds to the text, which has been shown by now.
fn results(format: &str, report: &Report) -> anyhow::Result<String> {
    Ok(match format {
        "json" => format!("{}\n", serde_json::to_string_pretty(report)?),
        "junit" => junit::write(report),
        "autolab" => autolab::line(report),
        "gradescope" => gradescope::write(report),
        _ => String::new(),
    })
}
