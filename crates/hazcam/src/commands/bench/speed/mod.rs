//! `hazcam bench --speed`: how long matching takes, against OpenCV's matchers of the same kind.
//!
//! How it is measured is the arena's business (`arena::speed`); here stand the images
//! ([`sizes`]), what is asked for, and what is shown ([`report`]).

mod report;
mod sizes;

use std::path::PathBuf;
use std::process::ExitCode;

use arena::engine::Definition;
use arena::report::Format;
use arena::speed::{self, Event, PEERS, Record, Run, Setting};
use matching::Preset;

use super::contest::{tell_absent, tell_silent, this_machine};
use super::engines::EngineArguments;
use super::into::{Page, command_line};
use super::scenes::{SceneArguments, matching};
use crate::cli;
use crate::outputs::{self, Output};
use crate::ui::Ui;
use sizes::Size;

/// What is asked for besides scenes and engines.
#[derive(clap::Args)]
#[command(next_help_heading = "Speed")]
// Of the group, not of --speed alone: what an option needs is not asked for where another one excludes it.
#[group(conflicts_with_all = ["stress", "purpose", "reference", "limits", "jobs"])]
#[group(conflicts_with_all = ["ablation", "reliability", "obstacles", "out", "pictures"])]
pub struct SpeedArguments {
    /// Measure how long matching alone takes, against OpenCV's matchers of the same kind
    ///
    /// Engines take turns on the same grey images with the same number of threads: Cones with 64
    /// disparities and KITTI with 160 (where there is no data, rendered pairs of their sizes), 20 runs
    /// each, and a rendered pair of 3000 x 2000 pixels with 256, 3 runs; --repeat N sets the runs of
    /// all. Without --matcher and --engine, best and OpenCV's WLS run on the first alone.
    #[arg(long)]
    pub speed: bool,

    /// Measure on rendered sizes from 0.1 to 6 megapixels and 16 to 512 disparities instead, 5 runs
    /// each: does the time per pixel and disparity stay the same?
    #[arg(long, requires = "speed", conflicts_with = "data")]
    sweep: bool,

    /// Keep the runs in this JSON file, in the place of those of the same size, number of threads and
    /// machine; --into then shows all that it holds
    #[arg(long, value_name = "FILE", requires = "speed")]
    record: Option<PathBuf>,

    /// Measure nothing, show what --record holds
    #[arg(long, requires = "record")]
    #[arg(conflicts_with_all = ["sweep", "scenes", "data", "matcher", "engine", "threads", "repeat"])]
    recorded: bool,
}

impl SpeedArguments {
    /// Measures, keeps and shows. The status is 0 when every pair could be read and every matcher of
    /// hazcam's own, and every engine that was called by its name, has answered.
    pub fn run(
        &self,
        scenes: &SceneArguments,
        engines: &EngineArguments,
        format: Format,
        page: Option<Page>,
        ui: &Ui,
    ) -> anyhow::Result<ExitCode> {
        let mut kept = match &self.record {
            Some(path) if self.recorded || path.exists() => Record::read(path)?,
            _ => Record::default(),
        };
        if let Some(path) = self.record.as_ref().filter(|_| !self.recorded) {
            outputs::check(&[Output::text("--record", path, "")], &[])?;
        }
        let mut complete = true;
        let runs = match self.recorded {
            true => kept.runs.clone(),
            false => {
                let sizes = match self.sweep {
                    true => sizes::sweep(),
                    false => sizes::fixed(scenes, ui)?,
                };
                let sizes = matching(sizes, |size| &size.case.id, scenes.scenes.as_deref())?;
                let asked = sizes.len();
                let runs = self.measure(sizes, engines, ui, |run| {
                    // At once: what is yet to come may take long, and be cut short. Others may have written meanwhile.
                    if let Some(path) = self.record.as_ref().filter(|path| path.exists()) {
                        kept = Record::read(path)?;
                    }
                    // A run of which nothing came takes no earlier one's place.
                    if run.measurements.iter().all(|found| found.status.message().is_some()) {
                        return Ok(());
                    }
                    kept.put(run.clone());
                    match &self.record {
                        Some(path) => Ok(kept.write(path)?),
                        None => Ok(()),
                    }
                })?;
                let all = runs.iter().flat_map(|run| &run.measurements);
                let ends = all.map(|found| (&*found.engine, found.status.message()));
                let all_answered = tell_silent(engines.called(), &ends.collect::<Vec<_>>(), ui);
                complete = runs.len() == asked && all_answered;
                runs
            }
        };
        let shown = ui.print(&report::show(&runs, format));
        if let Some(page) = page.filter(|_| !kept.runs.is_empty()) {
            page.put(&report::for_page(&kept.runs))?;
        }
        shown?;
        Ok(match complete && runs.iter().all(own_have_answered) {
            true => ExitCode::SUCCESS,
            false => cli::ERROR.into(),
        })
    }

    /// A run for each size that can be read, each given to `keep` when it is done.
    fn measure(
        &self,
        sizes: Vec<Size>,
        engines: &EngineArguments,
        ui: &Ui,
        mut keep: impl FnMut(&Run) -> anyhow::Result<()>,
    ) -> anyhow::Result<Vec<Run>> {
        let peers = PEERS.map(|(_, peer)| peer);
        let definitions = engines.definitions(&peers, None)?;
        let programs = EngineArguments::programs()?;
        let mut absent: Vec<(String, String)> = Vec::new();
        let mut runs = Vec::new();
        for size in sizes {
            let entrants: Vec<Definition> = definitions
                .iter()
                .filter(|engine| size.for_slow || engines.are_chosen() || !is_slow(&engine.name))
                .cloned()
                .collect();
            let rounds = engines.repeats(size.rounds);
            let bar = ui.progress((entrants.len() * (rounds + 1)) as u64);
            bar.set_message(format!("{}: images", size.case.id));
            let data = match size.load() {
                Ok(data) => data,
                Err(error) => {
                    bar.finish_and_clear();
                    ui.warn(format_args!("{} is left out: {error}", size.case.id));
                    continue;
                }
            };
            let setting = Setting {
                data: &data,
                engines: &entrants,
                programs: &programs,
                limits: engines.limits(),
                threads: engines.threads,
                rounds,
            };
            let measurements = speed::run(&setting, |event| match event {
                Event::Absent { engine, message } => {
                    let who_and_why = (engine.to_owned(), message.to_owned());
                    if !absent.contains(&who_and_why) {
                        absent.push(who_and_why);
                    }
                    bar.inc(rounds as u64 + 1);
                }
                Event::Turn { engine, round: 0 } => {
                    bar.set_message(format!("{}, {engine}, to warm up", size.case.id));
                    bar.inc(1);
                }
                Event::Turn { engine, round } => {
                    bar.set_message(format!("{}, {engine}, run {round}", size.case.id));
                    bar.inc(1);
                }
            })?;
            bar.finish_and_clear();
            let run = Run {
                scene: size.case.id.clone(),
                columns: data.left.columns(),
                rows: data.left.rows(),
                disparities: data.range.count(),
                threads: engines.threads,
                sweep: self.sweep,
                hazcam: env!("CARGO_PKG_VERSION").into(),
                command: command_line(),
                date: speed::today(),
                machine: this_machine(),
                measurements,
            };
            keep(&run)?;
            runs.push(run);
        }
        tell_absent(absent, ui);
        Ok(runs)
    }
}

/// Accuracy first: they would take most of the time where nobody waits for their figures.
fn is_slow(engine: &str) -> bool {
    PEERS.iter().any(|&(own, peer)| own == Preset::Best.name() && [own, peer].contains(&engine))
}

fn own_have_answered(run: &Run) -> bool {
    let own = Preset::ALL.map(Preset::name);
    run.measurements
        .iter()
        .all(|found| found.status.message().is_none() || !own.contains(&&*found.engine))
}
