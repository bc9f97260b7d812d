//! One scene for all engines, some of them at once.

use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError, mpsc};
use std::thread;

use super::{Plan, run_one};
use crate::dataset::{Case, CaseData};
use crate::engine::{Answer, Definition, Worker};
use crate::record::Record;

/// What is told of one engine.
pub(super) enum Told {
    Begins(Definition),
    Finished(Box<Record>, Option<Answer>),
}

/// Gives a scene to every worker, to as many at once as planned; the next free one takes the next.
/// `observe` learns of it as it happens; when it breaks, what has begun is finished and nothing more
/// begins.
pub(super) fn run_all(
    plan: &Plan,
    case: &Case,
    data: &CaseData,
    workers: &mut [Worker],
    mut observe: impl FnMut(Told) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let at_once = plan.jobs.get().min(workers.len());
    let waiting = Mutex::new(workers.iter_mut());
    let next = || waiting.lock().unwrap_or_else(PoisonError::into_inner).next();
    // Without room to wait in: a job begins when it has been told of, and its answer is not kept longer
    // than it is looked at.
    let (tell, told) = mpsc::sync_channel(0);
    thread::scope(|scope| {
        for _ in 0..at_once {
            let (tell, next) = (tell.clone(), &next);
            scope.spawn(move || {
                while let Some(worker) = next() {
                    if tell.send(Told::Begins(worker.definition().clone())).is_err() {
                        break;
                    }
                    let (record, answer) = run_one(plan, case, data, worker, at_once);
                    if tell.send(Told::Finished(Box::new(record), answer)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(tell);
        // Taken along: when this loop ends early, nobody listens any more.
        told.into_iter().try_for_each(&mut observe)
    })
}
