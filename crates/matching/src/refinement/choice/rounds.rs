//! The rounds of choices, one for each judge: all pixels first, then those that see where the map moved.

use raster::{Plane, Reason};
use rayon::prelude::*;

use super::block::{Given, Scene};
use super::certainty;
use super::jury::Jury;
use super::lesson::Lesson;
use super::moved::Moved;
use super::reach::Reach;
use super::strip::Strip;
use super::{Worker, choose};
use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;
use crate::refinement::median::median_of_map;
use crate::refinement::row_fill::filled;
use crate::refinement::spared;
use crate::selection::cross_check::ViewMap;

/// A match whose disparity changed by more, in pixels, is not confirmed any more.
const CONFIRMED: f32 = 1.0;
/// So many pixels are looked at together: mostly all of them are.
const TOGETHER: usize = 64;

/// The rounds of a jury with their memory, kept between frames.
pub(crate) struct Choices {
    jury: &'static Jury,
    /// Whether medians between the rounds spare what is near.
    spares: bool,
    /// How sure pixels are, in bytes: what the last judge said, before the first one the paths.
    certainty: Plane<u8>,
    /// The same after the round that runs.
    next: Plane<u8>,
    moved: Moved,
    strip: Strip,
    /// One for each thread.
    workers: Vec<Worker>,
    /// Where judges are taught: what is known when those that there are have spoken.
    lesson: Option<Lesson>,
}

impl Choices {
    /// What they take for a map of so many columns and rows, in images of a width.
    pub fn bytes(jury: &Jury, (columns, rows): (usize, usize), width: usize) -> usize {
        let pixels = columns * rows;
        let maps = 2 * size_of::<u8>() * pixels + Moved::bytes(pixels);
        let workers = rayon::current_num_threads() * Worker::bytes(columns, width);
        maps + Strip::bytes(columns, rows, width, jury.reach) + workers
    }

    /// Of a jury, between whose rounds medians spare what is near or do not.
    pub fn new(jury: &'static Jury, spares: bool) -> Self {
        Self {
            jury,
            spares,
            certainty: Plane::default(),
            next: Plane::default(),
            moved: Moved::default(),
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

    /// How sure the last judge was, pixel after pixel, as a [share](super::certainty::share).
    pub fn certainty(&self) -> &[u8] {
        self.certainty.samples()
    }

    /// Lets the pixels of `values`, a map without holes, choose, in so many rounds if the jury has as many.
    /// The reasons of `map` are theirs; its disparities are overwritten. The columns and rows of the map stand as far
    /// apart in the image as the jury wants.
    pub fn run(
        &mut self,
        level: Level,
        rounds: usize,
        given: &Given<'_>,
        confidence: &Plane<f32>,
        values: &mut Plane<f32>,
        map: &mut ViewMap,
    ) -> Work {
        let ViewMap { values: other, reasons, .. } = map;
        let Self { jury, spares, certainty, next, moved, strip, workers, .. } = self;
        let reach = jury.reach;
        let (columns, rows) = values.size();
        workers.resize_with(rayon::current_num_threads(), Default::default);
        workers.iter_mut().for_each(|worker| worker.reset(columns, given.grey[0].columns()));
        other.reshape(columns, rows, 0.0);
        next.reshape(columns, rows, 0);
        let mut done = keep(confidence, certainty);
        let several = Strip::all(rows).count() > 1;
        for (round, judge) in jury.judges.iter().take(rounds).enumerate() {
            if round > 0 {
                done = done + moved.find(level, other, values);
                done = done + smooth(level, reach, *spares, reasons, values, other);
            }
            for rows in Strip::all(rows) {
                // What is seen of the images stays.
                if round == 0 || several {
                    done = done + strip.look(level, given, reach, values.size(), &rows);
                }
                done = done + strip.know(level, given, values, certainty, reasons);
                let scene = Scene { values, reasons, certainty, strip, given };
                let moved = (round > 0).then_some(&*moved);
                let judge = (reach, judge);
                done = done + choose(level, judge, &scene, moved, rows, workers, next, other);
            }
            std::mem::swap(values, other);
            std::mem::swap(certainty, next);
            done = done + unconfirm(level, given, reach, other, values, reasons);
        }
        done
    }

    /// Learns, where there is a lesson, from what is known after these rounds.
    pub fn learn(
        &mut self,
        level: Level,
        given: &Given<'_>,
        values: &mut Plane<f32>,
        map: &mut ViewMap,
    ) {
        let Self { jury, spares, certainty, strip, lesson: Some(lesson), .. } = self else {
            return;
        };
        let ViewMap { values: other, reasons, .. } = map;
        if !jury.judges.is_empty() {
            smooth(level, jury.reach, *spares, reasons, values, other);
        }
        let pixels = lesson.pick(values, jury.reach.every);
        for rows in Strip::all(values.rows()) {
            strip.look(level, given, jury.reach, values.size(), &rows);
            strip.know(level, given, values, certainty, reasons);
            let scene = Scene { values, reasons, certainty, strip, given };
            lesson.learn(level, &scene, jury.reach, &pixels, &rows);
        }
    }
}

/// Takes out what stands alone between two rounds, and nothing that is [`spared`] if something is.
fn smooth(
    level: Level,
    reach: &Reach,
    spares: bool,
    reasons: &Plane<Reason>,
    values: &mut Plane<f32>,
    other: &mut Plane<f32>,
) -> Work {
    if !reach.smooths() {
        return Work::default();
    }
    let mut done = median_of_map(level, values, other);
    if spares {
        done = done + spared::spare_map(level, values, reasons, other);
    }
    std::mem::swap(values, other);
    done
}

/// Keeps in bytes how sure the paths are.
fn keep(confidence: &Plane<f32>, certainty: &mut Plane<u8>) -> Work {
    let (columns, rows) = confidence.size();
    certainty.reshape(columns, rows, 0);
    let lines = certainty.samples_mut().par_chunks_mut(columns);
    let lines = lines.zip(confidence.samples().par_chunks(columns));
    lines.for_each(|(certainty, confidence)| {
        for (byte, &share) in certainty.iter_mut().zip(confidence) {
            *byte = certainty::byte(share);
        }
    });
    Work::bytes((size_of::<f32>() + size_of::<u8>()) * certainty.samples().len())
}

/// Says what the pixels of a map are that had the disparities `before`: one that took another is not confirmed any
/// more. Where the map was not smoothed either, those that kept theirs are what they were.
fn unconfirm(
    level: Level,
    given: &Given<'_>,
    reach: &Reach,
    before: &Plane<f32>,
    now: &Plane<f32>,
    reasons: &mut Plane<Reason>,
) -> Work {
    let image = (given.grey[0].columns(), given.first, reach.every);
    let columns = now.columns();
    let rows = reasons.samples_mut().par_chunks_mut(columns).enumerate();
    rows.for_each(|(y, reasons)| {
        unconfirm_row(level, image, reach.smooths(), before.row(y), now.row(y), reasons);
    });
    Work::bytes(2 * size_of_val(now.samples()) + 2 * size_of_val(reasons.samples()))
}

at_every_level! {
    /// A row, of an image of a width; it begins at a column, and has every so many-th.
    fn unconfirm_row(
        image: (usize, usize, usize),
        smoothed: bool,
        before: &[f32],
        now: &[f32],
        reasons: &mut [Reason],
    ) {
        let (width, start, every) = image;
        for first in (0..reasons.len()).step_by(TOGETHER) {
            let end = reasons.len().min(first + TOGETHER);
            let (before, now) = (&before[first..end], &now[first..end]);
            let reasons = &mut reasons[first..end];
            let mut same = 0;
            for ((before, now), reason) in before.iter().zip(now).zip(&*reasons) {
                let confirmed = ((before - now).abs() <= CONFIRMED) & (*reason == Reason::Matched);
                same += u32::from(confirmed | !smoothed & (before == now));
            }
            if same as usize == now.len() {
                continue;
            }
            for (i, reason) in reasons.iter_mut().enumerate() {
                let hole = match *reason {
                    _ if !smoothed & (before[i] == now[i]) => continue,
                    Reason::Matched if (before[i] - now[i]).abs() <= CONFIRMED => continue,
                    Reason::Matched | Reason::MismatchedFilled => Reason::MismatchedHole,
                    _ => Reason::OccludedHole,
                };
                *reason = filled(width, start + every * (first + i), now[i], hole);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use Reason::{Matched, MismatchedFilled, OccludedFilled, OccludedHole, OutsideRightFilled};

    /// Columns of the image, the map's first one, and how far they are apart.
    const IMAGES: [(usize, usize, usize); 3] = [(150, 0, 1), (400, 3, 2), (290, 1, 2)];

    /// What a pixel is in column `x` of the image.
    fn definition(
        width: usize,
        x: usize,
        smoothed: bool,
        (before, now): (f32, f32),
        reason: Reason,
    ) -> Reason {
        let stays = !smoothed && before == now;
        let is_confirmed = reason == Matched && (before - now).abs() <= 1.0;
        let right = x as f32 - now;
        match reason {
            reason if stays || is_confirmed => reason,
            _ if right < -0.5 || right > width as f32 - 0.5 => OutsideRightFilled,
            Matched | MismatchedFilled => MismatchedFilled,
            _ => OccludedFilled,
        }
    }

    #[test]
    fn a_case_worked_by_hand() {
        // Kept; moved within a pixel; farther; filled ones that moved, the last out of the right image.
        let before = [5.0, 5.0, 5.0, 5.0, 5.0, 5.0];
        let now = [5.0, 6.0, 6.5, 5.5, 5.5, 105.5];
        let reasons = [Matched, Matched, Matched, MismatchedFilled, OutsideRightFilled, Matched];
        for level in Level::available() {
            let mut found = reasons;
            unconfirm_row(level, (200, 20, 2), false, &before, &now, &mut found);
            let moved = [MismatchedFilled, MismatchedFilled, OccludedFilled, OutsideRightFilled];
            assert_eq!(found[..2], [Matched; 2]);
            assert_eq!(found[2..], moved);
        }
    }

    #[test]
    fn reasons_after_a_round_are_their_definition_at_every_level() {
        let all = [Matched, MismatchedFilled, OccludedFilled, OutsideRightFilled, OccludedHole];
        for smoothed in [false, true] {
            for (width, first, every) in IMAGES {
                let mut chance = Chance(7);
                let columns = 150.min(width.div_ceil(every));
                // Parts in which all are confirmed, in which some moved, and in which nearly all did.
                let moves = [0.0, 0.1, 0.9];
                let mut pixel = |x: usize| {
                    let before = (40.0 * chance.share()).round() / 4.0 + 8.0;
                    let by = [0.25, -1.0, 1.25, 9.0, -60.0, 300.0][x % 6];
                    let moved = chance.share().abs() < moves[x / TOGETHER % 3];
                    let reason = if x < TOGETHER { Matched } else { all[x * 7 % 5] };
                    (before, if moved { before + by } else { before }, reason)
                };
                let row: Vec<(f32, f32, Reason)> = (0..columns).map(&mut pixel).collect();
                let before: Vec<f32> = row.iter().map(|pixel| pixel.0).collect();
                let now: Vec<f32> = row.iter().map(|pixel| pixel.1).collect();
                let expected: Vec<Reason> = (row.iter().enumerate())
                    .map(|(i, &(before, now, reason))| {
                        let x = first + every * i;
                        definition(width, x, smoothed, (before, now), reason)
                    })
                    .collect();
                for reason in [Matched, MismatchedFilled, OccludedFilled, OutsideRightFilled] {
                    assert!(expected.contains(&reason), "{reason:?} of {width} columns");
                }
                for level in Level::available() {
                    let mut reasons: Vec<Reason> = row.iter().map(|pixel| pixel.2).collect();
                    let image = (width, first, every);
                    unconfirm_row(level, image, smoothed, &before, &now, &mut reasons);
                    assert_eq!(reasons, expected, "{width} columns, level {}", level.name());
                }
            }
        }
    }
}
