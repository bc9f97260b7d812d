//! What came of one engine on one pair, and what follows from it.

use score::median;
use serde::{Deserialize, Serialize};

use crate::engine::{Definition, Status};

/// All rounds of one engine on one pair of images.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// The engine's name.
    pub engine: String,
    /// What it is, in one line.
    pub description: String,
    /// The version that it states.
    pub version: Option<String>,
    /// How it ended.
    #[serde(flatten)]
    pub status: Status,
    /// What each round took by the engine's own clock, matching alone, in order.
    pub seconds: Vec<f64>,
    /// CPU time of the process as seen from outside, files included, in seconds: median over the
    /// rounds. `None` where the system does not tell.
    pub cpu_seconds: Option<f64>,
    /// Largest resident set of the process in bytes; `None` where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
}

impl Measurement {
    /// Nothing measured yet.
    pub fn new(engine: &Definition, version: Option<&str>) -> Self {
        Self {
            engine: engine.name.clone(),
            description: engine.description.clone(),
            version: version.map(Into::into),
            status: Status::Done,
            seconds: Vec::new(),
            cpu_seconds: None,
            peak_memory_bytes: None,
        }
    }

    /// The quickest round in seconds.
    pub fn minimum(&self) -> Option<f64> {
        self.seconds.iter().copied().min_by(f64::total_cmp)
    }

    /// The round in the middle in seconds, or the mean of the two in the middle.
    pub fn median(&self) -> Option<f64> {
        median(self.seconds.iter().copied())
    }
}
