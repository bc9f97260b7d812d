//! A matcher that has seen one frame allocates nothing for the next of that size.

use matching::{Ingredient, Matcher, Options, Preset};
use peak_alloc::PeakAlloc;
use raster::{DisparityRange, Image, Plane};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// The thread pool hands work over through a queue that takes a new block of about 1.5 kB every 63
/// times and gives the old one back, and each of its threads takes some 2 kB when it first takes work
/// from another, which on a busy machine may be after the first frame. That is its affair, and far less
/// than any plane of a frame, for each thread.
const QUEUE: usize = 4096;

/// Columns and rows.
const SIZE: (usize, usize) = (320, 120);
const DISPARITIES: i32 = 32;

#[test]
fn frames_after_the_first_allocate_nothing() {
    // Without a limit, and with one that makes bands of the sums.
    for (preset, memory, frames) in [
        (Preset::Fast, None, 50),
        (Preset::Balanced, None, 10),
        (Preset::Balanced, Some(4_000_000), 10),
        (Preset::Best, None, 4),
    ] {
        for threads in [1, 2, 4] {
            let mut options = options(preset);
            (options.threads, options.memory) = (threads, memory);
            frames_after_the_first(options, frames);
        }
    }
    // What is done in the place of what is left out.
    for without in Ingredient::of(Preset::Balanced) {
        let mut options = options(Preset::Balanced);
        (options.threads, options.without) = (2, vec![*without]);
        frames_after_the_first(options, 3);
    }
}

fn options(preset: Preset) -> Options {
    Options::new(preset, DisparityRange::new(0, DISPARITIES - 1).unwrap())
}

fn frames_after_the_first(options: Options, frames: usize) {
    let (columns, rows) = SIZE;
    let texture = |x: usize, y: usize| (x * 7919 + y * 104_729 + x * x * y * 31) as u8;
    // Two rows higher in the right image: there is vertical disparity to be taken out.
    let image = |(along, down): (usize, usize)| {
        Plane::from_fn(columns, rows, |x, y| texture(x + along, y + down))
    };
    let pair = |shift: usize| [(0, 0), (shift, 2)].map(|by| Image::Grey8(image(by)));
    let pairs = [pair(3), pair(11)];
    let rectified = [0, 3].map(|along| Image::Grey8(image((along, 0))));
    let Options { preset, threads, .. } = options;
    let mends = preset != Preset::Fast && !options.without.contains(&Ingredient::VerticalAlignment);
    let what = format!("{options:?}");
    let mut matcher = Matcher::new(options).unwrap();
    let frame = |matcher: &mut Matcher, i: usize| {
        let [left, right] = &pairs[i % 2];
        matcher.compute(left, right, None).unwrap();
    };
    // Nothing to mend in the first frame: what that takes must be there already.
    matcher.compute(&rectified[0], &rectified[1], None).unwrap();
    assert_eq!(matcher.vertical_disparity(), None);
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    (0..frames).for_each(|i| frame(&mut matcher, i));
    assert_eq!(matcher.vertical_disparity().is_some(), mends, "{what}");
    // An allocation that was given back again has raised the peak all the same.
    let peak = MEMORY.peak_usage().saturating_sub(before);
    let pool = QUEUE * threads;
    assert!(peak <= pool, "{what}: {peak} bytes at most beyond the first frame");
    let left_over = MEMORY.current_usage().saturating_sub(before);
    assert!(left_over <= pool, "{what}: {left_over} bytes kept by {frames} frames");
}
