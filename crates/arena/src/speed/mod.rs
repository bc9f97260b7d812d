//! How fast engines are: matching alone, many times over, in turns.
//!
//! | file | question |
//! | --- | --- |
//! | `contest` | how is it measured? Engines take turns on one pair of images, A B A B |
//! | `measurement` | what came of one engine, and what follows from it: minimum, median, rate |
//! | `peers` | who is compared with whom? |
//! | `record` | what is kept, and what a later run replaces |
//! | `tables` | how is it shown? |
//!
//! The time that counts is the one that an engine states for its matching alone (`seconds` in
//! `PROTOCOL.md`): what is seen from outside has the reading and writing of files in it, which costs
//! a fast matcher more than matching does. CPU time and memory are seen from outside.

mod contest;
mod measurement;
mod peers;
mod record;
mod tables;

pub use contest::{Event, Setting, run};
pub use measurement::Measurement;
pub use peers::PEERS;
pub use record::{Record, RecordError, Run, today};
pub use tables::{measurements_table, peers_table, sweep_table};
