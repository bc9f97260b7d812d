//! What stands along the kerbs: lamps, signs, bollards, railings, trees; and wires overhead.

use super::super::builder::Builder;
use super::buildings::ALONG;
use super::{KERB, ROAD, UP};
use crate::geometry::{Cuboid, Disc, Frustum, Holes, Panel, Shape, Sphere};
use crate::texture::{Material, Pattern};
use crate::vector::{Frame, Vector, vector};

fn steel() -> Material {
    Material::matt(vector(0.2, 0.21, 0.22)).with_highlight(0.3, 4)
}

pub(super) fn along_the_kerbs(builder: &mut Builder) {
    for side in [-1.0, 1.0] {
        let mut y = builder.random.between(6.0, 14.0);
        while y < 110.0 {
            lamp(builder, side, y);
            y += 17.0;
        }
        for _ in 0..4 {
            let y = builder.random.between(5.0, 45.0);
            sign(builder, side, y);
        }
        // Bollards or a railing: many alike, a fixed step apart.
        let x = side * (ROAD + 0.35);
        let start = builder.random.between(4.0, 12.0);
        if builder.random.chance(0.5) {
            for i in 0..14 {
                let foot = vector(x, start + 1.6 * f64::from(i), KERB);
                let post = Frustum::between(foot, foot + UP * 0.95, 0.055, 0.045).into();
                let cap = Sphere::new(foot + UP * 0.98, 0.07).into();
                builder.add_beyond_near(vec![(post, steel()), (cap, steel())]);
            }
        } else {
            let half = 6.0;
            let at = vector(x, start + half, KERB + 0.5);
            let bars = Panel::new(at, ALONG, half, 0.45)
                .with_holes(Holes::Slats { pitch: 0.22, bar: 0.04 });
            let rail = Cuboid::new(at + UP * 0.47, ALONG, vector(half, 0.03, 0.03));
            builder.add_beyond_near(vec![(bars.into(), steel()), (rail.into(), steel())]);
        }
    }
}

/// A lamp post whose arm reaches over the road.
fn lamp(builder: &mut Builder, side: f64, y: f64) {
    let foot = vector(side * (ROAD + 0.55), y, KERB);
    let top = foot + UP * 6.2;
    let end = top + vector(-side * 1.6, 0.0, 0.35);
    let head = Cuboid::new(end, Frame::WORLD, vector(0.35, 0.13, 0.06));
    builder.add_beyond_near(vec![
        (Frustum::between(foot, top, 0.085, 0.05).into(), steel()),
        (Frustum::between(top, end, 0.04, 0.035).into(), steel()),
        (Frustum::between(foot, foot + UP * 0.8, 0.12, 0.11).into(), steel()),
        (head.into(), Material::matt(vector(0.35, 0.35, 0.34))),
    ]);
}

/// A round or square sign on a thin pole.
fn sign(builder: &mut Builder, side: f64, y: f64) {
    let random = &mut builder.random;
    let foot = vector(side * (ROAD + random.between(0.3, 0.7)), y, KERB);
    let tall = random.between(2.2, 2.7);
    let at = foot + UP * tall - vector(0.0, 0.04, 0.0);
    let turn = Frame::about(UP, random.between(-0.2, 0.2));
    let facing = Frame { x: turn.x, y: -turn.z, z: turn.y };
    let mut parts: Vec<(Shape, Material)> =
        vec![(Frustum::between(foot, foot + UP * (tall + 0.3), 0.028, 0.028).into(), steel())];
    if random.chance(0.6) {
        let rim = Material::matt(vector(0.55, 0.03, 0.03)).with_highlight(0.2, 4);
        let face = Material::matt(random.pick(&[
            vector(0.75, 0.75, 0.73),
            vector(0.05, 0.12, 0.5),
            vector(0.6, 0.45, 0.05),
        ]));
        parts.push((Disc::new(at, facing, 0.32).into(), rim));
        parts.push((Disc::new(at - vector(0.0, 0.005, 0.0), facing, 0.25).into(), face));
    } else {
        let print = Pattern::Print { line: 0.12 };
        let face = Material::patterned(print, vector(0.05, 0.1, 0.3), vector(0.7, 0.72, 0.75));
        parts.push((Panel::new(at, facing, 0.36, 0.27).into(), face));
    }
    builder.add_beyond_near(parts);
}

/// Trees: a trunk, branches, and leaves all around them with gaps to see through.
pub(super) fn trees(builder: &mut Builder) {
    for _ in 0..5 {
        let random = &mut builder.random;
        let side = if random.chance(0.5) { 1.0 } else { -1.0 };
        let foot = vector(side * random.between(5.4, 6.2), random.between(7.0, 45.0), KERB);
        let parts = tree(builder, foot);
        builder.add_beyond_near(parts);
    }
}

fn tree(builder: &mut Builder, foot: Vector) -> Vec<(Shape, Material)> {
    let random = &mut builder.random;
    let bark = Material::matt(vector(0.13, 0.1, 0.075)).with_grain(0.5, 0.12);
    let green = vector(0.09, 0.2, 0.05).mix(vector(0.2, 0.22, 0.05), random.unit());
    let fork = foot + vector(random.between(-0.2, 0.2), random.between(-0.2, 0.2), 2.4);
    let mut parts: Vec<(Shape, Material)> =
        vec![(Frustum::between(foot, fork, 0.17, 0.12).into(), bark)];
    for _ in 0..7 {
        let lean = random.direction() + UP * 1.1;
        let tip = fork + lean.normalized() * random.between(1.4, 2.6);
        parts.push((Frustum::between(fork, tip, 0.07, 0.025).into(), bark));
        for _ in 0..26 {
            let along = random.between(0.35, 1.1);
            let at = fork.mix(tip, along) + random.direction() * random.between(0.1, 0.75);
            let leaf = Material::matt(green * random.between(0.5, 1.5)).with_grain(0.25, 0.1);
            let tilt = random.direction() + UP * 0.6;
            parts
                .push((Disc::new(at, Frame::along(tilt), random.between(0.09, 0.24)).into(), leaf));
        }
    }
    parts
}

/// Wires from house to house, a few centimetres thick.
pub(super) fn wires(builder: &mut Builder) {
    let black = Material::matt(vector(0.03, 0.03, 0.03));
    for _ in 0..4 {
        let random = &mut builder.random;
        let (y, z) = (random.between(10.0, 60.0), random.between(4.6, 6.4));
        let a = vector(-8.0, y, z + random.between(0.0, 0.8));
        let b = vector(8.0, y + random.between(-3.0, 3.0), z + random.between(0.0, 0.8));
        let sag = a.mix(b, 0.5) - UP * random.between(0.3, 0.8);
        const PIECES: u32 = 8;
        let point = |i: u32| {
            let t = f64::from(i) / f64::from(PIECES);
            a.mix(sag, t).mix(sag.mix(b, t), t)
        };
        for i in 0..PIECES {
            builder.add(Frustum::between(point(i), point(i + 1), 0.018, 0.018), black);
        }
    }
}
