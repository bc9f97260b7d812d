//! One run of one test, from empty folders to scores or the reason why there are none.

use std::fs;
use std::io;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use raster::{DisparityRange, Plane};

use super::answer::{self, Scores};
use super::confined::{Confinement, Ended, Workplace};
use super::entrant::Entrant;
use super::outcome::Outcome;
use super::scene::Scene;
use super::scheme::Test;
use super::verdict::{Failure, judge};
use crate::engine::protocol::Job;
use crate::engine::{self, Definition, Kind, Pair, Programs, Status, Usage, exchange};
use crate::submission::{self, Part, Runner, Submission};

/// What came of one run.
pub(super) struct Attempt {
    pub result: Result<(Plane<f32>, Scores), Failure>,
    pub usage: Usage,
    pub startup: Usage,
    /// What was said besides messages.
    pub log: String,
    /// Whether it ended because something is not installed, by its own word.
    absent: bool,
}

impl Attempt {
    fn failed(failure: Failure) -> Self {
        let (usage, startup) = (Usage::default(), Usage::default());
        Self { result: Err(failure), usage, startup, log: String::new(), absent: false }
    }

    /// A run that ended by the grader's fault.
    fn broken(message: impl Into<String>) -> Self {
        Self::failed(Failure::new(Outcome::Xx, message))
    }
}

/// What runs belong to.
pub(super) struct Bench<'a> {
    pub confinement: &'a Confinement,
    pub programs: &'a Programs,
    /// Runs submissions; in words, why there is none.
    pub runner: Result<&'a Runner, &'a str>,
    /// Files out of reach besides those of each scene.
    pub secrets: &'a [PathBuf],
}

impl Bench<'_> {
    /// Runs a test once.
    pub fn attempt(&self, entrant: &Entrant, test: &Test, scene: &Scene) -> Attempt {
        let place = match Workplace::new() {
            Ok(place) => place,
            Err(error) => return Attempt::broken(format!("no folder to work in: {error}")),
        };
        let (command, readable, kind) = match self.command(entrant, test.part, &place) {
            Ok(found) => found,
            Err(failure) => return Attempt::failed(failure),
        };
        let cpu = Duration::from_secs_f64(test.cpu_seconds);
        if let Err(message) = self.check_reach(&readable, &place, cpu, scene) {
            return Attempt::broken(message);
        }
        let range = match i32::try_from(test.max_disparity).map(|max| DisparityRange::new(0, max)) {
            Ok(Ok(range)) => range,
            _ => return Attempt::broken(format!("no range ends at {}", test.max_disparity)),
        };
        let (left, right, bounds) = (&scene.left, &scene.right, scene.bounds);
        let pair = Pair { left, right, bounds, range };
        let attempt = match kind {
            Kind::Protocol => self.run_protocol(command, &readable, &place, cpu, &pair, scene),
            Kind::RobustVision => {
                self.run_robust_vision(command, &readable, &place, cpu, &pair, scene)
            }
        };
        match (entrant, &attempt.result) {
            (Entrant::Submission(_), Err(said)) if attempt.absent && !self.lacks_something(cpu) => {
                let message = format!(
                    "it says that this machine lacks something, but numpy and scipy are installed: {}",
                    said.message
                );
                Attempt { result: Err(Failure::new(Outcome::Bad, message)), ..attempt }
            }
            _ => attempt,
        }
    }

    /// Whether Python lacks what submissions may rely on. A submission is not believed: it runs in the
    /// process that says so.
    fn lacks_something(&self, cpu: Duration) -> bool {
        let (Ok(runner), Ok(place)) = (self.runner, Workplace::new()) else { return true };
        let part = Part::Fast;
        let module = place.home().join(format!("{}.py", part.function()));
        if fs::write(module, "import scipy\n").is_err() {
            return true;
        }
        let command = submission::engine(runner, &place.home(), part);
        let started = self.confinement.start(command, &runner.readable(), &place, cpu);
        started.is_err()
    }

    /// The process to start, what it must be able to read, and how it is spoken to.
    fn command(
        &self,
        entrant: &Entrant,
        part: Part,
        place: &Workplace,
    ) -> Result<(Command, Vec<PathBuf>, Kind), Failure> {
        let broken = |message: String| Failure::new(Outcome::Xx, message);
        match entrant {
            Entrant::Refused(message) => Err(Failure::new(Outcome::Re, message)),
            Entrant::NotTaken(message) => Err(broken(message.clone())),
            Entrant::Submission(submission) => {
                let runner = self.runner.map_err(|why| broken(why.to_owned()))?;
                submission.copy_to(&place.home()).map_err(|error| broken(error.to_string()))?;
                let command = submission::engine(runner, &place.home(), part);
                Ok((command, runner.readable(), Kind::Protocol))
            }
            Entrant::Engines(engines) => {
                let definition = engines.get(&part).ok_or_else(|| {
                    Failure::new(Outcome::Re, format!("there is no engine for `{}`", part.name()))
                })?;
                let command = engine::command(definition, self.programs, &place.home(), 1)
                    .map_err(|status| broken(status.message().unwrap_or_default().to_owned()))?;
                let readable = self.readable_by(definition, &command)?;
                Ok((command, readable, definition.kind))
            }
        }
    }

    /// A program reads itself and the folder of its definition; a Python program reads Python.
    fn readable_by(
        &self,
        definition: &Definition,
        command: &Command,
    ) -> Result<Vec<PathBuf>, Failure> {
        let mut readable: Vec<PathBuf> = definition.folder.iter().cloned().collect();
        let program = PathBuf::from(command.get_program());
        if program.is_absolute() && program.exists() {
            readable.push(program);
        }
        if definition.command.iter().any(|word| word.contains("{python}")) {
            let runner = self.runner.map_err(|why| Failure::new(Outcome::Xx, why))?;
            readable.extend_from_slice(runner.python().paths());
        }
        Ok(readable)
    }

    /// Errors when a confined program could read what must stay secret.
    fn check_reach(
        &self,
        readable: &[PathBuf],
        place: &Workplace,
        cpu: Duration,
        scene: &Scene,
    ) -> Result<(), String> {
        if self.confinement.helper.is_none() {
            return Ok(());
        }
        let policy = self.confinement.policy(readable, place, cpu);
        for secret in scene.secrets.iter().chain(self.secrets) {
            if let Some(within) = policy.within_reach(secret) {
                return Err(format!(
                    "{}, which tells the truth, lies within {}, which entrants can read: keep data \
                     and boards in folders of their own",
                    secret.display(),
                    within.display()
                ));
            }
        }
        Ok(())
    }

    fn run_protocol(
        &self,
        command: Command,
        readable: &[PathBuf],
        place: &Workplace,
        cpu: Duration,
        pair: &Pair<'_>,
        scene: &Scene,
    ) -> Attempt {
        let hidden = match exchange::write_job(&place.hidden(), 1, pair, 1) {
            Ok(job) => job,
            Err(error) => return Attempt::broken(error.to_string()),
        };
        let job = place.shown(&hidden);
        let ended = match self.confinement.start(command, readable, place, cpu) {
            // The clock starts when the images come within reach, so none of the work can be done
            // before.
            Ok(confined) => match place.show(&hidden, &job) {
                Ok(()) => confined.finish(&job),
                Err(error) => return Attempt::failed(in_the_way(&error)),
            },
            Err(ended) => *ended,
        };
        let max = pair.range.max().unsigned_abs();
        self.settled(ended, || answer::read(&job, scene, max))
    }

    fn run_robust_vision(
        &self,
        command: Command,
        readable: &[PathBuf],
        place: &Workplace,
        cpu: Duration,
        pair: &Pair<'_>,
        scene: &Scene,
    ) -> Attempt {
        let command = match self.confinement.prepare(command, readable, place, cpu) {
            Ok(command) => command,
            Err(status) => return Attempt::broken(status.message().unwrap_or_default()),
        };
        let watch = self.confinement.watch(place);
        let limits = self.confinement.limits(cpu);
        let finished = engine::robust_vision::run(command, &place.home(), pair, limits);
        let ended = Ended {
            status: finished.status,
            usage: finished.usage,
            startup: Usage::default(),
            log: finished.log,
            excess: watch.stop(),
        };
        let max = pair.range.max().unsigned_abs();
        self.settled(ended, || match finished.answer {
            Some(answer) => answer::score(answer.disparity, scene, max),
            None => Err(Failure::new(Outcome::Bad, "it left no answer")),
        })
    }

    /// What came of a run whose process has ended; `read` is asked for the answer if there is one.
    fn settled(
        &self,
        ended: Ended,
        read: impl FnOnce() -> Result<(Plane<f32>, Scores), Failure>,
    ) -> Attempt {
        let result = judge(&ended, self.confinement.allowance.start).and_then(|()| read());
        let absent = matches!(ended.status, Status::Absent { .. });
        let Ended { usage, startup, log, .. } = ended;
        Attempt { result, usage, startup, log, absent }
    }

    /// What can be seen in a submission without running its matchers.
    pub fn inspect(&self, submission: &Submission) -> submission::Inspection {
        let runner = match self.runner {
            Ok(runner) => runner,
            Err(_) => return submission::Inspection::default(),
        };
        let prepared = Workplace::new().map_err(|error| error.to_string()).and_then(|place| {
            submission.copy_to(&place.home()).map_err(|error| error.to_string())?;
            Ok(place)
        });
        let Ok(place) = prepared else { return submission::Inspection::default() };
        let command = submission::inspector(runner, &place.home());
        let cpu = Duration::from_secs(10);
        match self.confinement.start(command, &runner.readable(), &place, cpu) {
            Ok(confined) => {
                let secret_id = confined.name().map(str::to_owned);
                let ended = confined.finish(&question(&place));
                submission::Inspection::told(secret_id, &ended.status)
            }
            Err(ended) => submission::Inspection::told(None, &ended.status),
        }
    }
}

/// The folder for images was empty before the entrant was started.
fn in_the_way(error: &io::Error) -> Failure {
    Failure::new(
        Outcome::Bad,
        format!(
            "it put something where the images go, before they came ({error}): leave the folder of \
             the job alone"
        ),
    )
}

/// The job by which the runner is asked for its findings; it carries no images.
fn question(place: &Workplace) -> Job {
    let nowhere = place.job().join("none");
    Job {
        job: 1,
        left: nowhere.clone(),
        right: nowhere.clone(),
        columns: 0,
        rows: 0,
        bounds: [0; 4],
        min_disparity: 0,
        max_disparity: 0,
        threads: 1,
        disparity: nowhere.clone(),
        reasons: nowhere.clone(),
        confidence: nowhere,
    }
}
