//! Every pixel chooses among the planes around it, and a learned judge says which.
//!
//! What is left wrong after matching and filling is mostly within reach of what is right: a surface
//! that grew beyond its edge, a hole that was filled from the wrong side, a patch matched far off. To
//! choose, many small hints count: which candidate the pixel looks like, how it fits the other image,
//! what the other view says there, how many around agree. How much each of them counts is learned
//! (`training/choice.py`), as SGM-Forest learns which path to believe (Schoenberger et al., ECCV
//! 2018), but of candidates in space; scores do not know a candidate's disparity, only how it stands
//! to others, so the range does not matter.
//!
//! A round looks at the map as it was before: rows can be done in any order, by any number of
//! threads.

mod candidates;
mod edges;
mod judge;
mod lesson;
mod rounds;

use std::sync::LazyLock;

use raster::Plane;
use rayon::prelude::*;

pub(crate) use self::candidates::Given;
use self::candidates::Scene;
pub use self::candidates::{CANDIDATES, Known, OF_EACH, OF_PIXEL};
use self::judge::Judge;
pub(crate) use self::lesson::Lesson;
pub use self::lesson::Pixel;
pub(crate) use self::rounds::Choices;
use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;

/// The weights of the judges, one after the other: 32-bit floats in the order of [`Judge::new`].
/// `training/choice.py` makes them.
const TRAINED: &[u8] = include_bytes!("weights.bin");

static JUDGES: LazyLock<Vec<Judge>> = LazyLock::new(|| {
    let judges = TRAINED.as_chunks().0.chunks_exact(Judge::NUMBERS);
    judges.map(|numbers| Judge::new(numbers.iter().copied().map(f32::from_le_bytes))).collect()
});

/// The judges, one for each round of choices, with or without the last one.
fn judges(with_last: bool) -> &'static [Judge] {
    let without = JUDGES.len().saturating_sub(1);
    if with_last { &JUDGES } else { &JUDGES[..without] }
}

/// Lets every pixel of `scene` choose, into `out`; `certainty` says how sure the judge is, 1 where there
/// is nothing to choose.
fn choose(
    level: Level,
    judge: &Judge,
    scene: &Scene<'_>,
    certainty: &mut Plane<f32>,
    out: &mut Plane<f32>,
) -> Work {
    let (columns, rows) = scene.values.size();
    out.reset(columns, rows, 0.0);
    certainty.reset(columns, rows, 1.0);
    let certainty = certainty.samples_mut().par_chunks_mut(columns);
    let rows = out.samples_mut().par_chunks_mut(columns).zip(certainty).enumerate();
    let chosen = rows.map(|(y, (out, certainty))| {
        let mut known = Known::default();
        choose_row(level, judge, scene, y, &mut known, out, certainty)
    });
    // Values, slopes, confidence and the right view are read, the choice and its certainty written;
    // reasons, doubts and the looks of both views are bytes.
    Work::bytes((4 * (5 + 2) + 2 + 2 * 3) * scene.values.samples().len())
        + Work::operations(Judge::OPERATIONS) * chosen.sum::<usize>()
}

at_every_level! {
    /// Lets the pixels of row `y` choose; how many had a choice.
    fn choose_row(
        judge: &Judge,
        scene: &Scene<'_>,
        y: usize,
        known: &mut Known,
        out: &mut [f32],
        certainty: &mut [f32],
    ) -> usize {
        let mut chosen = 0;
        out.copy_from_slice(scene.values.row(y));
        for x in 0..out.len() {
            if scene.know(x, y, known) {
                let verdict = judge.decide(known);
                (out[x], certainty[x]) = (verdict.disparity, verdict.certainty);
                chosen += 1;
            }
        }
        chosen
    }
}

#[cfg(test)]
mod tests {
    use raster::Reason;

    use super::edges::Edges;
    use super::*;
    use crate::chance::Chance;
    use crate::cost::looks::Looks;
    use crate::refinement::slopes::Slopes;

    const COLUMNS: usize = 90;
    const ROWS: usize = 40;
    const FIRST: usize = 10;
    const WIDTH: usize = 104;

    /// All that a scene borrows: a board at 12 before a wall at 4, both of noise. Some columns of the
    /// image are not mapped.
    struct World {
        values: Plane<f32>,
        slopes: Slopes,
        reasons: Plane<Reason>,
        doubtful: Plane<bool>,
        confidence: Plane<f32>,
        looks: [Looks; 2],
        right: Plane<f32>,
        edges: Edges,
    }

    fn truth(x: usize) -> f32 {
        if (40..64).contains(&x) { 12.0 } else { 4.0 }
    }

    impl World {
        fn new(values: Plane<f32>) -> Self {
            Self::textured(values, 200.0)
        }

        /// With noise of so many grey levels.
        fn textured(values: Plane<f32>, texture: f32) -> Self {
            let level = Level::available()[0];
            let mut chance = Chance(3);
            let grey = Plane::from_fn(WIDTH + 20, ROWS, |_, _| (texture * chance.share()) as u8);
            let shade = |x: usize, y: usize, d: f32| grey.row(y)[x].saturating_add(4 * d as u8);
            let left = Plane::from_fn(WIDTH, ROWS, |x, y| shade(x, y, truth(x)));
            let right = Plane::from_fn(WIDTH, ROWS, |x, y| {
                let d = if (40..64).contains(&(x + 12)) { 12.0 } else { 4.0 };
                shade(x + d as usize, y, d)
            });
            let looks = [left, right].map(|image| {
                let mut looks = Looks::default();
                looks.compute(level, &image, 0, ROWS);
                looks
            });
            let mut slopes = Slopes::default();
            slopes.compute(level, &values);
            let mut edges = Edges::default();
            edges.compute(&looks[0], FIRST, COLUMNS);
            Self {
                edges,
                slopes,
                reasons: values.map(|_| Reason::Matched),
                doubtful: values.map(|_| false),
                confidence: values.map(|_| 0.5),
                looks,
                right: Plane::from_fn(WIDTH, ROWS, |m, _| {
                    let x = WIDTH - 1 - m;
                    if (40..64).contains(&(x + 12)) { 12.0 } else { 4.0 }
                }),
                values,
            }
        }

        fn given(&self) -> Given<'_> {
            Given {
                doubtful: &self.doubtful,
                base: &self.looks[0],
                other: &self.looks[1],
                right: &self.right,
                first: FIRST,
                least: 0.0,
                most: 20.0,
            }
        }

        fn scene<'a>(&'a self, given: &'a Given<'a>) -> Scene<'a> {
            Scene {
                values: &self.values,
                slopes: &self.slopes,
                reasons: &self.reasons,
                confidence: &self.confidence,
                edges: &self.edges,
                given,
            }
        }
    }

    #[test]
    fn what_is_known_of_a_pixel_beside_an_edge() {
        // The board has grown by four columns: pixel 66 of the image is the wall's.
        let mut world = World::new(Plane::from_fn(COLUMNS, ROWS, |x, _| {
            if (40..68).contains(&(x + FIRST)) { 12.0 } else { 4.0 }
        }));
        let (x, y) = (66 - FIRST, 20);
        world.reasons.row_mut(y)[x] = Reason::MismatchedFilled;
        world.doubtful.row_mut(y)[x] = true;
        let mut known = Known::default();
        assert!(world.scene(&world.given()).know(x, y, &mut known));
        let at = |d: f32| known.disparities.iter().position(|&other| other == d).unwrap();
        let (own, wall) = (at(12.0), at(4.0));
        assert_eq!(own, 0);
        // The wall lies 8 below: (sqrt(9) - 1) with its sign.
        assert_eq!([0, 1].map(|i| known.of_each[i][wall]), [-2.0, 2.0]);
        assert_eq!([2, 3, 4].map(|i| known.of_each[i][own]), [0.5, 1.0, 1.0]);
        assert_eq!([2, 3, 4].map(|i| known.of_each[i][wall]), [0.5, 0.0, 0.0]);
        assert!(known.of_each[6][wall] < known.of_each[6][own], "the wall fits better");
        assert_eq!(known.of_each[8][wall], 0.0);
        // The right view says 4 where the wall's match lies.
        assert_eq!([9, 10].map(|i| known.of_each[i][wall]), [0.0, 0.0]);
        assert_eq!([13, 14].map(|i| known.of_each[i][wall]), [0.0, 2.0]);
        assert_eq!(known.of_each[15], [0.0; CANDIDATES]);
        assert_eq!(known.of_each[17][0], 0.0);
        let mut edges = known.of_each[17].iter().zip(known.inside).skip(1);
        assert!(edges.all(|(&edges, inside)| !inside || edges > 0.0), "all of it is noise");
        assert_eq!(known.of_pixel[..5], [0.5, 0.0, 1.0, 0.0, 1.0]);
        let inside = known.inside.iter().filter(|&&inside| inside).count() as f32;
        assert!(inside < 32.0, "some lie above and below the map");
        let votes: f32 = known.of_each[11][wall] + known.of_each[11][own];
        assert!(votes > 1.5 && votes <= 3.0 * inside / 32.0, "most say one or the other: {votes}");
    }

    #[test]
    fn flat_ground_and_settled_matches_have_nothing_to_choose() {
        let mut known = Known::default();
        let flat = World::new(Plane::filled(COLUMNS, ROWS, 4.0));
        assert!(!flat.scene(&flat.given()).know(30, 20, &mut known));
        // The edge is twelve columns away: only pixels that were filled, or in doubt, look that far.
        let mut world =
            World::new(Plane::from_fn(COLUMNS, ROWS, |x, _| if x < 40 { 4.0 } else { 12.0 }));
        assert!(!world.scene(&world.given()).know(52, 20, &mut known));
        world.doubtful.row_mut(20)[52] = true;
        assert!(world.scene(&world.given()).know(52, 20, &mut known));
    }

    #[test]
    fn every_level_and_number_of_threads_chooses_the_same() {
        let mut chance = Chance(9);
        let numbers: Vec<f32> = (0..Judge::NUMBERS).map(|_| chance.share() - 0.5).collect();
        let judge = Judge::new(numbers);
        let mut world = World::new(Plane::from_fn(COLUMNS, ROWS, |x, _| {
            truth(x + FIRST) + 3.0 * chance.share()
        }));
        for (i, reason) in world.reasons.samples_mut().iter_mut().enumerate() {
            *reason = [Reason::Matched, Reason::OccludedFilled, Reason::OutsideRightFilled][i % 3];
        }
        let choices = |level, threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let [mut certainty, mut out] = [Plane::default(), Plane::default()];
            pool.install(|| {
                choose(level, &judge, &world.scene(&world.given()), &mut certainty, &mut out)
            });
            (certainty, out)
        };
        let expected = choices(Level::available()[0], 1);
        assert!(expected.1 != world.values, "nothing was chosen");
        assert!(expected.0.samples().iter().all(|sure| (0.0..=1.0).contains(sure)));
        for level in Level::available() {
            eprintln!("level {}", level.name());
            assert!(choices(level, 2) == expected);
        }
    }

    #[test]
    fn the_shipped_judges_give_back_what_was_filled_from_the_wrong_side() {
        // Where every pixel is a step away from the next, edges say nothing, and less is mended.
        for (texture, most) in [(60.0, 0.2), (200.0, 0.8)] {
            let grown = |x: usize| if (40..70).contains(&x) { 12.0 } else { 4.0 };
            let grown = Plane::from_fn(COLUMNS, ROWS, |x, _| grown(x + FIRST));
            let mut world = World::textured(grown, texture);
            for y in 0..ROWS {
                world.reasons.row_mut(y)[64 - FIRST..70 - FIRST].fill(Reason::OccludedFilled);
                world.confidence.row_mut(y)[64 - FIRST..70 - FIRST].fill(0.0);
            }
            let [mut certainty, mut out] = [Plane::default(), Plane::default()];
            choose(
                Level::detect(),
                &judges(true)[0],
                &world.scene(&world.given()),
                &mut certainty,
                &mut out,
            );
            let wrong = |values: &Plane<f32>| {
                let rows = 5..ROWS - 5;
                let pixels = rows.flat_map(|y| (0..COLUMNS).map(move |x| (x, y)));
                pixels.filter(|&(x, y)| (values.row(y)[x] - truth(x + FIRST)).abs() > 2.0).count()
            };
            let [before, after] = [&world.values, &out].map(wrong);
            eprintln!("texture {texture}: of {before} wrong pixels {after} are left");
            assert!((after as f32) < most * before as f32, "{after} of {before}");
        }
    }
}
