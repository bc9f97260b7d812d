//! The rounds of choices: one for each judge.

use raster::{Plane, Reason};
use rayon::prelude::*;

use super::candidates::{Given, Scene};
use super::edges::Edges;
use super::lesson::Lesson;
use super::{choose, judges};
use crate::kernels::level::Level;
use crate::profile::Work;
use crate::refinement::median::median_of_map;
use crate::refinement::row_fill::filled;
use crate::refinement::slopes::Slopes;
use crate::selection::cross_check::ViewMap;

/// A match whose disparity changed by more, in pixels, is not confirmed any more.
const CONFIRMED: f32 = 1.0;

/// The memory of the rounds, kept between frames.
#[derive(Default)]
pub(crate) struct Choices {
    /// How sure pixels are: confidence at first, then what the last judge said.
    certainty: Plane<f32>,
    /// The same after the round that runs.
    next: Plane<f32>,
    edges: Edges,
    /// Where judges are taught: what is known when those that there are have spoken.
    lesson: Option<Lesson>,
}

impl Choices {
    /// What they take for a map of so many pixels.
    pub fn bytes(pixels: usize) -> usize {
        2 * size_of::<f32>() * pixels + Edges::bytes(pixels)
    }

    /// With a lesson to be learned from the first frame.
    pub fn teaching(lesson: Lesson) -> Self {
        Self { lesson: Some(lesson), ..Self::default() }
    }

    /// The lesson, learned.
    pub fn into_lesson(self) -> Option<Lesson> {
        self.lesson
    }

    /// Takes the confidence of a map's rows.
    pub fn begin<'a>(
        &mut self,
        (columns, rows): (usize, usize),
        confidence: impl Iterator<Item = &'a [f32]>,
    ) {
        self.certainty.reset(columns, rows, 0.0);
        let to = self.certainty.samples_mut().chunks_exact_mut(columns);
        to.zip(confidence).for_each(|(to, from)| to.copy_from_slice(from));
    }

    /// How sure the last judge was, pixel after pixel.
    pub fn certainty(&self) -> &[f32] {
        self.certainty.samples()
    }

    /// Lets the pixels of `values`, a map without holes, choose. The reasons of `map` are theirs; its
    /// disparities are overwritten.
    pub fn run(
        &mut self,
        level: Level,
        with_last: bool,
        given: &Given<'_>,
        slopes: &mut Slopes,
        values: &mut Plane<f32>,
        map: &mut ViewMap,
    ) -> Work {
        let Self { certainty, next, edges, lesson } = self;
        let ViewMap { values: other, reasons, .. } = map;
        let mut done = edges.compute(given.base, given.first, values.columns());
        let lessons = lesson.as_mut().map(Err);
        for (round, judge) in judges(with_last).iter().map(Ok).chain(lessons).enumerate() {
            if round > 0 {
                done = done + median_of_map(level, values, other);
                std::mem::swap(values, other);
            }
            done = done + slopes.compute(level, values);
            let scene = Scene { values, slopes, reasons, confidence: certainty, edges, given };
            match judge {
                Ok(judge) => done = done + choose(level, judge, &scene, next, other),
                Err(lesson) => {
                    lesson.learn(&scene);
                    break;
                }
            }
            std::mem::swap(values, other);
            std::mem::swap(certainty, next);
            done = done + unconfirm(given, other, values, reasons);
        }
        done
    }
}

/// Says what the pixels of a map are that had the disparities `before`: one that took another is not
/// confirmed any more.
fn unconfirm(
    given: &Given<'_>,
    before: &Plane<f32>,
    now: &Plane<f32>,
    reasons: &mut Plane<Reason>,
) -> Work {
    let (columns, width) = (now.columns(), given.base.columns());
    let rows = reasons.samples_mut().par_chunks_mut(columns).enumerate();
    rows.for_each(|(y, reasons)| {
        let values = before.row(y).iter().zip(now.row(y));
        for ((column, (before, now)), reason) in (given.first..).zip(values).zip(reasons) {
            let hole = match *reason {
                Reason::Matched if (before - now).abs() <= CONFIRMED => continue,
                Reason::Matched | Reason::MismatchedFilled => Reason::MismatchedHole,
                _ => Reason::OccludedHole,
            };
            *reason = filled(width, column, *now, hole);
        }
    });
    Work::bytes(2 * size_of_val(now.samples()) + 2 * size_of_val(reasons.samples()))
}
