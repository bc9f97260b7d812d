//! How much memory the stages take for a frame, told before any of it is taken.
//!
//! Every stage keeps its memory until the next frame, so what a frame takes is a sum over all of
//! them: planes that are counted here in bytes per pixel, and what semi-global matching keeps, for
//! which there is a choice ([`Bands`]).

use raster::{BoundingBox, Image};

use super::right_choices::RightChoices;
use crate::allowance::Allowance;
use crate::cost::{MatchedRows, SearchSpace};
use crate::ingredient::{Ingredient, Ingredients};
use crate::matcher::Frame;
use crate::optimization::bands::{Bands, Volume};
use crate::optimization::semi_global::SemiGlobal;
use crate::prepare::alignment::Alignment;
use crate::prepare::descriptor::Descriptors;
use crate::refinement::choice::{Choices, Jury};
use crate::refinement::columns_between;
use crate::refinement::groups::Groups;
use crate::refinement::least_squares::LeastSquares;
use crate::refinement::plane_smoothing::PlaneSmoothing;
use crate::refinement::repetition::Repetition;

/// What a frame takes at most where no limit was given, or else what the sums of semi-global matching
/// take of it. Bands cost time, so the pairs of the usual benchmarks are matched without any (KITTI with
/// 160 disparities: 75 MB of sums); several megapixels, which would take gigabytes, are matched with
/// bands.
const UNASKED: usize = 200_000_000;
const SUMS: usize = 100_000_000;

/// Room for what is done row by row: bytes per column and thread, and in all.
const ROW: usize = 64;
const ODDS_AND_ENDS: usize = 64 << 10;

/// A disparity map: value, reason, confidence.
pub(super) const ANSWER: usize = 4 + 1 + 4;

/// Bytes per pixel that the grey of a colour image takes.
pub(super) fn grey(image: &Image) -> usize {
    match image {
        Image::Grey8(_) | Image::Grey16(_) => 0,
        Image::Rgb8(_) => 1,
        Image::Rgb16(_) => 2,
    }
}

/// Bytes per pixel that the upper bits of an image take beside its grey.
pub(super) fn upper_bits(image: &Image) -> usize {
    usize::from(image.depth() > u8::BITS)
}

/// What `count` rows of images of `width` columns take while they are worked on, each by one thread.
pub(super) fn rows(width: usize, count: usize) -> usize {
    ROW * width * rayon::current_num_threads().min(count) + ODDS_AND_ENDS
}

/// What a frame takes with `balanced` and `best`.
pub(super) struct Needs {
    /// All but semi-global matching.
    rest: usize,
    volume: Volume,
}

impl Needs {
    /// To match the part `work` of the images over a search space.
    pub fn new(
        frame: &Frame<'_>,
        work: BoundingBox,
        space: &SearchSpace,
        ingredients: Ingredients,
        jury: &Jury,
    ) -> Self {
        let (width, height) = frame.size();
        let (columns, lines) = (space.columns(), MatchedRows::of(work, space.apart).count);
        // Pixels of the images, of their rows that are matched, those that are of the left one's part, and all
        // columns of it.
        let (all, wide, part) = (width * height, width * lines, columns * lines);
        let rows_of_part = work.columns() * lines;
        let of_image = |image| (grey(image) + upper_bits(image)) * all;
        let images = of_image(frame.left) + of_image(frame.right);
        let deep = upper_bits(frame.right) > 0;
        let images = match ingredients.has(Ingredient::VerticalAlignment) {
            false => images,
            true => images + Alignment::bytes(width, height, frame.range, deep),
        };
        let images = match ingredients.has(Ingredient::NoiseSmoothing) {
            false => images,
            true => images + 2 * all,
        };
        let flat = if ingredients.has(Ingredient::Gradient) { 0 } else { all };
        // Census words and steps of both, the right ones between margins; descriptors, and where they
        // are asked for.
        let places = part + wide + 2 * space.lanes * lines;
        let features = (4 + 1) * places;
        let descriptors = match ingredients.has(Ingredient::Descriptors) {
            false => 0,
            // Beside them, which pixels are plain and which in doubt.
            true => 8 * places + 2 * part + Descriptors::bytes(width),
        };
        // Disparities, reasons and confidence of the left view, filled, its groups, and its fixed point with the
        // columns between. The right view and the disparities between have the memory of the answer.
        let left = (2 * 4 + 1 + 4) * part + 2 * rows_of_part + Groups::bytes(columns, lines);
        let between = match space.apart {
            1 => 0,
            _ => columns_between::Sources::bytes(rows_of_part),
        };
        let prior = ingredients.has(Ingredient::SurfacePrior);
        let choice = ingredients.has(Ingredient::LearnedChoice);
        let right_choice = choice && ingredients.has(Ingredient::RightChoices);
        let prior = match prior {
            false => 0,
            // A surface per pixel and cell.
            true => 12 * (part + columns.div_ceil(4) * lines.div_ceil(4)),
        };
        let right = match right_choice {
            false => 0,
            // The right view filled, its reasons, fixed point and groups.
            true => {
                (4 + 1 + 2) * wide + Groups::bytes(width, lines) + RightChoices::bytes(width, lines)
            }
        };
        // In the right view all columns choose.
        let chosen = if right_choice { width } else { columns };
        let choice = if choice { Choices::bytes(jury, (chosen, lines), width) } else { 0 };
        let least_squares = match ingredients.has(Ingredient::LeastSquares) {
            false => 0,
            true => LeastSquares::bytes(work.columns()),
        };
        let smoothing = match ingredients.has(Ingredient::PlaneSmoothing) {
            false => 0,
            true => PlaneSmoothing::bytes(columns, space.apart),
        };
        let refined = right + choice + smoothing + least_squares;
        // The steps of the guide, and the left view in fixed point with the rows between.
        let spread = part + between + 2 * work.columns() * work.rows();
        let repetition = Repetition::bytes(width, work, frame.range);
        let stages =
            images + flat + features + descriptors + left + prior + refined + repetition + spread;
        let volume = Volume { columns, rows: lines, lanes: space.lanes };
        Self { rest: ANSWER * all + stages + rows(width + space.count, height), volume }
    }

    /// The least that it takes.
    pub fn least(&self) -> usize {
        self.with(Bands::least(&self.volume))
    }

    /// What it takes with these bands.
    fn with(&self, bands: Bands) -> usize {
        self.rest + SemiGlobal::bytes(&self.volume, bands)
    }

    /// The bands with which all of it may be taken.
    pub fn bands(&self, allowance: Allowance) -> Bands {
        let most = allowance.most(UNASKED.max(self.rest + SUMS));
        Bands::within(&self.volume, |bands| self.with(bands) <= most)
    }
}
