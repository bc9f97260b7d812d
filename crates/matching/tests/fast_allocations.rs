//! A matcher that has seen one frame allocates nothing for the next of that size.

use matching::{Matcher, Options, Preset};
use peak_alloc::PeakAlloc;
use raster::{DisparityRange, Image, Plane};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// The thread pool hands work over through a queue that takes a new block of about 1.5 kB every 63
/// times and gives the old one back: that is its affair, and far less than any row of a frame.
const QUEUE: usize = 4096;

#[test]
fn frames_after_the_first_allocate_nothing() {
    let (columns, rows) = (320, 200);
    let texture = |x: usize, y: usize| (x * 7919 + y * 104_729 + x * x * y * 31) as u8;
    let image = |shift: usize| Plane::from_fn(columns, rows, |x, y| texture(x + shift, y));
    let images = |shift: usize| [Image::Grey8(image(0)), Image::Grey8(image(shift))];
    let frames = [images(3), images(11)];
    for threads in [1, 2, 4] {
        let range = DisparityRange::new(0, 31).unwrap();
        let mut options = Options::new(Preset::Fast, range);
        options.threads = threads;
        let mut matcher = Matcher::new(options).unwrap();
        for [left, right] in &frames {
            matcher.compute(left, right, None).unwrap();
        }
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        for _ in 0..25 {
            for [left, right] in &frames {
                matcher.compute(left, right, None).unwrap();
            }
        }
        // An allocation that was given back again has raised the peak all the same.
        let peak = MEMORY.peak_usage().saturating_sub(before);
        assert!(peak <= QUEUE, "{peak} bytes at most beyond the first frame, {threads} threads");
        let left_over = MEMORY.current_usage().saturating_sub(before);
        assert!(left_over <= QUEUE, "{left_over} bytes kept by 50 frames, {threads} threads");
    }
}
