//! A limit to the memory is kept and costs no quality.

use matching::{MatchError, Matcher, Options, Preset};
use peak_alloc::PeakAlloc;
use raster::{BoundingBox, DisparityMap, DisparityRange, Image, Plane};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// A slanted wall of noise that stands two rows higher in the right image.
fn pair(columns: usize, rows: usize) -> [Plane<u8>; 2] {
    let texture = |x: usize, y: usize| {
        let noise = (x * 0x9E37 + y * 0x79B9).wrapping_mul(0x2545_F491_4F6C_DD1D);
        (noise ^ noise >> 29).wrapping_mul(0x5851_F42D_4C95_7F2D) >> 40
    };
    let seen = |x: usize, y: usize| texture(x, y) as u8;
    let left = Plane::from_fn(columns, rows, seen);
    let right = Plane::from_fn(columns, rows, |x, y| seen(x + 3 + y / 16, y + 2));
    [left, right]
}

fn options(preset: Preset, threads: usize, memory: Option<usize>) -> Options {
    let mut options = Options::new(preset, DisparityRange::new(-2, 47).unwrap());
    (options.threads, options.memory) = (threads, memory);
    options
}

/// What the first frame takes, and its answer.
fn first_frame(
    options: Options,
    [left, right]: &[Image; 2],
    bounds: Option<BoundingBox>,
) -> (usize, DisparityMap) {
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let mut matcher = Matcher::new(options).unwrap();
    matcher.compute(left, right, bounds).unwrap();
    // Where there are enough pixels to tell, the rows are mended.
    let mends = matcher.options().preset != Preset::Fast && left.columns().min(left.rows()) > 100;
    assert_eq!(matcher.vertical_disparity().is_some(), mends);
    let answer = matcher.map();
    let peak = MEMORY.peak_usage() - before;
    (peak, answer.clone())
}

/// What a matcher says that it needs at least.
fn needed(preset: Preset, [left, right]: &[Image; 2], bounds: Option<BoundingBox>) -> usize {
    let mut matcher = Matcher::new(options(preset, 2, Some(1))).unwrap();
    match matcher.compute(left, right, bounds) {
        Err(MatchError::Memory { needed, .. }) => needed,
        other => panic!("{other:?}"),
    }
}

fn bits(map: &DisparityMap) -> Vec<(u32, u32)> {
    let pixels = map.values.samples().iter().zip(map.confidence.samples());
    pixels.map(|(value, sure)| (value.to_bits(), sure.to_bits())).collect()
}

// One test: what others allocate at the same time would be counted too.
#[test]
fn a_limit_is_kept_and_does_not_show_in_the_answer() {
    let colour = |plane: &Plane<u8>| Image::Rgb8(plane.map(|&v| [v, v / 2, 255 - v]));
    let deep = |plane: &Plane<u8>| Image::Grey16(plane.map(|&v| u16::from(v) * 201));
    let grey = |plane: &Plane<u8>| Image::Grey8(plane.clone());
    let wide = pair(400, 150);
    let cases = [
        (wide.each_ref().map(grey), None),
        (wide.each_ref().map(grey), Some(BoundingBox::new(90, 20, 240, 140).unwrap())),
        (wide.each_ref().map(colour), None),
        (wide.each_ref().map(deep), None),
        (pair(70, 1500).each_ref().map(grey), None),
        (pair(300, 1).each_ref().map(grey), None),
    ];
    for preset in Preset::ALL {
        // `best` takes its time.
        let cases = if preset == Preset::Best { &cases[..2] } else { &cases };
        for (images, bounds) in cases {
            let what = format!("{preset}, {:?}, {bounds:?}", images[0].size());
            let needed = needed(preset, images, *bounds);
            let (_, expected) = first_frame(options(preset, 2, None), images, *bounds);
            for limit in [needed, needed + needed / 4, 2 * needed] {
                let (peak, found) = first_frame(options(preset, 2, Some(limit)), images, *bounds);
                assert!(peak <= limit, "{what}: {peak} of {limit}, {needed} needed");
                assert!(bits(&found) == bits(&expected), "{what}: another answer with {limit}");
                if limit == needed && images[0].rows() > 1 {
                    assert!(needed <= peak + peak / 6, "{what}: {needed} needed, but {peak} taken");
                }
            }
        }
        // Of boxes that grow, wander and shrink each has what the last one needs, whatever came before.
        let images = wide.each_ref().map(grey);
        let boxes = [(0, 40), (0, 60), (0, 120), (20, 110), (90, 149), (60, 80)]
            .map(|(y0, y1)| BoundingBox::new(60, y0, 399, y1).unwrap());
        let limit = boxes.iter().map(|&bounds| needed(preset, &images, Some(bounds))).max();
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        let mut matcher = Matcher::new(options(preset, 2, limit)).unwrap();
        for bounds in boxes {
            matcher.compute(&images[0], &images[1], Some(bounds)).unwrap();
        }
        let peak = MEMORY.peak_usage() - before;
        assert!(
            peak <= limit.unwrap(),
            "{preset}: {peak} of {limit:?} for boxes one after the other"
        );
    }
}
