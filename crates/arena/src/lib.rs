//! Data sets, engines, runs and records: everything that compares matchers.

pub mod engine;
pub mod sandbox;
