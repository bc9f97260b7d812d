//! Engines against each other on the same scenes, with progress, and what comes of it.

use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::process::ExitCode;

use anyhow::anyhow;
use arena::dataset::Case;
use arena::engine::Definition;
use arena::record::Machine;
use arena::report::printable;
use arena::run::{self, Event, Outcome, Plan};
use matching::Level;

use super::engines::EngineArguments;
use super::limits::Limits;
use super::output::Output;
use super::scales::Scales;
use crate::cli;
use crate::ui::Ui;

/// What is run, and what it is held to.
pub struct Contest {
    /// The scenes, in order.
    pub cases: Vec<Case>,
    /// The engines, in order.
    pub engines: Vec<Definition>,
    /// The engine that others are compared with.
    pub reference: Option<String>,
    /// Figures that must not be exceeded.
    pub limits: Option<Limits>,
    /// How many engines work at once.
    pub jobs: NonZeroUsize,
}

impl Contest {
    /// Runs the engines on the cases, keeps and prints the results.
    ///
    /// The status is 0 when every scene could be read, every matcher of hazcam's own has answered, and every other
    /// engine that was called by its name has, on some scene: its failure on one is a row in the table. It is 1 when
    /// a figure is past its limit.
    pub fn run(
        self,
        engines: &EngineArguments,
        mut output: Output,
        ui: &Ui,
    ) -> anyhow::Result<ExitCode> {
        let plan = Plan {
            cases: self.cases,
            engines: self.engines,
            programs: EngineArguments::programs()?,
            limits: engines.limits(),
            threads: engines.threads,
            repeats: engines.repeats(1),
            jobs: self.jobs,
            machine: this_machine(),
        };
        let Outcome { records, unreadable, .. } = conduct(&plan, &mut output, ui)?;
        // What cannot be kept shall at least be seen, and what cannot be shown be kept.
        let shown = ui.print(&output.shown(&records, self.reference.as_deref()));
        output.finish(&records, self.reference.as_deref())?;
        shown?;
        let any_answered = records.iter().any(|record| record.status.message().is_none());
        if let Some(place) = output.place(any_answered).filter(|_| !records.is_empty()) {
            ui.note(place);
        }
        let is_own = |name: &str| {
            let mut own = plan.engines.iter().filter(|engine| engine.command[0] == "{hazcam}");
            own.any(|engine| engine.name == name)
        };
        let own_failed = records
            .iter()
            .any(|record| record.status.message().is_some() && is_own(&record.engine));
        if own_failed {
            ui.error(&anyhow!("a matcher of hazcam's own has not answered: its row says why"));
        }
        let called = engines.called().chain(self.reference.as_deref());
        let ends: Vec<_> =
            records.iter().map(|record| (&*record.engine, record.status.message())).collect();
        // Where nothing could be read nobody was asked.
        let nobody_asked = ends.is_empty() && unreadable > 0;
        let all_answered = nobody_asked || tell_silent(called, &ends, ui);
        if own_failed || unreadable > 0 || records.is_empty() || !all_answered {
            return Ok(cli::ERROR.into());
        }
        let broken = match &self.limits {
            Some(limits) => limits.broken(&records)?,
            None => Vec::new(),
        };
        broken.iter().for_each(|line| ui.fail(line));
        Ok(if broken.is_empty() { ExitCode::SUCCESS } else { cli::THRESHOLD_FAILED.into() })
    }
}

/// Says which of the engines that were called have given no answer at all, and why; whether all have given one. `ends`
/// are the engines' names and what went wrong, if anything did, as often as they were run.
pub fn tell_silent<'a>(
    called: impl Iterator<Item = &'a str>,
    ends: &[(&str, Option<&str>)],
    ui: &Ui,
) -> bool {
    let called: BTreeSet<&str> = called.collect();
    let mut all_answered = true;
    for name in called {
        let of_engine = ends.iter().filter(|(engine, _)| *engine == name);
        let problems: Vec<Option<&str>> = of_engine.map(|(_, problem)| *problem).collect();
        if problems.iter().all(Option::is_some) {
            let why = problems.first().copied().flatten();
            let why = why.map(|why| format!(": {}", printable(why))).unwrap_or_default();
            ui.fail(format_args!("{name} was asked for and has given no answer that counts{why}"));
            all_answered = false;
        }
    }
    all_answered
}

/// The machine with the vector instructions that the presets use.
pub fn this_machine() -> Machine {
    Machine::this(Level::chosen().ok().map(|level| level.name().into()))
}

/// Says which engines cannot work here and why, a line for each reason.
pub fn tell_absent(absent: Vec<(String, String)>, ui: &Ui) {
    for (names, message) in by_message(absent) {
        ui.note(format_args!("{} left out: {}", names.join(", "), printable(&message)));
    }
}

fn conduct(plan: &Plan, output: &mut Output, ui: &Ui) -> anyhow::Result<Outcome> {
    let mut scales = Scales::default();
    let bar = ui.progress((plan.cases.len() * plan.engines.len()) as u64);
    let mut failure = None;
    let mut absent: Vec<(String, String)> = Vec::new();
    let outcome = run::run(plan, |event| {
        match event {
            Event::EngineAbsent { engine, message } => {
                absent.push((engine.name.clone(), message.into()));
                bar.set_length(bar.length().unwrap_or(0).saturating_sub(plan.cases.len() as u64));
            }
            Event::CaseUnreadable { case, error } => {
                bar.suspend(|| ui.warn(format_args!("{} is left out: {error}", case.id)));
                bar.inc((plan.engines.len() - absent.len()) as u64);
            }
            Event::Begins { case, engine } => {
                bar.set_message(format!("{}, {}", case.id, engine.name));
            }
            Event::Finished { case, data, record, answer } => {
                bar.inc(1);
                scales.look_at(case, data, record, answer);
                if let Err(error) = output.keep(case, data, record, answer) {
                    failure = Some(error);
                    return ControlFlow::Break(());
                }
            }
        }
        ControlFlow::Continue(())
    })?;
    bar.finish_and_clear();
    tell_absent(absent, ui);
    scales.told().iter().for_each(|line| ui.warn(printable(line)));
    match failure {
        Some(error) => Err(error),
        None => Ok(outcome),
    }
}

/// Names that share a message, in order: what one missing package silences is one line.
fn by_message(absent: Vec<(String, String)>) -> Vec<(Vec<String>, String)> {
    let mut groups: Vec<(Vec<String>, String)> = Vec::new();
    for (name, message) in absent {
        match groups.iter_mut().find(|(_, known)| *known == message) {
            Some((names, _)) => names.push(name),
            None => groups.push((vec![name], message)),
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_missing_package_is_one_line() {
        let absent = [("a", "no cv2"), ("b", "no python"), ("c", "no cv2")]
            .map(|(name, message)| (name.to_owned(), message.to_owned()));
        let groups = by_message(absent.to_vec());
        assert_eq!(groups.len(), 2);
        assert_eq!(groups[0], (vec!["a".to_owned(), "c".to_owned()], "no cv2".to_owned()));
    }
}
