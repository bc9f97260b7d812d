//! Things with a body: they stand on the floor or hang in the air.

use super::Room;
use crate::geometry::{Cuboid, Disc, Frustum, Panel, Shape, Sphere};
use crate::texture::Material;
use crate::vector::{Frame, vector};

impl Room {
    /// Something that stands on the floor.
    pub(super) fn standing(&mut self) -> bool {
        let share = self.builder.random.between(0.26, 0.72);
        let depth = Self::depth(share);
        let x = self.free_place(0.9);
        let radius = self.builder.random.between(16.0, 38.0);
        let radius = self.pixels(radius, depth);
        let tall = radius * self.builder.random.between(1.5, 5.0);
        let (half_width, _) = self.builder.half_view(depth);
        let foot = vector(x * half_width, depth, -self.floor);
        let material = self.material(depth);
        let up = vector(0.0, 0.0, 1.0);
        let shape: Shape = match self.builder.random.below(5) {
            0 => Sphere::new(foot + up * radius, radius).into(),
            1 => Frustum::between(foot, foot + up * tall, radius, radius).into(),
            2 => Frustum::between(foot, foot + up * tall, radius, 0.0).into(),
            _ => {
                let turn = Frame::about(up, self.builder.random.between(-0.4, 0.4));
                let half = vector(
                    radius * self.builder.random.between(0.6, 1.2),
                    radius * self.builder.random.between(0.5, 1.0),
                    0.5 * tall,
                );
                Cuboid::new(foot + up * half.z, turn, half).into()
            }
        };
        let added = self.builder.add_beyond_near(vec![(shape, material)]);
        if added {
            self.taken.push(x);
        }
        added
    }

    /// Something that hangs in the air.
    pub(super) fn hanging(&mut self) -> bool {
        let depth = Self::depth(self.builder.random.between(0.25, 0.97));
        let x = self.builder.random.between(-0.95, 0.95);
        let y = self.builder.random.between(-0.95, 0.35);
        let at = self.place(x, y, depth);
        let radius = self.builder.random.between(7.0, 26.0);
        let radius = self.pixels(radius, depth);
        let material = self.material(depth);
        let frame = self.builder.random.frame();
        let random = &mut self.builder.random;
        let shape: Shape = match random.below(6) {
            0 => Sphere::new(at, radius).into(),
            1 => Cuboid::new(at, frame, vector(radius, 0.7 * radius, 0.5 * radius)).into(),
            2 => Frustum::between(at, at + frame.x * (2.2 * radius), 0.5 * radius, 0.5 * radius)
                .into(),
            3 => {
                let tilt = vector(random.between(-0.6, 0.6), -1.0, random.between(-0.6, 0.6));
                Disc::new(at, Frame::along(tilt), radius).into()
            }
            _ => {
                // A card that leans by up to about 45 degrees, its lines of print level.
                let turn = Frame::about(vector(0.0, 0.0, 1.0), random.between(-0.4, 0.4));
                let lean = random.between(-0.4, 0.4);
                let down = (turn.y * lean - turn.z).normalized();
                let frame = Frame { x: turn.x, y: down, z: turn.x.cross(down) };
                Panel::new(at, frame, 1.3 * radius, radius).into()
            }
        };
        let mut group = vec![(shape, material)];
        if self.builder.random.chance(0.5) {
            // It hangs from a thread one pixel wide.
            let thread = 0.5 * self.pixels(1.0, depth);
            let top = at + vector(0.0, 0.0, 2.0 * self.builder.half_view(depth).1);
            let dark = Material::matt(vector(0.08, 0.08, 0.08));
            group.push((Frustum::between(at, top, thread, thread).into(), dark));
        }
        self.builder.add_beyond_near(group)
    }
}
