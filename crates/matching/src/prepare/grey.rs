//! Grey views of an image, without a copy where the image is grey already.
//!
//! Colour is turned into ITU-R BT.601 luma ([`LUMA`]), rounded to nearest,
//! exactly as [`Image::to_grey`] does, but into memory that is kept between frames.

use raster::{Image, LUMA, Plane, View};
use rayon::prelude::*;

use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;

/// Grey samples of either depth, borrowed.
#[derive(Debug, Clone, Copy)]
pub(crate) enum GreyView<'a> {
    /// 0 to 255.
    Depth8(View<'a, u8>),
    /// 0 to 65535.
    Depth16(View<'a, u16>),
}

impl GreyView<'_> {
    /// `(columns, rows)`.
    pub fn size(&self) -> (usize, usize) {
        match self {
            Self::Depth8(view) => (view.columns(), view.rows()),
            Self::Depth16(view) => (view.columns(), view.rows()),
        }
    }

    /// Bytes of so many rows.
    pub fn bytes(&self, rows: usize) -> usize {
        match self {
            Self::Depth8(view) => view.columns() * rows,
            Self::Depth16(view) => size_of::<u16>() * view.columns() * rows,
        }
    }
}

/// Where the grey of a colour image is kept, and the upper bits of grey with 16.
#[derive(Debug, Default)]
pub(crate) struct GreyBuffer {
    depth8: Plane<u8>,
    depth16: Plane<u16>,
    /// Of grey with 16 bits.
    upper: Plane<u8>,
}

#[inline(always)]
fn luma([r, g, b]: [u32; 3]) -> u32 {
    (LUMA[0] * r + LUMA[1] * g + LUMA[2] * b + 500) / 1000
}

at_every_level! {
    fn luma_of_8_bit(colours: &[[u8; 3]], grey: &mut [u8]) {
        for (grey, colour) in grey.iter_mut().zip(colours) {
            *grey = luma(colour.map(u32::from)) as u8;
        }
    }

    fn luma_of_16_bit(colours: &[[u16; 3]], grey: &mut [u16]) {
        for (grey, colour) in grey.iter_mut().zip(colours) {
            *grey = luma(colour.map(u32::from)) as u16;
        }
    }
}

impl GreyBuffer {
    /// What [`GreyBuffer::view`] does: three colours are read, one grey is written, after three
    /// products, three sums and a division of 32 bits.
    pub fn work(image: &Image) -> Work {
        let colours = |size: usize| Work::bytes((3 + 1) * size) + Work::operations(7 * 4);
        let pixel = match image {
            Image::Grey8(_) | Image::Grey16(_) => Work::default(),
            Image::Rgb8(_) => colours(1),
            Image::Rgb16(_) => colours(2),
        };
        let (columns, rows) = image.size();
        pixel * (columns * rows)
    }

    /// What [`GreyBuffer::with_upper_bits`] does.
    pub fn work_with_upper_bits(image: &Image) -> Work {
        let (columns, rows) = image.size();
        let upper = match image.depth() > u8::BITS {
            false => Work::default(),
            true => Work::bytes((2 + 1) * columns * rows),
        };
        Self::work(image) + upper
    }

    /// The image's grey: borrowed from the image itself, or computed here from its colours.
    pub fn view<'a>(&'a mut self, level: Level, image: &'a Image) -> GreyView<'a> {
        grey(level, &mut self.depth8, &mut self.depth16, image)
    }

    /// The image's grey, and the upper 8 bits of it.
    pub fn with_upper_bits<'a>(
        &'a mut self,
        level: Level,
        image: &'a Image,
    ) -> (GreyView<'a>, View<'a, u8>) {
        let Self { depth8, depth16, upper } = self;
        let grey = grey(level, depth8, depth16, image);
        let bits = match grey {
            GreyView::Depth8(view) => view,
            GreyView::Depth16(view) => {
                upper.reshape(view.columns(), view.rows(), 0);
                let rows = upper.samples_mut().par_chunks_mut(view.columns()).enumerate();
                rows.for_each(|(y, to)| upper_bits(view.row(y), to));
                upper.view()
            }
        };
        (grey, bits)
    }
}

/// The upper 8 of 16 bits.
pub(crate) fn upper_bits(from: &[u16], to: &mut [u8]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = (from >> 8) as u8);
}

/// The image's grey, with memory for that of a colour image of either depth.
fn grey<'a>(
    level: Level,
    depth8: &'a mut Plane<u8>,
    depth16: &'a mut Plane<u16>,
    image: &'a Image,
) -> GreyView<'a> {
    let (columns, rows) = image.size();
    match image {
        Image::Grey8(plane) => GreyView::Depth8(plane.view()),
        Image::Grey16(plane) => GreyView::Depth16(plane.view()),
        Image::Rgb8(plane) => {
            depth8.reshape(columns, rows, 0);
            let rows = depth8.samples_mut().par_chunks_mut(columns);
            let rows = rows.zip(plane.samples().par_chunks(columns));
            rows.for_each(|(grey, colours)| luma_of_8_bit(level, colours, grey));
            GreyView::Depth8(depth8.view())
        }
        Image::Rgb16(plane) => {
            depth16.reshape(columns, rows, 0);
            let rows = depth16.samples_mut().par_chunks_mut(columns);
            let rows = rows.zip(plane.samples().par_chunks(columns));
            rows.for_each(|(grey, colours)| luma_of_16_bit(level, colours, grey));
            GreyView::Depth16(depth16.view())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::Grey;

    fn to_grey(view: GreyView<'_>) -> Grey {
        match view {
            GreyView::Depth8(view) => Grey::Depth8(view.to_plane()),
            GreyView::Depth16(view) => Grey::Depth16(view.to_plane()),
        }
    }

    #[test]
    fn grey_is_what_the_image_says_it_is_at_every_level() {
        let scramble = |x: usize, y: usize| (x * 7919 + y * 104_729 + x * x * 31) as u16;
        let images = [
            Image::Grey8(Plane::from_fn(99, 5, |x, y| scramble(x, y) as u8)),
            Image::Grey16(Plane::from_fn(99, 5, scramble)),
            Image::Rgb8(Plane::from_fn(99, 5, |x, y| {
                [scramble(x, y) as u8, scramble(y, x) as u8, scramble(x + y, 3) as u8]
            })),
            Image::Rgb16(Plane::from_fn(99, 5, |x, y| {
                [scramble(x, y), scramble(y, x), scramble(x + y, 3)]
            })),
        ];
        let mut buffer = GreyBuffer::default();
        let levels = Level::available();
        for (image, &level) in
            images.iter().flat_map(|image| levels.iter().map(move |l| (image, l)))
        {
            eprintln!("level {}", level.name());
            assert_eq!(to_grey(buffer.view(level, image)), image.to_grey());
            let (grey, upper) = buffer.with_upper_bits(level, image);
            let expected = match to_grey(grey) {
                Grey::Depth8(grey) => grey,
                Grey::Depth16(grey) => grey.map(|sample| (sample >> 8) as u8),
            };
            assert_eq!(upper.to_plane(), expected);
        }
    }
}
