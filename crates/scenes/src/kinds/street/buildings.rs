//! Road, pavements, and the houses along them.

use super::super::builder::Builder;
use super::{KERB, ROAD, UP};
use crate::geometry::{Cuboid, Holes, Panel};
use crate::texture::{Material, Pattern};
use crate::vector::{Frame, Vector, vector};

/// Where the houses begin and the street ends, in metres ahead.
const FIRST: f64 = -8.0;
const LAST: f64 = 130.0;

/// A frame whose x runs along the street and whose y points down: that of facades and fences.
pub(super) const ALONG: Frame =
    Frame { x: vector(0.0, 1.0, 0.0), y: vector(0.0, 0.0, -1.0), z: vector(-1.0, 0.0, 0.0) };

/// A box from its lowest to its highest corner.
fn block(low: Vector, high: Vector) -> Cuboid {
    Cuboid::new(low.mix(high, 0.5), Frame::WORLD, (high - low) * 0.5)
}

pub(super) fn ground(builder: &mut Builder) {
    let level = Frame { x: vector(1.0, 0.0, 0.0), y: vector(0.0, -1.0, 0.0), z: -UP };
    let asphalt = Material::patterned(
        Pattern::Regolith { size: 1.5 },
        vector(0.055, 0.055, 0.06),
        vector(0.15, 0.148, 0.145),
    );
    builder.add(Panel::new(vector(0.0, 60.0, 0.0), level, 400.0, 400.0), asphalt);
    let slabs = Material::patterned(
        Pattern::Bricks { length: 0.6, height: 0.4 },
        vector(0.22, 0.21, 0.2),
        vector(0.34, 0.33, 0.31),
    )
    .with_grain(0.2, 0.15);
    for side in [-1.0, 1.0] {
        let low = vector(if side > 0.0 { ROAD } else { -40.0 }, FIRST - 30.0, -0.1);
        let high = vector(if side > 0.0 { 40.0 } else { -ROAD }, LAST + 200.0, KERB);
        builder.add(block(low, high), slabs);
    }
    // Lane marks, worn: one dash every 6 m, all alike; lines along the kerbs; a crossing.
    let paint = Material::matt(vector(0.5, 0.5, 0.47)).with_grain(0.35, 0.2);
    let mut mark = |x: f64, y: f64, width: f64, length: f64| {
        let half = vector(0.5 * width, 0.5 * length, 0.002);
        builder.add(Cuboid::new(vector(x, y, 0.002), Frame::WORLD, half), paint);
    };
    for i in 0..24 {
        mark(-1.4, 4.0 + 6.0 * f64::from(i), 0.14, 2.6);
    }
    for side in [-1.0, 1.0] {
        mark(side * (ROAD - 2.3), 60.0, 0.1, 160.0);
    }
    let crossing = builder.random.between(14.0, 30.0);
    let mut x = -ROAD + 0.5;
    while x < ROAD - 0.3 {
        let half = vector(0.25, 1.7, 0.002);
        builder.add(Cuboid::new(vector(x, crossing, 0.0025), Frame::WORLD, half), paint);
        x += 1.0;
    }
}

pub(super) fn facades(builder: &mut Builder) {
    for side in [-1.0, 1.0] {
        let mut from = FIRST;
        while from < LAST {
            let length = builder.random.between(8.0, 19.0);
            let gap =
                if builder.random.chance(0.2) { builder.random.between(2.0, 5.0) } else { 0.0 };
            house(builder, side, from, from + length);
            from += length + gap;
        }
    }
    // The street ends at a house across.
    let wall = facade(builder);
    let high = builder.random.between(9.0, 16.0);
    let across = Frame { x: vector(1.0, 0.0, 0.0), y: -UP, z: vector(0.0, 1.0, 0.0) };
    let at = vector(builder.random.between(-6.0, 6.0), LAST + 12.0, 0.5 * high);
    builder.add(Cuboid::new(at, across, vector(26.0, 0.5 * high, 4.0)), wall);
}

fn facade(builder: &mut Builder) -> Material {
    let wall = builder.paint() * 0.55 + vector(0.16, 0.14, 0.11);
    let random = &mut builder.random;
    let (width, height) = (random.between(1.7, 3.2), random.between(2.7, 3.4));
    match random.below(5) {
        0 => Material::patterned(
            Pattern::Bricks { length: 0.9, height: 0.36 },
            vector(0.26, 0.1, 0.06),
            vector(0.42, 0.36, 0.3),
        )
        .with_grain(0.2, 0.8),
        // Plaster without a window.
        1 => Material::matt(wall).with_grain(0.07, 2.0),
        _ => {
            Material::patterned(Pattern::Windows { width, height }, vector(0.05, 0.06, 0.075), wall)
                .with_grain(0.1, 1.2)
        }
    }
}

fn house(builder: &mut Builder, side: f64, from: f64, to: f64) {
    let wall = facade(builder);
    let random = &mut builder.random;
    let front = side * random.between(7.2, 8.6);
    let (deep, high) = (10.0, random.between(5.0, 15.0));
    let middle = 0.5 * (from + to);
    let half = vector(0.5 * (to - from), 0.5 * high, 0.5 * deep);
    let at = vector(front + side * half.z, middle, half.y);
    builder.add(Cuboid::new(at, ALONG, half), wall);
    // A ledge above the shops.
    let ledge = vector(half.x, 0.12, 0.35);
    let stone = Material::matt(vector(0.4, 0.38, 0.35)).with_grain(0.1, 0.3);
    builder.add(Cuboid::new(vector(front, middle, 3.4), ALONG, ledge), stone);
    if builder.random.chance(0.55) {
        // A shop: glass that mirrors the street, in a coloured frame.
        let colour = builder.paint();
        let frame = vector(0.42 * (to - from), 1.35, 0.06);
        builder.add(
            Cuboid::new(vector(front, middle, 1.6), ALONG, frame),
            Material::matt(colour).with_grain(0.06, 0.3),
        );
        let glass =
            Material::matt(vector(0.03, 0.035, 0.04)).with_mirror(0.9).with_highlight(0.5, 7);
        let pane = frame.scaled(vector(0.96, 0.86, 1.0)) + vector(0.0, 0.0, 0.01);
        builder.add(Cuboid::new(vector(front, middle, 1.6), ALONG, pane), glass);
    }
    if builder.random.chance(0.6) {
        balconies(builder, side * 0.5 + front - side, (from, to), high);
    }
}

/// Balconies with railings of thin bars, one above the other.
fn balconies(builder: &mut Builder, x: f64, (from, to): (f64, f64), high: f64) {
    let y = builder.random.between(from + 2.5, to - 2.5);
    let concrete = Material::matt(vector(0.38, 0.37, 0.35)).with_grain(0.1, 0.4);
    let iron = Material::matt(vector(0.06, 0.06, 0.07));
    let mut z = 4.0;
    while z < high - 2.5 {
        builder.add(Cuboid::new(vector(x, y, z), ALONG, vector(1.5, 0.08, 0.5)), concrete);
        let side = if x > 0.0 { -0.5 } else { 0.5 };
        let rail = Panel::new(vector(x + side, y, z + 0.55), ALONG, 1.5, 0.5)
            .with_holes(Holes::Slats { pitch: 0.15, bar: 0.03 });
        builder.add(rail, iron);
        let top = Cuboid::new(vector(x + side, y, z + 1.05), ALONG, vector(1.5, 0.03, 0.03));
        builder.add(top, iron);
        z += 3.0;
    }
}
