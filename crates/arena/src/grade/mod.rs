//! Points for entrants: every test of a [`Scheme`], each in a process of its own.
//!
//! ```text
//! Scheme (TOML) + Scenes ---> Grader::grade(entrant) ---> Report ---> output: text, JSON, JUnit,
//!                               |  one process per test                 Autolab, Gradescope
//!                               |  in a sandbox, measured from outside
//! ```
//! For every test: empty folders; the images, and for a submission a fresh copy of its files, go
//! into them, the truth never does; the process starts, says that it is ready, gets the job, and
//! the clock runs until its answer; it is killed; its answer is read as if an enemy had written it,
//! and scored. What goes wrong is an [`Outcome`] with a message that its author can act on, never
//! the end of the grading: a report has a result for every test, always. What is the grader's own
//! fault is marked so ([`Outcome::Xx`]) and never blamed on the entrant.

mod answer;
mod attempt;
mod confined;
mod entrant;
mod error;
mod grader;
mod machine_speed;
mod outcome;
pub mod output;
mod report;
mod scene;
mod scheme;
mod verdict;

pub use answer::Scores;
pub use confined::{Allowance, Confinement};
pub use entrant::Entrant;
pub use error::SchemeError;
pub use grader::{Event, Grader};
pub use machine_speed::MachineSpeed;
pub use outcome::Outcome;
pub use report::{PROTOCOL, Report, TestResult};
pub use scene::{Render, Scene, Scenes, load_scenes};
pub use scheme::{COURSE, MOST_SECONDS, SceneSource, Scheme, Test};
