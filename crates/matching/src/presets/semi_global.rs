//! The stages that `balanced` and `best` share, and those that only `best` has.
//!
//! `balanced`:
#![doc = include_str!("balanced.md")]
//!
//! `best`:
#![doc = include_str!("best.md")]

use raster::{BoundingBox, DisparityMap, DisparityRange, Plane, Reason};

use super::answer::{Answer, ONE_SURFACE};
use super::memory::Needs;
use super::pair::{Pair, Prepared};
use super::penalties::penalties;
use super::right_choices::RightChoices;
use super::view::{Search, View, in_steps};
use super::widened::widened;
use crate::Preset;
use crate::allowance::Allowance;
use crate::cost::census_gradient::{Described, FeaturePair};
use crate::cost::{MatchedRows, SearchSpace};
use crate::ingredient::{Ingredient, Ingredients};
use crate::kernels::every::take_every;
use crate::kernels::level::Level;
use crate::matcher::{Frame, Pipeline};
use crate::optimization::semi_global::SemiGlobal;
use crate::optimization::surface_prior::SurfacePrior;
use crate::prepare::alignment::VerticalDisparity;
use crate::prepare::grey::GreyView;
use crate::prepare::plain;
use crate::profile::{Profile, Work};
use crate::refinement::Map;
use crate::refinement::choice::{Choices, Given, Jury, Lesson, certainty};
use crate::refinement::columns_between;
use crate::refinement::least_squares::LeastSquares;
use crate::refinement::outside;
use crate::refinement::plane_fill::fill;
use crate::refinement::plane_smoothing::PlaneSmoothing;
use crate::refinement::repetition::Repetition;
use crate::selection::both_views::Selection;
use crate::selection::cross_check::disagreements;
use crate::selection::fixed_point::FixedPoint;
use crate::selection::unseen;
use crate::selection::winner::Winners;

/// A winner is no match unless its sum is lower by at least this than every other disparity's, its two neighbours
/// apart, or if there are no others to compare it with, at the end of the right image. Where only three disparities
/// are tried, one of its neighbours' sums must be larger by as much.
const UNIQUE: u16 = 2;
/// How much paths press the fractions of `best` towards whole disparities; those of `balanced`, whose matched pixels
/// stand for four, they do not.
const LOCKING: f32 = 0.5;
/// So many pixels around the box are matched too: what lies beside a pixel helps to match it.
const SURROUNDINGS: usize = 32;
/// Descriptors find something nearly everywhere: a pixel in doubt with less confidence stays a hole.
const SURE: f32 = 0.4;

/// Stages that run more than once, for the profile.
const PATHS: &str = "costs, eight paths, winners";
const CHECK: &str = "check, speckles";
const FILL: &str = "fill";

/// The stages and their memory.
pub(crate) struct SemiGlobalMatching {
    ingredients: Ingredients,
    preset: Preset,
    level: Level,
    pair: Pair,
    /// What was taken out of the right image of the last frame.
    vertical: Option<VerticalDisparity>,
    /// What stands for the grey of both images where grey steps do not count: it has none, so it is never written.
    flat: Plane<u8>,
    features: FeaturePair,
    /// The grey of what is matched, whose steps the penalties go by.
    guide: Plane<u8>,
    /// Pixels of the left view that show nothing but noise.
    plain: Plane<bool>,
    /// Pixels of the left view that both cameras should see and that no run has matched so far.
    doubtful: Plane<bool>,
    optimizer: SemiGlobal,
    prior: SurfacePrior,
    /// Of each half of the rows.
    winners: [Winners; 2],
    /// The left view, and the right one as it looks in a mirror.
    left: View,
    right: View,
    right_choices: RightChoices,
    choices: Choices,
    /// How sure the matched pixels are.
    confidence: Plane<f32>,
    /// Of the left view with the columns between.
    between: columns_between::Sources,
    repetition: Repetition,
    answer: Answer,
    plane_smoothing: PlaneSmoothing,
    least_squares: LeastSquares,
}

impl SemiGlobalMatching {
    /// A preset with all ingredients, and a lesson to be learned from the first frame.
    pub fn teaching(preset: Preset, level: Level, lesson: Lesson) -> Self {
        let untaught = Self::new(preset, &[], level);
        Self { choices: untaught.choices.teaching(lesson), ..untaught }
    }

    /// The lesson, learned.
    pub fn into_lesson(self) -> Option<Lesson> {
        self.choices.into_lesson()
    }

    /// `balanced` or `best`, without some of its ingredients.
    pub fn new(preset: Preset, without: &[Ingredient], level: Level) -> Self {
        let ingredients = Ingredients::of(preset, without);
        Self {
            ingredients,
            preset,
            level,
            pair: Pair::default(),
            vertical: None,
            flat: Plane::default(),
            features: FeaturePair::default(),
            guide: Plane::default(),
            plain: Plane::default(),
            doubtful: Plane::default(),
            optimizer: SemiGlobal::default(),
            prior: SurfacePrior::default(),
            winners: Default::default(),
            left: View::default(),
            right: View::default(),
            right_choices: RightChoices::default(),
            choices: Choices::new(Jury::of(preset), ingredients.has(Ingredient::NearDetail)),
            confidence: Plane::default(),
            between: columns_between::Sources::default(),
            repetition: Repetition::default(),
            answer: Answer::default(),
            plane_smoothing: PlaneSmoothing::default(),
            least_squares: LeastSquares::default(),
        }
    }
}

/// The part of the images that is matched to answer a frame's box.
fn surroundings(frame: &Frame<'_>) -> BoundingBox {
    let (columns, rows) = frame.size();
    let bounds = widened(frame.bounds, frame.range, columns);
    BoundingBox {
        x0: bounds.x0.saturating_sub(SURROUNDINGS),
        y0: bounds.y0.saturating_sub(SURROUNDINGS),
        x1: (bounds.x1 + SURROUNDINGS).min(columns - 1),
        y1: (bounds.y1 + SURROUNDINGS).min(rows - 1),
    }
}

impl SemiGlobalMatching {
    /// Takes the grey of what is matched, so many columns apart.
    fn look_at_guide(&mut self, search: Search<'_>, apart: usize) -> Work {
        let grey = search.matched_rows();
        let columns = grey.columns().div_ceil(apart);
        self.guide.reshape(columns, grey.rows(), 0);
        let rows = self.guide.samples_mut().chunks_exact_mut(columns).enumerate();
        rows.for_each(|(y, row)| take_every(apart, grey.row(y), row));
        Work::bytes(2 * size_of_val(self.guide.samples()))
    }

    /// Disparities of the left view that the right one confirms, and how sure they are. Of the right view those
    /// that the left one confirms where pixels of it are to choose.
    fn find_matches(
        &mut self,
        space: &SearchSpace,
        search: Search<'_>,
        views: [GreyView<'_>; 2],
        chooses: bool,
        confidence: &mut [f32],
        profile: &mut Profile,
    ) {
        let Search { ingredients, level, grey, noise, work, rows, width, .. } = search;
        let stepped = match ingredients.has(Ingredient::Gradient) {
            true => grey,
            false => {
                self.flat.reshape(width, grey[0].rows(), 0);
                [self.flat.view(); 2]
            }
        };
        let seen = [0, 1].map(|i| (views[i], stepped[i]));
        let features = self.features.compute(level, seen, space, rows);
        profile.end("census and gradient", features + self.look_at_guide(search, space.apart));
        if ingredients.has(Ingredient::Descriptors) {
            self.doubtful.reset(space.columns(), rows.count, false);
            let described = self.features.describe(level, views, space, work.y0);
            let noise = if ingredients.has(Ingredient::NoiseCheck) { noise } else { 0.0 };
            let checked = plain::find(level, grey[0], noise, work, &mut self.plain);
            profile.end("descriptors", described + checked);
        }
        profile.end(PATHS, self.optimize(space, search, confidence, false));
        if ingredients.has(Ingredient::SurfacePrior) {
            self.follow_surfaces(space, search, confidence, profile);
            if ingredients.has(Ingredient::LastSurfaceRun) {
                self.follow_surfaces(space, search, confidence, profile);
            }
        }
        if !ingredients.has(Ingredient::PathMargin) {
            self.trust_agreement(width, confidence);
        }
        let both = chooses && ingredients.has(Ingredient::RightChoices);
        self.check(search, both, confidence, profile);
    }

    /// Disparities of both views by semi-global matching, along the prior's surfaces or parallel to
    /// the image. `confidence` takes how sure those of the left view are.
    fn optimize(
        &mut self,
        space: &SearchSpace,
        search: Search<'_>,
        confidence: &mut [f32],
        follow: bool,
    ) -> Work {
        let Search { ingredients, level, rows, bands, .. } = search;
        let described = Described { plain: &self.plain, doubtful: &self.doubtful };
        let described = ingredients.has(Ingredient::Descriptors).then_some(described);
        let locking = if self.preset == Preset::Best { LOCKING } else { 0.0 };
        let sub_pixel = ingredients.has(Ingredient::SubPixel).then_some(locking);
        let least_margin = if ingredients.has(Ingredient::Uniqueness) { UNIQUE } else { 0 };
        let middle = SemiGlobal::middle(rows.count);
        let left = self.left.map.values.samples_mut().split_at_mut(middle * space.columns());
        let right = self.right.map.values.samples_mut().split_at_mut(middle * space.width);
        let confidence = confidence.split_at_mut(middle * space.columns());
        let [upper, lower] = &mut self.winners;
        let halves = [
            (0, left.0, right.0, confidence.0, upper),
            (middle, left.1, right.1, confidence.1, lower),
        ];
        let finish = halves.map(|(first, left, right, confidence, winners)| {
            let mut rows = Selection {
                level,
                space,
                sub_pixel,
                least_margin,
                first,
                left,
                confidence,
                right,
                winners,
            };
            move |y: usize, sums: &[u16]| rows.row(y, sums)
        });
        let paths = self.optimizer.run(
            level,
            &self.features.costs(level, space, described),
            self.guide.view(),
            follow.then_some(&self.prior),
            &search.penalties,
            bands,
            finish,
        );
        paths + Selection::work(space) * rows.count
    }

    /// Runs the paths again along the surfaces of the map as it is.
    fn follow_surfaces(
        &mut self,
        space: &SearchSpace,
        search: Search<'_>,
        confidence: &mut [f32],
        profile: &mut Profile,
    ) {
        self.check(search, false, confidence, profile);
        let Search { ingredients, level, width, range, .. } = search;
        let View { map, filled, .. } = &mut self.left;
        if ingredients.has(Ingredient::Descriptors) {
            let reasons = map.reasons.samples().iter();
            for (doubtful, &reason) in self.doubtful.samples_mut().iter_mut().zip(reasons) {
                *doubtful |= reason == Reason::MismatchedHole;
            }
        }
        profile.end(FILL, fill(ingredients, level, width, range, map, filled));
        profile.end("surfaces", self.prior.fit(level, &map.values, filled));
        let mut done = self.optimize(space, search, confidence, true);
        if ingredients.has(Ingredient::Descriptors) {
            done = done + self.reject_unsure(confidence);
        }
        profile.end(PATHS, done);
    }

    /// Takes out winners of pixels in doubt that are not clearly better than other disparities.
    fn reject_unsure(&mut self, confidence: &[f32]) -> Work {
        let pixels = self.left.map.values.samples_mut().iter_mut().zip(confidence);
        for ((value, &confidence), &doubtful) in pixels.zip(self.doubtful.samples()) {
            if doubtful && confidence < SURE {
                *value = f32::NAN;
            }
        }
        Work::bytes((4 + 4 + 1) * confidence.len())
    }

    /// Checks the left view, which is as sure as `confidence`, against the right one, and that against the left one as it
    /// was.
    fn check(&mut self, search: Search<'_>, both: bool, confidence: &[f32], profile: &mut Profile) {
        let View { map, filled: unchecked, .. } = &mut self.left;
        let mut done = Work::default();
        if both {
            unchecked.reshape(map.values.columns(), map.values.rows(), 0.0);
            unchecked.samples_mut().copy_from_slice(map.values.samples());
            done = Work::bytes(2 * size_of_val(unchecked.samples()));
        }
        if let Some(vertical) = &self.vertical {
            unseen::reject(vertical, search.rows, &mut self.right.map.values);
        }
        let right = &self.right.map;
        done = done + self.left.check(search, &right.values, right.first, Some(confidence));
        if both {
            let (unchecked, first) = (&self.left.filled, self.left.map.first);
            done = done + self.right.check(search, unchecked, first, None);
        }
        profile.end(CHECK, done);
    }

    /// Fills the holes of the left view, and of the right one where its pixels are to choose.
    fn fill_views(&mut self, search: Search<'_>, chooses: bool, profile: &mut Profile) {
        let Search { ingredients, level, width, range, .. } = search;
        let View { map, filled, .. } = &mut self.left;
        let mut done = fill(ingredients, level, width, range, map, filled);
        if chooses && ingredients.has(Ingredient::RightChoices) {
            let View { map, filled, .. } = &mut self.right;
            done = done + fill(ingredients, level, width, range, map, filled);
        }
        profile.end(FILL, done);
    }

    /// Lets pixels of the left view, which is filled, choose planes around them, before it those of the
    /// right one. One without a match is as confident as the judge is certain, one with a match as both are.
    fn choose(&mut self, search: Search<'_>, confidence: &mut Plane<f32>, profile: &mut Profile) {
        let Search { ingredients, level, grey, work, range, .. } = search;
        let further = ingredients.has(Ingredient::FurtherChoices);
        if ingredients.has(Ingredient::RightChoices) {
            let (left, right) = (&self.left, &mut self.right);
            let choices = &mut self.choices;
            let done = self.right_choices.run(search, further, choices, left, confidence, right);
            profile.end("choices in the right view", done);
        }
        let View { map, filled, .. } = &mut self.left;
        let given = Given {
            doubtful: &self.doubtful,
            grey,
            right: &self.right.map.values,
            first: work.x0,
            top: work.y0,
            least: range.min() as f32,
            most: range.max() as f32,
        };
        let rounds = if further { usize::MAX } else { 1 };
        let done = self.choices.run(level, rounds, &given, confidence, filled, map);
        self.choices.learn(level, &given, filled, map);
        if ingredients.has(Ingredient::PathMargin) {
            let told = self.choices.certainty().iter().zip(map.reasons.samples());
            for (to, (&certainty, reason)) in confidence.samples_mut().iter_mut().zip(told) {
                let certainty = certainty::share(certainty);
                *to = if *reason == Reason::Matched { *to * certainty } else { certainty };
            }
        }
        // Confidence is multiplied by the certainty where there is a match.
        let told = 2 * size_of_val(filled.samples()) + 2 * size_of_val(map.reasons.samples());
        profile.end("choices", done + Work::bytes(told));
    }

    /// From the left view, which is filled and has chosen, the answer to a box in `map`: all columns, fractions of a
    /// pixel by least squares, all rows, the median. The right view has said what it knows: its memory takes the
    /// columns between, and goes back to the disparities of `map` then.
    fn answer(
        &mut self,
        space: &SearchSpace,
        search: Search<'_>,
        chooses: bool,
        sure: &mut Plane<f32>,
        bounds: BoundingBox,
        map: &mut DisparityMap,
        profile: &mut Profile,
    ) {
        let Search { ingredients, level, grey, rows, width, range, .. } = search;
        let View { map: left, filled, steps, .. } = &mut self.left;
        if space.count > 0 && ingredients.has(Ingredient::PlaneSmoothing) {
            let scratch = &mut self.right.map.values;
            let rough = Map { values: filled, first: left.first, rows, range };
            let smoothed = self.plane_smoothing.smooth(level, space.apart, grey, rough, scratch);
            profile.end("plane smoothing", smoothed);
        }
        let (values, reasons, confidence) = if space.apart > 1 {
            let matched = columns_between::Matched {
                values: filled,
                reasons: &left.reasons,
                confidence: sure,
            };
            let grey = search.matched_rows();
            let values = &mut self.right.map.values;
            let spread = self.between.spread(level, grey, ONE_SURFACE, matched, values);
            profile.end("columns between", spread);
            let columns_between::Sources { reasons, confidence } = &mut self.between;
            (values, reasons, confidence)
        } else {
            (filled, &mut left.reasons, sure)
        };
        if space.count > 0 && ingredients.has(Ingredient::LeastSquares) {
            let (values, first) = (&mut *values, left.first);
            let shifted = Map { values, first, rows, range };
            profile.end("least squares", self.least_squares.refine(level, grey, reasons, shifted));
        }
        let searched = (space.count > 0).then_some(range);
        profile.end("repetition", self.repetition.find(level, grey[0], search.work, searched));
        let stepped = in_steps(level, search.numbers, values, steps);
        // Without a search there is one value everywhere.
        let nowhere = values.row(0)[0];
        map.values = std::mem::take(&mut self.right.map.values);
        map.values.reshape(width, grey[0].rows(), nowhere);
        let judged = chooses && ingredients.has(Ingredient::PathMargin);
        let (told, repetition) = ((&*steps, reasons), &self.repetition);
        let answered = self.answer.spread(search, judged, repetition, told, confidence, map);
        profile.end("answer", stepped + answered);
        let medians = match space.count {
            0 => {
                map.values.samples_mut().fill(nowhere);
                // A column's reason is also that of the one between, which may see more.
                let rows = map.values.samples().chunks_exact(width);
                let reasons = map.reasons.samples_mut().chunks_exact_mut(width);
                let confidence = map.confidence.samples_mut().chunks_exact_mut(width);
                for (values, (reasons, confidence)) in rows.zip(reasons.zip(confidence)) {
                    outside::mark(level, width, 0, range, values, reasons, confidence);
                }
                Work::default()
            }
            _ => self.answer.smooth(search, bounds, map),
        };
        profile.end("median", medians);
        map.empty_around(bounds);
    }

    /// Confidence by nothing but the difference of the two views, which both must still be unchecked.
    fn trust_agreement(&self, width: usize, confidence: &mut [f32]) {
        let (left, right) = (&self.left.map, &self.right.map);
        disagreements(self.level, width, left, &right.values, right.first, confidence);
        for confidence in confidence {
            *confidence = if confidence.is_nan() { 0.0 } else { 1.0 / (1.0 + *confidence) };
        }
    }

    /// What is searched in a part of a frame: what no judge asks need not be matched.
    fn space(&self, frame: &Frame<'_>, work: BoundingBox) -> SearchSpace {
        let every = self.choices.jury().reach.every;
        SearchSpace::of_every(every, frame.size().0, work, frame.range)
    }

    fn needs(&self, frame: &Frame<'_>, work: BoundingBox, space: &SearchSpace) -> Needs {
        Needs::new(frame, work, space, self.ingredients, self.choices.jury())
    }
}

impl Pipeline for SemiGlobalMatching {
    fn vertical_disparity(&self) -> Option<&VerticalDisparity> {
        self.vertical.as_ref()
    }

    fn least_memory(&self, frame: &Frame<'_>) -> usize {
        let work = surroundings(frame);
        let space = self.space(frame, work);
        self.needs(frame, work, &space).least()
    }

    fn run(
        &mut self,
        frame: &Frame<'_>,
        allowance: Allowance,
        map: &mut DisparityMap,
        profile: &mut Profile,
    ) {
        let bounds = frame.bounds;
        let width = frame.size().0;
        let work = surroundings(frame);
        let space = self.space(frame, work);
        let rows = MatchedRows::of(work, space.apart);
        let columns = space.columns();
        let bands = self.needs(frame, work, &space).bands(allowance);
        // Disparities that are tried anywhere; without any, all pixels lie outside the right image.
        let searched = DisparityRange::new(space.min, space.min + space.count as i32 - 1);
        let range = searched.unwrap_or(frame.range);
        let (ingredients, level) = (self.ingredients, self.level);
        // Borrowed while the stages run.
        let mut pair = std::mem::take(&mut self.pair);
        let Prepared { views, grey, vertical, noise, done } =
            pair.prepare(level, ingredients, frame, space.count > 0);
        self.vertical = vertical;
        let (penalties, measured) =
            penalties(self.preset, ingredients, grey[0], noise, space.apart);
        profile.end("grey, vertical alignment, noise", done + measured);
        let search = Search {
            ingredients,
            level,
            left: views[0],
            grey,
            noise,
            work,
            rows,
            bands,
            width,
            range,
            numbers: FixedPoint::new(&space),
            penalties,
        };
        // The answer's disparities come last: until then the right view has their memory.
        self.right.map.values = std::mem::take(&mut map.values);
        self.left.begin((work.x0, space.apart), columns, rows.count);
        self.right.begin((0, 1), width, rows.count);
        let mut sure = std::mem::take(&mut self.confidence);
        sure.reshape(columns, rows.count, 0.0);
        let chooses = space.count > 0 && ingredients.has(Ingredient::LearnedChoice);
        if space.count > 0 {
            self.find_matches(&space, search, views, chooses, sure.samples_mut(), profile);
        } else {
            self.left.map.values.samples_mut().fill(f32::NAN);
            self.left.map.reasons.reset(columns, rows.count, Reason::OccludedHole);
            sure.samples_mut().fill(0.0);
        }
        self.fill_views(search, chooses, profile);
        if chooses {
            self.choose(search, &mut sure, profile);
        }
        self.answer(&space, search, chooses, &mut sure, bounds, map, profile);
        self.confidence = sure;
        self.pair = pair;
    }
}
