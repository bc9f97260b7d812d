//! Engines: processes that match pairs of images, hazcam's own presets included.
//!
//! A [`Session`] is one such process. It is started with a scratch folder, says that it is ready,
//! takes [`protocol::Job`]s and answers them through files; its CPU time, wall time and memory are
//! measured from outside ([`Usage`]). Whatever goes wrong becomes a [`Status`], never the end of a
//! run. `PROTOCOL.md` at the crate's root is the engine author's side of the story.

mod limits;
mod process;
pub mod protocol;
mod session;
mod status;
mod talk;
mod usage;

pub use limits::Limits;
pub use session::Session;
pub use status::Status;
pub use usage::{Usage, measures_cpu_time};
