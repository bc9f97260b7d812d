//! How much of small obstacles an answer misses: what a p_bad that forgives 2 px does not see.

use serde::Serialize;

use super::coverage::SURE;
use crate::dataset::CaseData;
use crate::engine::Answer;

/// From how many pixels on obstacles are told apart by their width, and from how many on they are not counted.
pub const WIDTHS: [usize; 4] = [0, 10, 17, usize::MAX];
/// The same of the pixels of disparity by which they stand before what is behind them.
pub const STEPS: [f32; 4] = [0.7, 1.5, 3.0, f32::INFINITY];

/// What became of obstacles of some width that stand some way before what is behind them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Missed {
    /// Their width in pixels: from the first of [`WIDTHS`] that they reach, below the next.
    pub from_width: usize,
    /// By how much they stand before what is behind them, in the same way of [`STEPS`].
    pub from_step: f32,
    /// How many pixels they have in the scene's box.
    pub pixels: usize,
    /// Those whose estimate is nearer to what is behind than to the obstacle, or missing.
    pub missed: usize,
    /// Those of the missed ones whose confidence is at least [`SURE`], if the engine says how sure it is.
    pub surely: Option<usize>,
}

/// What an answer makes of the obstacles of a scene; nothing where none were laid.
pub(super) fn missed(answer: &Answer, data: &CaseData) -> Vec<Missed> {
    let (Some(obstacles), Some(truth)) = (&data.obstacles, &data.truth) else { return Vec::new() };
    // Of either list all but the last begin a group.
    let [widths, steps] = [WIDTHS.len() - 1, STEPS.len() - 1];
    let group = |from_width: usize, from_step: f32| {
        let surely = answer.confidence.as_ref().map(|_| 0);
        Missed { from_width, from_step, pixels: 0, missed: 0, surely }
    };
    let groups =
        WIDTHS[..widths].iter().flat_map(|&w| STEPS[..steps].iter().map(move |&s| group(w, s)));
    let mut groups: Vec<Missed> = groups.collect();
    for (x, y) in data.bounds.pixels() {
        let width = usize::from(obstacles.widths.row(y)[x]);
        if width == 0 {
            continue;
        }
        let (truth, behind) = (truth.row(y)[x], obstacles.behind.row(y)[x]);
        let step = truth - behind;
        let width = WIDTHS[..widths].iter().rposition(|&from| width >= from);
        // Neither disparity is known everywhere, and what is not a number or finite is in no range.
        let step = STEPS[..steps].iter().rposition(|&from| (from..STEPS[steps]).contains(&step));
        let (Some(width), Some(step)) = (width, step) else { continue };
        let group = &mut groups[width * steps + step];
        group.pixels += 1;
        let estimate = answer.disparity.row(y)[x];
        if (estimate - truth).abs() <= (estimate - behind).abs() {
            continue;
        }
        group.missed += 1;
        if let (Some(confidence), Some(surely)) = (&answer.confidence, &mut group.surely) {
            *surely += usize::from(estimate.is_finite() && confidence.row(y)[x] >= SURE);
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use raster::{DisparityRange, Image, Plane};

    use super::*;
    use crate::dataset::Obstacles;

    #[test]
    fn what_is_nearer_to_the_ground_is_missed() {
        let image = Image::Grey8(Plane::filled(6, 1, 0));
        let mut data = CaseData::new(image.clone(), image, DisparityRange::new(0, 9).unwrap());
        let row = |values: [f32; 6]| Plane::new(6, 1, values.to_vec()).unwrap();
        let hole = f32::NAN;
        let answer = Answer {
            disparity: row([5.4, 6.0, 5.6, hole, 5.0, 5.0]),
            reasons: None,
            confidence: Some(row([0.5, 0.9, 0.9, 0.9, 0.4, 0.9])),
        };
        assert!(missed(&answer, &data).is_empty());
        data.truth = Some(row([6.0, 6.0, 6.0, 6.0, 7.0, hole]));
        data.obstacles = Some(Obstacles {
            behind: row([5.0; 6]),
            widths: Plane::new(6, 1, vec![9, 9, 9, 9, 17, 17]).unwrap(),
        });
        let found = missed(&answer, &data);
        assert_eq!(found.len(), 9);
        let of = |width, step: f32| {
            let group = found.iter().find(|m| (m.from_width, m.from_step) == (width, step));
            group.map(|m| (m.pixels, m.missed, m.surely)).unwrap()
        };
        assert_eq!(of(0, 0.7), (4, 2, Some(1)));
        assert_eq!(of(17, 1.5), (1, 1, Some(0)));
        assert_eq!(of(10, 0.7), (0, 0, Some(0)));
        let silent = Answer { confidence: None, ..answer };
        assert_eq!(missed(&silent, &data)[0].surely, None);
        data.bounds = raster::BoundingBox::new(1, 0, 2, 0).unwrap();
        assert_eq!((missed(&silent, &data)[0].pixels, missed(&silent, &data)[0].missed), (2, 0));
    }
}
