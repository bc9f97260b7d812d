//! What a judge is to learn from.

use std::ops::Range;

use raster::Plane;

use super::block::{Block, Compared, NONE, OF_PIXEL, Scene};
use super::hint::OF_EACH;
use super::reach::Reach;
use super::undecided::undecided_from;
use super::windows::Windows;
use crate::kernels::level::{Level, at_every_level};

/// A pixel to learn from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pixel {
    /// From the left, from 0.
    pub column: usize,
    /// From the top, from 0.
    pub row: usize,
    /// How many pixels it stands for.
    pub weight: f32,
}

/// A pixel's candidates and what is known of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Known {
    /// Of the candidates' planes, where the pixel lies.
    pub disparities: Vec<f32>,
    /// Whether they come from inside the map.
    pub inside: Vec<bool>,
    /// What is known of each candidate: one thing of all of them, then the next.
    pub of_each: [Vec<f32>; OF_EACH],
    /// What is known of the pixel.
    pub of_pixel: [f32; OF_PIXEL],
}

impl Known {
    /// What is known of a pixel, if it has a choice.
    #[cfg(test)]
    pub(super) fn of(
        level: Level,
        scene: &Scene<'_>,
        reach: &Reach,
        (x, y): (usize, usize),
    ) -> Option<Self> {
        let mut windows = scene.given.grey.map(|image| Windows::new(image.columns()));
        let compared = Compared::rows(level, scene, &mut windows, (y, 1), |_| true);
        known(level, scene, reach, &compared, (x, y))
    }
}

at_every_level! {
    fn known[products](
        scene: &Scene<'_>,
        reach: &Reach,
        compared: &Compared<'_>,
        pixel: (usize, usize),
    ) -> Option<Known> {
        let (mut block, (x, y)) = (Block::default(), pixel);
        let is_asked = undecided_from(scene, reach, pixel)[0] > 0;
        if !is_asked || !block.find(products, scene, reach, &[[x as i32, y as i32]]) {
            return None;
        }
        block.compare(products, scene.given, compared);
        let mut known = Known { of_pixel: block.of_pixel.map(|of| of[0]), ..Known::default() };
        let mut hints = [NONE; OF_EACH];
        for k in 0..block.candidates() {
            known.disparities.push(block.disparities[k][0]);
            known.inside.push(block.inside[k][0] > 0.0);
        }
        for pair in 0..block.candidates() / 2 {
            for (i, votes) in block.votes(products, pair).iter().enumerate() {
                block.hints(products, compared, 2 * pair + i, votes, &mut hints);
                for (of_each, hint) in known.of_each.iter_mut().zip(&hints) {
                    of_each.push(hint[0]);
                }
            }
        }
        Some(known)
    }
}

/// Says which pixels of an image, of whose disparities it is shown every so many-th of every so many-th row.
pub(crate) type Pick = dyn FnMut(&Plane<f32>, usize) -> Vec<Pixel> + Send;

/// Pixels, and what is known of them.
pub(crate) struct Lesson {
    pick: Box<Pick>,
    pub known: Vec<(Pixel, Known)>,
}

impl Lesson {
    pub fn new(pick: impl FnMut(&Plane<f32>, usize) -> Vec<Pixel> + Send + 'static) -> Self {
        Self { pick: Box::new(pick), known: Vec::new() }
    }

    /// Picks pixels of an image, of which these are the disparities of every so many-th of every so many-th row.
    pub fn pick(&mut self, values: &Plane<f32>, every: usize) -> Vec<Pixel> {
        (self.pick)(values, every)
    }

    /// Remembers what is known of the pixels in some rows that have a choice.
    pub fn learn(
        &mut self,
        level: Level,
        scene: &Scene<'_>,
        reach: &Reach,
        pixels: &[Pixel],
        rows: &Range<usize>,
    ) {
        let mut windows = scene.given.grey.map(|image| Windows::new(image.columns()));
        for row in pixels.chunk_by(|one, next| one.row == next.row) {
            let y = row[0].row / reach.every;
            if !rows.contains(&y) {
                continue;
            }
            let compared = Compared::rows(level, scene, &mut windows, (y, 1), |_| true);
            for &pixel in row {
                let known = known(level, scene, reach, &compared, (pixel.column / reach.every, y));
                self.known.extend(known.map(|known| (pixel, known)));
            }
        }
    }
}
