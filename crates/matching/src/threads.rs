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
    let pool = match threads == processors.len() {
        true => builder.start_handler(move |thread| keep_to(processors[thread])).build(),
        false => builder.build(),
    }?;
    // Memory allocators set some aside for a thread that asks for the first time (glibc 64 MB of addresses): all are
    // to have theirs before anybody looks at what the process has taken and may take.
    run_in(&pool, || {
        rayon::broadcast(|_| drop(std::hint::black_box(Vec::<u8>::with_capacity(1))));
    });
    Ok(pool)
}

/// What a closure gives in a pool. A thread of another pool would take up other work of its own while it waits,
/// work that may need what it holds: then a thread that belongs to none waits for it instead.
pub(crate) fn run_in<T: Send>(pool: &ThreadPool, work: impl FnOnce() -> T + Send) -> T {
    if rayon::current_thread_index().is_none() {
        return pool.install(work);
    }
    let done = std::thread::scope(|scope| scope.spawn(|| pool.install(work)).join());
    done.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
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
    fn a_worker_of_another_pool_takes_up_nothing_else_while_it_waits() {
        use std::sync::atomic::{AtomicBool, Ordering};
        let (pool, callers) = (start(1).unwrap(), start(1).unwrap());
        // Long enough for the caller to look for other work.
        let work = || {
            std::thread::sleep(std::time::Duration::from_millis(50));
            7
        };
        let to_run = || assert_eq!(run_in(&pool, work), 7);
        // Of many threads it takes a while to have all.
        let to_start = || drop(start(200).unwrap());
        let waits: [&(dyn Fn() + Sync); 2] = [&to_run, &to_start];
        for waits in waits {
            let is_waiting = AtomicBool::new(false);
            let wait = || {
                is_waiting.store(true, Ordering::SeqCst);
                waits();
                is_waiting.store(false, Ordering::SeqCst);
            };
            let look = || is_waiting.load(Ordering::SeqCst);
            let ((), was_waiting) = callers.install(|| rayon::join(wait, look));
            assert!(!was_waiting);
        }
    }

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
