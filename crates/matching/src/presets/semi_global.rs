//! The stages that `balanced` and `best` share, and those that only `best` has.
//!
//! `balanced`:
#![doc = include_str!("balanced.md")]
//!
//! `best`:
#![doc = include_str!("best.md")]

use raster::{BoundingBox, DisparityMap, DisparityRange, Plane, Reason};
use rayon::prelude::*;

use crate::MatchError;
use crate::cost::SearchSpace;
use crate::cost::census_gradient::FeaturePair;
use crate::ingredient::{Ingredient, Ingredients};
use crate::kernels::level::Level;
use crate::kernels::median::{median_of_5_rows, rows_around};
use crate::kernels::path::padded;
use crate::matcher::{Frame, Pipeline};
use crate::optimization::semi_global::{Penalties, SemiGlobal};
use crate::optimization::support_weights::{Looks, Pair, SupportWeights};
use crate::optimization::surface_prior::SurfacePrior;
use crate::prepare::grey::{GreyBuffer, GreyView};
use crate::refinement::groups::Groups;
use crate::refinement::median::median_row;
use crate::refinement::plane_fill::fill;
use crate::selection::cross_check::{ViewMap, cross_check, disagreements};
use crate::selection::fixed_point::{FixedPoint, row_in_pixels, row_in_steps};
use crate::selection::winner::{Winners, fraction, right_fraction};

/// What changes of disparity cost.
const PENALTIES: Penalties = Penalties { p1: 16, p2: 75, p2_least: 25, fall: 1.5 };
/// Smaller groups of equal disparity are speckles.
const LEAST_GROUP: usize = 60;
/// Neighbours of one group differ by at most this.
const GROUP_STEP: f32 = 1.0;
/// So many pixels around the box are matched too: what lies beside a pixel helps to match it.
const SURROUNDINGS: usize = 32;
/// A winner whose sum is so much below that of any other disparity has confidence 1/2.
const HALF_SURE: f32 = 60.0;
/// The confidence of a pixel that both cameras see, but that got its disparity from its neighbours.
const MISMATCHED: f32 = 0.05;

/// What every stage after the paths needs to know.
#[derive(Clone, Copy)]
struct Search {
    ingredients: Ingredients,
    level: Level,
    /// Columns of both images.
    width: usize,
    /// Disparities that are tried anywhere.
    range: DisparityRange,
    numbers: FixedPoint,
}

/// One view with everything that is done to it.
#[derive(Default)]
struct View {
    map: ViewMap,
    filled: Plane<f32>,
    smooth: Plane<f32>,
    looks: Looks,
    weights: SupportWeights,
    groups: Groups,
    /// The map in fixed point.
    steps: Plane<u16>,
}

/// The stages and their memory.
pub(crate) struct SemiGlobalMatching {
    ingredients: Ingredients,
    level: Level,
    buffers: [GreyBuffer; 2],
    grey: [Plane<u8>; 2],
    guide: Plane<u8>,
    features: FeaturePair,
    optimizer: SemiGlobal,
    prior: SurfacePrior,
    rows: Vec<Row>,
    /// The left view, and the right one as it looks in a mirror.
    left: View,
    right: View,
    /// The looks of the other image, for each view.
    others: [Looks; 2],
    confidence: Plane<f32>,
}

/// What the selection says of one row.
#[derive(Default)]
struct Row {
    winners: Winners,
    left: Vec<f32>,
    right: Vec<f32>,
    confidence: Vec<f32>,
}

impl Row {
    /// Disparities of both views; those of the right one in mirror order.
    fn select(&mut self, level: Level, space: &SearchSpace, sums: &[u16], sub_pixel: bool) {
        self.winners.select(level, space, sums);
        let disparity = |k: usize, part: f32| {
            (space.min + k as i32) as f32 + if sub_pixel { part } else { 0.0 }
        };
        self.left.clear();
        self.confidence.clear();
        for (x, &(winner, margin)) in self.winners.left.iter().enumerate() {
            let sums = &sums[x * space.lanes..][..space.lanes];
            let value = winner.disparity().map_or(f32::NAN, |k| {
                disparity(k, fraction(sums, k, space.candidates(space.first + x)))
            });
            self.left.push(value);
            self.confidence.push(f32::from(margin) / (f32::from(margin) + HALF_SURE));
        }
        self.right.clear();
        let right = self.winners.right(space).zip((0..space.width).rev());
        self.right.extend(right.map(|(winner, x)| {
            winner.disparity().map_or(f32::NAN, |k| disparity(k, right_fraction(space, sums, x, k)))
        }));
    }
}

impl SemiGlobalMatching {
    pub fn new(ingredients: Ingredients, level: Level) -> Self {
        Self {
            ingredients,
            level,
            buffers: Default::default(),
            grey: Default::default(),
            guide: Plane::default(),
            features: FeaturePair::default(),
            optimizer: SemiGlobal::default(),
            prior: SurfacePrior::default(),
            rows: Vec::new(),
            left: View::default(),
            right: View::default(),
            others: Default::default(),
            confidence: Plane::default(),
        }
    }
}

/// The upper 8 bits of grey.
fn copy_upper_bits(view: GreyView<'_>, grey: &mut Plane<u8>) {
    let (columns, rows) = view.size();
    grey.reset(columns, rows, 0);
    for y in 0..rows {
        let grey = grey.row_mut(y);
        match view {
            GreyView::Depth8(view) => grey.copy_from_slice(view.row(y)),
            GreyView::Depth16(view) => {
                grey.iter_mut().zip(view.row(y)).for_each(|(to, from)| *to = (from >> 8) as u8);
            }
        }
    }
}

/// The median of 3 x 3 pixels.
fn small_median(values: &Plane<f32>, out: &mut Plane<f32>) {
    let (columns, rows) = values.size();
    out.reset(columns, rows, 0.0);
    let rows = out.samples_mut().par_chunks_mut(columns).enumerate();
    rows.for_each(|(y, out)| median_row(values, y, out));
}

/// A map in fixed point.
fn in_steps(level: Level, numbers: FixedPoint, values: &Plane<f32>, steps: &mut Plane<u16>) {
    steps.reset(values.columns(), values.rows(), 0);
    let rows = steps.samples_mut().par_chunks_mut(values.columns()).enumerate();
    rows.for_each(|(y, steps)| row_in_steps(level, numbers, values.row(y), steps));
}

/// The median of 5 x 5 pixels, in fixed point: `steps` is scratch.
fn median(
    level: Level,
    numbers: FixedPoint,
    values: &Plane<f32>,
    steps: &mut Plane<u16>,
    out: &mut Plane<f32>,
) {
    let (columns, rows) = values.size();
    in_steps(level, numbers, values, steps);
    out.reset(columns, rows, 0.0);
    let steps = &*steps;
    let rows_out = out.samples_mut().par_chunks_mut(columns).enumerate();
    rows_out.for_each_init(
        || vec![0; columns],
        |medians, (y, out)| {
            median_of_5_rows(level, rows_around(steps, y), medians);
            row_in_pixels(level, numbers, medians, out);
        },
    );
}

/// The part of the image that is matched to answer a box.
fn surroundings(bounds: BoundingBox, (columns, rows): (usize, usize)) -> BoundingBox {
    BoundingBox {
        x0: bounds.x0.saturating_sub(SURROUNDINGS),
        y0: bounds.y0.saturating_sub(SURROUNDINGS),
        x1: (bounds.x1 + SURROUNDINGS).min(columns - 1),
        y1: (bounds.y1 + SURROUNDINGS).min(rows - 1),
    }
}

impl View {
    fn begin(&mut self, first: usize, columns: usize, rows: usize) {
        self.map.first = first;
        self.map.values.reset(columns, rows, f32::NAN);
        self.map.reasons.reset(columns, rows, Reason::OccludedHole);
    }

    /// Takes out what the other view does not confirm, and small groups.
    fn check(&mut self, search: Search, other: &Plane<f32>, other_first: usize) {
        let Search { ingredients, level, numbers, width, .. } = search;
        if ingredients.has(Ingredient::LeftRightCheck) {
            cross_check(width, &mut self.map, other, other_first);
        } else {
            self.accept();
        }
        if !ingredients.has(Ingredient::SpeckleFilter) {
            return;
        }
        let ViewMap { values, reasons, .. } = &mut self.map;
        let (columns, rows) = values.size();
        in_steps(level, numbers, values, &mut self.steps);
        let step = numbers.steps(GROUP_STEP);
        let height = rows.div_ceil(rayon::current_num_threads());
        self.groups.find(level, self.steps.samples(), columns, step, height);
        for y in 0..rows {
            for (run, size) in self.groups.runs(y) {
                if size < LEAST_GROUP {
                    values.row_mut(y)[run.clone()].fill(f32::NAN);
                    reasons.row_mut(y)[run].fill(Reason::MismatchedHole);
                }
            }
        }
    }

    /// Takes every disparity for a match.
    fn accept(&mut self) {
        let ViewMap { values, reasons, .. } = &mut self.map;
        for (value, reason) in values.samples().iter().zip(reasons.samples_mut()) {
            *reason = if value.is_nan() { Reason::OccludedHole } else { Reason::Matched };
        }
    }

    /// Fills the holes and lets every pixel take a neighbour's plane. The map has no holes after.
    fn refine(&mut self, search: Search, other: &Looks) {
        let Search { ingredients, level, width, range, .. } = search;
        fill(ingredients, level, width, range, &mut self.map, &mut self.filled);
        small_median(&self.filled, &mut self.smooth);
        let pair = Pair {
            base: &self.looks,
            other,
            first: self.map.first,
            least: range.min() as f32,
            most: range.max() as f32,
        };
        self.weights.refine(level, &pair, &self.smooth, &mut self.map.values);
    }
}

impl SemiGlobalMatching {
    /// Disparities of both views by semi-global matching, along the prior's surfaces or parallel to
    /// the image.
    fn optimize(&mut self, space: &SearchSpace, follow: bool) {
        let level = self.level;
        let penalties = match self.ingredients.has(Ingredient::AdaptiveP2) {
            true => PENALTIES,
            false => Penalties { fall: 0.0, ..PENALTIES },
        };
        let sub_pixel = self.ingredients.has(Ingredient::SubPixel);
        self.optimizer.run(
            level,
            &self.features.costs(level, space),
            &self.guide,
            follow.then_some(&self.prior),
            &penalties,
            &mut self.rows,
            |_, sums, row| row.select(level, space, sums, sub_pixel),
        );
        for (y, row) in self.rows.iter().enumerate() {
            self.left.map.values.row_mut(y).copy_from_slice(&row.left);
            self.right.map.values.row_mut(y).copy_from_slice(&row.right);
            self.confidence.row_mut(y).copy_from_slice(&row.confidence);
        }
    }

    /// Runs the paths again along the surfaces of the map as it is.
    fn follow_surfaces(&mut self, space: &SearchSpace, search: Search) {
        self.left.check(search, &self.right.map.values, self.right.map.first);
        let Search { ingredients, level, width, range, .. } = search;
        let View { map, filled, .. } = &mut self.left;
        fill(ingredients, level, width, range, map, filled);
        self.prior.fit(level, &map.values, filled);
        self.optimize(space, true);
    }

    /// Sharpens both views, or the left one alone: each takes planes from its neighbourhood.
    fn sharpen(&mut self, search: Search, work: BoundingBox) {
        // Both are checked against the other as it was.
        let View { map, filled: raw, .. } = &mut self.left;
        raw.reset(map.values.columns(), map.values.rows(), 0.0);
        raw.samples_mut().copy_from_slice(map.values.samples());
        self.left.check(search, &self.right.map.values, self.right.map.first);
        let both = search.ingredients.has(Ingredient::RightSupportWeights);
        if both {
            self.right.check(search, &self.left.filled, self.left.map.first);
        }
        let [other_of_left, other_of_right] = &mut self.others;
        self.left.looks.compute(&self.grey[0], work.y0, work.rows());
        other_of_left.compute(&self.grey[1], work.y0, work.rows());
        if both {
            other_of_left.mirrored(&mut self.right.looks);
            self.left.looks.mirrored(other_of_right);
            self.right.refine(search, other_of_right);
        }
        self.left.refine(search, other_of_left);
    }

    /// Confidence by nothing but the difference of the two views, which both must still be unchecked.
    fn trust_agreement(&mut self, width: usize) {
        let (left, right) = (&self.left.map, &self.right.map);
        disagreements(width, left, &right.values, right.first, &mut self.confidence);
        for confidence in self.confidence.samples_mut() {
            *confidence = if confidence.is_nan() { 0.0 } else { 1.0 / (1.0 + *confidence) };
        }
    }
}

impl Pipeline for SemiGlobalMatching {
    fn run(&mut self, frame: &Frame<'_>, map: &mut DisparityMap) -> Result<(), MatchError> {
        let bounds = frame.bounds;
        let (width, height) = frame.size();
        let work = surroundings(bounds, (width, height));
        let (columns, rows) = (work.columns(), work.rows());
        let [left, right] = &mut self.buffers;
        let views = [left.view(frame.left), right.view(frame.right)];
        for (view, grey) in views.into_iter().zip(&mut self.grey) {
            copy_upper_bits(view, grey);
        }
        self.guide.reset(columns, rows, 0);
        for y in 0..rows {
            let from = &self.grey[0].row(work.y0 + y)[work.x0..=work.x1];
            self.guide.row_mut(y).copy_from_slice(from);
        }

        let mut space = SearchSpace::new(width, work, frame.range);
        space.lanes = padded(space.count);
        // Disparities that are tried anywhere; without any, all pixels lie outside the right image.
        let searched = DisparityRange::new(space.min, space.min + space.count as i32 - 1);
        let range = searched.unwrap_or(frame.range);
        let (ingredients, level, numbers) = (self.ingredients, self.level, FixedPoint::new(&space));
        let search = Search { ingredients, level, width, range, numbers };
        self.left.begin(work.x0, columns, rows);
        self.right.begin(0, width, rows);
        self.confidence.reset(columns, rows, 0.0);
        if space.count > 0 {
            // Flat grey has no gradient.
            let flat = match ingredients.has(Ingredient::Gradient) {
                true => None,
                false => Some(Plane::filled(width, height, 0)),
            };
            let seen = [0, 1].map(|i| (views[i], flat.as_ref().unwrap_or(&self.grey[i])));
            self.features.compute(level, seen, &space, (work.y0, rows));
            self.rows.resize_with(rows, Row::default);
            self.optimize(&space, false);
            if ingredients.has(Ingredient::SurfacePrior) {
                self.follow_surfaces(&space, search);
                if ingredients.has(Ingredient::LastSurfaceRun) {
                    self.follow_surfaces(&space, search);
                }
            }
            if ingredients.has(Ingredient::SupportWeights) {
                self.sharpen(search, work);
            }
            if !ingredients.has(Ingredient::PathMargin) {
                self.trust_agreement(width);
            }
            self.left.check(search, &self.right.map.values, self.right.map.first);
        }
        let View { map: left, filled, smooth, steps, .. } = &mut self.left;
        fill(ingredients, level, width, range, left, filled);
        if space.count > 0 && ingredients.has(Ingredient::Median) {
            median(level, numbers, filled, steps, smooth);
        } else {
            smooth.clone_from(filled);
        }

        let (dx, dy) = (bounds.x0 - work.x0, bounds.y0 - work.y0);
        for y in 0..bounds.rows() {
            let from = dx..dx + bounds.columns();
            let to = bounds.x0..=bounds.x1;
            let values = &mut map.values.row_mut(bounds.y0 + y)[to.clone()];
            values.copy_from_slice(&self.left.smooth.row(dy + y)[from.clone()]);
            let reasons = &mut map.reasons.row_mut(bounds.y0 + y)[to.clone()];
            reasons.copy_from_slice(&self.left.map.reasons.row(dy + y)[from.clone()]);
            let confidence = &mut map.confidence.row_mut(bounds.y0 + y)[to];
            confidence.copy_from_slice(&self.confidence.row(dy + y)[from]);
            for (reason, confidence) in reasons.iter().zip(confidence) {
                match reason {
                    Reason::Matched => {}
                    Reason::MismatchedFilled => *confidence *= MISMATCHED,
                    _ => *confidence = 0.0,
                }
            }
        }
        Ok(())
    }
}
