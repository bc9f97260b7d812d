//! A room full of things at all depths, in the manner of Middlebury's indoor scenes.
//!
//! The floor and a side wall are strongly slanted, the back wall is blank, plastered or papered
//! with posters on it, and before them stand and hang boxes, balls, cylinders, cones, discs and cards. Thin rods,
//! nets, blinds, pens and leaves are a few pixels wide. Textures are blank, fine, coarse, or
//! repeated with a period well within the range of disparities; a third of the things shine.

mod solid;
mod thin;
mod walls;

use super::Stage;
use super::builder::Builder;
use crate::light::{Light, Sky};
use crate::number::{greatest, least};
use crate::rig::Pose;
use crate::settings::Settings;
use crate::texture::{Material, Pattern};
use crate::vector::{Vector, vector};

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
    let builder = Builder::new(settings, "clutter", pose, 1.6 * side, NEAR);
    let floor = builder.half_view(NEAR / FLOOR).1;
    let unit = greatest(side / 450.0, 0.5);
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
            let room = self.taken.iter().map(|t| (t - x).abs()).fold(9.0, least);
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
}
