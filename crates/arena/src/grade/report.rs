//! What comes out of a grading: everything that the outputs show.

use raster::Plane;
use serde::{Deserialize, Serialize};

use super::answer::Scores;
use super::machine_speed::MachineSpeed;
use super::outcome::Outcome;
use crate::engine::Usage;
use crate::report::shown_until;
use crate::submission::{Finding, Part};

/// How points are given, for reports.
pub const PROTOCOL: &str = "A test gives its points when E_RMS and p_bad are both below their \
thresholds, else none. Both are taken over the pixels of the box (inclusive) with known, nonzero \
truth; values outside [0, max_disparity] are brought to the nearer end and counted. CPU time is \
user and system time of the entrant's process, read from outside between sending the images and \
receiving the answer, on one thread; imports are not part of it.";

/// One graded entrant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The version of hazcam.
    pub hazcam: String,
    /// The scheme's name.
    pub scheme: String,
    /// What was graded, as it was called on the command line.
    pub entrant: String,
    /// The name for the leaderboard, where there is a usable one.
    pub secret_id: Option<String>,
    /// What was noticed before anything was run.
    pub findings: Vec<Finding>,
    /// One result per test of the scheme, in its order, always.
    pub tests: Vec<TestResult>,
    /// The sum of the tests' points.
    pub points: f64,
    /// What can be had.
    pub max_points: f64,
    /// How points are given.
    pub protocol: String,
    /// How entrants were confined: "sandbox" or "none".
    pub confinement: String,
    /// The Python that ran a submission.
    pub python: Option<String>,
    /// How fast the machine was.
    #[serde(rename = "calibration")]
    pub machine_speed: MachineSpeed,
}

/// One test of one entrant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TestResult {
    /// The test's name.
    pub name: String,
    /// Which function was asked.
    pub part: Part,
    /// On which scene.
    pub scene: String,
    /// How it ended.
    pub outcome: Outcome,
    /// Why there is no answer.
    pub message: Option<String>,
    /// The two numbers, when there is an answer.
    pub scores: Option<Scores>,
    /// E_RMS passes below this, in pixels.
    pub max_e_rms: f64,
    /// p_bad passes below this.
    pub max_p_bad: f64,
    /// The limit of CPU time in seconds.
    pub cpu_limit_seconds: f64,
    /// Points given.
    pub points: f64,
    /// What can be had.
    pub max_points: f64,
    /// From the job to its answer.
    pub usage: Usage,
    /// Until it was ready: imports.
    pub startup: Usage,
    /// What the instructor, and perhaps the author, should know.
    pub remarks: Vec<String>,
    /// What the entrant printed, its last part.
    pub output: String,
    /// The answer, for pictures.
    #[serde(skip)]
    pub disparity: Option<Plane<f32>>,
}

impl TestResult {
    /// Whether both numbers are below their thresholds.
    pub fn passes(&self) -> bool {
        self.scores
            .as_ref()
            .is_some_and(|scores| scores.e_rms < self.max_e_rms && scores.p_bad < self.max_p_bad)
    }

    /// Whether points depend on it; of one without it is enough to be answered.
    pub fn counts(&self) -> bool {
        self.max_points > 0.0
    }

    /// Whether there is an answer, and one that passes where points depend on that.
    pub fn is_met(&self) -> bool {
        if self.counts() { self.passes() } else { self.scores.is_some() }
    }

    /// Why there are no points, in one text; `None` when there are.
    pub fn shortfall(&self) -> Option<String> {
        if let Some(message) = &self.message {
            return Some(message.clone());
        }
        let scores = self.scores.as_ref()?;
        let mut parts = Vec::new();
        if scores.e_rms >= self.max_e_rms {
            let e_rms = shown_until(scores.e_rms, 2, |shown| shown >= self.max_e_rms);
            parts.push(format!("E_RMS {e_rms} px is not below {}", self.max_e_rms));
        }
        if scores.p_bad >= self.max_p_bad {
            let p_bad = shown_until(scores.p_bad, 4, |shown| shown >= self.max_p_bad);
            parts.push(format!("p_bad {p_bad} is not below {}", self.max_p_bad));
        }
        (!parts.is_empty()).then(|| parts.join(", "))
    }
}

impl Report {
    /// Whether the grader failed in any test: then nothing is said about the entrant there.
    pub fn grader_failed(&self) -> bool {
        self.tests.iter().any(|test| test.outcome == Outcome::Xx)
    }

    /// CPU time of all tests, where it is known of all.
    pub fn cpu_seconds(&self) -> Option<f64> {
        self.tests.iter().map(|test| test.usage.cpu_seconds).sum()
    }
}
