//! What a judge is to learn from.

use raster::Plane;

use super::candidates::{Known, Scene};

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

/// Says which pixels of a map of disparities.
pub(crate) type Pick = dyn FnMut(&Plane<f32>) -> Vec<Pixel> + Send;

/// Pixels, and what is known of them.
pub(crate) struct Lesson {
    pick: Box<Pick>,
    pub known: Vec<(Pixel, Known)>,
}

impl Lesson {
    pub fn new(pick: impl FnMut(&Plane<f32>) -> Vec<Pixel> + Send + 'static) -> Self {
        Self { pick: Box::new(pick), known: Vec::new() }
    }

    /// Picks pixels, and remembers what is known of those that have a choice.
    pub fn learn(&mut self, scene: &Scene<'_>) {
        for pixel in (self.pick)(scene.values) {
            let mut known = Known::default();
            if scene.know(pixel.column, pixel.row, &mut known) {
                self.known.push((pixel, known));
            }
        }
    }
}
