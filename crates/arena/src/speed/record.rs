//! What is kept of speeds: a JSON file of runs, each made at one go on one machine.

use std::fs;
use std::path::Path;
use std::time::SystemTime;

use formats::{FormatError, write_atomically};
use serde::{Deserialize, Serialize};

use super::measurement::Measurement;
use crate::record::Machine;

/// Engines in turns on one pair of images: what may be compared with each other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The pair's id.
    pub scene: String,
    /// Width in pixels.
    pub columns: usize,
    /// Height in pixels.
    pub rows: usize,
    /// How many disparities were searched.
    pub disparities: usize,
    /// How many threads each engine was allowed.
    pub threads: usize,
    /// Whether it is one of many sizes, which show how time grows.
    pub sweep: bool,
    /// Version of the program that measured.
    pub hazcam: String,
    /// The command that was given.
    pub command: String,
    /// The day, UTC, `YYYY-MM-DD`.
    pub date: String,
    /// Where it ran.
    pub machine: Machine,
    /// What came of each engine, in the order of their turns.
    pub measurements: Vec<Measurement>,
}

impl Run {
    /// The measurement of this engine.
    pub fn of(&self, engine: &str) -> Option<&Measurement> {
        self.measurements.iter().find(|measurement| measurement.engine == engine)
    }

    /// Whether both are of the same images, with as many disparities and threads.
    pub fn asks_as(&self, other: &Self) -> bool {
        let asked = |run: &Self| (run.columns, run.rows, run.disparities, run.threads, run.sweep);
        self.scene == other.scene && asked(self) == asked(other)
    }

    /// Disparities evaluated per second when matching takes so long: every disparity at every pixel
    /// counts, whether or not a matcher has to look at it.
    pub fn rate(&self, seconds: f64) -> f64 {
        (self.columns * self.rows * self.disparities) as f64 / seconds
    }

    /// How many times as long `peer` takes as `engine`, by their medians.
    pub fn ratio(&self, engine: &str, peer: &str) -> Option<f64> {
        Some(self.of(peer)?.median()? / self.of(engine)?.median()?)
    }
}

/// Runs that are kept: one for each machine, scene and number of threads.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Record {
    /// Machines in the order in which they first measured, and the scenes of each: those of one scene stand
    /// together.
    pub runs: Vec<Run>,
}

/// A record that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The file cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// Which file.
        path: String,
        /// Why.
        source: std::io::Error,
    },
    /// The file holds something else.
    #[error(
        "{path} holds no record of `hazcam bench --speed`: {problem}; name another file, or remove \
         this one"
    )]
    Content {
        /// Which file.
        path: String,
        /// What is wrong.
        problem: String,
    },
}

impl Record {
    /// Reads a record.
    pub fn read(path: &Path) -> Result<Self, RecordError> {
        let shown = || path.display().to_string();
        let text = fs::read_to_string(path)
            .map_err(|source| RecordError::Read { path: shown(), source })?;
        serde_json::from_str(&text)
            .map_err(|error| RecordError::Content { path: shown(), problem: error.to_string() })
    }

    /// Takes a run in. An earlier one of the same machine, scene and number of threads gives way as a whole:
    /// what was not measured together is not compared.
    pub fn put(&mut self, run: Run) {
        let same_machine = |known: &Run| known.machine == run.machine;
        let same_scene = |known: &Run| same_machine(known) && known.scene == run.scene;
        let same = |known: &Run| same_scene(known) && known.threads == run.threads;
        match self.runs.iter().position(same) {
            Some(at) => self.runs[at] = run,
            None => {
                let after = self.runs.iter().rposition(same_scene);
                let after = after.or_else(|| self.runs.iter().rposition(same_machine));
                self.runs.insert(after.map_or(self.runs.len(), |last| last + 1), run);
            }
        }
    }

    /// Writes the record, whole or not at all.
    pub fn write(&self, path: &Path) -> Result<(), FormatError> {
        write_atomically(path, |writer| writer.write_all(self.to_json().as_bytes()))
    }

    /// The record as JSON text.
    pub fn to_json(&self) -> String {
        let mut text =
            serde_json::to_string_pretty(self).expect("a record holds only what JSON can hold");
        text.push('\n');
        text
    }
}

/// This day, UTC, as `YYYY-MM-DD`.
pub fn today() -> String {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let (year, month, day) = civil(since.as_secs() as i64 / 86_400);
    format!("{year:04}-{month:02}-{day:02}")
}

/// Year, month and day of the day with this number, counted from 1 January 1970 (H. Hinnant,
/// "chrono-Compatible Low-Level Date Algorithms").
fn civil(day: i64) -> (i64, i64, i64) {
    // Eras of 400 years that begin in March, so that the leap day is a year's last.
    let day = day + 719_468;
    let (era, of_era) = (day.div_euclid(146_097), day.rem_euclid(146_097));
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let from_march = (5 * of_year + 2) / 153;
    let month = (from_march + 2) % 12 + 1;
    let day = of_year - (153 * from_march + 2) / 5 + 1;
    (era * 400 + year + i64::from(month <= 2), month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_have_their_dates() {
        assert_eq!(civil(0), (1970, 1, 1));
        assert_eq!(civil(-1), (1969, 12, 31));
        assert_eq!(civil(11_016), (2000, 2, 29));
        assert_eq!(civil(11_017), (2000, 3, 1));
        assert_eq!(civil(20_453), (2025, 12, 31));
    }
}
