//! A tree of boxes that finds the few shapes near a ray.
//!
//! A bounding volume hierarchy, split at the median along the widest axis. It decides only in which
//! order shapes are asked, so it never changes an answer.

use super::{Bounds, Ray};

/// At most this many shapes are asked one by one.
const LEAF: usize = 2;

#[derive(Debug, Clone, PartialEq)]
struct Node {
    bounds: Bounds,
    /// A leaf's shapes are `order[first..first + count]`; an inner node has count 0, its nearer
    /// half right behind it, and its other half at `first`.
    first: u32,
    count: u32,
    axis: u8,
}

/// Boxes within boxes, over shapes known by their number.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Tree {
    /// The tree over shapes with these bounds.
    pub fn over(bounds: &[Bounds]) -> Self {
        let mut tree = Self { nodes: Vec::new(), order: (0..bounds.len() as u32).collect() };
        if !bounds.is_empty() {
            tree.split(bounds, 0, bounds.len());
        }
        tree
    }

    fn split(&mut self, bounds: &[Bounds], first: usize, last: usize) {
        let part = &mut self.order[first..last];
        let all = part.iter().fold(Bounds::NOTHING, |all, &i| all.with(bounds[i as usize]));
        let centres = part.iter().fold(Bounds::NOTHING, |all, &i| {
            let centre = bounds[i as usize].doubled_centre();
            all.with(Bounds { low: centre, high: centre })
        });
        let wide = centres.high - centres.low;
        let axis = if wide.x >= wide.y && wide.x >= wide.z {
            0
        } else if wide.y >= wide.z {
            1
        } else {
            2
        };
        let here = self.nodes.len();
        self.nodes.push(Node {
            bounds: all,
            first: first as u32,
            count: (last - first) as u32,
            axis,
        });
        if last - first <= LEAF {
            return;
        }
        let key = |i: u32| {
            let centre = bounds[i as usize].doubled_centre();
            [centre.x, centre.y, centre.z][usize::from(axis)]
        };
        part.sort_by(|&a, &b| key(a).total_cmp(&key(b)));
        let middle = first + (last - first) / 2;
        self.split(bounds, first, middle);
        self.nodes[here].first = self.nodes.len() as u32;
        self.nodes[here].count = 0;
        self.split(bounds, middle, last);
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
        let backwards = [ray.direction.x < 0.0, ray.direction.y < 0.0, ray.direction.z < 0.0];
        let mut before = before;
        // The halves are equal in number, so 2^32 shapes would need 32 places.
        let mut stack = [0u32; 40];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let at = stack[waiting];
            let node = &self.nodes[at as usize];
            if !node.bounds.meets(&prepared, after, before) {
                continue;
            }
            if node.count > 0 {
                let first = node.first as usize;
                for &number in &self.order[first..first + node.count as usize] {
                    before = shape(number as usize, before);
                }
            } else {
                let (low, high) = (at + 1, node.first);
                let (near, far) =
                    if backwards[usize::from(node.axis)] { (high, low) } else { (low, high) };
                stack[waiting] = far;
                stack[waiting + 1] = near;
                waiting += 2;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Shape, Sphere};
    use crate::random::Random;

    #[test]
    fn the_tree_finds_what_asking_everyone_finds() {
        let mut random = Random::new(2, 0);
        for count in [0, 1, 2, 3, 7, 300] {
            let shapes: Vec<Shape> = (0..count)
                .map(|_| Sphere::new(random.direction() * random.between(1.0, 5.0), 0.3).into())
                .collect();
            let bounds: Vec<_> = shapes.iter().map(Shape::bounds).collect();
            let tree = Tree::over(&bounds);
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
