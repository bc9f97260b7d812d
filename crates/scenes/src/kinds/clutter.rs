//! A room full of things at all depths, in the manner of Middlebury's indoor scenes.
//!
//! The floor and a side wall are strongly slanted, the back wall is blank, plastered or papered
//! with posters on it, and before them stand and hang boxes, balls, cylinders, cones, discs and cards. Thin rods,
//! nets, blinds, pens and leaves are a few pixels wide. Textures are blank, fine, coarse, or
//! repeated with a period well within the range of disparities; a third of the things shine.

use super::Stage;
use super::builder::Builder;
use crate::geometry::{Cuboid, Disc, Frustum, Holes, Panel, Shape, Sphere};
use crate::light::{Light, Sky};
use crate::rig::Pose;
use crate::settings::Settings;
use crate::texture::{Material, Pattern};
use crate::vector::{Frame, Vector, vector};

/// Depth of the largest disparity, in metres. Everything else is a multiple of it.
const NEAR: f64 = 1.0;
/// The back wall's share of the largest disparity.
const WALL: f64 = 0.2;
/// Share of the largest disparity where the floor meets the lower edge of the image.
const FLOOR: f64 = 0.88;
/// Tries to add one thing before it is left out.
const TRIES: usize = 8;

/// The room and what is in it.
struct Room {
    builder: Builder,
    /// One pixel of a 450-pixel image, in pixels of this one.
    unit: f64,
    /// How far below the cameras the floor is, in metres.
    floor: f64,
    /// Columns (in half views, -1 to 1) already taken by what stands about.
    taken: Vec<f64>,
}

pub(super) fn build(settings: &Settings) -> Stage {
    let side = Builder::side(settings);
    let pose = Pose::looking_ahead(vector(0.0, 0.0, 0.0), 0.0);
    let builder = Builder::new(settings, 0x636c_7574_7465_72, pose, 1.6 * side, NEAR);
    let floor = builder.half_view(NEAR / FLOOR).1;
    let unit = (side / 450.0).max(0.5);
    let mut room = Room { builder, unit, floor, taken: Vec::new() };
    let walled = if room.builder.random.chance(0.5) { 1.0 } else { -1.0 };
    room.walls(walled);
    room.posters();
    room.shelf();
    room.repeat(11, Room::standing);
    room.repeat(12, Room::hanging);
    room.repeat(2, Room::net);
    room.repeat(1, Room::blinds);
    room.repeat(2, Room::pens);
    room.repeat(2, Room::plant);
    room.repeat(9, Room::rod);
    // The sun comes from behind and from the open side.
    let sun = vector(
        -walled * room.builder.random.between(0.1, 0.9),
        room.builder.random.between(-1.0, -0.4),
        room.builder.random.between(0.8, 1.3),
    );
    let light = Light {
        sun: sun.normalized(),
        sunlight: vector(0.95, 0.9, 0.8),
        above: vector(0.34, 0.35, 0.38),
        below: vector(0.16, 0.15, 0.13),
        sky: Sky::plain(vector(0.5, 0.5, 0.5)),
        haze: f64::INFINITY,
    };
    room.builder.finish(None, light, settings.seed)
}

impl Room {
    fn repeat(&mut self, count: usize, add: impl Fn(&mut Self) -> bool) {
        for _ in 0..count {
            let _ = (0..TRIES).any(|_| add(self));
        }
    }

    /// Depth of a share of the largest disparity.
    fn depth(share: f64) -> f64 {
        NEAR / share
    }

    /// So many pixels (of a 450-pixel image), in metres at that depth.
    fn pixels(&self, count: f64, depth: f64) -> f64 {
        count * self.unit * self.builder.pixel(depth)
    }

    /// The point at that depth, `x` and `y` half views to the right and downwards.
    fn place(&self, x: f64, y: f64, depth: f64) -> Vector {
        let (half_width, half_height) = self.builder.half_view(depth);
        self.builder.rig.pose.point(x * half_width, y * half_height, depth)
    }

    /// A free place among those who stand: the candidate farthest from all of them (Mitchell
    /// 1991), so that things spread over the view.
    fn free_place(&mut self, reach: f64) -> f64 {
        let mut best = (-1.0, 0.0);
        for _ in 0..6 {
            let x = self.builder.random.between(-reach, reach);
            let room = self.taken.iter().map(|t| (t - x).abs()).fold(9.0, f64::min);
            if room > best.0 {
                best = (room, x);
            }
        }
        best.1
    }

    /// A surface for something at that depth.
    fn material(&mut self, depth: f64) -> Material {
        let (dark, light) = (self.builder.paint() * 0.6, self.builder.paint());
        let px = self.pixels(1.0, depth);
        let random = &mut self.builder.random;
        let pattern = match random.below(20) {
            0..=3 => Pattern::Blank,
            4..=6 => Pattern::Speckle { size: px * random.between(8.0, 20.0) },
            7..=8 => Pattern::Cloudy { size: px * random.between(20.0, 60.0) },
            9..=10 => Pattern::Stripes { period: px * random.between(5.0, 14.0) },
            11..=12 => Pattern::Checks { period: px * random.between(9.0, 22.0) },
            13 => Pattern::Dots { period: px * random.between(7.0, 14.0) },
            14 => Pattern::Bricks { length: px * 22.0, height: px * 9.0 },
            15..=17 => Pattern::Print { line: px * random.between(6.0, 11.0) },
            _ => Pattern::Wood { ring: px * random.between(5.0, 12.0) },
        };
        let mut material = Material::patterned(pattern, dark, light);
        if pattern != Pattern::Blank || random.chance(0.5) {
            material =
                material.with_grain(random.between(0.04, 0.3), px * random.between(5.0, 12.0));
        }
        if random.chance(0.35) {
            material =
                material.with_highlight(random.between(0.2, 0.7), 4 + random.below(4) as u32);
        }
        material
    }

    fn walls(&mut self, walled: f64) {
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
    fn posters(&mut self) {
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
    fn shelf(&mut self) {
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

    /// Something that stands on the floor.
    fn standing(&mut self) -> bool {
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
    fn hanging(&mut self) -> bool {
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

    /// A net of crossed bars with wide meshes.
    fn net(&mut self) -> bool {
        let depth = Self::depth(self.builder.random.between(0.4, 0.8));
        let (x, y) =
            (self.builder.random.between(-0.8, 0.8), self.builder.random.between(-0.6, 0.4));
        let turn = Frame::about(vector(0.0, 0.0, 1.0), self.builder.random.between(-0.35, 0.35));
        let frame = Frame { x: turn.x, y: -turn.z, z: turn.y };
        let pitch = self.builder.random.between(9.0, 16.0);
        let holes = Holes::Lattice {
            pitch: self.pixels(pitch, depth),
            bar: self.pixels(self.builder.random.clone().between(1.5, 3.0), depth),
        };
        let half = self.builder.random.between(35.0, 60.0);
        let half = self.pixels(half, depth);
        let panel = Panel::new(self.place(x, y, depth), frame, half, 0.8 * half).with_holes(holes);
        let paint = Material::matt(self.builder.paint());
        self.builder.add_beyond_near(vec![(panel.into(), paint)])
    }

    /// Level slats, one above the other, all alike.
    fn blinds(&mut self) -> bool {
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
    fn pens(&mut self) -> bool {
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
    fn plant(&mut self) -> bool {
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
    fn rod(&mut self) -> bool {
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
