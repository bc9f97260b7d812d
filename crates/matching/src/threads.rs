//! The threads that work on a frame.
//!
//! Between frames they sleep, and in the next one the first of them wakes the others. Linux may queue
//! one that is woken behind the thread that woke it though another processor idles, and moves it only
//! some milliseconds later, when a small frame is over. With pauses of 30 ms, as between a camera's
//! frames, two threads on two processors took 18 ms for `fast` on a frame of KITTI, and 12 ms where each
//! keeps to one of them. So they do where there is one for every processor that the process may use:
//! then no other is free to go to.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// So many threads.
pub(crate) fn start(threads: usize) -> Result<ThreadPool, ThreadPoolBuildError> {
    let processors = processors();
    let builder = ThreadPoolBuilder::new().num_threads(threads);
    match threads == processors.len() {
        true => builder.start_handler(move |thread| keep_to(processors[thread])).build(),
        false => builder.build(),
    }
}

/// The processors that the process may use, where that can be told.
#[cfg(target_os = "linux")]
fn processors() -> Vec<usize> {
    use rustix::thread::{CpuSet, sched_getaffinity};
    // A machine with more processors than fit the set is not told about: threads go where they like.
    sched_getaffinity(None).map_or_else(
        |_| Vec::new(),
        |set| (0..CpuSet::MAX_CPU).filter(|&processor| set.is_set(processor)).collect(),
    )
}

#[cfg(not(target_os = "linux"))]
fn processors() -> Vec<usize> {
    Vec::new()
}

/// From now on this thread runs on one processor. Where the system refuses, it runs where it likes.
#[cfg(target_os = "linux")]
fn keep_to(processor: usize) {
    let mut set = rustix::thread::CpuSet::new();
    set.set(processor);
    let _ = rustix::thread::sched_setaffinity(None, &set);
}

#[cfg(not(target_os = "linux"))]
fn keep_to(_: usize) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_for_every_processor_has_one_of_its_own() {
        let all = processors();
        let count = all.len().max(1);
        let pool = start(count).unwrap();
        assert_eq!(pool.broadcast(|_| processors()).concat(), all);
        // One more than there are processors: all go where they like.
        let pool = start(count + 1).unwrap();
        assert!(pool.broadcast(|_| processors()).iter().all(|own| *own == all));
    }
}
