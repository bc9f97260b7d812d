#![doc = include_str!("fast.md")]

use raster::{DisparityMap, Reason};

use crate::MatchError;
use crate::matcher::{Frame, Pipeline};

/// The stages of `fast` and their memory.
#[derive(Default)]
pub(crate) struct Fast {}

impl Pipeline for Fast {
    fn run(&mut self, frame: &Frame<'_>, map: &mut DisparityMap) -> Result<(), MatchError> {
        let b = frame.bounds;
        for y in b.y0..=b.y1 {
            map.values.row_mut(y)[b.x0..=b.x1].fill(frame.range.min() as f32);
            map.reasons.row_mut(y)[b.x0..=b.x1].fill(Reason::Matched);
        }
        Ok(())
    }
}
