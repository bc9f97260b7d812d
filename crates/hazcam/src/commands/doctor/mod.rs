//! `hazcam doctor`: what this machine offers, and whether matching works on it.

mod python;
mod self_match;
mod system;

use std::process::ExitCode;

use serde::Serialize;

use crate::cli::ERROR;
use crate::ui::Ui;

/// Say what this machine offers and whether matching works on it
#[derive(clap::Args)]
#[command(after_help = "\
Everything but the self-match is optional: what is absent is told together with what it is for.

Environment:
  HAZCAM_CPU      vector instructions to use instead of the best
  HAZCAM_DATA     folder with stereo data sets
  HAZCAM_PYTHON   Python to look for numpy, scipy and OpenCV in
  HAZCAM_THREADS  threads that match uses

Exit status: 0 the self-match is right, 2 it is not.")]
pub struct Args {
    /// Print the findings as JSON
    #[arg(long)]
    json: bool,
}

/// One thing that was looked at.
#[derive(Serialize)]
pub struct Finding {
    /// What was looked at.
    topic: &'static str,
    verdict: Verdict,
    /// What was found, or what is missing and what for.
    detail: String,
}

#[derive(Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Verdict {
    /// There, or right.
    Ok,
    /// Not there; only what `detail` names needs it.
    Absent,
    /// Wrong: matching cannot be trusted.
    Wrong,
}

impl Finding {
    fn ok(topic: &'static str, detail: impl Into<String>) -> Self {
        Self { topic, verdict: Verdict::Ok, detail: detail.into() }
    }

    fn absent(topic: &'static str, detail: impl Into<String>) -> Self {
        Self { topic, verdict: Verdict::Absent, detail: detail.into() }
    }

    fn wrong(topic: &'static str, detail: impl Into<String>) -> Self {
        Self { topic, verdict: Verdict::Wrong, detail: detail.into() }
    }
}

/// Looks at one part of the machine.
type Look = fn() -> Vec<Finding>;

/// Looks at everything, then prints it.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let looks: [(&str, Look); 4] = [
        ("this machine", system::look),
        ("data sets", || vec![system::data()]),
        ("Python", python::look),
        ("matching a pair whose answer is known", self_match::run),
    ];
    let mut findings = vec![Finding::ok("version", env!("CARGO_PKG_VERSION"))];
    let progress = ui.progress(looks.len() as u64);
    for (what, look) in looks {
        progress.set_message(what);
        findings.extend(look());
        progress.inc(1);
    }
    progress.finish_and_clear();
    if args.json {
        ui.print(&(serde_json::to_string_pretty(&findings)? + "\n"))?;
    } else {
        for Finding { topic, verdict, detail } in &findings {
            let mark = match verdict {
                Verdict::Ok => "ok    ",
                Verdict::Absent => "absent",
                Verdict::Wrong => "WRONG ",
            };
            ui.print(&format!("{mark}  {topic:<20} {detail}\n"))?;
        }
    }
    let sound = findings.iter().all(|finding| finding.verdict != Verdict::Wrong);
    Ok(if sound { ExitCode::SUCCESS } else { ExitCode::from(ERROR) })
}
