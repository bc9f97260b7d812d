//! The rover's own front, seen from its mast: deck with instruments, cables and antenna; wheels on
//! rockers; the arm. Near, pale, partly blank, with thin parts over far ground.

use super::super::builder::Builder;
use super::DUST;
use crate::geometry::{Convex, Cuboid, Disc, Frustum, Holes, Panel, Shape, Sphere};
use crate::terrain::Terrain;
use crate::texture::{Material, Pattern};
use crate::vector::{Frame, Vector, vector};

/// Height of the deck's upper side in metres.
const DECK: f64 = 0.98;
/// Where the deck ends, ahead of the cameras.
const FRONT: f64 = 1.3;
const UP: Vector = vector(0.0, 0.0, 1.0);
const WHEEL: f64 = 0.26;
/// Steps of 15 degrees around a wheel: the tangent of half the angle.
const STEP: f64 = 0.131_652_497_587_395_83;

type Parts = Vec<(Shape, Material)>;

fn metal() -> Material {
    Material::matt(vector(0.5, 0.49, 0.46)).with_grain(0.05, 0.01).with_highlight(0.6, 5)
}

fn dark() -> Material {
    Material::matt(vector(0.05, 0.05, 0.055)).with_highlight(0.2, 4).with_dust(DUST, 0.3)
}

pub(super) fn front(builder: &mut Builder, ground: &Terrain) {
    deck(builder);
    instruments(builder);
    for _ in 0..5 {
        let parts = cable(builder);
        builder.add_beyond_near(parts);
    }
    let parts = antenna(builder);
    builder.add_beyond_near(parts);
    for side in [-1.0, 1.0] {
        let parts = wheel(builder, ground, side);
        builder.add_beyond_near(parts);
    }
    let parts = arm(builder, ground);
    builder.add_beyond_near(parts);
}

/// The deck itself and the body below it. They begin behind the cameras, and before the depth of
/// the largest disparity they are below the image.
fn deck(builder: &mut Builder) {
    let white = Material::patterned(
        Pattern::Bricks { length: 0.42, height: 0.3 },
        vector(0.56, 0.53, 0.49),
        vector(0.28, 0.26, 0.24),
    )
    .with_grain(0.04, 0.03)
    .with_dust(DUST, builder.random.between(0.15, 0.5))
    .with_highlight(0.15, 4);
    let middle = 0.5 * (FRONT - 2.0);
    let half = vector(0.62, 0.5 * (FRONT + 2.0), 0.02);
    builder.add(Cuboid::new(vector(0.0, middle, DECK - 0.02), Frame::WORLD, half), white);
    let body = vector(0.5, half.y - 0.08, 0.16);
    builder.add(Cuboid::new(vector(0.0, middle - 0.08, DECK - 0.2), Frame::WORLD, body), metal());
    // Screws along the front edge, all alike.
    for i in 0..13 {
        let at = vector(-0.57 + 0.095 * f64::from(i), FRONT - 0.03, DECK);
        let screw = Frustum::between(at, at + UP * 0.012, 0.009, 0.009);
        builder.add_beyond_near(vec![(screw.into(), metal())]);
    }
}

/// Boxes with fins, and the sundial by which colours are calibrated.
fn instruments(builder: &mut Builder) {
    for side in [-1.0, 1.0] {
        let random = &mut builder.random;
        let at = vector(side * random.between(0.22, 0.5), random.between(1.08, FRONT - 0.1), DECK);
        if random.chance(0.5) {
            let half = vector(
                random.between(0.05, 0.1),
                random.between(0.05, 0.1),
                random.between(0.03, 0.08),
            );
            let mut parts: Parts = vec![(
                Cuboid::new(at + UP * half.z, Frame::WORLD, half).into(),
                Material::matt(vector(0.45, 0.3, 0.08)).with_highlight(0.5, 4),
            )];
            for fin in 0..6 {
                let x = half.x * (-0.9 + 0.36 * f64::from(fin));
                let top = at + vector(x, 0.0, 2.0 * half.z + 0.015);
                let fin = Cuboid::new(top, Frame::WORLD, vector(0.003, half.y, 0.02));
                parts.push((fin.into(), metal()));
            }
            builder.add_beyond_near(parts);
        } else {
            let mut parts: Parts = Vec::new();
            for (ring, shade) in [0.7, 0.35, 0.12, 0.55].into_iter().enumerate() {
                let radius = 0.085 - 0.02 * ring as f64;
                let lift = 0.006 + 0.001 * ring as f64;
                let disc = Disc::new(at + UP * lift, Frame::along(UP), radius);
                parts.push((disc.into(), Material::matt(vector(shade, shade, shade))));
            }
            let post = Frustum::between(at, at + UP * 0.09, 0.006, 0.004);
            parts.push((post.into(), dark()));
            parts.push((Sphere::new(at + UP * 0.095, 0.013).into(), dark()));
            builder.add_beyond_near(parts);
        }
    }
}

/// A tube along a parabola from `a` to `b` by way of `bend`, in straight pieces with round joints.
fn tube(parts: &mut Parts, ends: (Vector, Vector), bend: Vector, radius: f64, material: Material) {
    const PIECES: u32 = 9;
    let point = |i: u32| {
        let t = f64::from(i) / f64::from(PIECES);
        ends.0.mix(bend, t).mix(bend.mix(ends.1, t), t)
    };
    for i in 0..PIECES {
        parts.push((Frustum::between(point(i), point(i + 1), radius, radius).into(), material));
        parts.push((Sphere::new(point(i + 1), radius).into(), material));
    }
}

/// A cable that loops up from the deck.
fn cable(builder: &mut Builder) -> Parts {
    let random = &mut builder.random;
    let x = random.between(-0.55, 0.4);
    let a = vector(x, random.between(1.05, 1.2), DECK);
    let b = vector(x + random.between(0.05, 0.35), random.between(1.1, FRONT + 0.02), DECK - 0.03);
    let bend = a.mix(b, 0.5) + UP * random.between(0.1, 0.4);
    let radius = random.between(0.003, 0.009);
    let mut parts = Parts::new();
    tube(&mut parts, (a, b), bend, radius, dark());
    parts
}

/// A post with a whip or a dish on one side of the deck.
fn antenna(builder: &mut Builder) -> Parts {
    let random = &mut builder.random;
    let side = if random.chance(0.5) { 1.0 } else { -1.0 };
    let foot = vector(side * random.between(0.4, 0.55), FRONT - 0.06, DECK);
    let tall = random.between(0.35, 0.75);
    let top = foot + vector(0.0, 0.05, tall);
    let mut parts: Parts = vec![
        (Frustum::between(foot, top, 0.018, 0.014).into(), metal()),
        (Frustum::between(foot, foot + UP * 0.03, 0.05, 0.05).into(), dark()),
    ];
    if random.chance(0.6) {
        let facing = Frame::along(vector(random.between(-0.8, 0.8), -0.5, 0.9));
        let dish = Material::patterned(
            Pattern::Dots { period: 0.022 },
            vector(0.3, 0.28, 0.26),
            vector(0.62, 0.6, 0.56),
        );
        parts.push((Disc::new(top + UP * 0.02, facing, 0.13).into(), dish.with_dust(DUST, 0.2)));
    } else {
        let whip = top + vector(random.between(-0.06, 0.06), 0.0, 0.6);
        parts.push((Frustum::between(top, whip, 0.004, 0.003).into(), dark()));
        let frame = Frame { x: vector(1.0, 0.0, 0.0), y: -UP, z: vector(0.0, 1.0, 0.0) };
        let mesh = Holes::Lattice { pitch: 0.028, bar: 0.006 };
        let panel = Panel::new(top + UP * 0.1, frame, 0.11, 0.08).with_holes(mesh);
        parts.push((panel.into(), metal()));
    }
    parts
}

/// A wheel with treads, and the rocker that carries it.
fn wheel(builder: &mut Builder, ground: &Terrain, side: f64) -> Parts {
    let x = side * builder.random.between(0.95, 1.1);
    let y = builder.random.between(2.05, 2.3);
    let hub = vector(x, y, ground.height(x, y) + WHEEL - 0.02);
    let across = vector(1.0, 0.0, 0.0);
    let half_width = 0.16;
    let rim = Material::matt(vector(0.3, 0.29, 0.28))
        .with_grain(0.15, 0.04)
        .with_highlight(0.5, 4)
        .with_dust(DUST, 0.6);
    let mut parts: Parts = vec![
        (
            Frustum::between(hub - across * half_width, hub + across * half_width, WHEEL, WHEEL)
                .into(),
            rim,
        ),
        (Sphere::new(hub - across * (side * half_width), 0.08).into(), dark()),
    ];
    // Treads: one bar every 15 degrees, turned from the one before it.
    let turn = Frame::about(across, STEP);
    let mut out = UP;
    for _ in 0..24 {
        let frame = Frame { x: across, y: out.cross(across), z: out };
        let bar = Cuboid::new(hub + out * WHEEL, frame, vector(half_width, 0.008, 0.012));
        parts.push((bar.into(), rim));
        out = turn.to_world(out);
    }
    let knee = vector(side * 0.72, y - 0.35, DECK - 0.2);
    let inner = hub - across * (side * (half_width + 0.04));
    parts.push((Frustum::between(knee, inner, 0.05, 0.04).into(), metal()));
    parts.push((Sphere::new(knee, 0.065).into(), metal()));
    let body = vector(side * 0.5, 1.0, DECK - 0.15);
    parts.push((Frustum::between(body, knee, 0.05, 0.05).into(), metal()));
    parts
}

/// The arm: shoulder, elbow, wrist, and the turret with its drill.
fn arm(builder: &mut Builder, ground: &Terrain) -> Parts {
    let random = &mut builder.random;
    let shoulder = vector(random.between(-0.35, 0.35), FRONT + 0.08, DECK - 0.2);
    let elbow = vector(
        shoulder.x + random.between(-0.6, 0.6),
        random.between(1.9, 2.3),
        random.between(0.75, 1.15),
    );
    let (x, y) = (elbow.x + random.between(-0.5, 0.5), elbow.y + random.between(0.1, 0.6));
    let wrist = vector(x, y, ground.height(x, y) + random.between(0.35, 0.7));
    let white =
        Material::matt(vector(0.55, 0.52, 0.48)).with_dust(DUST, 0.35).with_highlight(0.2, 4);
    let mut parts: Parts = vec![
        (Frustum::between(shoulder, elbow, 0.045, 0.04).into(), white),
        (Frustum::between(elbow, wrist, 0.035, 0.03).into(), white),
        (Sphere::new(shoulder, 0.075).into(), metal()),
        (Sphere::new(elbow, 0.065).into(), metal()),
    ];
    let frame = random.frame();
    let turret = Convex::cut_box(
        wrist,
        frame,
        vector(0.14, 0.1, 0.1),
        &[(vector(1.0, 1.0, 0.0), 0.14), (vector(-1.0, 0.0, 1.0), 0.14)],
    );
    let copper = Material::matt(vector(0.42, 0.25, 0.12)).with_highlight(0.5, 4);
    parts.push((turret.into(), copper.with_grain(0.15, 0.03)));
    let drill = wrist - UP * 0.22;
    parts.push((Frustum::between(wrist, drill, 0.03, 0.012).into(), dark()));
    // Cables along both bones, a little slack.
    for (a, b) in [(shoulder, elbow), (elbow, wrist)] {
        let lift = UP * 0.06;
        let bend = a.mix(b, 0.5) + UP * random.between(0.1, 0.2);
        tube(&mut parts, (a + lift, b + lift), bend, 0.008, dark());
    }
    parts
}
