//! The room itself: back wall, floor, side wall, posters and a shelf.

use super::{NEAR, Room, WALL};
use crate::geometry::{Cuboid, Panel};
use crate::texture::{Material, Pattern};
use crate::vector::{Frame, vector};

impl Room {
    pub(super) fn walls(&mut self, walled: f64) {
        let wall = Self::depth(WALL);
        let (half_width, _) = self.builder.half_view(wall);
        let px = self.pixels(1.0, wall);
        // The back wall, turned by a few degrees: blank, plastered, or papered in two ways.
        let turn = self.builder.random.between(-0.06, 0.06);
        let facing = Frame::about(vector(0.0, 0.0, 1.0), turn);
        let facing = Frame { x: facing.x, y: -facing.z, z: facing.y };
        let pale = self.builder.paint() * 0.3 + vector(0.45, 0.45, 0.42);
        let paint = match self.builder.random.below(4) {
            0 => Material::matt(pale),
            1 => Material::matt(pale).with_grain(0.16, 9.0 * px),
            2 => Material::patterned(Pattern::Dots { period: 11.0 * px }, pale * 0.8, pale),
            _ => Material::patterned(Pattern::Stripes { period: 17.0 * px }, pale * 0.85, pale)
                .with_grain(0.04, 12.0 * px),
        };
        self.builder
            .add(Panel::new(self.builder.rig.pose.point(0.0, 0.0, wall), facing, 1e3, 1e3), paint);
        // The floor: boards or tiles, all alike.
        let level =
            Frame { x: vector(0.0, 1.0, 0.0), y: vector(1.0, 0.0, 0.0), z: vector(0.0, 0.0, -1.0) };
        let near = self.pixels(1.0, NEAR);
        let (dark, light) = (vector(0.16, 0.1, 0.06), vector(0.42, 0.3, 0.2));
        let pattern = match self.builder.random.below(3) {
            0 => Pattern::Bricks { length: near * 90.0, height: near * 22.0 },
            1 => Pattern::Checks { period: near * 70.0 },
            _ => Pattern::Speckle { size: near * 30.0 },
        };
        let tiles = Material::patterned(pattern, dark, light)
            .with_grain(0.12, near * 14.0)
            .with_highlight(0.12, 5);
        let middle = vector(0.0, 0.5 * wall, -self.floor);
        self.builder.add(Panel::new(middle, level, 1e3, 1e3), tiles);
        // The side wall, of bricks or rough plaster.
        let upright = Frame {
            x: vector(0.0, 1.0, 0.0),
            y: vector(0.0, 0.0, -1.0),
            z: vector(-1.0, 0.0, 0.0),
        };
        let bricks = if self.builder.random.chance(0.6) {
            Material::patterned(
                Pattern::Bricks { length: 34.0 * px, height: 12.0 * px },
                vector(0.3, 0.1, 0.06),
                vector(0.55, 0.5, 0.45),
            )
            .with_grain(0.15, 8.0 * px)
        } else {
            Material::matt(pale * 0.8).with_grain(0.08, 15.0 * px)
        };
        let at = vector(walled * 0.78 * half_width, 0.5 * wall, 0.0);
        self.builder.add(Panel::new(at, upright, 1e3, 1e3), bricks);
    }

    /// Flat pictures a hand before the back wall.
    pub(super) fn posters(&mut self) {
        let depth = Self::depth(WALL * 1.06);
        for _ in 0..4 {
            let x = self.builder.random.between(-0.75, 0.75);
            let y = self.builder.random.between(-0.9, 0.0);
            let width = self.builder.random.between(20.0, 45.0);
            let height = self.builder.random.between(20.0, 45.0);
            let (width, height) = (self.pixels(width, depth), self.pixels(height, depth));
            let tilt = Frame::about(vector(0.0, 1.0, 0.0), self.builder.random.between(-0.1, 0.1));
            let frame = Frame { x: tilt.x, y: -tilt.z, z: tilt.y };
            let material = self.material(depth);
            self.builder.add(Panel::new(self.place(x, y, depth), frame, width, height), material);
        }
    }

    /// A shelf of books before the back wall: many alike, none equal.
    pub(super) fn shelf(&mut self) {
        let depth = Self::depth(WALL * 1.2);
        let px = self.pixels(1.0, depth);
        let x = self.builder.random.between(-0.6, 0.1);
        let y = self.builder.random.between(-0.55, -0.1);
        let start = self.place(x, y, depth);
        let length = self.builder.random.between(90.0, 150.0) * px;
        let board = Material::patterned(
            Pattern::Wood { ring: 6.0 * px },
            vector(0.2, 0.11, 0.06),
            vector(0.4, 0.26, 0.15),
        );
        let half = vector(0.5 * length, 9.0 * px, 2.0 * px);
        self.builder.add(
            Cuboid::new(start + vector(0.5 * length, 0.0, -2.0 * px), Frame::WORLD, half),
            board,
        );
        let mut at = 0.0;
        while at < length - 10.0 * px {
            let width = self.builder.random.between(4.0, 9.0) * px;
            let height = self.builder.random.between(24.0, 38.0) * px;
            let cover = Material::matt(self.builder.paint()).with_highlight(0.1, 4);
            let half =
                vector(0.46 * width, self.builder.random.between(5.0, 8.0) * px, 0.5 * height);
            self.builder.add(
                Cuboid::new(start + vector(at + 0.5 * width, 0.0, half.z), Frame::WORLD, half),
                cover,
            );
            at += width;
        }
    }
}
