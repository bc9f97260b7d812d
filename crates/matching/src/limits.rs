//! How fast a stage could be at the best: what this machine can do is measured, here and now, with the
//! threads and the instructions that the matcher uses.
//!
//! * **Memory.** A stage takes at least the time in which as many bytes are copied over and over. They
//!   are copied in pieces as large as the stage's own: what fits the caches is not asked to be as slow
//!   as main memory. Bytes read and bytes written both count.
//! * **Operations.** A stage takes at least the time in which the registers do as many operations on
//!   bytes, as many at a time as their width allows, with nothing to load or to store.
//! * **Products.** A stage takes at least the time in which as many products of numbers of 16 bits are added to sums
//!   in registers, with one load for many of them.
//!
//! Processors may do one while they do another, so the longest of the three counts.

use std::hint::black_box;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::kernels::aligned::Line;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::products::{LANES, Sums};
use crate::profile::Stage;

/// The smallest piece that is copied, in bytes read and written; the next are each twice as large.
const SMALLEST: u64 = 64 << 10;
/// The largest, far beyond most caches.
const LARGEST: u64 = 128 << 20;
/// A measurement takes so long at least.
const WINDOW: Duration = Duration::from_millis(2);
/// Of so many the best counts: others have work to do, too.
const MEASUREMENTS: usize = 4;

/// What this machine can do at the most with the threads and instructions of a matcher.
#[derive(Debug, Clone)]
pub struct Limits {
    /// Operations on bytes per second.
    operations: f64,
    /// Products of numbers of 16 bits per second.
    products: f64,
    /// Bytes per second, read and written, in pieces of [`SMALLEST`] and more.
    copies: Vec<f64>,
}

impl Limits {
    /// Measures in the thread pool that this is called in. Stages move up to `largest` bytes at once.
    pub(crate) fn measure(level: Level, largest: u64) -> Self {
        let sizes = largest.clamp(SMALLEST, LARGEST) / SMALLEST;
        let pieces = (0..=sizes.ilog2()).map(|i| SMALLEST << i);
        let mut buffer = vec![1; (SMALLEST << sizes.ilog2()) as usize];
        Self {
            operations: operations_per_second(level),
            products: products_per_second(level),
            copies: pieces.map(|piece| copied_per_second(&mut buffer[..piece as usize])).collect(),
        }
    }

    /// The least time that the bytes of a stage take; zero without any.
    pub fn memory(&self, stage: &Stage) -> Duration {
        let rate = self.bytes_per_second(stage.bytes_per_run());
        Duration::from_secs_f64(stage.bytes as f64 / rate)
    }

    /// The least time that the operations of a stage take; zero where none are counted.
    pub fn operations(&self, stage: &Stage) -> Duration {
        Duration::from_secs_f64(stage.operations as f64 / self.operations)
    }

    /// The least time that the products of a stage take; zero without any.
    pub fn products(&self, stage: &Stage) -> Duration {
        Duration::from_secs_f64(stage.products as f64 / self.products)
    }

    /// Operations on bytes per second, by all threads together.
    pub fn operations_per_second(&self) -> f64 {
        self.operations
    }

    /// Products of numbers of 16 bits, added to sums, per second, by all threads together.
    pub fn products_per_second(&self) -> f64 {
        self.products
    }

    /// Bytes read and written per second, by all threads together, where so many are moved at once.
    pub fn bytes_per_second(&self, at_once: u64) -> f64 {
        let place = (at_once.max(SMALLEST) / SMALLEST).ilog2() as usize;
        // Larger pieces are never faster, but for what else the machine had to do.
        let copies = &self.copies[place.min(self.copies.len() - 1)..];
        copies.iter().copied().fold(0.0, f64::max)
    }
}

/// The largest rate at which `run` does `amount` per round.
fn rate(amount: usize, mut run: impl FnMut(usize)) -> f64 {
    let mut time = |rounds: usize| {
        let start = Instant::now();
        run(rounds);
        start.elapsed()
    };
    let mut rounds = 1;
    let mut least = time(rounds);
    while least < WINDOW {
        rounds *= 2;
        least = time(rounds);
    }
    let least = (1..MEASUREMENTS).map(|_| time(rounds)).fold(least, Duration::min);
    (amount * rounds) as f64 / least.as_secs_f64()
}

/// One half of the buffer is copied into the other, each thread having its part.
fn copied_per_second(buffer: &mut [u8]) -> f64 {
    let amount = buffer.len();
    let (from, to) = buffer.split_at_mut(amount / 2);
    let part = from.len().div_ceil(rayon::current_num_threads());
    rate(amount, |rounds| {
        to.par_chunks_mut(part).zip(from.par_chunks(part)).for_each(|(to, from)| {
            (0..rounds).for_each(|_| black_box(&mut *to).copy_from_slice(black_box(from)));
        });
    })
}

/// It takes so many bytes that no operation waits for the one before, and so few that they stay in the
/// registers: how many differs from processor to processor, so several are tried.
fn operations_per_second(level: Level) -> f64 {
    [in_registers::<128>(level), in_registers::<256>(level), in_registers::<512>(level)]
        .into_iter()
        .fold(0.0, f64::max)
}

/// The rate of operations on `N` bytes that are not loaded or stored in between.
fn in_registers<const N: usize>(level: Level) -> f64 {
    const TIMES: usize = 1000;
    rate(2 * N * TIMES * rayon::current_num_threads(), |rounds| {
        rayon::broadcast(|_| {
            black_box(add_and_bound::<N>(level, rounds * TIMES, black_box(3), black_box(200)))
        });
    })
}

at_every_level! {
    /// Two operations on each of `N` bytes, over and over.
    fn add_and_bound<const N: usize>(times: usize, step: u8, most: u8) -> [u8; N] {
        let mut bytes = std::array::from_fn(|i| i as u8);
        for _ in 0..times {
            for byte in &mut bytes {
                *byte = byte.saturating_add(step).min(most);
            }
        }
        bytes
    }
}

/// So many pairs of numbers are loaded one after the other.
const PAIRS: usize = 16;

/// As many sums as fit the registers of one processor or another.
fn products_per_second(level: Level) -> f64 {
    [with_sums::<4>(level), with_sums::<8>(level), with_sums::<16>(level)]
        .into_iter()
        .fold(0.0, f64::max)
}

/// The rate of products that are added to `N` sums in every lane.
fn with_sums<const N: usize>(level: Level) -> f64 {
    const TIMES: usize = 100;
    let products = 2 * N * LANES * PAIRS * TIMES;
    rate(products * rayon::current_num_threads(), |rounds| {
        rayon::broadcast(|_| {
            let numbers = [Line([black_box(0); LANES]); PAIRS];
            black_box(multiply_and_add::<N>(level, rounds * TIMES, black_box([3, 5]), &numbers))
        });
    })
}

at_every_level! {
    /// Adds the products of all pairs with one pair to each of `N` sums of every lane, over and over.
    fn multiply_and_add<const N: usize>[products](times: usize, pair: [i16; 2], numbers: &[Sums; PAIRS]) -> [Sums; N] {
        let pairs = [[pair; N]; PAIRS];
        let mut sums = [Line([0; LANES]); N];
        for _ in 0..times {
            products.add_all(&mut sums, &pairs, black_box(numbers));
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::products::packed;

    fn stage(runs: u32, bytes: u64, operations: u64) -> Stage {
        Stage { name: "stage", runs, time: Duration::ZERO, bytes, operations, products: 3_000 }
    }

    #[test]
    fn pieces_are_as_large_as_a_run_and_slow_measurements_do_not_count() {
        // 64 kB at 8 GB/s, 128 kB at 2 (something was in the way), 256 kB and more at 4.
        let limits = Limits { operations: 1e9, products: 1e6, copies: vec![8e9, 2e9, 4e9] };
        let micros = |bytes, runs| limits.memory(&stage(runs, bytes, 0)).as_micros();
        assert_eq!([micros(0, 1), micros(80_000, 1), micros(160_000, 1)], [0, 10, 40]);
        assert_eq!([micros(160_000, 2), micros(40_000_000, 1)], [20, 10_000]);
        assert_eq!(limits.operations(&stage(3, 0, 5_000_000)), Duration::from_millis(5));
        assert_eq!(limits.products(&stage(3, 0, 0)), Duration::from_millis(3));
    }

    #[test]
    fn operations_are_done_as_they_are_counted() {
        for level in Level::available() {
            let bytes = add_and_bound::<128>(level, 3, 5, 100);
            assert_eq!((bytes[0], bytes[80], bytes[127]), (15, 95, 100));
            assert!(operations_per_second(level) > 0.0);
            let numbers = std::array::from_fn(|i| Line([packed(i as i32, 1); LANES]));
            let sums = multiply_and_add::<3>(level, 2, [10, 4], &numbers);
            assert_eq!(sums, [Line([2 * (10 * 120 + 4 * 16); LANES]); 3]);
            assert!(products_per_second(level) > 0.0);
        }
    }

    #[test]
    fn as_many_sizes_are_copied_as_the_stages_need() {
        for (largest, sizes) in [(0, 1), (SMALLEST, 1), (3 * SMALLEST, 2), (4 * SMALLEST, 3)] {
            assert_eq!(Limits::measure(Level::detect(), largest).copies.len(), sizes);
        }
    }
}
