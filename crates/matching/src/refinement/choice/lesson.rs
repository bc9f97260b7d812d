//! What a judge is to learn from.

use raster::Plane;

use super::candidates::{Known, Scene};

/// Says which pixels, as `(column, row)`, of a map of disparities.
pub(crate) type Pick = dyn FnMut(&Plane<f32>) -> Vec<(usize, usize)> + Send;

/// Pixels, and what is known of them.
pub(crate) struct Lesson {
    pick: Box<Pick>,
    pub known: Vec<((usize, usize), Known)>,
}

impl Lesson {
    pub fn new(pick: Box<Pick>) -> Self {
        Self { pick, known: Vec::new() }
    }

    /// Picks pixels, and remembers what is known of those that have a choice.
    pub fn learn(&mut self, scene: &Scene<'_>) {
        for (x, y) in (self.pick)(scene.values) {
            let mut known = Known::default();
            if scene.know(x, y, &mut known) {
                self.known.push(((x, y), known));
            }
        }
    }
}
