//! What is kept of one engine on one scene: everything needed to read its numbers right.
//!
//! A [`Record`] is a JSON object of its own: which scene, which engine, what was asked, how it
//! ended, the scores of every region with the protocol of every family of measures, what was used,
//! and on which machine. It is written whole or not at all.

mod coverage;
mod machine;
mod obstacles;
mod scoring;

use std::collections::BTreeMap;
use std::path::Path;

use formats::{FormatError, write_atomically};
use score::{Measure, Scores};
use serde::Serialize;

use crate::dataset::{Case, CaseData, Purpose};
use crate::engine::{Attempt, Status, Usage, Worker};

pub use coverage::{Coverage, SURE};
pub use machine::Machine;
pub use obstacles::{FalseAlarms, Missed, STEPS, Sight, WIDTHS, sights};
pub use scoring::{ConfidenceScore, LEAST_CONFIDENCES, RANKED_BAD, RegionScores, at_least, score};

/// One engine on one scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Record {
    /// Version of the program that wrote this.
    pub hazcam: &'static str,
    /// The scene's id.
    pub case: String,
    /// The data set that it belongs to.
    pub family: String,
    /// What the scene may be used for.
    #[serde(rename = "use")]
    pub purpose: Purpose,
    /// The engine's name.
    pub engine: String,
    /// What the engine is, in one line.
    pub engine_description: String,
    /// The version that it states.
    pub engine_version: Option<String>,
    /// Width of the images in pixels.
    pub columns: usize,
    /// Height of the images in pixels.
    pub rows: usize,
    /// `[x0, y0, x1, y1]`, inclusive: the pixels that were to be answered.
    #[serde(rename = "box")]
    pub bounds: [usize; 4],
    /// Smallest disparity searched.
    pub min_disparity: i32,
    /// Largest disparity searched, inclusive.
    pub max_disparity: i32,
    /// How many threads the engine was allowed.
    pub threads: usize,
    /// How many engines worked at once. With more than one, each disturbed the others' clocks.
    pub jobs: usize,
    /// How it ended.
    #[serde(flatten)]
    pub status: Status,
    /// Which truth, which masks, what was assumed.
    pub protocol: Vec<String>,
    /// Whether there is a truth to score against.
    pub has_truth: bool,
    /// How much of the box the answer speaks of, if there is one.
    pub coverage: Option<Coverage>,
    /// Scores over all pixels with truth, then over each region that has any. Empty without truth
    /// or without an answer.
    pub scores: Vec<Scores>,
    /// Scores over the pixels of each reason, if the engine gives reasons.
    pub by_reason: Vec<Scores>,
    /// Scores over the pixels that are sure enough, for several bounds, if the engine says how sure
    /// it is; their regions are named by [`at_least`].
    pub by_confidence: Vec<Scores>,
    /// How much of small obstacles is missed, by their width and step; empty where none were laid.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub missed: Vec<Missed>,
    /// How much of what is around them is taken for some, by how near it looks; empty where none were laid.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub false_alarms: Vec<FalseAlarms>,
    /// How well the engine's confidence ranks its errors.
    pub confidence: Option<ConfidenceScore>,
    /// How many pixels the engine gave each reason, if it gives reasons.
    pub reasons: BTreeMap<&'static str, usize>,
    /// What the median run used, ranked by CPU time where that is known, else by wall time.
    pub usage: Usage,
    /// What each run used, in order.
    pub runs: Vec<Usage>,
    /// Whether all runs gave the same disparities to the last bit; `None` after a single run.
    pub repeatable: Option<bool>,
    /// What the engine's start used, apart from the runs.
    pub startup: Option<Usage>,
    /// How long the engine itself says that the matching took in the last run, in seconds.
    pub claimed_seconds: Option<f64>,
    /// Where it ran.
    pub machine: Machine,
}

impl Record {
    /// Scores the last of `attempts`, which are runs of one engine on one scene, at least one, while
    /// `jobs` engines worked at once.
    pub fn new(
        case: &Case,
        data: &CaseData,
        worker: &Worker,
        attempts: &[Attempt],
        jobs: usize,
        machine: &Machine,
    ) -> Self {
        let last = attempts.last().expect("an engine runs at least once");
        let mut status = last.status.clone();
        let mut scored = RegionScores::default();
        if let Some(answer) = &last.answer {
            match score(answer, data) {
                Ok(scores) => scored = scores,
                Err(error) => status = Status::BadResult { message: error.to_string() },
            }
        }
        if attempts.len() > 1 {
            status = status.after_answers(attempts.len() - 1);
        }
        let mut reasons = BTreeMap::new();
        for reason in
            last.answer.iter().filter_map(|a| a.reasons.as_ref()).flat_map(|r| r.samples())
        {
            *reasons.entry(reason.name()).or_default() += 1;
        }
        let runs: Vec<Usage> = attempts.iter().map(|attempt| attempt.usage).collect();
        let definition = worker.definition();
        Self {
            hazcam: env!("CARGO_PKG_VERSION"),
            case: case.id.clone(),
            family: case.family().into(),
            purpose: case.purpose,
            engine: definition.name.clone(),
            engine_description: definition.description.clone(),
            engine_version: worker.version().map(Into::into),
            columns: data.left.columns(),
            rows: data.left.rows(),
            bounds: [data.bounds.x0, data.bounds.y0, data.bounds.x1, data.bounds.y1],
            min_disparity: data.range.min(),
            max_disparity: data.range.max(),
            threads: worker.threads(),
            jobs,
            status,
            protocol: data.protocol.clone(),
            has_truth: data.truth.is_some(),
            coverage: last.answer.as_ref().map(|answer| Coverage::of(answer, data.bounds)),
            scores: scored.scores,
            by_reason: scored.by_reason,
            by_confidence: scored.by_confidence,
            missed: scored.missed,
            false_alarms: scored.false_alarms,
            confidence: scored.confidence,
            reasons,
            usage: median(&runs),
            runs,
            repeatable: repeatable(attempts),
            startup: worker.startup(),
            claimed_seconds: last.claimed_seconds,
            machine: machine.clone(),
        }
    }

    /// The scores over a region: "all", "non-occluded", "occluded", ...
    pub fn scores_of(&self, region: &str) -> Option<&Scores> {
        self.scores.iter().find(|scores| scores.region == region)
    }

    /// A number by the name of its measure, over a region.
    pub fn value(&self, region: &str, measure: &str) -> Option<f64> {
        Measure::named(measure)?.value(self.scores_of(region)?)
    }

    /// CPU time in seconds until there was an answer; `None` where there is none, since what a crash
    /// or a time limit cut short says nothing of that, and where the system does not tell.
    pub fn answer_cpu_seconds(&self) -> Option<f64> {
        self.usage.cpu_seconds.filter(|_| self.status == Status::Done)
    }

    /// Writes the record as JSON, whole or not at all.
    pub fn write(&self, path: &Path) -> Result<(), FormatError> {
        write_atomically(path, |writer| {
            serde_json::to_writer_pretty(&mut *writer, self)?;
            writer.write_all(b"\n")
        })
    }
}

/// The run in the middle; of two in the middle the quicker one.
fn median(runs: &[Usage]) -> Usage {
    let time = |usage: &Usage| usage.cpu_seconds.unwrap_or(usage.wall_seconds);
    let mut sorted = runs.to_vec();
    sorted.sort_by(|a, b| time(a).total_cmp(&time(b)));
    sorted.get(sorted.len().saturating_sub(1) / 2).copied().unwrap_or_default()
}

/// Whether all answers are the same bits. Of fewer than two nobody knows: an attempt that ended without one says nothing.
fn repeatable(attempts: &[Attempt]) -> Option<bool> {
    let answers = attempts.iter().filter_map(|attempt| attempt.answer.as_ref());
    let mut maps = answers.map(|answer| answer.disparity.map(|value| value.to_bits()));
    let (first, second) = (maps.next()?, maps.next()?);
    Some(second == first && maps.all(|other| other == first))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_a_run_that_happened() {
        let run = |cpu| Usage { cpu_seconds: Some(cpu), wall_seconds: 9.0, ..Usage::default() };
        assert_eq!(median(&[run(3.0), run(1.0), run(2.0)]), run(2.0));
        assert_eq!(median(&[run(3.0), run(1.0)]), run(1.0));
        assert_eq!(median(&[]), Usage::default());
    }
}
