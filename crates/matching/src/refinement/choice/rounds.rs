//! The rounds of choices: one for each judge.

use raster::{Plane, Reason, View};
use rayon::prelude::*;

use super::between::follow;
use super::block::{Given, Scene};
use super::judge::Judge;
use super::jury::Jury;
use super::lesson::Lesson;
use super::strip::Strip;
use super::{Worker, choose};
use crate::kernels::level::Level;
use crate::profile::Work;
use crate::refinement::median::median_of_map;
use crate::refinement::row_fill::filled;
use crate::selection::cross_check::ViewMap;

/// A match whose disparity changed by more, in pixels, is not confirmed any more.
const CONFIRMED: f32 = 1.0;

/// Who looks at the map in a round: a judge, or in the end who is to become one.
enum Turn<'a> {
    Judge(&'a Judge),
    Lesson(&'a mut Lesson),
}

/// The rounds of a jury with their memory, kept between frames.
pub(crate) struct Choices {
    jury: &'static Jury,
    /// How sure pixels are: what the last judge said.
    certainty: Plane<f32>,
    /// The same after the round that runs.
    next: Plane<f32>,
    strip: Strip,
    /// One for each thread.
    workers: Vec<Worker>,
    /// Where judges are taught: what is known when those that there are have spoken.
    lesson: Option<Lesson>,
}

impl Choices {
    /// What they take for a map of so many columns and rows, in images of a width.
    pub fn bytes(jury: &Jury, (columns, rows): (usize, usize), width: usize) -> usize {
        let certainty = jury.judges(true).len().min(2) * size_of::<f32>() * columns * rows;
        let workers = rayon::current_num_threads() * Worker::bytes(width);
        certainty + Strip::bytes(columns, rows, width, jury.reach) + workers
    }

    pub fn new(jury: &'static Jury) -> Self {
        Self {
            jury,
            certainty: Plane::default(),
            next: Plane::default(),
            strip: Strip::default(),
            workers: Vec::new(),
            lesson: None,
        }
    }

    /// Who judges.
    pub fn jury(&self) -> &'static Jury {
        self.jury
    }

    /// With a lesson to be learned from the first frame.
    pub fn teaching(self, lesson: Lesson) -> Self {
        Self { lesson: Some(lesson), ..self }
    }

    /// The lesson, learned.
    pub fn into_lesson(self) -> Option<Lesson> {
        self.lesson
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
        confidence: View<'_, f32>,
        values: &mut Plane<f32>,
        map: &mut ViewMap,
    ) -> Work {
        let Self { jury, certainty, next, strip, workers, lesson } = self;
        let reach = jury.reach;
        workers.resize_with(rayon::current_num_threads(), Default::default);
        workers.iter_mut().for_each(|worker| worker.reset(given.grey[0].columns()));
        let ViewMap { values: other, reasons, .. } = map;
        let (columns, rows) = values.size();
        let mut done = Work::bytes(0);
        let turns = jury.judges(with_last).iter().map(Turn::Judge);
        let turns = turns.chain(lesson.as_mut().map(Turn::Lesson));
        for (round, turn) in turns.enumerate() {
            match round {
                // What the last frame left is not read any more: a single round needs one plane.
                0 => {
                    std::mem::swap(certainty, next);
                    other.reset(columns, rows, 0.0);
                }
                _ => {
                    done = done + median_of_map(level, values, other);
                    std::mem::swap(values, other);
                }
            }
            let confidence = if round == 0 { confidence } else { certainty.view() };
            let judge = match turn {
                Turn::Judge(judge) => judge,
                Turn::Lesson(lesson) => {
                    let pixels = lesson.pick(values);
                    for rows in Strip::all(rows) {
                        strip.compute(level, given, reach, values, &rows);
                        let scene = Scene { values, reasons, confidence, strip, given };
                        lesson.learn(level, &scene, reach, &pixels, &rows);
                    }
                    break;
                }
            };
            next.reset(columns, rows, 1.0);
            for rows in Strip::all(rows) {
                done = done + strip.compute(level, given, reach, values, &rows);
                let scene = Scene { values, reasons, confidence, strip, given };
                done = done + choose(level, (reach, judge), &scene, rows, workers, next, other);
            }
            if reach.every > 1 {
                done = done + follow(level, given, values, next, other);
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
    let (columns, width) = (now.columns(), given.grey[0].columns());
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
