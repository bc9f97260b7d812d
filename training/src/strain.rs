//! Pairs that a camera strained: what rovers see and data sets do not show.

use raster::{Image, Plane};
use scenes::Random;

/// What is done to a pair of grey images on the scale 0 to 255.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strain {
    /// Factors on the light that reaches both cameras, and on top of it the right one.
    exposure: f64,
    right_exposure: f64,
    /// Standard deviation of added noise in grey levels.
    noise: f64,
    /// How many rows lower things stand in the right image.
    vertical_offset: f64,
}

impl Strain {
    const NONE: Self =
        Self { exposure: 1.0, right_exposure: 1.0, noise: 0.0, vertical_offset: 0.0 };

    /// One of four by chance, as strong as chance wants.
    pub fn by_chance(random: &mut Random) -> Self {
        match random.below(4) {
            0 => Self { exposure: random.between(-3.0, 3.0).exp2(), ..Self::NONE },
            1 => Self { right_exposure: random.between(-2.0, 1.0).exp2(), ..Self::NONE },
            2 => Self { noise: random.between(3.0, 20.0), ..Self::NONE },
            _ => Self { vertical_offset: random.between(-2.0, 2.0), ..Self::NONE },
        }
    }

    /// The left and the right image, strained.
    pub fn apply(self, left: &Image, right: &Image, random: &mut Random) -> [Image; 2] {
        let seen = |image: &Image, exposure: f64, offset: f64, random: &mut Random| {
            let grey = image.to_grey_f32();
            let above = |y: usize| (y as f64 - offset).clamp(0.0, (grey.rows() - 1) as f64);
            Image::Grey8(Plane::from_fn(grey.columns(), grey.rows(), |x, y| {
                let (row, part) = (above(y) as usize, above(y).fract());
                let below = (row + 1).min(grey.rows() - 1);
                let [upper, lower] = [row, below].map(|row| f64::from(grey.row(row)[x]));
                let light = exposure * (upper + part * (lower - upper));
                (light.min(255.0) + self.noise * random.normal()).round().clamp(0.0, 255.0) as u8
            }))
        };
        [
            seen(left, self.exposure, 0.0, random),
            seen(right, self.exposure * self.right_exposure, self.vertical_offset, random),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp that falls by ten grey levels a row.
    fn ramp() -> Image {
        Image::Grey8(Plane::from_fn(40, 12, |_, y| (20 + 10 * y) as u8))
    }

    fn strained(strain: Strain) -> [Plane<f32>; 2] {
        strain.apply(&ramp(), &ramp(), &mut Random::new(1, "test")).map(|i| i.to_grey_f32())
    }

    #[test]
    fn things_stand_lower_and_darker_in_the_right_image() {
        let strain = Strain { vertical_offset: 1.5, right_exposure: 0.5, ..Strain::NONE };
        let [left, right] = strained(strain);
        assert_eq!(left, ramp().to_grey_f32());
        // Row 6 shows what stood 1.5 rows higher: 65, halved.
        assert_eq!(right.row(6)[3], 33.0);
        assert_eq!(right.row(0)[3], 10.0);
    }

    #[test]
    fn light_saturates_and_noise_has_its_deviation() {
        let [left, right] = strained(Strain { exposure: 8.0, ..Strain::NONE });
        assert_eq!((left.row(0)[0], left.row(2)[0], right.row(2)[0]), (160.0, 255.0, 255.0));
        let [left, _] = strained(Strain { noise: 5.0, ..Strain::NONE });
        let clean = ramp().to_grey_f32();
        let squares = left.samples().iter().zip(clean.samples()).map(|(a, b)| (a - b).powi(2));
        let deviation = (squares.sum::<f32>() / 480.0).sqrt();
        assert!((deviation - 5.0).abs() < 0.5, "{deviation}");
    }

    #[test]
    fn chance_strains_by_one_thing() {
        let mut random = Random::new(2, "test");
        for _ in 0..50 {
            let Strain { exposure, right_exposure, noise, vertical_offset } =
                Strain::by_chance(&mut random);
            let strained = [exposure != 1.0, right_exposure != 1.0, noise != 0.0];
            let strained = strained.iter().filter(|&&is| is).count();
            assert_eq!(strained + usize::from(vertical_offset != 0.0), 1);
        }
    }
}
