//! [`Matcher`]: built once from [`Options`], then fed frames.

use std::mem::{self, Discriminant};

use raster::{BoundingBox, DisparityMap, DisparityRange, Image, Reason};

use crate::allowance::{Admission, Allowance};
use crate::kernels::level::Level;
use crate::limits::Limits;
use crate::presets;
use crate::profile::{Profile, Stage};
use crate::refinement::groups::LARGEST;
use crate::threads;
use crate::{Holes, MOST_COLUMNS, MatchError, Options, VerticalDisparity};

/// One pair of images with everything that is asked of it, checked: equal sizes, at least one
/// pixel, a box inside the image.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame<'a> {
    pub left: &'a Image,
    pub right: &'a Image,
    pub bounds: BoundingBox,
    pub range: DisparityRange,
}

impl Frame<'_> {
    /// `(columns, rows)` of both images.
    pub fn size(&self) -> (usize, usize) {
        self.left.size()
    }
}

/// A preset's stages with their scratch memory. It runs inside the matcher's own thread pool, so
/// `rayon`'s parallel iterators use the threads that the options allow.
pub(crate) trait Pipeline: Send {
    /// The bytes that a frame takes at the least, of the stages and of `map`.
    fn least_memory(&self, frame: &Frame<'_>) -> usize;

    /// The vertical disparity that was taken out of the right image of the last frame.
    fn vertical_disparity(&self) -> Option<&VerticalDisparity> {
        None
    }

    /// Answers every pixel of `frame.bounds` in `map`, which arrives in the right size and is empty
    /// outside that box: inside it every value, reason and confidence is written, whatever stood there.
    /// Holes are filled, with reasons that say so. No more memory is taken than `allowance` says. `profile` is
    /// told when a stage has ended, and what it did.
    fn run(
        &mut self,
        frame: &Frame<'_>,
        allowance: Allowance,
        map: &mut DisparityMap,
        profile: &mut Profile,
    );
}

/// Takes filled values out again, of which nothing is then known, and says what each hole is.
pub(crate) fn open_holes(map: &mut DisparityMap, bounds: BoundingBox) {
    for y in bounds.y0..=bounds.y1 {
        let values = &mut map.values.row_mut(y)[bounds.x0..=bounds.x1];
        let reasons = &mut map.reasons.row_mut(y)[bounds.x0..=bounds.x1];
        let confidence = &mut map.confidence.row_mut(y)[bounds.x0..=bounds.x1];
        for ((value, reason), sure) in values.iter_mut().zip(reasons).zip(confidence) {
            *reason = match *reason {
                Reason::OccludedFilled => Reason::OccludedHole,
                Reason::MismatchedFilled => Reason::MismatchedHole,
                Reason::OutsideRightFilled => Reason::OutsideRightHole,
                other => other,
            };
            if !reason.has_value() {
                (*value, *sure) = (f32::NAN, 0.0);
            }
        }
    }
}

/// What memory is taken for: the size, the box, and how deep and of what colours both images are.
type Shape = ((usize, usize), BoundingBox, Discriminant<Image>);

/// Matches pairs of images. It keeps its memory between frames: equal sizes and boxes allocate nothing after
/// the first. Where memory is bounded ([`Options::memory`]), a frame of another shape begins with none.
pub struct Matcher {
    options: Options,
    level: Level,
    admission: Admission,
    pool: rayon::ThreadPool,
    pipeline: Box<dyn Pipeline>,
    map: DisparityMap,
    profile: Profile,
    /// Of the last frame that was answered.
    shape: Option<Shape>,
}

impl std::fmt::Debug for Matcher {
    /// What it was built from, and not its memory.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { options, level, .. } = self;
        f.debug_struct("Matcher")
            .field("options", options)
            .field("level", level)
            .finish_non_exhaustive()
    }
}

impl Matcher {
    /// Checks the options and prepares the stages. Where the environment variable `HAZCAM_CPU` is set, it
    /// names the vector instructions to use instead of the best ones ([`Level::name`]); the answer does
    /// not depend on them.
    ///
    /// # Errors
    ///
    /// [`MatchError::Option`] where an option has a value that is not allowed ([`Options::check`]), the
    /// system could not start the threads, or `HAZCAM_CPU` names no instructions that this processor has.
    pub fn new(options: Options) -> Result<Self, MatchError> {
        options.check()?;
        let pool = threads::start(options.threads).map_err(|e| MatchError::Option {
            field: "threads",
            value: options.threads.to_string(),
            allowed: format!("the system could not start them ({e}); ask for fewer, or raise what the process may take (ulimit)"),
        })?;
        let level = Level::chosen()?;
        let pipeline = presets::pipeline(&options, level);
        let admission = Admission::new(options.memory);
        let (map, profile) = (DisparityMap::default(), Profile::new());
        Ok(Self { options, level, admission, pool, pipeline, map, profile, shape: None })
    }

    /// The options it was built from.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The vector instructions that it uses.
    pub fn level(&self) -> Level {
        self.level
    }

    /// Where the time of the last frame that was answered went: its stages in the order in which they ran. Empty
    /// before the first one.
    pub fn profile(&self) -> &[Stage] {
        self.profile.stages()
    }

    /// The vertical disparity of the last pair that was answered, where it was found to be worth mending: things
    /// stood lower in the right image by so many pixels, which depend on the place, and `balanced` and `best`
    /// matched the image with that taken out. A pair that is rectified well has none; `fast` does not look for it.
    pub fn vertical_disparity(&self) -> Option<&VerticalDisparity> {
        self.pipeline.vertical_disparity()
    }

    /// The answer to the last pair that was answered, not refused; empty before the first one.
    pub fn map(&self) -> &DisparityMap {
        &self.map
    }

    /// Measures what this machine can do at the most, with the threads and instructions of this
    /// matcher, in a fraction of a second: how far the stages of the last frame stand from that.
    pub fn limits(&self) -> Limits {
        let largest = self.profile().iter().map(Stage::bytes_per_run).max().unwrap_or(0);
        let level = self.level;
        threads::run_in(&self.pool, || Limits::measure(level, largest))
    }

    /// The disparity of every pixel in `bounds` (the whole image without one), in pixels: `d` says that
    /// left `(x, y)` shows what right `(x - d, y)` shows, so it is the larger the nearer that is. Outside
    /// the box, and where holes are kept, it is NaN, and the reason says why. Colour images are matched as
    /// grey. What was filled in is a guess: depth is made of what is sure ([`DisparityMap::surer_than`]).
    ///
    /// Samples of 16 bits are to fill them. Those of cameras of 10 or 12 bits that are stored as they come are matched
    /// worse, in `fast` and `best` by far: give [`Image::widened_from`] of them. [`image_doubts`](crate::image_doubts)
    /// tells that and more of a pair, [`doubts`](crate::doubts) of an answer. Frames that come in a buffer with gaps
    /// between the rows go to an image that is kept ([`Plane::copy_from`](raster::Plane::copy_from)), answers to another
    /// thread by [`Clone::clone_from`] to a map that is kept: neither takes memory once it is large enough.
    ///
    /// Nothing is allocated for a frame of the size, the kind and the box of the one before; a box that moves takes a few
    /// allocations with each frame, and begins anew where [`Options::memory`] is set.
    ///
    /// A box is not cut out of the answer to the whole image: near its edges, and where fills and speckles reach
    /// beyond them, the two differ. It is answered from what it shows, in `fast` from twice as many columns as there
    /// are disparities if it has fewer, in `balanced` and `best` from 32 pixels around it too. These two measure the
    /// whole pair besides: vertical disparity, noise, how strong texture is.
    ///
    /// The matcher's own threads do the work while the calling one waits. For frames from several threads give
    /// each a matcher (it is `Send`), or put one behind a lock; that may be a thread of rayon, too.
    ///
    /// # Errors
    ///
    /// * [`MatchError::SizesDiffer`], [`MatchError::KindsDiffer`] and [`MatchError::NoPixels`] for images that are
    ///   no pair;
    /// * [`MatchError::RangeOutside`] and [`MatchError::Bounds`] for a range all of which lies beyond them, and for a
    ///   box that leaves them;
    /// * [`MatchError::TooLarge`] and [`MatchError::TooWide`] for more pixels than can be counted, and for more
    ///   columns than can be told apart;
    /// * [`MatchError::Memory`] and [`MatchError::MachineMemory`] for a frame that does not fit what is
    ///   allowed ([`Options::memory`]) or there.
    pub fn compute(
        &mut self,
        left: &Image,
        right: &Image,
        bounds: Option<BoundingBox>,
    ) -> Result<&DisparityMap, MatchError> {
        let ((columns, rows), (right_columns, right_rows)) = (left.size(), right.size());
        if (columns, rows) != (right_columns, right_rows) {
            let (left_columns, left_rows) = (columns, rows);
            return Err(MatchError::SizesDiffer {
                left_columns,
                left_rows,
                right_columns,
                right_rows,
            });
        }
        if columns == 0 || rows == 0 {
            return Err(MatchError::NoPixels);
        }
        if mem::discriminant(left) != mem::discriminant(right) {
            return Err(MatchError::KindsDiffer { left: left.kind(), right: right.kind() });
        }
        let (min, max) = (self.options.range.min(), self.options.range.max());
        if !self.options.range.meets(columns) {
            return Err(MatchError::RangeOutside { min, max, columns });
        }
        let bounds = bounds.unwrap_or(BoundingBox::whole(columns, rows));
        bounds.check_within(columns, rows)?;
        if columns * rows > LARGEST {
            return Err(MatchError::TooLarge { columns, rows, limit: LARGEST });
        }
        if columns > MOST_COLUMNS {
            return Err(MatchError::TooWide { columns, limit: MOST_COLUMNS });
        }
        let frame = Frame { left, right, bounds, range: self.options.range };
        let shape = Some((frame.size(), bounds, mem::discriminant(left)));
        let Self { options, level, admission, pipeline, map, profile, pool, shape: last } = self;
        threads::run_in(pool, || -> Result<(), MatchError> {
            let allowance = admission.of(&frame, pipeline.least_memory(&frame))?;
            // What a frame takes is reckoned for itself: what others have taken must be given back.
            if options.memory.is_some() && *last != shape {
                *map = DisparityMap::default();
                *pipeline = presets::pipeline(options, *level);
            }
            *last = shape;
            profile.begin();
            map.reshape(columns, rows, bounds);
            pipeline.run(&frame, allowance, map, profile);
            Ok(())
        })?;
        if self.options.holes == Holes::Keep {
            open_holes(map, bounds);
        }
        Ok(&self.map)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::Preset;
    use raster::Plane;

    /// The profile of a preset on two images that lie 20 pixels apart.
    fn profile(preset: Preset, memory: Option<usize>) -> Vec<Stage> {
        let scramble = |x: usize, y: usize| (x * 7919 + y * 104_729 + x * x * y * 31) as u8;
        let images = [0, 20]
            .map(|shift| Image::Grey8(Plane::from_fn(90, 100, |x, y| scramble(x + shift, y))));
        let mut options = Options::new(preset, DisparityRange::new(0, 31).unwrap());
        (options.threads, options.memory) = (1, memory);
        let mut matcher = Matcher::new(options).unwrap();
        matcher.compute(&images[0], &images[1], None).unwrap();
        matcher.profile().to_vec()
    }

    /// The bits of a map, so that what has no value is equal to itself.
    pub(crate) fn bits(map: &DisparityMap) -> Vec<(u32, Reason, u32)> {
        let rest = map.reasons.samples().iter().zip(map.confidence.samples());
        let all = map.values.samples().iter().zip(rest);
        all.map(|(value, (reason, sure))| (value.to_bits(), *reason, sure.to_bits())).collect()
    }

    #[test]
    fn a_frame_is_answered_alike_whatever_came_before() {
        // Cards before a wall: holes and edges.
        let frame = |columns: usize, rows: usize| {
            [0, 1].map(|view| {
                Image::Grey8(Plane::from_fn(columns, rows, |x, y| {
                    let near = |x: usize| (x / 11 + y / 13).is_multiple_of(3);
                    let x = x + view * if near(x) { 9 } else { 2 };
                    (x * 7919 + y * 104_729 + x * x * y * 31) as u8
                }))
            })
        };
        // Of twelve columns two have something to search from disparity 10 on.
        for (preset, least) in
            Preset::ALL.into_iter().flat_map(|preset| [(preset, 0), (preset, 10)])
        {
            let range = DisparityRange::new(least, least + 15).unwrap();
            let mut options = Options::new(preset, range);
            options.threads = 1;
            let matcher = || Matcher::new(options.clone()).unwrap();
            let mut kept = matcher();
            let part = |x0, y0, x1, y1| BoundingBox::new(x0, y0, x1, y1).ok();
            for (columns, rows, bounds) in [
                (150, 40, None),
                (150, 40, part(60, 3, 140, 30)),
                (40, 60, None),
                (12, 5, None),
                (90, 300, None),
                (90, 300, part(0, 20, 50, 299)),
                (90, 300, part(70, 0, 89, 250)),
            ] {
                let [left, right] = frame(columns, rows);
                let map = kept.compute(&left, &right, bounds).unwrap();
                let mut fresh = matcher();
                let expected = fresh.compute(&left, &right, bounds).unwrap();
                assert!(
                    bits(map) == bits(expected),
                    "{preset} from {least}, {columns} x {rows}, {bounds:?}"
                );
            }
        }
    }

    #[test]
    fn what_lies_outside_the_right_image_and_nothing_else_is_marked_so() {
        // A slanted floor, of which the left strip goes on and the right one begins.
        let images = [0, 1].map(|view| {
            Image::Grey8(Plane::from_fn(150, 60, |x, y| {
                let x = x + view * (4 + y / 5);
                (x * 7919 + y * 104_729 + x * x * y * 31) as u8
            }))
        });
        for (preset, mirror) in Preset::ALL.into_iter().flat_map(|p| [(p, false), (p, true)]) {
            let (least, most) = if mirror { (-20, 0) } else { (0, 20) };
            let range = DisparityRange::new(least, most).unwrap();
            let mut matcher = Matcher::new(Options::new(preset, range)).unwrap();
            let [left, right] = if mirror { [&images[1], &images[0]] } else { images.each_ref() };
            let map = matcher.compute(left, right, None).unwrap();
            let mut outside = 0;
            for (at, (&d, &reason)) in
                map.values.samples().iter().zip(map.reasons.samples()).enumerate()
            {
                let right = (at % 150) as f32 - d;
                let is_outside = !(-0.5..=149.5).contains(&right);
                assert_eq!(reason == Reason::OutsideRightFilled, is_outside, "{preset} {at}: {d}");
                outside += usize::from(is_outside);
            }
            assert!(outside > 200, "{preset}: {outside}");
        }
    }

    #[test]
    fn wider_images_than_places_can_be_told_in_are_refused() {
        let image = Image::Grey8(Plane::filled(MOST_COLUMNS + 1, 1, 0));
        let range = DisparityRange::new(0, 3).unwrap();
        let mut matcher = Matcher::new(Options::new(Preset::Fast, range)).unwrap();
        assert_eq!(
            matcher.compute(&image, &image, None).unwrap_err().to_string(),
            "the images are 4194305 columns wide, but at most 4194304 can be matched: cut them into \
             tiles"
        );
    }

    #[test]
    fn every_stage_of_every_preset_says_what_it_moves() {
        for preset in Preset::ALL {
            let stages = profile(preset, None);
            assert!(stages.len() >= 4, "{preset}: {stages:?}");
            for stage in stages {
                assert!(stage.bytes > 0 && stage.runs > 0, "{preset}: {stage:?}");
            }
        }
    }

    #[test]
    fn bands_of_sums_are_more_operations_and_no_more_matching() {
        let operations = |memory| {
            let stages = profile(Preset::Balanced, memory);
            ["eight paths", "census"].map(|name| {
                let stage = stages.iter().find(|stage| stage.name.contains(name));
                stage.expect("balanced has it").operations
            })
        };
        let ([whole, features], [bands, same]) = (operations(None), operations(Some(630_000)));
        assert!(whole < bands && bands < 2 * whole, "{whole}, {bands}");
        assert_eq!(features, same);
    }

    #[test]
    fn a_range_all_of_which_lies_outside_the_images_is_refused() {
        let image = Image::Grey8(Plane::filled(45, 2, 9));
        let answer = |min, max| {
            let range = DisparityRange::new(min, max).unwrap();
            let mut matcher = Matcher::new(Options::new(Preset::Fast, range)).unwrap();
            matcher.compute(&image, &image, None).map(|_| ())
        };
        for (min, max) in [(0, 6), (44, 52), (-52, -44), (-9, 90)] {
            assert_eq!(answer(min, max), Ok(()));
        }
        for (min, max) in [(45, 52), (-52, -45)] {
            let error = answer(min, max).unwrap_err().to_string();
            assert!(error.contains("45 columns") && error.contains("-44 to 44"), "{error}");
        }
    }

    #[test]
    fn images_of_two_kinds_are_no_pair() {
        let images = [
            Image::Grey8(Plane::filled(4, 2, 9)),
            Image::Grey16(Plane::filled(4, 2, 9)),
            Image::Rgb8(Plane::filled(4, 2, [9; 3])),
        ];
        let range = DisparityRange::new(0, 2).unwrap();
        let mut matcher = Matcher::new(Options::new(Preset::Fast, range)).unwrap();
        for (i, left) in images.iter().enumerate() {
            for (j, right) in images.iter().enumerate() {
                let answer = matcher.compute(left, right, None).map(|_| ());
                let differ = MatchError::KindsDiffer { left: left.kind(), right: right.kind() };
                assert_eq!(answer, if i == j { Ok(()) } else { Err(differ) });
            }
        }
    }

    #[test]
    fn what_cannot_fit_is_refused_with_the_size_that_would() {
        let images = [0, 1].map(|_| Image::Grey8(Plane::filled(3000, 2000, 0)));
        let mut options = Options::new(Preset::Balanced, DisparityRange::new(0, 255).unwrap());
        options.memory = Some(200_000_000);
        let mut matcher = Matcher::new(options).unwrap();
        let error = matcher.compute(&images[0], &images[1], None).unwrap_err();
        let MatchError::Memory { needed, .. } = error else { panic!("{error}") };
        assert_eq!(
            error.to_string(),
            format!(
                "`memory` is 200 MB, but 3000 x 2000 pixels and 256 disparities need at least \
                 {} MB: allow that much, narrow the range, or match a box",
                needed.div_ceil(1_000_000)
            )
        );
    }
}
