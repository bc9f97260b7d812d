//! What a file holds ([`Image`]) and what a matcher looks at ([`Grey`]).

use crate::Plane;

/// Pixels as an image file holds them: grey or colour, 8 or 16 bit per sample.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Image {
    /// Grey, 0 to 255.
    Grey8(Plane<u8>),
    /// Grey, 0 to 65535.
    Grey16(Plane<u16>),
    /// Red, green, blue, each 0 to 255.
    Rgb8(Plane<[u8; 3]>),
    /// Red, green, blue, each 0 to 65535.
    Rgb16(Plane<[u16; 3]>),
}

/// Grey pixels, 8 or 16 bit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Grey {
    /// 0 to 255.
    Depth8(Plane<u8>),
    /// 0 to 65535.
    Depth16(Plane<u16>),
}

/// ITU-R BT.601 luma in thousandths, as PIL and the course define grey.
fn luma([r, g, b]: [u32; 3]) -> u32 {
    299 * r + 587 * g + 114 * b
}

impl Image {
    /// Width in pixels.
    pub fn columns(&self) -> usize {
        self.size().0
    }

    /// Height in pixels.
    pub fn rows(&self) -> usize {
        self.size().1
    }

    /// `(columns, rows)`.
    pub fn size(&self) -> (usize, usize) {
        match self {
            Self::Grey8(p) => p.size(),
            Self::Grey16(p) => p.size(),
            Self::Rgb8(p) => p.size(),
            Self::Rgb16(p) => p.size(),
        }
    }

    /// Grey of the same depth: luma `(299 R + 587 G + 114 B) / 1000`, rounded to nearest.
    pub fn to_grey(&self) -> Grey {
        match self {
            Self::Grey8(p) => Grey::Depth8(p.clone()),
            Self::Grey16(p) => Grey::Depth16(p.clone()),
            Self::Rgb8(p) => Grey::Depth8(p.map(|c| ((luma(c.map(u32::from)) + 500) / 1000) as u8)),
            Self::Rgb16(p) => {
                Grey::Depth16(p.map(|c| ((luma(c.map(u32::from)) + 500) / 1000) as u16))
            }
        }
    }

    /// Grey with its fractions, on the scale 0 to 255 at either depth (a 16-bit sample is divided
    /// by 257): what the course's Python functions are given.
    pub fn to_grey_f32(&self) -> Plane<f32> {
        match self {
            Self::Grey8(p) => p.map(|&v| f32::from(v)),
            Self::Grey16(p) => p.map(|&v| f32::from(v) / 257.0),
            Self::Rgb8(p) => p.map(|c| luma(c.map(u32::from)) as f32 / 1000.0),
            Self::Rgb16(p) => p.map(|c| luma(c.map(u32::from)) as f32 / 257_000.0),
        }
    }
}

impl Grey {
    /// `(columns, rows)`.
    pub fn size(&self) -> (usize, usize) {
        match self {
            Self::Depth8(p) => p.size(),
            Self::Depth16(p) => p.size(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_is_bt601_luma() {
        let image = Image::Rgb8(Plane::new(2, 1, vec![[255, 0, 0], [10, 20, 30]]).unwrap());
        // 0.299 * 255 = 76.245; 2.99 + 11.74 + 3.42 = 18.15
        assert_eq!(image.to_grey(), Grey::Depth8(Plane::new(2, 1, vec![76, 18]).unwrap()));
        assert_eq!(image.to_grey_f32().samples(), [76.245, 18.15]);
    }

    #[test]
    fn white_stays_white_at_16_bit() {
        let image = Image::Rgb16(Plane::filled(1, 1, [65535; 3]));
        assert_eq!(image.to_grey(), Grey::Depth16(Plane::filled(1, 1, 65535)));
        assert_eq!(image.to_grey_f32().samples(), [255.0]);
    }
}
