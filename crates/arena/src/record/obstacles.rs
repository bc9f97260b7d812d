//! How much of small obstacles an answer misses, and how much of what is around them it takes for some: what a p_bad
//! that forgives 2 px does not see.

use raster::Plane;
use serde::Serialize;

use super::coverage::SURE;
use crate::dataset::CaseData;
use crate::engine::Answer;

/// From how many pixels on obstacles are told apart by their width, and from how many on they are not counted.
pub const WIDTHS: [usize; 4] = [0, 10, 17, usize::MAX];
/// The same of the pixels of disparity by which they stand before what is behind them.
pub const STEPS: [f32; 4] = [0.7, 1.5, 3.0, f32::INFINITY];

/// Fewer pixels of an obstacle do not tell whether it is seen.
const KNOWN: usize = 6;

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
    /// How many obstacles stand that far before what is behind them in the mean of their pixels, of which there are at
    /// least six.
    pub obstacles: usize,
    /// Those of which more than half of these pixels are missed.
    pub overlooked: usize,
}

/// What is around obstacles, and looks nearer than it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FalseAlarms {
    /// By how many pixels of disparity: from the first of [`STEPS`] that they reach, below the next.
    pub from_step: f32,
    /// How many pixels of the scene's box have a truth and show no obstacle.
    pub pixels: usize,
    /// Those whose estimate is nearer by so much.
    pub nearer: usize,
    /// Those of the nearer ones whose confidence is at least [`SURE`], if the engine says how sure it is.
    pub surely: Option<usize>,
}

/// What an answer makes of a pixel of a scene with obstacles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sight {
    /// Of an obstacle, whose disparity is nearer than that of what is behind.
    Seen,
    /// Of an obstacle, as if it were not there.
    Missed,
    /// Of what is around them, and looks nearer than it is by the second of [`STEPS`] and more: by less surfaces are off
    /// as a whole.
    FalseAlarm,
}

/// What it makes of each pixel of the box; nothing of those that count for nothing, nor where no obstacles were laid.
pub fn sights(answer: &Answer, data: &CaseData) -> Option<Plane<Option<Sight>>> {
    let (obstacles, truth) = (data.obstacles.as_ref()?, data.truth.as_ref()?);
    let sight = |x: usize, y: usize| {
        let (truth, behind) = (truth.row(y)[x], obstacles.behind.row(y)[x]);
        let estimate = answer.disparity.row(y)[x];
        if !data.bounds.contains(x, y) || !truth.is_finite() {
            return None;
        }
        if obstacles.things.row(y)[x] == 0 {
            return (estimate - truth >= STEPS[1]).then_some(Sight::FalseAlarm);
        }
        // Neither disparity is known everywhere.
        let is_seen = (estimate - truth).abs() <= (estimate - behind).abs();
        behind.is_finite().then_some(if is_seen { Sight::Seen } else { Sight::Missed })
    };
    Some(Plane::from_fn(truth.columns(), truth.rows(), sight))
}

/// The pixels of one obstacle whose step is known.
#[derive(Debug, Clone, Copy, Default)]
struct Obstacle {
    pixels: usize,
    missed: usize,
    /// The sum of their steps.
    steps: f32,
}

/// What an answer makes of the obstacles of a scene; nothing where none were laid.
pub(super) fn missed(answer: &Answer, data: &CaseData) -> Vec<Missed> {
    let (Some(obstacles), Some(truth), Some(sights)) =
        (&data.obstacles, &data.truth, sights(answer, data))
    else {
        return Vec::new();
    };
    let mut groups = Groups::new(answer.confidence.is_some());
    let mut each = vec![Obstacle::default(); obstacles.widths.len()];
    for (x, y) in data.bounds.pixels() {
        let Some(of) = (obstacles.things.row(y)[x] as usize).checked_sub(1) else { continue };
        let Some(sight) = sights.row(y)[x] else { continue };
        let step = truth.row(y)[x] - obstacles.behind.row(y)[x];
        let is_missed = sight == Sight::Missed;
        each[of].pixels += 1;
        each[of].missed += usize::from(is_missed);
        each[of].steps += step;
        let Some(group) = groups.of(obstacles.widths[of], step) else { continue };
        group.pixels += 1;
        group.missed += usize::from(is_missed);
        if let (Some(confidence), Some(surely)) = (&answer.confidence, &mut group.surely) {
            let is_sure = answer.disparity.row(y)[x].is_finite() && confidence.row(y)[x] >= SURE;
            *surely += usize::from(is_missed && is_sure);
        }
    }
    for (one, &width) in each.iter().zip(&obstacles.widths).filter(|(one, _)| one.pixels >= KNOWN) {
        let Some(group) = groups.of(width, one.steps / one.pixels as f32) else { continue };
        group.obstacles += 1;
        group.overlooked += usize::from(2 * one.missed > one.pixels);
    }
    groups.0
}

/// A group for each width and each step, step after step.
struct Groups(Vec<Missed>);

impl Groups {
    fn new(has_confidence: bool) -> Self {
        let group = |from_width: usize, from_step: f32| Missed {
            from_width,
            from_step,
            pixels: 0,
            missed: 0,
            surely: has_confidence.then_some(0),
            obstacles: 0,
            overlooked: 0,
        };
        let widths = beginnings(&WIDTHS).iter();
        Self(widths.flat_map(|&w| beginnings(&STEPS).iter().map(move |&s| group(w, s))).collect())
    }

    /// Those of a width and a step, unless it is too small.
    fn of(&mut self, width: usize, step: f32) -> Option<&mut Missed> {
        let width = beginnings(&WIDTHS).iter().rposition(|&from| width >= from)?;
        Some(&mut self.0[width * beginnings(&STEPS).len() + step_of(step)?])
    }
}

/// The last of [`STEPS`] that a step reaches.
fn step_of(step: f32) -> Option<usize> {
    beginnings(&STEPS).iter().rposition(|&from| step >= from)
}

/// What an answer takes for obstacles where none are; nothing where none were laid at all.
pub(super) fn false_alarms(answer: &Answer, data: &CaseData) -> Vec<FalseAlarms> {
    let (Some(obstacles), Some(truth)) = (&data.obstacles, &data.truth) else { return Vec::new() };
    let group = |&from_step: &f32| {
        let surely = answer.confidence.as_ref().map(|_| 0);
        FalseAlarms { from_step, pixels: 0, nearer: 0, surely }
    };
    let mut groups: Vec<FalseAlarms> = beginnings(&STEPS).iter().map(group).collect();
    let mut pixels = 0;
    for (x, y) in data.bounds.pixels() {
        let (truth, estimate) = (truth.row(y)[x], answer.disparity.row(y)[x]);
        if obstacles.things.row(y)[x] > 0 || !truth.is_finite() {
            continue;
        }
        pixels += 1;
        // Of a hole nothing is nearer.
        let Some(step) = step_of(estimate - truth) else { continue };
        let group = &mut groups[step];
        group.nearer += 1;
        if let (Some(confidence), Some(surely)) = (&answer.confidence, &mut group.surely) {
            *surely += usize::from(confidence.row(y)[x] >= SURE);
        }
    }
    groups.iter_mut().for_each(|group| group.pixels = pixels);
    groups
}

/// Of a list of ends all but the last begin a group.
fn beginnings<T>(ends: &[T]) -> &[T] {
    &ends[..ends.len() - 1]
}

#[cfg(test)]
mod tests {
    use raster::{DisparityRange, Image};

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
        assert!(missed(&answer, &data).is_empty() && sights(&answer, &data).is_none());
        data.truth = Some(row([6.0, 6.0, 6.0, 6.0, 7.0, hole]));
        data.obstacles = Some(Obstacles {
            behind: row([5.0; 6]),
            things: Plane::new(6, 1, vec![2, 2, 2, 2, 1, 1]).unwrap(),
            widths: vec![17, 9],
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
        // Of four pixels nobody says whether the thing is seen.
        assert!(found.iter().all(|m| m.obstacles == 0));
        let [seen, missed_one] = [Some(Sight::Seen), Some(Sight::Missed)];
        let each = [missed_one, seen, seen, missed_one, missed_one, None];
        assert_eq!(sights(&answer, &data).unwrap().row(0), each);
        let silent = Answer { confidence: None, ..answer };
        assert_eq!(missed(&silent, &data)[0].surely, None);
        data.bounds = raster::BoundingBox::new(1, 0, 2, 0).unwrap();
        assert_eq!((missed(&silent, &data)[0].pixels, missed(&silent, &data)[0].missed), (2, 0));
    }

    #[test]
    fn what_is_missed_by_more_than_half_is_overlooked() {
        let (columns, rows) = (12, 2);
        let image = Image::Grey8(Plane::filled(columns, rows, 0));
        let mut data = CaseData::new(image.clone(), image, DisparityRange::new(0, 9).unwrap());
        // Steps of 1 and 3 px, which are 1.75 px in the mean of all but one that nobody knows.
        let step = |x: usize| if x.is_multiple_of(6) { f32::NAN } else { [1.0, 3.0][x % 2] };
        data.truth = Some(Plane::from_fn(columns, rows, |x, _| 2.0 + step(x)));
        data.obstacles = Some(Obstacles {
            behind: Plane::filled(columns, rows, 2.0),
            things: Plane::from_fn(columns, rows, |x, _| 1 + x as u32 / 6),
            widths: vec![6, 12],
        });
        // Of ten pixels each, five of the first are missed and six of the second.
        let is_missed = |x: usize, y: usize| x < 3 || x == 3 && y == 0 || (8..11).contains(&x);
        let disparity =
            Plane::from_fn(columns, rows, |x, y| if is_missed(x, y) { 2.0 } else { 5.0 });
        let answer = Answer { disparity, reasons: None, confidence: None };
        let found = missed(&answer, &data);
        let overlooked = |from_width| {
            let all = found.iter().filter(|m| m.from_width == from_width && m.obstacles > 0);
            all.map(|m| (m.from_step, m.obstacles, m.overlooked)).collect::<Vec<_>>()
        };
        assert_eq!(overlooked(0), [(1.5, 1, 0)]);
        assert_eq!(overlooked(10), [(1.5, 1, 1)]);
        // Their pixels are told apart by their own steps.
        let pixels: usize = found.iter().filter(|m| m.from_step == 0.7).map(|m| m.pixels).sum();
        assert_eq!(pixels, 8);
    }

    #[test]
    fn what_looks_nearer_beside_obstacles_is_a_false_alarm() {
        let row = |values: [f32; 6]| Plane::new(6, 1, values.to_vec()).unwrap();
        let image = Image::Grey8(Plane::filled(6, 1, 0));
        let mut data = CaseData::new(image.clone(), image, DisparityRange::new(0, 9).unwrap());
        let answer = Answer {
            disparity: row([5.6, 5.8, 9.0, 9.0, f32::NAN, 9.0]),
            reasons: None,
            confidence: Some(row([0.9, 0.5, 0.4, 0.9, 0.9, 0.9])),
        };
        data.truth = Some(row([5.0, 5.0, 5.0, 5.0, 5.0, f32::NAN]));
        assert!(false_alarms(&answer, &data).is_empty());
        data.obstacles = Some(Obstacles {
            behind: row([2.0; 6]),
            things: Plane::new(6, 1, vec![0, 0, 0, 1, 0, 0]).unwrap(),
            widths: vec![9],
        });
        let found = false_alarms(&answer, &data).into_iter();
        let found: Vec<_> = found.map(|f| (f.from_step, f.pixels, f.nearer, f.surely)).collect();
        let expected = [(0.7, 4, 1, Some(1)), (1.5, 4, 0, Some(0)), (3.0, 4, 1, Some(0))];
        assert_eq!(found, expected);
        let far_nearer = sights(&answer, &data).unwrap();
        let [alarm, seen] = [Some(Sight::FalseAlarm), Some(Sight::Seen)];
        assert_eq!(far_nearer.row(0), [None, None, alarm, seen, None, None]);
    }
}
