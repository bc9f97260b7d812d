//! Damaged files are answered with an error that names them: no panic, no memory taken on the word
//! of a file, and a file that was cut off is never taken for a whole one.

mod samples;

use std::fs;
use std::path::Path;

use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// More than any of the small files may make a reader take. What compressed data of a thousand
/// bytes can stand for is the most of it.
const ALLOWED: usize = 16 << 20;

/// Repeatable pseudo-random numbers (SplitMix64).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % end as u64) as usize
    }
}

/// Decodes `bytes`; whether they are sound.
fn is_sound(name: &str, bytes: &[u8]) -> bool {
    let copy = bytes.to_vec();
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let result = formats::inspect_bytes(name, copy);
    let taken = MEMORY.peak_usage() - before;
    assert!(taken < ALLOWED, "{name}: {taken} bytes were taken for {} bytes", bytes.len());
    match result {
        Ok(info) => {
            assert!(info.to_string().starts_with(name));
            true
        }
        Err(error) => {
            assert_eq!(error.path(), Some(Path::new(name)), "{error}");
            false
        }
    }
}

// The memory is counted for the whole process: what runs beside this test must take little.
#[test]
fn every_decoder_survives_every_damage() {
    for (name, bytes) in &samples::every_kind() {
        let refused = ["objects.npy", "four_samples.tif", "bits_reversed.tif"].contains(&&name[..]);
        assert_eq!(is_sound(name, bytes), !refused, "{name} as it is");

        // Text that is cut off may still be whole, only with other numbers.
        let text = name.starts_with("plain") || name.ends_with(".txt");
        for length in 0..bytes.len() {
            let sound = is_sound(name, &bytes[..length]);
            assert!(text || !sound, "{name} cut off at {length} of {}", bytes.len());
        }

        let mut random = Random(bytes.len() as u64);
        for _ in 0..1000 {
            let mut damaged = bytes.clone();
            for _ in 0..=random.below(3) {
                let at = random.below(damaged.len());
                damaged[at] ^= 1 << random.below(8);
            }
            is_sound(name, &damaged);
        }
        // Headers are where the sizes stand.
        for _ in 0..1000 {
            let mut damaged = bytes.clone();
            let at = random.below(damaged.len().min(64));
            damaged[at] = [0, 1, 0x7f, 0x80, 0xff][random.below(5)];
            is_sound(name, &damaged);
        }
    }
}

#[test]
fn every_reader_names_the_file_that_it_cannot_read() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in samples::every_kind() {
        let path = folder.path().join(name);
        for length in [0, 1, 5, bytes.len() / 2, bytes.len() - 1, bytes.len()] {
            fs::write(&path, &bytes[..length]).unwrap();
            samples::read_as_everything(&path);
        }
    }
    let missing = folder.path().join("missing.png");
    samples::read_as_everything(&missing);
    samples::read_as_everything(folder.path());
}
