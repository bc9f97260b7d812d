//! Engines on scenes, one pair at a time, so that nothing disturbs the clock, or several where times
//! matter less than the wait.
//!
//! Every scene is loaded once and given to one engine after the other; an engine's process lives
//! through all scenes. What goes wrong with one engine or one scene is told and recorded, and the
//! rest goes on.

mod side_by_side;

use std::io;
use std::num::NonZeroUsize;
use std::ops::ControlFlow;

use self::side_by_side::{Told, run_all};
use crate::dataset::{Case, CaseData, DatasetError};
use crate::engine::{Answer, Definition, Limits, Pair, Programs, Status, Worker};
use crate::record::{Machine, Record};

/// What to run.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The scenes, in order.
    pub cases: Vec<Case>,
    /// The engines, in order.
    pub engines: Vec<Definition>,
    /// The programs that engines may refer to.
    pub programs: Programs,
    /// How long a job may take.
    pub limits: Limits,
    /// How many threads an engine may use.
    pub threads: usize,
    /// How often each pair is matched, at least once; the first answer that fails ends the
    /// repetition.
    pub repeats: usize,
    /// How many engines work at once. With more than one, each disturbs the others' clocks.
    pub jobs: NonZeroUsize,
    /// The machine, for the records.
    pub machine: Machine,
}

/// What a run tells while it goes on.
#[derive(Debug)]
pub enum Event<'a> {
    /// An engine cannot work on this machine; it is left out.
    EngineAbsent {
        /// Which.
        engine: &'a Definition,
        /// What is missing.
        message: &'a str,
    },
    /// A scene cannot be loaded; it is left out.
    CaseUnreadable {
        /// Which.
        case: &'a Case,
        /// Why.
        error: DatasetError,
    },
    /// A pair goes to an engine.
    Begins {
        /// The scene.
        case: &'a Case,
        /// The engine.
        engine: &'a Definition,
    },
    /// It is done, whatever came of it.
    Finished {
        /// The scene.
        case: &'a Case,
        /// Its images and truth.
        data: &'a CaseData,
        /// What is kept of it.
        record: &'a Record,
        /// The answer, if there is one.
        answer: Option<&'a Answer>,
    },
}

/// What a run left behind.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// One record for each scene that could be loaded and each engine that is not absent, in the plan's
    /// order.
    pub records: Vec<Record>,
    /// Scenes that could not be loaded.
    pub unreadable: usize,
    /// Engines that cannot work on this machine.
    pub absent: usize,
}

/// Runs every engine on every scene. `observe` learns of everything as it happens and may end the
/// run by [`ControlFlow::Break`].
///
/// Errors when no scratch folder can be made.
pub fn run(
    plan: &Plan,
    mut observe: impl FnMut(Event<'_>) -> ControlFlow<()>,
) -> io::Result<Outcome> {
    let mut outcome = Outcome::default();
    let mut workers = Vec::new();
    for definition in &plan.engines {
        let mut worker =
            Worker::new(definition.clone(), plan.programs.clone(), plan.limits, plan.threads)?;
        if let Err(Status::Absent { message }) = worker.start() {
            outcome.absent += 1;
            if observe(Event::EngineAbsent { engine: definition, message: &message }).is_break() {
                return Ok(outcome);
            }
        } else {
            workers.push(worker);
        }
    }
    for case in &plan.cases {
        let data = match case.load() {
            Ok(data) => data,
            Err(error) => {
                outcome.unreadable += 1;
                match observe(Event::CaseUnreadable { case, error }) {
                    ControlFlow::Continue(()) => continue,
                    ControlFlow::Break(()) => break,
                }
            }
        };
        let first = outcome.records.len();
        let told = run_all(plan, case, &data, &mut workers, |told| match told {
            Told::Begins(engine) => observe(Event::Begins { case, engine: &engine }),
            Told::Finished(record, answer) => {
                let answer = answer.as_ref();
                let told = observe(Event::Finished { case, data: &data, record: &record, answer });
                outcome.records.push(*record);
                told
            }
        });
        let place = |record: &Record| plan.engines.iter().position(|e| e.name == record.engine);
        outcome.records[first..].sort_by_key(place);
        if told.is_break() {
            break;
        }
    }
    workers.into_iter().for_each(Worker::end);
    Ok(outcome)
}

/// One engine on one scene, as often as asked, while `jobs` engines work at once.
fn run_one(
    plan: &Plan,
    case: &Case,
    data: &CaseData,
    worker: &mut Worker,
    jobs: usize,
) -> (Record, Option<Answer>) {
    let pair =
        Pair { left: &data.left, right: &data.right, bounds: data.bounds, range: data.range };
    let mut attempts = vec![worker.run(&pair)];
    while attempts.len() < plan.repeats && attempts.last().is_some_and(|a| a.answer.is_some()) {
        attempts.push(worker.run(&pair));
    }
    let record = Record::new(case, data, worker, &attempts, jobs, &plan.machine);
    (record, attempts.pop().and_then(|attempt| attempt.answer))
}
