//! One view of a pair, and what is done to it after matching: checked against the other view, cleared
//! of speckles, in fixed point.

use std::ops::Range;

use raster::{BoundingBox, DisparityRange, Plane, Reason};
use rayon::prelude::*;

use crate::cost::MatchedRows;
use crate::ingredient::{Ingredient, Ingredients};
use crate::kernels::level::Level;
use crate::optimization::bands::Bands;
use crate::optimization::semi_global::Penalties;
use crate::prepare::grey::GreyView;
use crate::profile::Work;
use crate::refinement::groups::{self, Groups};
use crate::selection::cross_check::{ViewMap, cross_check};
use crate::selection::fixed_point::{FixedPoint, row_in_steps};

/// Groups that weigh less are speckles: so many pixels of the image, each of which weighs as much as it is sure.
const LEAST_GROUP: f32 = 20.0;
/// How sure a pixel is taken to be whose confidence is not known.
const UNKNOWN: f32 = 0.6;
/// Weights are counted in such parts of a pixel.
const PARTS: f32 = 64.0;

/// What every stage needs to know.
#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    pub ingredients: Ingredients,
    pub level: Level,
    /// The left image as it is matched, in all its bits.
    pub left: GreyView<'a>,
    /// The upper 8 bits of both images.
    pub grey: [raster::View<'a, u8>; 2],
    /// The standard deviation of the noise in them, in grey levels.
    pub noise: f32,
    /// The part of the left image that is matched.
    pub work: BoundingBox,
    /// Those of its rows that are.
    pub rows: MatchedRows,
    pub bands: Bands,
    /// Columns of both images.
    pub width: usize,
    /// Disparities that are tried anywhere.
    pub range: DisparityRange,
    pub numbers: FixedPoint,
    pub penalties: Penalties,
}

impl<'a> Search<'a> {
    /// The grey values of the part of the left image that is matched, all of them.
    pub fn left_part(&self) -> raster::View<'a, u8> {
        let Self { grey, work, .. } = self;
        grey[0].part(work.x0..work.x1 + 1, work.y0..work.y1 + 1)
    }

    /// The same of its matched rows alone.
    pub fn matched_rows(&self) -> raster::View<'a, u8> {
        self.left_part().every_row(self.rows.apart)
    }
}

/// One view with everything that is done to it.
#[derive(Default)]
pub(super) struct View {
    pub map: ViewMap,
    pub filled: Plane<f32>,
    groups: Groups,
    /// The map in fixed point.
    pub steps: Plane<u16>,
}

impl View {
    /// Takes the memory of a map that begins at a column and has every so many-th.
    pub fn begin(&mut self, (first, apart): (usize, usize), columns: usize, rows: usize) {
        (self.map.first, self.map.apart) = (first, apart);
        self.map.values.reshape(columns, rows, f32::NAN);
    }

    /// Takes out what the other view does not confirm, and small groups. `confidence` is that of the map's pixels, if it
    /// is known.
    pub fn check(
        &mut self,
        search: Search<'_>,
        other: &Plane<f32>,
        other_first: usize,
        confidence: Option<&[f32]>,
    ) -> Work {
        let Search { ingredients, level, numbers, width, .. } = search;
        let area = (search.rows.apart * self.map.apart) as f32;
        let least = (PARTS * LEAST_GROUP / area) as u32;
        let checked = if ingredients.has(Ingredient::LeftRightCheck) {
            cross_check(level, width, &mut self.map, other, other_first)
        } else {
            self.accept()
        };
        if !ingredients.has(Ingredient::SpeckleFilter) {
            return checked;
        }
        let ViewMap { values, reasons, .. } = &mut self.map;
        let (columns, rows) = values.size();
        let written = in_steps(level, numbers, values, &mut self.steps);
        let step = numbers.steps(groups::STEP);
        let height = rows.div_ceil(rayon::current_num_threads());
        let weight = |run: Range<usize>| weight(confidence, run);
        let grouped = self.groups.find(level, self.steps.samples(), columns, step, height, weight);
        let groups = &self.groups;
        let rows = values.samples_mut().par_chunks_exact_mut(columns);
        let rows = rows.zip(reasons.samples_mut().par_chunks_exact_mut(columns)).enumerate();
        rows.for_each(|(y, (values, reasons))| {
            let speckles = groups.runs(y).filter(|(_, weight)| *weight < least);
            for (run, _) in speckles {
                values[run.clone()].fill(f32::NAN);
                reasons[run].fill(Reason::MismatchedHole);
            }
        });
        let weighed = Work::bytes(confidence.map_or(0, size_of_val));
        checked + written + weighed + grouped + self.groups.looked_at()
    }

    /// Takes every disparity for a match.
    fn accept(&mut self) -> Work {
        let ViewMap { values, reasons, .. } = &mut self.map;
        reasons.reset(values.columns(), values.rows(), Reason::OccludedHole);
        for (value, reason) in values.samples().iter().zip(reasons.samples_mut()) {
            *reason = if value.is_nan() { Reason::OccludedHole } else { Reason::Matched };
        }
        Work::bytes(size_of_val(values.samples()) + size_of_val(reasons.samples()))
    }
}

/// What pixels weigh that lie side by side in a map with this confidence, or one that is not known.
fn weight(confidence: Option<&[f32]>, places: Range<usize>) -> u32 {
    let sure = match confidence {
        Some(confidence) => confidence[places].iter().sum(),
        None => UNKNOWN * places.len() as f32,
    };
    (PARTS * sure) as u32
}

/// A map in fixed point.
pub(super) fn in_steps(
    level: Level,
    numbers: FixedPoint,
    values: &Plane<f32>,
    steps: &mut Plane<u16>,
) -> Work {
    steps.reshape(values.columns(), values.rows(), 0);
    let rows = steps.samples_mut().par_chunks_mut(values.columns()).enumerate();
    rows.for_each(|(y, steps)| row_in_steps(level, numbers, values.row(y), steps));
    Work::bytes(size_of_val(values.samples()) + size_of_val(steps.samples()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_weighs_as_much_as_it_is_sure() {
        let confidence = [0.5, 0.25, 1.0, 0.0];
        assert_eq!(weight(Some(&confidence), 0..3) as f32, 1.75 * PARTS);
        assert_eq!(weight(Some(&confidence), 3..4), 0);
        let known = [UNKNOWN; 20];
        assert!(weight(None, 5..15).abs_diff(weight(Some(&known), 5..15)) <= 1);
    }
}
