//! Engines in turns on one pair of images, so that what disturbs the machine disturbs all alike.

use std::io;

use score::median;

use super::measurement::Measurement;
use crate::dataset::CaseData;
use crate::engine::{Attempt, Definition, Limits, Pair, Programs, Status, Usage, Worker};

/// What to measure.
#[derive(Debug)]
pub struct Setting<'a> {
    /// The images, the box to answer and the disparities to search.
    pub data: &'a CaseData,
    /// The engines, in the order of their turns.
    pub engines: &'a [Definition],
    /// The programs that engines may refer to.
    pub programs: &'a Programs,
    /// How long a run may take.
    pub limits: Limits,
    /// How many threads an engine may use.
    pub threads: usize,
    /// How many rounds are measured, after one that is not.
    pub rounds: usize,
}

/// What a contest tells while it goes on.
#[derive(Debug)]
pub enum Event<'a> {
    /// An engine cannot work on this machine; it is left out.
    Absent {
        /// Its name.
        engine: &'a str,
        /// What is missing.
        message: &'a str,
    },
    /// An engine's turn.
    Turn {
        /// Its name.
        engine: &'a str,
        /// The round; 0 is the one that is not measured.
        round: usize,
    },
}

/// Runs every engine once to warm up, then in rounds. One measurement for each engine that is not
/// absent; an engine that fails sits out the rest.
///
/// Every engine is a process of its own that lives through all rounds and ends with them, so that
/// the memory of one setting is free for the next. Errors when no scratch folder can be made.
pub fn run(
    setting: &Setting<'_>,
    mut observe: impl FnMut(Event<'_>),
) -> io::Result<Vec<Measurement>> {
    let mut entrants = Vec::new();
    for engine in setting.engines {
        let mut worker =
            Worker::new(engine.clone(), setting.programs.clone(), setting.limits, setting.threads)?;
        match worker.start() {
            Err(Status::Absent { message }) => {
                observe(Event::Absent { engine: &engine.name, message: &message });
            }
            // What else is wrong with it shows again in its first turn.
            _ => entrants.push(Entrant { worker, runs: Vec::new(), status: Status::Done }),
        }
    }
    let data = setting.data;
    let pair =
        Pair { left: &data.left, right: &data.right, bounds: data.bounds, range: data.range };
    for round in 0..=setting.rounds {
        for entrant in entrants.iter_mut().filter(|entrant| entrant.status == Status::Done) {
            observe(Event::Turn { engine: &entrant.worker.definition().name, round });
            let attempt = entrant.worker.run(&pair);
            entrant.take(&attempt, round > 0);
        }
    }
    Ok(entrants.into_iter().map(Entrant::end).collect())
}

struct Entrant {
    worker: Worker,
    /// Seconds of matching by its own clock, and what was seen from outside.
    runs: Vec<(f64, Usage)>,
    status: Status,
}

impl Entrant {
    fn take(&mut self, attempt: &Attempt, measured: bool) {
        match (&attempt.status, attempt.claimed_seconds) {
            (Status::Done, Some(seconds)) if measured => self.runs.push((seconds, attempt.usage)),
            (Status::Done, Some(_)) => {}
            (Status::Done, None) => {
                let message = "its answer does not say how long matching took: let it add \
                               `seconds` to `done`, see PROTOCOL.md";
                self.status = Status::BadResult { message: message.into() };
            }
            (wrong, _) => self.status = wrong.clone(),
        }
    }

    fn end(self) -> Measurement {
        let Self { worker, runs, status } = self;
        let usage = || runs.iter().map(|(_, usage)| usage);
        let measurement = Measurement {
            status,
            seconds: runs.iter().map(|(seconds, _)| *seconds).collect(),
            cpu_seconds: median(usage().filter_map(|usage| usage.cpu_seconds)),
            peak_memory_bytes: usage().filter_map(|usage| usage.peak_memory_bytes).max(),
            ..Measurement::new(worker.definition(), worker.version())
        };
        worker.end();
        measurement
    }
}
