//! From light to numbers: exposure, response curve, gain, noise, quantisation.
//!
//! With light `L` per channel (1 fills the sensor), the grey value before noise is
//!
//! `v = min(gain * (min(exposure * L, 1) ^ (1 / 2.2)) ^ gamma, 1)`, on the scale 0 to 1,
//!
//! grey images take the BT.601 luma of the three channels' `v`, and a sample is
//! `v + noise`, cut to the scale and rounded. Noise is normal, independent per sample, of equal
//! deviation everywhere, and drawn from a hash of the pixel, so that threads do not matter.

use raster::{Image, Plane};

use crate::number::{greatest, least, power};
use crate::random::{hash, normal, salt};
use crate::rig::Side;
use crate::settings::{Channels, Depth, Settings};
use crate::vector::Vector;

/// How one of the cameras turns light into grey values.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sensor {
    exposure: f64,
    exponent: f64,
    gain: f64,
    noise: f64,
    seed: u64,
    channels: Channels,
    depth: Depth,
}

impl Sensor {
    pub fn new(settings: &Settings, side: Side) -> Self {
        let (exposure, gamma, gain, salt) = match side {
            Side::Left => (1.0, 1.0, 1.0, salt("left")),
            Side::Right => {
                (settings.right_exposure, settings.right_gamma, settings.right_gain, salt("right"))
            }
        };
        Self {
            exposure: exposure * settings.exposure,
            exponent: gamma / 2.2,
            gain,
            noise: settings.noise / 255.0,
            seed: settings.seed ^ salt,
            channels: settings.channels,
            depth: settings.depth,
        }
    }

    /// The grey values before noise and quantisation, per channel, on the scale 0 to 1.
    pub fn respond(&self, light: Vector) -> [f32; 3] {
        let one = |l: f64| {
            let filled = least(greatest(self.exposure * l, 0.0), 1.0);
            least(self.gain * power(filled, self.exponent), 1.0) as f32
        };
        let values = [one(light.x), one(light.y), one(light.z)];
        match self.channels {
            Channels::Colour => values,
            Channels::Grey => [luma(values); 3],
        }
    }

    /// The picture: noise added, cut to the scale, rounded.
    pub fn read(&self, values: &Plane<[f32; 3]>) -> Image {
        match (self.channels, self.depth) {
            (Channels::Grey, Depth::Eight) => {
                Image::Grey8(self.develop(values, |[v, _, _]| self.quantised(v, 255.0) as u8))
            }
            (Channels::Grey, Depth::Sixteen) => {
                Image::Grey16(self.develop(values, |[v, _, _]| self.quantised(v, 65535.0) as u16))
            }
            (Channels::Colour, Depth::Eight) => {
                Image::Rgb8(self.develop(values, |v| v.map(|v| self.quantised(v, 255.0) as u8)))
            }
            (Channels::Colour, Depth::Sixteen) => {
                Image::Rgb16(self.develop(values, |v| v.map(|v| self.quantised(v, 65535.0) as u16)))
            }
        }
    }

    fn develop<T>(&self, values: &Plane<[f32; 3]>, sample: impl Fn([f64; 3]) -> T) -> Plane<T> {
        Plane::from_fn(values.columns(), values.rows(), |x, y| {
            let mut noisy = values.row(y)[x].map(f64::from);
            if self.noise > 0.0 {
                for (channel, v) in noisy.iter_mut().enumerate() {
                    let at = hash(self.seed, x as i64, y as i64, channel as i64);
                    *v += self.noise * normal(at);
                }
            }
            sample(noisy)
        })
    }

    fn quantised(&self, v: f64, white: f64) -> f64 {
        (v * white).round().clamp(0.0, white)
    }
}

/// ITU-R BT.601 luma.
pub(crate) fn luma([r, g, b]: [f32; 3]) -> f32 {
    0.299 * r + 0.587 * g + 0.114 * b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::Kind;
    use crate::vector::vector;

    #[test]
    #[allow(clippy::disallowed_methods)] // compared with, not rendered by
    fn the_response_is_its_formula() {
        let mut settings = Settings::new(Kind::Cards, 0);
        settings.exposure = 2.0;
        settings.right_exposure = 0.5;
        settings.right_gamma = 1.5;
        settings.right_gain = 1.1;
        let light = vector(0.1, 0.3, 0.9);
        let left = Sensor::new(&settings, Side::Left).respond(light);
        let right = Sensor::new(&settings, Side::Right).respond(light);
        for (got, expected) in [
            (left[0], 0.2f64.powf(1.0 / 2.2)),
            (left[2], 1.0),
            (right[0], 1.1 * 0.1f64.powf(1.5 / 2.2)),
            (right[2], 1.0), // 1.1 * 0.9^0.68 = 1.02 is cut
        ] {
            assert!((f64::from(got) - expected).abs() < 1e-6, "{got} {expected}");
        }
    }

    #[test]
    #[allow(clippy::disallowed_methods)] // compared with, not rendered by
    fn noise_has_its_deviation_and_differs_between_the_cameras() {
        let mut settings = Settings::new(Kind::Cards, 0);
        settings.noise = 5.0;
        settings.channels = Channels::Grey;
        let flat = Plane::filled(100, 100, [0.5f32; 3]);
        let read = |side| match Sensor::new(&settings, side).read(&flat) {
            Image::Grey8(plane) => plane,
            _ => panic!("grey, 8 bit was asked for"),
        };
        let (left, right) = (read(Side::Left), read(Side::Right));
        assert_ne!(left, right);
        let variance =
            left.samples().iter().map(|&v| (f64::from(v) - 127.5).powi(2)).sum::<f64>() / 1e4;
        assert!((variance.sqrt() - 5.0).abs() < 0.15, "{variance}");
    }
}
