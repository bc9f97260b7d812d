//! Vertical disparity that rectification left, found and taken out of the right image.
//!
//! Rectified, a point stands in one row of both images, and all matching relies on it. Real pairs come
//! close: a camera that is turned by a thousandth of a radian, as a calibration of some weeks ago may
//! have it, moves things by up to half a pixel or more, in one corner otherwise than in the next, and one pixel
//! is enough to spoil small windows. It is seen without knowing any depth, since it changes smoothly over the image:
//!
//! 1. Corners (Shi & Tomasi 1994) spread over the left image are matched in the right one, some rows
//!    up and down too, to a fraction of a pixel ([`correspondence`]).
//! 2. A smooth model is fitted to how far they stand above or below their row ([`model`]). Where none
//!    holds they are looked for once more, in many rows.
//! 3. Where that comes to something, every pixel of the right image is taken from there ([`resample`]).
//!
//! What the windows of a corner do not share once it is found is the noise of both images.
//!
//! What is found depends on both whole images and the range, not on the box. Corners are sought in the
//! upper 8 bits: where images of 16 bits use few of them there are none. Rows that a mended image would
//! need from beyond its ends repeat its last ones.

mod correlation;
mod correspondence;
mod model;
mod resample;

use raster::{DisparityRange, Plane, View};
use rayon::prelude::*;

use self::correlation::Scores;
use self::correspondence::{Correspondence, MARGIN, Reach, correspond};
pub use self::model::VerticalDisparity;
use self::resample::{resample_8_bit, resample_16_bit};
use crate::kernels::level::Level;
use crate::prepare::grey::{GreyView, upper_bits};
use crate::prepare::take;
use crate::profile::Work;

/// About so many corners are looked for.
const CORNERS: usize = 300;
/// Smaller vertical disparities (root of the mean square over the image, in pixels) are left alone:
/// taking them out blurs more than it mends.
const LEAST: f64 = 0.1;
/// Noise is what one in so many of the corners is below.
const MOST_ALIKE: usize = 10;

/// The memory of the alignment, kept between frames.
#[derive(Debug, Default)]
pub(crate) struct Alignment {
    /// What was found in each cell of the left image.
    found: Vec<Option<Correspondence>>,
    /// Scratch memory: of the model's fit, then the noise of each corner.
    residuals: Vec<f64>,
    /// One for each thread.
    scores: Vec<Scores>,
    depth8: Plane<u8>,
    depth16: Plane<u16>,
    upper: Plane<u8>,
}

/// The right image as it should be, its upper 8 bits, what was taken out of it, and the noise of the pair: the
/// standard deviation, in grey levels, of what corners do not look alike by. Without any nobody knows.
pub(crate) struct Aligned<'a> {
    pub grey: GreyView<'a>,
    pub upper: View<'a, u8>,
    pub vertical: Option<VerticalDisparity>,
    pub noise: Option<f32>,
    pub done: Work,
}

impl Alignment {
    /// What it takes beside the images' own memory: an image of so many pixels in its depth, with its
    /// upper bits where it has 16.
    pub fn bytes(columns: usize, rows: usize, range: DisparityRange, deep: bool) -> usize {
        let (across, down) = cells(columns, rows);
        let corners = across * down * (size_of::<Option<Correspondence>>() + size_of::<f64>());
        let image = if deep { 3 } else { 1 } * columns * rows;
        image + corners + rayon::current_num_threads() * Scores::bytes(columns, range)
    }

    /// Aligns the right image with the left one. `left` and `upper` are the upper 8 bits, `grey` the
    /// right image in its depth.
    pub fn align<'a>(
        &'a mut self,
        level: Level,
        left: View<'_, u8>,
        grey: GreyView<'a>,
        upper: View<'a, u8>,
        range: DisparityRange,
    ) -> Aligned<'a> {
        let (columns, rows) = (left.columns(), left.rows());
        self.reserve(grey, range);
        let (vertical, looked) = self.measure(level, [left, upper], range);
        let noise = self.noise();
        let vertical = vertical.filter(|vertical| vertical.root_mean_square() >= LEAST);
        let Self { depth8, depth16, upper: upper_plane, .. } = self;
        let Some(vertical) = vertical else {
            return Aligned { grey, upper, vertical: None, noise, done: looked };
        };
        let done = looked
            + (Work::bytes(2 * grey.bytes(1)) + Work::operations(resample::OPERATIONS * columns))
                * rows;
        let (grey, upper) = match grey {
            GreyView::Depth8(view) => {
                let out = depth8.samples_mut().par_chunks_mut(columns).enumerate();
                out.for_each(|(y, out)| resample_8_bit(level, view, &vertical, y, out));
                (GreyView::Depth8(depth8.view()), depth8.view())
            }
            GreyView::Depth16(view) => {
                let out = depth16.samples_mut().par_chunks_mut(columns);
                let out = out.zip(upper_plane.samples_mut().par_chunks_mut(columns)).enumerate();
                out.for_each(|(y, (out, upper))| {
                    resample_16_bit(level, view, &vertical, y, out);
                    upper_bits(out, upper);
                });
                (GreyView::Depth16(depth16.view()), upper_plane.view())
            }
        };
        Aligned { grey, upper, vertical: Some(vertical), noise, done }
    }

    /// Takes all the memory that images of this size and depth may need: that it is first needed some
    /// frames later must not show.
    fn reserve(&mut self, grey: GreyView<'_>, range: DisparityRange) {
        let (columns, rows) = grey.size();
        let (across, down) = cells(columns, rows);
        let Self { found, residuals, scores, depth8, depth16, upper } = self;
        found.clear();
        found.resize(across * down, None);
        residuals.clear();
        residuals.reserve_exact(across * down);
        scores.resize_with(rayon::current_num_threads(), Scores::default);
        scores.iter_mut().for_each(|scores| scores.reserve(columns, range));
        match grey {
            GreyView::Depth8(_) => take(depth8, (columns, rows)),
            GreyView::Depth16(_) => {
                take(depth16, (columns, rows));
                take(upper, (columns, rows));
            }
        }
    }

    /// The noise of the corners that were found: of those that look most alike, since in other windows there is
    /// more than one depth.
    fn noise(&mut self) -> Option<f32> {
        let Self { found, residuals: noises, .. } = self;
        noises.clear();
        noises.extend(found.iter().flatten().map(|corner| f64::from(corner.noise)));
        let place = noises.len() / MOST_ALIKE;
        (!noises.is_empty()).then(|| *noises.select_nth_unstable_by(place, f64::total_cmp).1 as f32)
    }

    /// The vertical disparity that corners of the left image show.
    fn measure(
        &mut self,
        level: Level,
        images: [View<'_, u8>; 2],
        range: DisparityRange,
    ) -> (Option<VerticalDisparity>, Work) {
        let (near, work) = self.measure_within(level, images, (range, Reach::Near));
        if near.is_some() {
            return (near, work);
        }
        let (far, work_far) = self.measure_within(level, images, (range, Reach::Far));
        (far, work + work_far)
    }

    fn measure_within(
        &mut self,
        level: Level,
        images: [View<'_, u8>; 2],
        searched: (DisparityRange, Reach),
    ) -> (Option<VerticalDisparity>, Work) {
        let Self { found, residuals, scores, .. } = self;
        let (columns, rows) = (images[0].columns(), images[0].rows());
        if found.is_empty() {
            return (None, Work::default());
        }
        let (across, down) = cells(columns, rows);
        let inside = (columns - 2 * MARGIN, rows - 2 * MARGIN);
        // Windows begin anywhere: half of the vectors of 32 bytes lie in one cache line, of those of 64 hardly any.
        let level = level.of_32_bytes();
        let part = found.len().div_ceil(scores.len());
        let parts = found.par_chunks_mut(part).zip(scores).enumerate();
        parts.for_each(|(i, (found, scores))| {
            for (cell, found) in (i * part..).zip(found) {
                let ends = |at: usize, of: usize, size: usize| {
                    MARGIN + at * size / of..MARGIN + (at + 1) * size / of
                };
                let x = ends(cell % across, across, inside.0);
                let y = ends(cell / across, down, inside.1);
                *found = correspond(level, images, (x, y), searched, scores);
            }
        });
        let followed = found.iter().flatten();
        let (range, reach) = searched;
        let work = correspondence::looked() * found.len()
            + correspondence::work(columns, range, reach) * followed.clone().count();
        (VerticalDisparity::fit(followed, (columns, rows), residuals), work)
    }
}

/// Columns and rows of cells, each of which has one corner at the most.
fn cells(columns: usize, rows: usize) -> (usize, usize) {
    let [columns, rows] = [columns, rows].map(|size| size.saturating_sub(2 * MARGIN));
    // Where they would be narrower than a window, or higher than the image, there are fewer.
    let least = [MARGIN, columns / CORNERS, rows / CORNERS].into_iter().max().unwrap_or(0);
    let side = ((columns * rows) as f64 / CORNERS as f64).sqrt().max(least as f64);
    let [across, down] = [columns, rows].map(|size| (size as f64 / side).ceil() as usize);
    (across, down)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    /// A texture that can be looked at between pixels.
    fn texture() -> impl Fn(f64, f64) -> f64 {
        let mut chance = Chance(7);
        let waves: Vec<[f64; 4]> = (0..40)
            .map(|_| [0.8, 0.8, 6.3, 12.0].map(|most| f64::from(chance.share()) * most))
            .collect();
        move |x, y| {
            let wave = |[along, down, phase, size]: &[f64; 4]| {
                size * ((along - 0.4) * x + (down - 0.4) * y + phase).sin()
            };
            128.0 + waves.iter().map(wave).sum::<f64>() / 2.0
        }
    }

    /// The right image stands lower by `dy` and to the left by 9.
    fn pair(dy: impl Fn(f64, f64) -> f64) -> [Plane<u8>; 2] {
        let texture = texture();
        let seen = |shift: f64, dy: &dyn Fn(f64, f64) -> f64| {
            Plane::from_fn(200, 160, |x, y| {
                let (x, y) = (x as f64, y as f64);
                texture(x + shift, y - dy(x, y)).round().clamp(0.0, 255.0) as u8
            })
        };
        [seen(0.0, &|_, _| 0.0), seen(9.0, &dy)]
    }

    fn aligned(level: Level, pair: &[Plane<u8>; 2]) -> (Plane<u8>, Option<VerticalDisparity>) {
        let mut alignment = Alignment::default();
        let [left, right] = pair.each_ref().map(Plane::view);
        let range = DisparityRange::new(-30, 30).unwrap();
        let aligned = alignment.align(level, left, GreyView::Depth8(right), right, range);
        (aligned.upper.to_plane(), aligned.vertical)
    }

    fn mean_difference(a: &Plane<u8>, b: &Plane<u8>) -> f64 {
        let differences =
            a.samples().iter().zip(b.samples()).map(|(a, b)| f64::from(a.abs_diff(*b)));
        differences.sum::<f64>() / a.samples().len() as f64
    }

    #[test]
    fn noise_is_what_two_images_do_not_share() {
        let range = DisparityRange::new(-30, 30).unwrap();
        let found = |[left, right]: &[Plane<u8>; 2]| {
            let (left, right) = (left.view(), right.view());
            let mut alignment = Alignment::default();
            alignment.align(Level::detect(), left, GreyView::Depth8(right), right, range).noise
        };
        let mut chance = Chance(6);
        for deviation in [1.5, 5.0, 12.0] {
            let noisy = pair(|_, _| 0.0).map(|image| {
                image.map(|&sample| {
                    let normal = (0..12).map(|_| chance.share()).sum::<f32>() - 6.0;
                    (f32::from(sample) + deviation * normal).round().clamp(0.0, 255.0) as u8
                })
            });
            let found = found(&noisy).expect("there are corners");
            // Rather less, since what is found to look alike does so by chance too.
            assert!((0.75..1.1).contains(&(found / deviation)), "{deviation}: {found}");
        }
        // Gravel, as fine as noise.
        let gravel = Plane::from_fn(209, 160, |_, _| chance.bits(7) as u8);
        let [left, right] = [0, 9].map(|x| Plane::from_fn(200, 160, |u, v| gravel.row(v)[u + x]));
        let alone = crate::prepare::noise::noise(left.view());
        let of_pair = found(&[left, right]).expect("there are corners");
        assert!(alone > 20.0 && of_pair < 1.0, "{alone}, {of_pair}");
        let flat = || Plane::filled(200, 160, 90);
        assert_eq!(found(&[flat(), flat()]), None);
    }

    #[test]
    fn a_turned_camera_is_turned_back_at_every_level_alike() {
        let pairs =
            [pair(|_, _| 1.4), pair(|x, y| 0.3 + x / 200.0 + (x - 100.0) * (y - 80.0) / 9e3)];
        for turned in pairs {
            let straight = pair(|_, _| 0.0)[1].clone();
            let expected = aligned(Level::available()[0], &turned);
            let before = mean_difference(&turned[1], &straight);
            let after = mean_difference(&expected.0, &straight);
            assert!(before > 2.0 && after < 0.1 * before, "{before} {after} {:?}", expected.1);
            for level in Level::available() {
                eprintln!("level {}", level.name());
                assert!(aligned(level, &turned) == expected);
            }
        }
    }

    #[test]
    fn rows_that_are_off_by_many_are_found_and_no_others() {
        let found = |dy: &dyn Fn(f64, f64) -> f64| aligned(Level::detect(), &pair(dy)).1;
        for down in [-24.0, -11.0, -7.5, 5.0, 17.3, 24.0] {
            let vertical = found(&|_, _| down).expect("they are within reach");
            assert!((vertical.at(100.0, 80.0) - down).abs() < 0.1, "{down}: {vertical:?}");
        }
        let rolled = found(&|x, _| 0.1 * (x - 100.0)).expect("they are within reach");
        for x in [0.0, 60.0, 199.0] {
            let off = rolled.at(x, 80.0) - 0.1 * (x - 100.0);
            assert!(off.abs() < 0.4, "column {x}: {off}");
        }
        assert_eq!(found(&|_, _| 30.0), None);
    }

    #[test]
    fn what_is_rectified_or_cannot_be_told_is_left_alone() {
        let straight = pair(|_, _| 0.03);
        assert_eq!(aligned(Level::detect(), &straight), (straight[1].clone(), None));
        let noise = [1, 2].map(|seed| {
            let mut chance = Chance(seed);
            Plane::from_fn(200, 160, |_, _| chance.bits(8) as u8)
        });
        assert_eq!(aligned(Level::detect(), &noise), (noise[1].clone(), None));
        for (columns, rows) in [(1, 1), (24, 90), (25, 25), (300, 3)] {
            let flat = [0, 1].map(|_| Plane::filled(columns, rows, 90));
            assert_eq!(aligned(Level::detect(), &flat), (flat[1].clone(), None));
        }
    }

    #[test]
    fn corners_anywhere_in_images_of_any_size_are_followed_to_their_ends() {
        let mut chance = Chance(5);
        let sizes = (1..40).flat_map(|size| [(size, 70), (70, size), (size, size), (2000, size)]);
        for (columns, rows) in sizes.chain([(140, 130), (130, 170)]) {
            let noise = Plane::from_fn(columns + 9, rows + 9, |_, _| chance.bits(8) as u8);
            for (along, down) in [(0, 0), (0, 2), (3, 4), (9, 9)] {
                let part = |x: usize, y: usize| {
                    Plane::from_fn(columns, rows, |u, v| noise.row(y + v)[x + u])
                };
                for pair in [[part(0, 0), part(along, down)], [part(along, down), part(0, 0)]] {
                    let (image, vertical) = aligned(Level::detect(), &pair);
                    assert_eq!(image.size(), (columns, rows));
                    // A few corners tell nothing, many tell how many rows.
                    let found = vertical.map_or(0.0, |vertical| vertical.largest());
                    let is_right = (found - down as f64).abs() < 0.1;
                    let enough = columns.min(rows) > 120;
                    assert!(
                        is_right || (!enough && found == 0.0),
                        "{columns} x {rows}, {down}: {found}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_number_of_threads_changes_nothing() {
        let turned = pair(|x, _| x / 100.0);
        let alone = aligned(Level::detect(), &turned);
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert!(pool.install(|| aligned(Level::detect(), &turned)) == alone, "{threads}");
        }
    }

    #[test]
    fn sixteen_bits_are_aligned_with_all_of_them() {
        let turned = pair(|_, _| 1.4);
        let [left, right] =
            turned.each_ref().map(|plane| plane.map(|&grey| u16::from(grey) << 8 | 0x5b));
        let mut alignment = Alignment::default();
        let range = DisparityRange::new(0, 30).unwrap();
        let [left_upper, right_upper] =
            [&left, &right].map(|plane| plane.map(|&grey| (grey >> 8) as u8));
        let grey = GreyView::Depth16(right.view());
        let upper = right_upper.view();
        let level = Level::detect();
        let deep = alignment.align(level, left_upper.view(), grey, upper, range);
        let (expected, _) = aligned(level, &turned);
        let GreyView::Depth16(grey) = deep.grey else { panic!("another depth") };
        assert!(mean_difference(&deep.upper.to_plane(), &expected) < 0.6);
        assert_eq!(deep.upper.to_plane(), grey.to_plane().map(|&grey| (grey >> 8) as u8));
        let low = |x: usize| grey.row(80)[x] & 0xff;
        assert!((1..200).any(|x| low(x) != low(0)), "the lower bits are interpolated too");
    }

    #[test]
    fn images_without_room_for_a_corner_have_no_cells() {
        for (narrow, long) in (0..=2 * MARGIN).flat_map(|n| [(n, 1), (n, 500), (n, 100_000)]) {
            for (columns, rows) in [(narrow, long), (long, narrow)] {
                let (across, down) = cells(columns, rows);
                assert_eq!(across * down, 0, "{columns} x {rows}");
            }
        }
        let (across, down) = cells(2 * MARGIN + 1, 2 * MARGIN + 1);
        assert_eq!(across * down, 1);
    }
}
