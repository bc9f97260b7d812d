//! Things a few pixels wide, with much behind them: nets, blinds, pens, leaves, rods.

use super::Room;
use crate::geometry::{Cuboid, Disc, Frustum, Holes, Panel, Shape};
use crate::texture::Material;
use crate::vector::{Frame, vector};

impl Room {
    /// A net of crossed bars with wide meshes.
    pub(super) fn net(&mut self) -> bool {
        let depth = Self::depth(self.builder.random.between(0.4, 0.8));
        let (x, y) =
            (self.builder.random.between(-0.8, 0.8), self.builder.random.between(-0.6, 0.4));
        let turn = Frame::about(vector(0.0, 0.0, 1.0), self.builder.random.between(-0.35, 0.35));
        let frame = Frame { x: turn.x, y: -turn.z, z: turn.y };
        let px = self.pixels(1.0, depth);
        let holes = Holes::Lattice {
            pitch: self.builder.random.between(9.0, 16.0) * px,
            bar: self.builder.random.between(1.5, 3.0) * px,
        };
        let half = self.builder.random.between(35.0, 60.0) * px;
        let panel = Panel::new(self.place(x, y, depth), frame, half, 0.8 * half).with_holes(holes);
        let paint = Material::matt(self.builder.paint());
        self.builder.add_beyond_near(vec![(panel.into(), paint)])
    }

    /// Level slats, one above the other, all alike.
    pub(super) fn blinds(&mut self) -> bool {
        let depth = Self::depth(self.builder.random.between(0.3, 0.6));
        let (x, y) =
            (self.builder.random.between(-0.8, 0.8), self.builder.random.between(-0.8, -0.2));
        let px = self.pixels(1.0, depth);
        let paint = Material::matt(self.builder.paint() * 0.5 + vector(0.3, 0.3, 0.3));
        let top = self.place(x, y, depth);
        let half = vector(self.builder.random.between(30.0, 50.0) * px, 3.0 * px, 0.5 * px);
        let tilt = Frame::about(vector(1.0, 0.0, 0.0), 0.3);
        let slats = (0..12).map(|i| {
            let at = top - vector(0.0, 0.0, 9.0 * px * f64::from(i));
            (Cuboid::new(at, tilt, half).into(), paint)
        });
        self.builder.add_beyond_near(slats.collect())
    }

    /// A jar of pens on the floor.
    pub(super) fn pens(&mut self) -> bool {
        let depth = Self::depth(self.builder.random.between(0.4, 0.8));
        let px = self.pixels(1.0, depth);
        let x = self.free_place(0.85);
        let foot = vector(x * self.builder.half_view(depth).0, depth, -self.floor);
        let up = vector(0.0, 0.0, 1.0);
        let mut group = vec![(
            Frustum::between(foot, foot + up * (32.0 * px), 12.0 * px, 14.0 * px).into(),
            self.material(depth),
        )];
        for _ in 0..9 {
            let lean = vector(
                self.builder.random.between(-0.35, 0.35),
                self.builder.random.between(-0.35, 0.35),
                1.0,
            );
            let start = foot + up * (10.0 * px) + vector(lean.x, lean.y, 0.0) * (6.0 * px);
            let width = self.builder.random.between(0.8, 2.0) * px;
            let length = self.builder.random.between(45.0, 75.0) * px;
            let paint = Material::matt(self.builder.paint()).with_highlight(0.3, 5);
            group
                .push((Frustum::between(start, start + lean * length, width, width).into(), paint));
        }
        let added = self.builder.add_beyond_near(group);
        if added {
            self.taken.push(x);
        }
        added
    }

    /// A plant: stems from one pot, leaves all over.
    pub(super) fn plant(&mut self) -> bool {
        let depth = Self::depth(self.builder.random.between(0.35, 0.75));
        let px = self.pixels(1.0, depth);
        let x = self.free_place(0.85);
        let foot = vector(x * self.builder.half_view(depth).0, depth, -self.floor);
        let up = vector(0.0, 0.0, 1.0);
        let clay = Material::matt(vector(0.45, 0.2, 0.12)).with_grain(0.1, 6.0 * px);
        let mut group: Vec<(Shape, Material)> = vec![(
            Frustum::between(foot, foot + up * (26.0 * px), 11.0 * px, 15.0 * px).into(),
            clay,
        )];
        let green = vector(0.1, 0.3, 0.07);
        for _ in 0..7 {
            let random = &mut self.builder.random;
            let lean = vector(random.between(-0.5, 0.5), random.between(-0.3, 0.3), 1.0);
            let start = foot + up * (25.0 * px);
            let end = start + lean * (random.between(40.0, 85.0) * px);
            let stem = Material::matt(green * 0.7);
            group.push((Frustum::between(start, end, 1.0 * px, 0.6 * px).into(), stem));
            for leaf in 1..6 {
                let at = start.mix(end, f64::from(leaf) / 5.0) + random.direction() * (5.0 * px);
                let tilt = random.direction() + vector(0.0, -0.7, 0.5);
                let radius = random.between(3.0, 7.5) * px;
                let colour = green * random.between(0.6, 1.5);
                let leaf = Material::matt(colour).with_grain(0.1, 4.0 * px).with_highlight(0.15, 4);
                group.push((Disc::new(at, Frame::along(tilt), radius).into(), leaf));
            }
        }
        let added = self.builder.add_beyond_near(group);
        if added {
            self.taken.push(x);
        }
        added
    }

    /// A rod through the room, one to four pixels thick.
    pub(super) fn rod(&mut self) -> bool {
        let depth = Self::depth(self.builder.random.between(0.35, 0.95));
        let random = &mut self.builder.random;
        let (x, lean) = (random.between(-1.0, 1.0), random.between(-0.5, 0.5));
        // Its ends are at different depths, by up to a fifth.
        let (top, foot) = (random.between(-1.3, -0.2), random.between(-0.1, 1.1));
        let (first, second) = (depth, depth * random.between(0.9, 1.2));
        let thick = random.between(0.6, 2.0);
        let thick = self.pixels(thick, depth);
        let paint = Material::matt(self.builder.paint()).with_highlight(0.3, 4);
        let (a, b) = (self.place(x - lean, top, first), self.place(x + lean, foot, second));
        // Rods that would run below the floor stop there.
        let low = -self.floor;
        let b = if b.z < low { a.mix(b, (a.z - low) / (a.z - b.z)) } else { b };
        self.builder.add_beyond_near(vec![(Frustum::between(a, b, thick, thick).into(), paint)])
    }
}
