//! Data sets, engines, runs and records: everything that compares matchers.

pub mod board;
pub mod dataset;
pub mod engine;
pub mod grade;
pub mod interrupt;
pub mod record;
pub mod report;
pub mod run;
pub mod sandbox;
pub mod speed;
pub mod submission;
pub mod viewer;
