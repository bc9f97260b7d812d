//! Where the time of a frame goes, stage by stage, and what was done in it.
//!
//! Every stage says what its work amounts to at the least, beside the code that does it: the bytes of
//! the planes that it goes through from beginning to end, once for each time that it does, and the
//! operations on bytes that its formulas ask for (one on numbers of 16 or 32 bits counts as 2 or 4), and apart from
//! these the products of numbers of 16 bits that are summed up, for which processors have instructions of their own.
//! What fits a row or two is not counted, since it stays in the nearest cache. How long that takes at
//! the least, [`crate::Limits`] tells.

use std::ops::{Add, Mul};
use std::time::{Duration, Instant};

/// A stage of a preset, with the time on the wall that a frame spent in it, and what was done at the
/// least. Sums over all of its runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Stage {
    /// In the words of the preset's explanation.
    pub name: &'static str,
    /// How often it ran.
    pub runs: u32,
    /// From the end of the stage before to its own.
    pub time: Duration,
    /// Bytes of whole planes that it reads and writes.
    pub bytes: u64,
    /// Operations on single bytes; 0 where it does little but move them, or where what it does depends
    /// too much on what the images show.
    pub operations: u64,
    /// Products of numbers of 16 bits, each added to a sum: what networks are made of.
    pub products: u64,
}

impl Stage {
    /// What it reads and writes each time, on average.
    pub fn bytes_per_run(&self) -> u64 {
        self.bytes / u64::from(self.runs.max(1))
    }
}

/// What is done at the least.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Work {
    bytes: u64,
    operations: u64,
    products: u64,
}

impl Work {
    /// So many bytes of planes.
    pub fn bytes(bytes: usize) -> Self {
        Self { bytes: bytes as u64, ..Self::default() }
    }

    /// So many operations on bytes.
    pub fn operations(operations: usize) -> Self {
        Self { operations: operations as u64, ..Self::default() }
    }

    /// So many products of numbers of 16 bits, each added to a sum.
    pub fn products(products: usize) -> Self {
        Self { products: products as u64, ..Self::default() }
    }
}

impl Add for Work {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            bytes: self.bytes + other.bytes,
            operations: self.operations + other.operations,
            products: self.products + other.products,
        }
    }
}

impl Mul<usize> for Work {
    type Output = Self;

    /// The same so many times, such as for every pixel.
    fn mul(self, times: usize) -> Self {
        let times = times as u64;
        Self {
            bytes: times * self.bytes,
            operations: times * self.operations,
            products: times * self.products,
        }
    }
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

    /// The time since the last stage ended went into this one, which did `work`.
    pub fn end(&mut self, name: &'static str, work: Work) {
        let now = Instant::now();
        let time = now - self.since;
        self.since = now;
        let Work { bytes, operations, products } = work;
        match self.stages.iter_mut().find(|stage| stage.name == name) {
            Some(stage) => {
                stage.runs += 1;
                stage.time += time;
                stage.bytes += bytes;
                stage.operations += operations;
                stage.products += products;
            }
            None => self.stages.push(Stage { name, runs: 1, time, bytes, operations, products }),
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
        let paths = Work::bytes(10) + Work::operations(100) + Work::products(7);
        profile.end("paths", paths);
        profile.end("fill", Work::bytes(3));
        profile.end("paths", paths + (Work::bytes(1) + Work::operations(2)) * 4);
        let sums = profile.stages().iter();
        let sums = sums.map(|s| (s.name, s.runs, s.bytes, s.operations, s.products));
        assert_eq!(sums.collect::<Vec<_>>(), [("paths", 2, 24, 208, 14), ("fill", 1, 3, 0, 0)]);
        profile.begin();
        assert!(profile.stages().is_empty());
    }
}
