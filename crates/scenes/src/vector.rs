//! Vectors in space, in metres, and turns of space.
//!
//! Only `+ - * /` and `sqrt` are used, which IEEE 754 rounds in one way on every machine; see
//! [`crate::number`] for why that matters.

use std::ops::{Add, Mul, Neg, Sub};

/// A point or a direction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Vector {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// The vector with these coordinates.
pub(crate) const fn vector(x: f64, y: f64, z: f64) -> Vector {
    Vector { x, y, z }
}

impl Vector {
    #[inline]
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline]
    pub fn cross(self, other: Self) -> Self {
        vector(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    #[inline]
    pub fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// The direction of this vector, which must not be zero.
    #[inline]
    pub fn normalized(self) -> Self {
        self * (1.0 / self.length())
    }

    /// Coordinate by coordinate, for colours and boxes.
    #[inline]
    pub fn scaled(self, by: Self) -> Self {
        vector(self.x * by.x, self.y * by.y, self.z * by.z)
    }

    #[inline]
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        vector(f(self.x), f(self.y), f(self.z))
    }

    /// The way from `self` (at 0) to `to` (at 1).
    #[inline]
    pub fn mix(self, to: Self, at: f64) -> Self {
        self + (to - self) * at
    }
}

impl Add for Vector {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        vector(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl Sub for Vector {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        vector(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

impl Mul<f64> for Vector {
    type Output = Self;
    #[inline]
    fn mul(self, by: f64) -> Self {
        vector(self.x * by, self.y * by, self.z * by)
    }
}

impl Neg for Vector {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        vector(-self.x, -self.y, -self.z)
    }
}

/// Three directions of length 1 at right angles: where an object's own axes point in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub x: Vector,
    pub y: Vector,
    pub z: Vector,
}

impl Frame {
    /// The world's own axes.
    pub const WORLD: Self =
        Self { x: vector(1.0, 0.0, 0.0), y: vector(0.0, 1.0, 0.0), z: vector(0.0, 0.0, 1.0) };

    /// The turn of the unit quaternion that points along `(w, axis)`, which must not be zero.
    pub fn turned(w: f64, axis: Vector) -> Self {
        let scale = 1.0 / (w * w + axis.dot(axis)).sqrt();
        let (w, v) = (w * scale, axis * scale);
        let (x, y, z) = (v.x, v.y, v.z);
        Self {
            x: vector(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
            y: vector(2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
            z: vector(2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
        }
    }

    /// A turn around `axis` by the angle whose half has this tangent: no sine is needed.
    pub fn about(axis: Vector, half_tangent: f64) -> Self {
        Self::turned(1.0, axis.normalized() * half_tangent)
    }

    /// A frame whose `z` points along `direction`.
    pub fn along(direction: Vector) -> Self {
        let z = direction.normalized();
        let aside = if z.x.abs() < 0.6 { vector(1.0, 0.0, 0.0) } else { vector(0.0, 1.0, 0.0) };
        let x = (aside - z * z.dot(aside)).normalized();
        Self { x, y: z.cross(x), z }
    }

    /// A direction of the world, in this frame's coordinates.
    #[inline]
    pub fn to_local(self, v: Vector) -> Vector {
        vector(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    /// A direction in this frame's coordinates, in the world.
    #[inline]
    pub fn to_world(self, v: Vector) -> Vector {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Vector, b: Vector) -> bool {
        (a - b).length() < 1e-12
    }

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let frame = Frame::about(vector(0.0, 0.0, 2.0), 1.0);
        assert!(close(frame.x, vector(0.0, 1.0, 0.0)));
        assert!(close(frame.y, vector(-1.0, 0.0, 0.0)));
    }

    #[test]
    fn frames_are_upright_and_come_back() {
        for direction in [vector(1.0, 0.2, 0.0), vector(0.0, 0.0, -3.0), vector(-0.3, 4.0, 1.0)] {
            let frame = Frame::along(direction);
            assert!(close(frame.x.cross(frame.y), frame.z));
            assert!(close(frame.z, direction.normalized()));
            let v = vector(0.3, -0.7, 1.9);
            assert!(close(frame.to_world(frame.to_local(v)), v));
        }
    }
}
