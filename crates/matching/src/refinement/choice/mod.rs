//! Pixels that are not settled choose among the planes around them, and a learned judge says which.
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
//! threads. What a pixel takes is what its neighbours choose from in the next round, so what is right
//! spreads. Each round has a judge of its own (`jury`); after the first one it is asked only where the
//! map moved in the round before (`rounds`).

mod block;
pub(crate) mod certainty;
mod edges;
mod hint;
mod judge;
mod jury;
mod lesson;
mod looks;
mod moved;
mod notes;
mod reach;
mod relations;
mod rounds;
mod slopes;
mod strip;
mod undecided;
mod verdict;
mod windows;

use std::ops::Range;
use std::sync::Mutex;

use raster::Plane;
use rayon::prelude::*;

pub(crate) use self::block::Given;
use self::block::{Block, Compared, LANES, Scene};
use self::certainty::CERTAIN;
use self::judge::{Judge, Mind};
pub(crate) use self::jury::Jury;
pub(crate) use self::lesson::Lesson;
pub use self::lesson::{Known, Pixel};
use self::moved::Moved;
use self::notes::Notes;
use self::reach::Reach;
pub(crate) use self::rounds::Choices;
use self::verdict::{Verdict, verdict};
use self::windows::Windows;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::products::Products;
use crate::profile::Work;

/// So many rows are worked on together: pixels that are not settled are gathered into full blocks, and the last one of
/// a row mostly is not full.
const TOGETHER: usize = 8;

/// The memory of what is done some rows at a time.
#[derive(Default)]
pub(crate) struct Worker {
    /// Of the left and of the right image.
    windows: [Windows; 2],
    /// Which pixels of these rows are asked, and how many of their places moved, of one row.
    marks: Vec<bool>,
    counts: Vec<u8>,
    /// Those of them that are not settled.
    unsettled: Vec<undecided::At>,
    block: Block,
    mind: Mind,
}

impl Worker {
    /// What it takes for a map of so many columns, in images of a width.
    fn bytes(columns: usize, width: usize) -> usize {
        let marks = TOGETHER * (size_of::<bool>() + size_of::<undecided::At>()) + 1;
        size_of::<Self>() + 2 * Windows::bytes(width, TOGETHER) + marks * columns
    }

    /// Takes it, whether there will be rows to do or not.
    fn reset(&mut self, columns: usize, width: usize) {
        self.windows.iter_mut().for_each(|windows| windows.reset(width, TOGETHER));
        taken(&mut self.marks, TOGETHER * columns, true);
        taken(&mut self.counts, columns, 0);
        taken(&mut self.unsettled, TOGETHER * columns, [0; 2]);
    }
}

/// Takes memory for so many samples and no more.
fn taken<T: Copy>(samples: &mut Vec<T>, count: usize, value: T) {
    samples.clear();
    samples.reserve_exact(count);
    samples.resize(count, value);
}

/// Lets the pixels of some rows of `scene` choose, into `out`: all, or those that see where the map `moved`
/// in the round before. `certainty` says how sure the judge is where there is anything to choose. Each of
/// the `workers` takes a few rows after the others until none are left: where a map is wrong there is more to
/// choose, so equal parts would not be done at the same time. Every second one begins at the other end: what it has
/// noted of these rows is in its processor's own cache.
fn choose(
    level: Level,
    (reach, judge): (&Reach, &Judge),
    scene: &Scene<'_>,
    moved: Option<&Moved>,
    rows: Range<usize>,
    workers: &mut [Worker],
    certainty: &mut Plane<u8>,
    out: &mut Plane<f32>,
) -> Work {
    let columns = scene.values.columns();
    let samples = rows.start * columns..rows.end * columns;
    let certainty = certainty.samples_mut()[samples.clone()].chunks_mut(TOGETHER * columns);
    let lines = out.samples_mut()[samples.clone()].chunks_mut(TOGETHER * columns).zip(certainty);
    let lines = Mutex::new(rows.step_by(TOGETHER).zip(lines));
    let next = |from_top: bool| {
        let mut lines = lines.lock().expect("no worker fails while it takes rows");
        if from_top { lines.next() } else { lines.next_back() }
    };
    let chosen = workers.par_iter_mut().enumerate().map(|(i, worker)| {
        let Worker { windows, marks, counts, unsettled, block, mind } = worker;
        let mut chosen = 0;
        while let Some((first, (out, certainty))) = next(i.is_multiple_of(2)) {
            let before = first * columns..first * columns + out.len();
            out.copy_from_slice(&scene.values.samples()[before.clone()]);
            match moved {
                None => certainty.fill(CERTAIN),
                Some(_) => certainty.copy_from_slice(&scene.certainty.samples()[before]),
            }
            let marks = &mut marks[..out.len()];
            let mut any = moved.is_none();
            if let Some(moved) = moved {
                for (row, marks) in marks.chunks_exact_mut(columns).enumerate() {
                    any |= moved.seen_from(level, reach, first + row, counts, marks);
                }
            }
            if !any {
                continue;
            }
            let count = undecided::undecided(level, scene, reach, first, marks, unsettled);
            let pixels = &unsettled[..count];
            let mut wanted = [false; TOGETHER];
            pixels.iter().for_each(|&[_, row]| wanted[row as usize - first] = true);
            let rows = (first, out.len() / columns);
            let compared = Compared::rows(level, scene, windows, rows, |row| wanted[row]);
            let (judge, memory) = ((reach, judge), (&mut *block, &mut *mind));
            let answer = (first, &mut *out, certainty);
            chosen += choose_for(level, judge, scene, &compared, pixels, memory, answer);
        }
        chosen
    });
    // Values are copied, certainty written. In rows that are asked, values and slopes are read for who is not settled,
    // then notes, the edges of two ways more and the right view, the choice is written; reasons and the looks of both
    // views are bytes.
    Work::bytes((2 * 4 + 1 + 2 * 4 + Notes::bytes(1) + 2 * 2 + 2 * 4 + 1 + 2 * 3) * samples.len())
        + judge.work() * chosen.sum::<usize>()
}

at_every_level! {
    /// Lets these pixels choose, into some rows of disparities and of certainty, of which the first one is told; how
    /// many had a choice.
    fn choose_for[products](
        judge: (&Reach, &Judge),
        scene: &Scene<'_>,
        compared: &Compared<'_>,
        pixels: &[undecided::At],
        memory: (&mut Block, &mut Mind),
        answer: (usize, &mut [f32], &mut [u8]),
    ) -> usize {
        let ((reach, judge), (block, mind), (first, out, certainty)) = (judge, memory, answer);
        let columns = scene.values.columns();
        let mut chosen = 0;
        for pixels in pixels.chunks(LANES) {
            if !block.find(products, scene, reach, pixels) {
                continue;
            }
            let verdict = decide(products, judge, scene.given, compared, block, mind);
            for (l, &[column, row]) in pixels.iter().enumerate() {
                if block.open[l] {
                    let pixel = (row as usize - first) * columns + column as usize;
                    out[pixel] = verdict.disparity[l];
                    certainty[pixel] = certainty::byte(verdict.certainty[l]);
                    chosen += 1;
                }
            }
        }
        chosen
    }
}

/// What a judge says of pixels.
#[inline(always)]
fn decide(
    products: impl Products,
    judge: &Judge,
    given: &Given<'_>,
    compared: &Compared<'_>,
    block: &mut Block,
    mind: &mut Mind,
) -> Verdict {
    block.compare(products, given, compared);
    let pairs = block.candidates() / 2;
    // Where nobody has to hear all candidates first, hints are used before they leave the nearest cache.
    if judge.has_context() {
        for pair in 0..pairs {
            hear(products, block, compared, pair, 2 * pair, mind);
        }
        judge.look(products, &block.of_pixel, mind);
        for pair in 0..pairs {
            judge.score(products, 2 * pair, 2 * pair, mind);
        }
    } else {
        judge.look(products, &block.of_pixel, mind);
        for pair in 0..pairs {
            hear(products, block, compared, pair, 0, mind);
            judge.score(products, 2 * pair, 0, mind);
        }
    }
    let Mind { scores, odds, .. } = mind;
    verdict(products, block, scores, odds)
}

/// Lets the mind hear of a pair of candidates, after so many others.
#[inline(always)]
fn hear(
    products: impl Products,
    block: &Block,
    compared: &Compared<'_>,
    pair: usize,
    others: usize,
    mind: &mut Mind,
) {
    let votes = block.votes(products, pair);
    for i in 0..2 {
        block.hints(products, compared, 2 * pair + i, &votes[i], &mut mind.hints);
        mind.hear(products, others + i);
    }
}

#[cfg(test)]
mod tests;
