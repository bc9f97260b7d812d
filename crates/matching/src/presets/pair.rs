//! Both images as the stages of `balanced` and `best` see them: grey, with the same things in the same rows, smoothed
//! where they are noisy.

use raster::{Plane, View};

use crate::ingredient::{Ingredient, Ingredients};
use crate::kernels::level::Level;
use crate::matcher::Frame;
use crate::prepare::alignment::{Alignment, VerticalDisparity};
use crate::prepare::grey::{GreyBuffer, GreyView};
use crate::prepare::noise::{self, noise};
use crate::prepare::smoothing::{self, NOISY, smooth};
use crate::prepare::take;
use crate::profile::Work;

/// Their memory.
#[derive(Default)]
pub(super) struct Pair {
    buffers: [GreyBuffer; 2],
    alignment: Alignment,
    /// Both images, if they are noisy.
    smoothed: [Plane<u8>; 2],
}

/// The images of a frame.
pub(super) struct Prepared<'a> {
    /// In all their bits.
    pub views: [GreyView<'a>; 2],
    /// Their upper 8 bits.
    pub grey: [View<'a, u8>; 2],
    /// What was taken out of the right one.
    pub vertical: Option<VerticalDisparity>,
    /// The standard deviation of the noise that is left, in grey levels.
    pub noise: f32,
    pub done: Work,
}

impl Pair {
    /// Prepares the images of a frame, of which disparities are `searched` or not.
    pub fn prepare<'a>(
        &'a mut self,
        level: Level,
        ingredients: Ingredients,
        frame: &Frame<'a>,
        searched: bool,
    ) -> Prepared<'a> {
        let Self { buffers: [left, right], alignment, smoothed } = self;
        let both = [(left, frame.left), (right, frame.right)]
            .map(|(buffer, image)| buffer.with_upper_bits(level, image));
        let (mut views, mut grey) = (both.map(|(view, _)| view), both.map(|(_, grey)| grey));
        let [of_left, of_right] = [frame.left, frame.right].map(GreyBuffer::work_with_upper_bits);
        let mut done = of_left + of_right + noise::work(grey[0]);
        let mut vertical = None;
        // Texture as fine as noise passes for it in one image, but both images show the same texture.
        let mut noise = noise(grey[0]);
        if searched && ingredients.has(Ingredient::VerticalAlignment) {
            let aligned = alignment.align(level, grey[0], views[1], grey[1], frame.range);
            (views[1], grey[1], vertical) = (aligned.grey, aligned.upper, aligned.vertical);
            noise = aligned.noise.map_or(noise, |of_pair| of_pair.min(noise));
            done = done + aligned.done;
        }
        if ingredients.has(Ingredient::NoiseSmoothing) {
            // Whether they are noisy or not: that it is first needed some frames later must not show.
            smoothed.iter_mut().for_each(|smoothed| take(smoothed, frame.size()));
            if noise > NOISY {
                for (smoothed, grey) in smoothed.iter_mut().zip(&grey) {
                    done = done + smoothing::work(*grey);
                    smooth(level, *grey, smoothed);
                }
                grey = smoothed.each_ref().map(Plane::view);
                views = grey.map(GreyView::Depth8);
                // Steps of grey need not be freed from what is left of it.
                noise = 0.0;
            }
        }
        Prepared { views, grey, vertical, noise, done }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;
    use crate::chance::Chance;
    use raster::{BoundingBox, DisparityRange, Image};

    /// Grey with noise of a standard deviation: twelve equally likely numbers added up are nearly normal.
    fn noisy(deviation: f32, mut chance: Chance) -> Plane<u8> {
        Plane::from_fn(200, 150, |_, _| {
            let normal = (0..12).map(|_| chance.share()).sum::<f32>() - 6.0;
            (100.0 + deviation * normal).round() as u8
        })
    }

    #[test]
    fn a_noisy_pair_is_smoothed_and_a_clean_one_is_not() {
        let balanced = Ingredients::of(Preset::Balanced, &[]);
        let (bounds, range) = (BoundingBox::whole(200, 150), DisparityRange::new(0, 9).unwrap());
        for (deviation, is_smoothed) in [(1.0, false), (2.5, true)] {
            let planes = [5, 6].map(|seed| noisy(deviation, Chance(seed)));
            let [left, right] = planes.clone().map(Image::Grey8);
            let frame = Frame { left: &left, right: &right, bounds, range };
            let mut pair = Pair::default();
            let prepared = pair.prepare(Level::detect(), balanced, &frame, false);
            for (grey, plane) in prepared.grey.iter().zip(planes) {
                assert_eq!(grey.to_plane() != plane, is_smoothed, "{deviation}");
            }
            // What is left of noise counts as none.
            assert_eq!(prepared.noise == 0.0, is_smoothed, "{deviation}");
        }
    }
}
