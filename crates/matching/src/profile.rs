//! Where the time of a frame goes, stage by stage.

use std::time::{Duration, Instant};

/// A stage of a preset, with the time on the wall that a frame spent in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Stage {
    /// In the words of the preset's explanation.
    pub name: &'static str,
    /// All of its runs together.
    pub time: Duration,
}

/// The stages of one frame, in the order in which they first ran.
pub(crate) struct Profile {
    stages: Vec<Stage>,
    since: Instant,
}

impl Profile {
    /// No stage has run yet.
    pub fn new() -> Self {
        Self { stages: Vec::new(), since: Instant::now() }
    }

    /// A new frame begins.
    pub fn begin(&mut self) {
        self.stages.clear();
        self.since = Instant::now();
    }

    /// The time since the last stage ended went into this one.
    pub fn end(&mut self, name: &'static str) {
        let now = Instant::now();
        let time = now - self.since;
        self.since = now;
        match self.stages.iter_mut().find(|stage| stage.name == name) {
            Some(stage) => stage.time += time,
            None => self.stages.push(Stage { name, time }),
        }
    }

    pub fn stages(&self) -> &[Stage] {
        &self.stages
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_that_runs_again_is_added_up_and_a_new_frame_begins_anew() {
        let mut profile = Profile::new();
        profile.begin();
        ["paths", "fill", "paths"].into_iter().for_each(|name| profile.end(name));
        let names: Vec<_> = profile.stages().iter().map(|stage| stage.name).collect();
        assert_eq!(names, ["paths", "fill"]);
        profile.begin();
        assert!(profile.stages().is_empty());
    }
}
