//! Data sets, engines, runs and records: everything that compares matchers.

pub mod dataset;
pub mod engine;
pub mod sandbox;
