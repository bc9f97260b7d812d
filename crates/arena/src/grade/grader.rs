//! Runs every test of a scheme for one entrant, whatever happens.

use std::path::PathBuf;

use raster::{BoundingBox, Plane};

use super::attempt::{Attempt, Bench};
use super::confined::Confinement;
use super::entrant::Entrant;
use super::machine_speed::{self, MachineSpeed};
use super::outcome::Outcome;
use super::report::{PROTOCOL, Report, TestResult};
use super::scene::{Scene, Scenes};
use super::scheme::{Scheme, Test, total};
use super::verdict::Failure;
use crate::engine::Programs;
use crate::submission::{Finding, Inspection, Runner};

/// What is told while a grading goes on.
#[derive(Debug)]
pub enum Event<'a> {
    /// A test begins.
    Begins(&'a Test),
    /// A test has ended.
    Ended(&'a TestResult),
}

/// Grades entrants by one scheme.
pub struct Grader<'a> {
    /// The tests.
    pub scheme: &'a Scheme,
    /// Their scenes.
    pub scenes: &'a Scenes,
    /// How entrants are run.
    pub confinement: Confinement,
    /// What definitions of engines refer to.
    pub programs: Programs,
    /// Runs submissions; in words, why there is none.
    pub runner: Result<Runner, String>,
    /// Whether every test is run twice, to see whether both answers agree.
    pub twice: bool,
    /// Files that must be out of every entrant's reach, besides those of the scenes.
    pub secrets: Vec<PathBuf>,
}

impl Grader<'_> {
    /// Looks at a submission, without running its matchers; there is nothing to be seen of others.
    pub fn inspect(&self, entrant: &Entrant) -> Inspection {
        match entrant {
            Entrant::Submission(submission) => {
                let mut inspection = self.bench().inspect(submission);
                let missing = submission.findings().iter().cloned();
                inspection.findings.splice(0..0, missing);
                inspection
            }
            Entrant::Refused(_) | Entrant::NotTaken(_) | Entrant::Engines(_) => {
                Inspection::default()
            }
        }
    }

    /// Runs all tests for `entrant`, which is called `name` in the report, and was looked at.
    pub fn grade(
        &self,
        name: &str,
        entrant: &Entrant,
        inspection: Inspection,
        observe: &mut dyn FnMut(Event<'_>),
    ) -> Report {
        let bench = self.bench();
        let before_seconds = machine_speed::measure();
        let mut tests = Vec::new();
        for test in &self.scheme.tests {
            observe(Event::Begins(test));
            let result = self.test(&bench, entrant, &inspection.findings, test);
            observe(Event::Ended(&result));
            tests.push(result);
        }
        let machine_speed =
            MachineSpeed { before_seconds, after_seconds: machine_speed::measure() };
        Report {
            hazcam: env!("CARGO_PKG_VERSION").to_owned(),
            scheme: self.scheme.name.clone(),
            entrant: name.to_owned(),
            secret_id: inspection.secret_id,
            findings: inspection.findings,
            points: total(tests.iter().map(|test| test.points)),
            max_points: self.scheme.points(),
            tests,
            protocol: PROTOCOL.to_owned(),
            confinement: if self.confinement.helper.is_some() { "sandbox" } else { "none" }.into(),
            python: match (entrant, &self.runner) {
                (Entrant::Submission(_), Ok(runner)) => Some(runner.python().version.clone()),
                _ => None,
            },
            machine_speed,
        }
    }

    /// Runs one more test, such as a hold-out, that is not part of the scheme.
    pub fn extra(&self, entrant: &Entrant, test: &Test, scene: &Scene) -> TestResult {
        let (first, second) = self.attempts(&self.bench(), entrant, test, scene);
        self.judge(test, scene, first, second)
    }

    /// One run, and a second one where its answer is to be compared.
    fn attempts(
        &self,
        bench: &Bench<'_>,
        entrant: &Entrant,
        test: &Test,
        scene: &Scene,
    ) -> (Attempt, Option<Attempt>) {
        let first = bench.attempt(entrant, test, scene);
        let is_repeated = self.twice && first.result.is_ok();
        let second = is_repeated.then(|| bench.attempt(entrant, test, scene));
        (first, second)
    }

    fn bench(&self) -> Bench<'_> {
        Bench {
            confinement: &self.confinement,
            programs: &self.programs,
            runner: self.runner.as_ref().map_err(String::as_str),
            secrets: &self.secrets,
        }
    }

    fn test(
        &self,
        bench: &Bench<'_>,
        entrant: &Entrant,
        findings: &[Finding],
        test: &Test,
    ) -> TestResult {
        let scene = match self.scenes.get(&test.scene) {
            Some(Ok(scene)) => scene,
            Some(Err(problem)) => return unanswered(test, Failure::new(Outcome::Xx, problem)),
            None => {
                let problem = format!("scene {} was not loaded", test.scene);
                return unanswered(test, Failure::new(Outcome::Xx, problem));
            }
        };
        let file = format!("{}.py", test.part.function());
        if let Some(fatal) = findings.iter().find(|found| found.fatal && found.file == file) {
            return unanswered(test, Failure::new(Outcome::Re, fatal.to_string()));
        }
        let (first, second) = self.attempts(bench, entrant, test, scene);
        self.judge(test, scene, first, second)
    }

    fn judge(
        &self,
        test: &Test,
        scene: &Scene,
        attempt: Attempt,
        second: Option<Attempt>,
    ) -> TestResult {
        let mut remarks = Vec::new();
        let (disparity, scores) = match attempt.result {
            Ok(answer) => answer,
            Err(failure) => {
                let (usage, startup, output) = (attempt.usage, attempt.startup, attempt.log);
                return TestResult { usage, startup, output, remarks, ..unanswered(test, failure) };
            }
        };
        if scores.clipped > 0 {
            remarks.push(format!(
                "{} of the {} pixels in the box were outside 0 to {} and were brought to the \
                 nearer end",
                scores.clipped,
                scene.bounds.columns() * scene.bounds.rows(),
                test.max_disparity
            ));
        }
        if scores.looks_copied() {
            remarks.push(format!(
                "suspicious: {:.0} % of the scored pixels equal the truth to the last bit, {:.0} % to 0.05 px",
                scores.identical * 100.0,
                scores.nearly * 100.0
            ));
        }
        remarks.extend(second.and_then(|second| disagreement(&disparity, second, scene.bounds)));
        let mut result = TestResult {
            outcome: Outcome::Ok,
            message: None,
            scores: Some(scores),
            usage: attempt.usage,
            startup: attempt.startup,
            remarks,
            output: attempt.log,
            disparity: Some(disparity),
            ..unanswered(test, Failure::new(Outcome::Ok, ""))
        };
        if result.passes() {
            result.points = test.points;
        }
        result
    }
}

/// How the second answer differs from the first; `None` when it does not.
fn disagreement(first: &Plane<f32>, second: Attempt, bounds: BoundingBox) -> Option<String> {
    let second = match second.result {
        Ok((disparity, _)) => disparity,
        Err(failure) => {
            return Some(format!(
                "a second run ended differently, {}: {}",
                failure.outcome, failure.message
            ));
        }
    };
    let differs = |(x, y): (usize, usize)| {
        let (a, b) = (first.row(y)[x], second.row(y)[x]);
        a != b && !(a.is_nan() && b.is_nan())
    };
    match bounds.pixels().filter(|&pixel| differs(pixel)).count() {
        0 => None,
        count => Some(format!("a second run gave other values in {count} pixels of the box")),
    }
}

fn unanswered(test: &Test, failure: Failure) -> TestResult {
    TestResult {
        name: test.name.clone(),
        part: test.part,
        scene: test.scene.clone(),
        outcome: failure.outcome,
        message: Some(failure.message),
        scores: None,
        max_e_rms: test.max_e_rms,
        max_p_bad: test.max_p_bad,
        cpu_limit_seconds: test.cpu_seconds,
        points: 0.0,
        max_points: test.points,
        usage: Default::default(),
        startup: Default::default(),
        remarks: Vec::new(),
        output: String::new(),
        disparity: None,
    }
}
