//! One file per command, each with `Args` (what is typed, with its help) and `run`.

pub mod bench;
pub mod board;
pub mod completions;
pub mod demo;
pub mod depth;
pub mod doctor;
pub mod engine;
pub mod explain;
pub mod grade;
pub mod info;
pub mod man;
pub mod match_pair;
pub mod sandbox_exec;
pub mod score;
pub mod view;

use clap::builder::PossibleValuesParser;

/// One of these names; a wrong one is answered with the list.
pub fn choice<const N: usize>(names: [&'static str; N]) -> PossibleValuesParser {
    PossibleValuesParser::new(names)
}
