//! Cars and people.

use super::super::builder::Builder;
use super::{KERB, ROAD, UP};
use crate::geometry::{Convex, Cuboid, Disc, Frustum, Shape, Sphere};
use crate::texture::Material;
use crate::vector::{Frame, Vector, vector};

type Parts = Vec<(Shape, Material)>;

/// Cars parked along both kerbs, and some on the road.
pub(super) fn cars(builder: &mut Builder) {
    for side in [-1.0, 1.0] {
        let mut y = builder.random.between(5.0, 9.0);
        while y < 90.0 {
            if builder.random.chance(0.7) {
                let x = side * (ROAD - builder.random.between(1.05, 1.2));
                car(builder, vector(x, y, 0.0), side);
            }
            y += builder.random.between(5.4, 7.5);
        }
    }
    let ahead = builder.random.between(9.0, 26.0);
    car(builder, vector(0.3, ahead, 0.0), 1.0);
    let oncoming = builder.random.between(16.0, 50.0);
    car(builder, vector(-2.2, oncoming, 0.0), -1.0);
}

/// A car with the middle of its floor at a point, its front ahead (`heading` 1) or towards the
/// cameras (-1).
fn car(builder: &mut Builder, at: Vector, heading: f64) {
    let colour = builder.paint();
    let random = &mut builder.random;
    let half_length = random.between(1.9, 2.4);
    let half_width = random.between(0.84, 0.95);
    let (waist, roof) = (random.between(0.82, 0.95), random.between(1.4, 1.75));
    let turn = Frame::about(UP, random.between(-0.02, 0.02));
    let frame = Frame { x: turn.x * heading, y: turn.y * heading, z: UP };
    let lacquer = Material::matt(colour * 0.8).with_highlight(0.8, 6).with_mirror(0.35);
    let glass = Material::matt(vector(0.025, 0.03, 0.035)).with_highlight(0.7, 7).with_mirror(0.85);
    let tyre = Material::matt(vector(0.025, 0.025, 0.025)).with_grain(0.2, 0.05);
    let dark = Material::matt(vector(0.04, 0.04, 0.045));

    let clear = 0.22;
    let body_half = vector(half_width, half_length, 0.5 * (waist - clear));
    let body = Convex::cut_box(
        at + UP * (0.5 * (waist + clear)),
        frame,
        body_half,
        &[
            // Bonnet and boot fall off a little, and the sides lean in.
            (vector(0.0, 0.35, 1.0), 0.94 * (0.33 * half_length + body_half.z) * 0.94),
            (vector(0.0, -0.25, 1.0), 0.94 * (0.24 * half_length + body_half.z) * 0.97),
            (vector(1.0, 0.0, 0.35), 0.94 * (half_width + 0.2 * body_half.z)),
            (vector(-1.0, 0.0, 0.35), 0.94 * (half_width + 0.2 * body_half.z)),
        ],
    );
    let cabin_half = vector(half_width * 0.86, half_length * 0.6, 0.5 * (roof - waist) + 0.04);
    let middle = at + UP * (waist + cabin_half.z - 0.08) - frame.y * (0.1 * half_length);
    let slopes = |lean: f64| (vector(0.0, lean, 0.9), 0.72 * cabin_half.y);
    let (front, back) = (slopes(1.0), slopes(-1.2));
    let sides = 0.9 * cabin_half.x;
    let cabin = Convex::cut_box(
        middle,
        frame,
        cabin_half,
        &[front, back, (vector(1.0, 0.0, 0.4), sides), (vector(-1.0, 0.0, 0.4), sides)],
    );
    let top_half = vector(cabin_half.x * 0.8, cabin_half.y * 0.5, 0.02);
    let top = middle + UP * cabin_half.z - frame.y * (0.05 * half_length);
    let mut parts: Parts = vec![
        (body.into(), lacquer),
        (cabin.into(), glass),
        (Cuboid::new(top, frame, top_half).into(), lacquer),
    ];
    for (x, y) in [(-1.0, -0.62), (1.0, -0.62), (-1.0, 0.62), (1.0, 0.62)] {
        let hub = at + frame.x * (x * half_width * 0.9) + frame.y * (y * half_length) + UP * 0.31;
        let out = frame.x * (0.11 * x);
        parts.push((Frustum::between(hub - out, hub + out, 0.31, 0.31).into(), tyre));
        let cap = Disc::new(hub + out * 1.02, Frame::along(out), 0.19);
        parts.push((cap.into(), Material::matt(vector(0.4, 0.4, 0.42)).with_highlight(0.5, 4)));
    }
    // Lamps, number plate and bumper at both ends.
    for (end, lamp) in [(1.0, vector(0.8, 0.8, 0.75)), (-1.0, vector(0.5, 0.03, 0.02))] {
        let face = at + frame.y * (end * (half_length + 0.005));
        for side in [-1.0, 1.0] {
            let place = face + frame.x * (0.68 * side * half_width) + UP * 0.62;
            let lens = Cuboid::new(place, frame, vector(0.17, 0.01, 0.07));
            parts.push((lens.into(), Material::matt(lamp).with_highlight(0.5, 6)));
        }
        let plate = Cuboid::new(face + UP * 0.45, frame, vector(0.26, 0.012, 0.06));
        parts.push((plate.into(), Material::matt(vector(0.75, 0.75, 0.7))));
        let bumper = Cuboid::new(face + UP * 0.33, frame, vector(half_width * 0.92, 0.05, 0.07));
        parts.push((bumper.into(), dark));
    }
    builder.add_beyond_near(parts);
}

/// People on the pavements and on the crossing.
pub(super) fn people(builder: &mut Builder) {
    for _ in 0..9 {
        let random = &mut builder.random;
        let side = if random.chance(0.5) { 1.0 } else { -1.0 };
        let crosses = random.chance(0.15);
        let x = if crosses { random.between(-3.0, 3.0) } else { side * random.between(5.0, 6.8) };
        let foot = vector(x, random.between(5.0, 40.0), if crosses { 0.0 } else { KERB });
        let parts = person(builder, foot);
        builder.add_beyond_near(parts);
    }
}

fn person(builder: &mut Builder, foot: Vector) -> Parts {
    let (coat, trousers) = (builder.paint() * 0.7, builder.paint() * 0.4);
    let random = &mut builder.random;
    let tall = random.between(1.5, 1.9);
    let skin = vector(0.5, 0.33, 0.24) * random.between(0.4, 1.2);
    let facing = Frame::about(UP, random.between(-1.0, 1.0));
    let stride = random.between(0.0, 0.25);
    let point = |x: f64, y: f64, z: f64| foot + facing.x * x + facing.y * y + UP * (z * tall);
    let cloth = |colour: Vector| Material::matt(colour).with_grain(0.2, 0.06);
    let limb = |a: Vector, b: Vector, thick: f64, thin: f64, colour: Vector| {
        (Shape::from(Frustum::between(a, b, thick, thin)), cloth(colour))
    };
    vec![
        limb(point(0.09, 0.0, 0.5), point(0.1, stride, 0.0), 0.085, 0.05, trousers),
        limb(point(-0.09, 0.0, 0.5), point(-0.1, -stride, 0.0), 0.085, 0.05, trousers),
        limb(point(0.0, 0.0, 0.46), point(0.0, 0.0, 0.83), 0.16, 0.2, coat),
        limb(point(0.22, 0.0, 0.81), point(0.27, -stride, 0.47), 0.06, 0.04, coat),
        limb(point(-0.22, 0.0, 0.81), point(-0.27, stride, 0.47), 0.06, 0.04, coat),
        limb(point(0.0, 0.0, 0.83), point(0.0, 0.0, 0.88), 0.06, 0.05, skin),
        (Sphere::new(point(0.0, 0.0, 0.935), 0.115).into(), Material::matt(skin)),
    ]
}
