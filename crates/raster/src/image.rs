//! What a file holds ([`Image`]) and what a matcher looks at ([`Grey`]).

use crate::Plane;

/// Pixels as an image file holds them: grey or colour, 8 or 16 bit per sample.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Image {
    /// Grey, 0 to 255.
    Grey8(Plane<u8>),
    /// Grey, 0 to 65535. Samples of cameras of 10 or 12 bits fill a part of that: [`Image::widened_from`] makes the most
    /// of them.
    Grey16(Plane<u16>),
    /// Red, green, blue, each 0 to 255.
    Rgb8(Plane<[u8; 3]>),
    /// Red, green, blue, each 0 to 65535; of 10 or 12 bits as [`Image::Grey16`].
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

/// How much red, green and blue count in grey, in thousandths: ITU-R BT.601 luma, as PIL and the course
/// define it.
pub const LUMA: [u32; 3] = [299, 587, 114];

/// Luma in thousandths.
fn luma([r, g, b]: [u32; 3]) -> u32 {
    LUMA[0] * r + LUMA[1] * g + LUMA[2] * b
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

    /// Whether its pixels have red, green and blue.
    pub fn is_coloured(&self) -> bool {
        matches!(self, Self::Rgb8(_) | Self::Rgb16(_))
    }

    /// Bits per sample: 8 or 16.
    pub fn depth(&self) -> u32 {
        match self {
            Self::Grey8(_) | Self::Rgb8(_) => u8::BITS,
            Self::Grey16(_) | Self::Rgb16(_) => u16::BITS,
        }
    }

    /// What its samples are, in words: both images of a pair are of one kind.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Grey8(_) => "grey of 8 bits",
            Self::Grey16(_) => "grey of 16 bits",
            Self::Rgb8(_) => "colour of 8 bits",
            Self::Rgb16(_) => "colour of 16 bits",
        }
    }

    /// The smallest and the largest sample; `None` without any.
    pub fn extremes(&self) -> Option<[u32; 2]> {
        fn of<T: Copy + Ord + Into<u32>, const N: usize>(pixels: &[[T; N]]) -> Option<[u32; 2]> {
            let (&first, others) = pixels.as_flattened().split_first()?;
            let wider = |(least, most): (T, T), &sample: &T| (least.min(sample), most.max(sample));
            let (least, most) = others.iter().fold((first, first), wider);
            Some([least.into(), most.into()])
        }
        match self {
            Self::Grey8(p) => of(p.samples().as_chunks::<1>().0),
            Self::Grey16(p) => of(p.samples().as_chunks::<1>().0),
            Self::Rgb8(p) => of(p.samples()),
            Self::Rgb16(p) => of(p.samples()),
        }
    }

    /// How many bits the largest sample takes.
    pub fn bits_used(&self) -> u32 {
        self.extremes().map_or(0, |[_, largest]| u32::BITS - largest.leading_zeros())
    }

    /// 16-bit samples of which only the lower `bits` are used over all 16: 0 stays black, and the largest
    /// number of so many bits becomes white. Larger samples are white too. Images of 8 bits stay as they
    /// are.
    ///
    /// # Panics
    ///
    /// If `bits` is not from 1 to 16.
    pub fn widened_from(self, bits: u32) -> Self {
        assert!(
            (1..=16).contains(&bits),
            "samples of 16 bits cannot have used {bits}: give 1 to 16"
        );
        let largest = (1u32 << bits) - 1;
        let widen = |v: u16| {
            ((u32::from(v).min(largest) * u32::from(u16::MAX) + largest / 2) / largest) as u16
        };
        match self {
            Self::Grey16(p) => Self::Grey16(p.map(|&v| widen(v))),
            Self::Rgb16(p) => Self::Rgb16(p.map(|c| c.map(widen))),
            shallow => shallow,
        }
    }

    /// Grey of the same depth: [`LUMA`] `(299 R + 587 G + 114 B) / 1000`, rounded to nearest.
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
        let (columns, rows) = self.size();
        let mut grey = Plane::filled(columns, rows, 0.0);
        for y in 0..rows {
            self.grey_row_f32(y, grey.row_mut(y));
        }
        grey
    }

    /// Row `y` of [`to_grey_f32`](Self::to_grey_f32), into as many samples as it has columns.
    ///
    /// # Panics
    ///
    /// If the image does not have that row, or another number of columns.
    pub fn grey_row_f32(&self, y: usize, grey: &mut [f32]) {
        match self {
            Self::Grey8(p) => convert(p.row(y), grey, |&v| f32::from(v)),
            Self::Grey16(p) => convert(p.row(y), grey, |&v| f32::from(v) / 257.0),
            Self::Rgb8(p) => convert(p.row(y), grey, |c| luma(c.map(u32::from)) as f32 / 1000.0),
            Self::Rgb16(p) => {
                convert(p.row(y), grey, |c| luma(c.map(u32::from)) as f32 / 257_000.0);
            }
        }
    }
}

fn convert<T>(row: &[T], grey: &mut [f32], of: impl Fn(&T) -> f32) {
    assert_eq!(grey.len(), row.len(), "a sample for each column");
    for (grey, sample) in grey.iter_mut().zip(row) {
        *grey = of(sample);
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
    fn grey_is_rounded_to_the_nearest() {
        // 0.587 and 0.114 are next to 1 and to 0; 0.299 + 0.587 to 1.
        for (colour, grey) in [([0, 1, 0], 1), ([0, 0, 1], 0), ([1, 1, 0], 1)] {
            let shallow = Image::Rgb8(Plane::filled(1, 1, colour));
            assert_eq!(shallow.to_grey(), Grey::Depth8(Plane::filled(1, 1, grey)));
            let deep = Image::Rgb16(Plane::filled(1, 1, colour.map(u16::from)));
            assert_eq!(deep.to_grey(), Grey::Depth16(Plane::filled(1, 1, grey.into())));
        }
    }

    #[test]
    fn few_bits_are_widened_to_16() {
        let image = Image::Grey16(Plane::new(3, 1, vec![0, 512, 1023]).unwrap());
        assert_eq!((image.depth(), image.bits_used()), (16, 10));
        assert_eq!(image.extremes(), Some([0, 1023]));
        // 65535 * 512 / 1023 = 32799.5
        let wide = Image::Grey16(Plane::new(3, 1, vec![0, 32800, 65535]).unwrap());
        assert_eq!(image.clone().widened_from(10), wide);
        // What is larger than so many bits can say is white, and no wrapped grey.
        let white = Image::Grey16(Plane::new(3, 1, vec![0, 65535, 65535]).unwrap());
        assert_eq!(image.widened_from(9), white);
        assert_eq!((wide.bits_used(), wide.clone().widened_from(16)), (16, wide));
        let colour = Image::Rgb16(Plane::filled(1, 1, [0, 1, 0]));
        assert_eq!(colour.bits_used(), 1);
        assert_eq!(colour.widened_from(1), Image::Rgb16(Plane::filled(1, 1, [0, 65535, 0])));
        let shallow = Image::Grey8(Plane::filled(1, 1, 7));
        assert_eq!((shallow.bits_used(), shallow.clone().widened_from(3)), (3, shallow));
        let black = Image::Rgb8(Plane::filled(2, 1, [0; 3]));
        assert_eq!((black.depth(), black.bits_used()), (8, 0));
    }

    #[test]
    fn white_stays_white_at_16_bit() {
        let image = Image::Rgb16(Plane::filled(1, 1, [65535; 3]));
        assert_eq!(image.to_grey(), Grey::Depth16(Plane::filled(1, 1, 65535)));
        assert_eq!(image.to_grey_f32().samples(), [255.0]);
        assert_eq!(Image::Grey16(Plane::filled(1, 1, 65535)).to_grey_f32().samples(), [255.0]);
    }
}
