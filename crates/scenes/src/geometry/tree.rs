//! A tree of boxes that finds the few shapes near a ray.
//!
//! A bounding volume hierarchy, split where the surface area heuristic (MacDonald & Booth 1990)
//! expects the fewest questions: the sum over both halves of surface times number of boxes is
//! smallest. It decides only in which order shapes are asked, so it never changes an answer.

use super::{Bounds, Ray};

/// At most this many boxes are asked one by one.
const LEAF: usize = 2;
/// Below this depth halves are made equal in number, so that no tree outgrows the walk's stack.
const CAREFUL: usize = 24;
/// Room for [`CAREFUL`] levels and as many as halving 2^32 boxes takes.
const STACK: usize = CAREFUL + 33;

#[derive(Debug, Clone, PartialEq)]
struct Node {
    bounds: Bounds,
    /// A leaf's shapes are `order[first..first + count]`; an inner node has count 0, its lower
    /// half right behind it, and its other half at `first`.
    first: u32,
    count: u32,
}

/// Boxes within boxes, over shapes known by their number.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Tree {
    /// The tree over boxes, each with the number of the shape that it holds a part of.
    pub fn over(mut boxes: Vec<(Bounds, u32)>) -> Self {
        let mut tree = Self { nodes: Vec::new(), order: Vec::with_capacity(boxes.len()) };
        if !boxes.is_empty() {
            tree.split(&mut boxes, 0);
        }
        tree
    }

    fn split(&mut self, boxes: &mut [(Bounds, u32)], depth: usize) {
        let here = self.nodes.len();
        let bounds = boxes.iter().fold(Bounds::NOTHING, |all, b| all.with(b.0));
        let (first, count) = (self.order.len() as u32, boxes.len() as u32);
        self.nodes.push(Node { bounds, first, count });
        if boxes.len() <= LEAF {
            self.order.extend(boxes.iter().map(|b| b.1));
            return;
        }
        let (axis, middle) = if depth < CAREFUL { best_split(boxes) } else { (0, boxes.len() / 2) };
        sort(boxes, axis);
        let (low, high) = boxes.split_at_mut(middle);
        self.split(low, depth + 1);
        self.nodes[here] = Node { bounds, first: self.nodes.len() as u32, count: 0 };
        self.split(high, depth + 1);
    }

    /// Asks `shape(number, before)` of every shape whose box the ray passes between `after` and
    /// the nearest meeting so far, which is what `shape` returns: the new `before`.
    #[inline]
    pub fn walk(
        &self,
        ray: &Ray,
        after: f64,
        before: f64,
        mut shape: impl FnMut(usize, f64) -> f64,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let prepared = ray.prepared();
        let mut before = before;
        let mut at = 0;
        // Halves yet to be visited, and where the ray enters them.
        let mut stack = [(0, 0.0); STACK];
        let mut waiting = 0;
        loop {
            let node = &self.nodes[at];
            if node.count == 0 {
                let (low, high) = (at + 1, node.first as usize);
                let enter = |i: usize| Some(self.nodes[i].bounds.span(&prepared, after, before)?.0);
                match (enter(low), enter(high)) {
                    (Some(a), Some(b)) => {
                        // The nearer half first: what it finds may spare the other.
                        stack[waiting] = if a <= b { (high, b) } else { (low, a) };
                        waiting += 1;
                        at = if a <= b { low } else { high };
                        continue;
                    }
                    (Some(_), None) => {
                        at = low;
                        continue;
                    }
                    (None, Some(_)) => {
                        at = high;
                        continue;
                    }
                    (None, None) => {}
                }
            } else {
                let first = node.first as usize;
                for &number in &self.order[first..first + node.count as usize] {
                    before = shape(number as usize, before);
                }
            }
            loop {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                if stack[waiting].1 < before {
                    at = stack[waiting].0;
                    break;
                }
            }
        }
    }
}

fn sort(boxes: &mut [(Bounds, u32)], axis: usize) {
    boxes.sort_by(|a, b| a.0.doubled_centre(axis).total_cmp(&b.0.doubled_centre(axis)));
}

/// The axis to sort along, and how many boxes belong to the lower half.
fn best_split(boxes: &mut [(Bounds, u32)]) -> (usize, usize) {
    let mut best = (f64::INFINITY, 0, boxes.len() / 2);
    let mut below = vec![0.0; boxes.len()];
    for axis in 0..3 {
        sort(boxes, axis);
        let mut bounds = Bounds::NOTHING;
        for (i, b) in boxes.iter().enumerate() {
            below[i] = bounds.area() * i as f64;
            bounds = bounds.with(b.0);
        }
        bounds = Bounds::NOTHING;
        for i in (1..boxes.len()).rev() {
            bounds = bounds.with(boxes[i].0);
            let cost = below[i] + bounds.area() * (boxes.len() - i) as f64;
            if cost < best.0 {
                best = (cost, axis, i);
            }
        }
    }
    (best.1, best.2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Shape, Sphere};
    use crate::random::Random;

    #[test]
    fn the_tree_finds_what_asking_everyone_finds() {
        let mut random = Random::new(2, "test");
        for count in [0, 1, 2, 3, 7, 300] {
            let shapes: Vec<Shape> = (0..count)
                .map(|_| Sphere::new(random.direction() * random.between(1.0, 5.0), 0.3).into())
                .collect();
            let boxes = shapes.iter().zip(0..).map(|(shape, i)| (shape.bounds(), i)).collect();
            let tree = Tree::over(boxes);
            let mut met = 0;
            for _ in 0..500 {
                let origin = random.direction() * 7.0;
                let ray = Ray { origin, direction: random.direction() * 3.0 - origin };
                let mut nearest = None;
                tree.walk(&ray, 0.0, f64::INFINITY, |i, before| {
                    match shapes[i].meets(&ray, 0.0, before) {
                        Some(m) => {
                            nearest = Some((i, m.t));
                            m.t
                        }
                        None => before,
                    }
                });
                let expected = (0..count)
                    .filter_map(|i| shapes[i].meets(&ray, 0.0, f64::INFINITY).map(|m| (i, m.t)))
                    .min_by(|a, b| a.1.total_cmp(&b.1));
                assert_eq!(nearest, expected);
                met += u32::from(nearest.is_some());
            }
            assert!(count < 300 || met > 250);
        }
    }
}
