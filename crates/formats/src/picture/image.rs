//! An image as a picture.

use raster::{Image, Plane};

/// An image in colours of 8 bits: of 16 bits the upper ones.
pub fn image(image: &Image) -> Plane<[u8; 3]> {
    let high = |sample: u16| (sample >> 8) as u8;
    match image {
        Image::Grey8(grey) => grey.map(|&grey| [grey; 3]),
        Image::Grey16(grey) => grey.map(|&grey| [high(grey); 3]),
        Image::Rgb8(colours) => colours.clone(),
        Image::Rgb16(colours) => colours.map(|&colour| colour.map(high)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_depth_becomes_eight_bits() {
        let colour = |image: Image| super::image(&image).samples()[0];
        assert_eq!(colour(Image::Grey8(Plane::filled(1, 1, 7))), [7; 3]);
        assert_eq!(colour(Image::Grey16(Plane::filled(1, 1, 0x12ff))), [0x12; 3]);
        assert_eq!(colour(Image::Rgb8(Plane::filled(1, 1, [1, 2, 3]))), [1, 2, 3]);
        let deep = Plane::filled(1, 1, [0xff00, 0x0100, 0x00ff]);
        assert_eq!(colour(Image::Rgb16(deep)), [255, 1, 0]);
    }
}
