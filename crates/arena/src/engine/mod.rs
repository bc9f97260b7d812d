//! Engines: processes that match pairs of images, hazcam's own presets included.
//!
//! | piece | question |
//! | --- | --- |
//! | [`protocol`] | which messages are exchanged? (`PROTOCOL.md` at the crate's root has the whole story) |
//! | [`Session`] | one process from start to end; sends jobs, waits for answers, enforces [`Limits`] |
//! | [`Usage`] | CPU time, wall time and memory, read from outside |
//! | [`exchange`] | the files through which images and answers travel, read strictly |
//! | [`Definition`], [`Engines`] | what is an engine? A few lines of TOML |
//! | [`Worker`] | an engine at work on many pairs, started again after a crash |
//! | [`serve`] | the engine's side, for engines written in Rust |
//!
//! Whatever goes wrong becomes a [`Status`], never the end of a run.

mod attempt;
mod definition;
pub mod exchange;
mod launch;
mod limits;
pub(crate) mod process;
pub mod protocol;
pub(crate) mod robust_vision;
mod serve;
mod session;
pub(crate) mod status;
mod talk;
mod usage;
mod worker;

pub use attempt::Attempt;
pub use definition::{Definition, DefinitionError, Engines, Kind};
pub use exchange::{Answer, Pair, write_answer};
pub use launch::Programs;
pub(crate) use launch::{THREAD_VARIABLES, command, from_here};
pub use limits::Limits;
pub use serve::serve;
pub use session::Session;
pub use status::Status;
pub use usage::{Usage, measures_cpu_time};
pub use worker::Worker;
