//! The points that a depth map's pixels show, with their colours.

use camera::StereoCamera;
use formats::Point;
use formats::picture::{self, ColourMap};
use raster::{Image, Plane};

/// Points in the order of the pixels; those without a depth have none.
pub fn points(
    disparities: &Plane<f32>,
    depths: &Plane<f32>,
    camera: &StereoCamera,
    image: Option<&Image>,
) -> Vec<Point> {
    let colours = colours(disparities, image);
    let pixels = camera.points(disparities, depths).zip(colours.samples());
    pixels.filter_map(|(position, &colour)| Some(Point { position: position?, colour })).collect()
}

/// Those of the picture in 8 bits; without one, near is red and far is blue.
fn colours(disparities: &Plane<f32>, image: Option<&Image>) -> Plane<[u8; 3]> {
    match image {
        Some(image) => picture::image(image),
        None => {
            let (least, most) = picture::value_range(disparities).unwrap_or((0.0, 1.0));
            picture::disparity(disparities, least, most, ColourMap::Turbo)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_stand_where_the_camera_says_in_the_colours_of_the_picture() {
        let camera = StereoCamera::new(100.0, 0.5, 0.0, 1.0, 0.0).unwrap();
        let disparities = Plane::new(2, 2, vec![25.0, f32::NAN, 10.0, 50.0]).unwrap();
        let depths = Plane::new(2, 2, vec![2.0, f32::NAN, f32::NAN, 1.0]).unwrap();
        let image =
            Image::Rgb16(Plane::from_fn(2, 2, |x, y| [0x1200 + x as u16, 0xff00, y as u16]));
        let points = points(&disparities, &depths, &camera, Some(&image));
        let expected = [
            Point { position: [-0.02, 0.0, 2.0], colour: [0x12, 0xff, 0] },
            Point { position: [0.0, 0.01, 1.0], colour: [0x12, 0xff, 0] },
        ];
        assert_eq!(points, expected);
    }
}
