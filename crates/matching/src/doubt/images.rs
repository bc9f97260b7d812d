//! What makes a pair of images doubtful before anything is matched: few of the grey levels that samples can tell apart,
//! blocks of compression, one that is less sharp than the other.

use std::fmt;

use raster::Image;

use super::detail::{Detail, details};

/// Cameras give 10, 12 or 14 bits, and drivers store them in samples of 16 as they are: the pictures are nearly
/// black. Steps of grey are what matching lives on, so it wants them over all 16 bits. Up to so many bits,
/// the others are taken as never used.
const FEW_BITS: u32 = 14;
/// Of 65536 levels of grey fewer are few: those of a thermal camera may lie far from 0. Of 256 fewer than so many.
const FEW_LEVELS: u32 = 1 << 12;
const FEW_OF_256: u32 = 32;
/// Samples that use a smaller part of their bits lie far from 0, so that other bits would not help.
const PART_OF_BITS: u32 = 8;
/// Steps at the borders of blocks are so many times as large as within, in both directions of both images. Of 53 pairs of
/// Middlebury, KITTI, ETH3D and others none comes to more than 1.04, Spirit's pairs, which were JPEG once, to 1.12; with
/// JPEG of quality 80 and less mostly more than this.
const BLOCKY: f64 = 1.13;
/// Fine detail, beside coarse detail, is so many times as strong in one image as in the other. Of all these pairs none
/// comes to more than 1.75; where one image was out of focus by 2 px, or at half the resolution, mostly more.
const UNEQUAL: f64 = 1.9;
/// Exposures differ by less than so many bits.
const UNEQUAL_BITS: u32 = 3;
/// So large a part of an image is at the end of what samples hold. Of all these pairs none comes to more than an eighth,
/// which is sky over streets.
const MUCH_SATURATED: f64 = 0.25;
/// Smaller images say too little about either.
const SMALLEST: usize = 64;

/// What there is to doubt about a pair of images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ImageDoubt {
    /// Of 16 bits the samples use so many alone, as those of cameras with 10 or 12 do: matches are worse than they would
    /// be of [`Image::widened_from`] so many.
    FewBits(u32),
    /// All samples lie between the first two, far from filling what their bits hold, up to the third: steps of grey are
    /// what matching lives on.
    FewLevels([u32; 3]),
    /// Both images show the blocks of a compression, which stand in the same places of both and are matched at
    /// multiples of their side.
    Compressed,
    /// The left image is less sharp, or less noisy: the right one has so many times as much fine detail. Blurred
    /// edges match sharp ones at one of their ends.
    LeftBlurred(f64),
    /// The right one is.
    RightBlurred(f64),
    /// So large shares of the left and of the right image are as bright as samples can be: nothing is matched there.
    Saturated([f64; 2]),
    /// The samples of the left image use so many bits, those of the right one so many, of as many as count in each: steps
    /// of grey are by far smaller in one of them.
    UnequalBits([u32; 2]),
}

/// What it is and what to do, as the end of a sentence that begins with the pair's name.
impl fmt::Display for ImageDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let blurred = |f: &mut fmt::Formatter<'_>, less: &str, more: &str, ratio: f64| {
            write!(
                f,
                "the {more} image has {ratio:.1} times as much fine detail as the {less} one: is one out of focus, moved, \
                 of another resolution or noisier?"
            )
        };
        match *self {
            Self::FewBits(used) => write!(
                f,
                "of 16 bits the upper {} are never used, which makes matches worse: widen the samples from {used} bits",
                u16::BITS - used
            ),
            Self::FewLevels([least, most, all]) => write!(
                f,
                "all samples lie from {least} to {most}, of 0 to {all}, which makes matches worse: expose for longer, or \
                 spread them over all"
            ),
            Self::Compressed => f.write_str(
                "both images show the blocks of 8 x 8 pixels of a compression, which are matched at multiples of 8 \
                 pixels: take pictures without, or of a better quality",
            ),
            Self::LeftBlurred(ratio) => blurred(f, "left", "right", ratio),
            Self::RightBlurred(ratio) => blurred(f, "right", "left", ratio),
            Self::Saturated(shares) => {
                let [left, right] = shares.map(|share| 100.0 * share);
                write!(
                    f,
                    "{left:.0} % of the left and {right:.0} % of the right image are as bright as samples can be, where \
                     nothing is matched: expose for shorter"
                )
            }
            Self::UnequalBits([left, right]) => write!(
                f,
                "the samples of the left image use {left} bits, those of the right one {right}, which makes matches \
                 worse: store both alike, over all bits"
            ),
        }
    }
}

/// Doubts about a pair of images of one size, before anything is matched. It takes about as long as `fast`; of a camera
/// that stays the same the first pair tells.
pub fn image_doubts(left: &Image, right: &Image) -> Vec<ImageDoubt> {
    let is_large = |image: &Image| {
        let (columns, rows) = image.size();
        columns.min(rows) >= SMALLEST
    };
    let mut doubts = Vec::from_iter(few_bits(left, right).map(ImageDoubt::FewBits));
    doubts.extend(few_levels(left, right).map(ImageDoubt::FewLevels));
    doubts.extend(unequal_bits(left, right).map(ImageDoubt::UnequalBits));
    let saturated = [left, right].map(saturated);
    let is_much = saturated.iter().any(|&share| share > MUCH_SATURATED);
    doubts.extend(is_much.then_some(ImageDoubt::Saturated(saturated)));
    if is_large(left) && is_large(right) {
        let details = [left, right].map(details);
        let mut all = details.as_flattened().iter();
        let are_compressed = all.all(|detail| detail.blockiness() > BLOCKY);
        doubts.extend(are_compressed.then_some(ImageDoubt::Compressed));
        doubts.extend(blurred(&details));
    }
    doubts
}

/// How many of 16 bits the samples of a pair use, where they leave many unused ([`ImageDoubt::FewBits`], told quickly).
/// `None` where they do not, for samples of 8 bits, and for black images, of which there is nothing to tell.
pub fn few_bits(left: &Image, right: &Image) -> Option<u32> {
    if left.depth() < u16::BITS || right.depth() < u16::BITS {
        return None;
    }
    few_of_16(levels(left, right)?)
}

/// The share of an image's pixels all colours of which are as bright as samples can be.
fn saturated(image: &Image) -> f64 {
    fn of<T: Copy + PartialEq, const N: usize>(pixels: &[[T; N]], most: T) -> f64 {
        let count = pixels.iter().filter(|pixel| **pixel == [most; N]).count();
        count as f64 / pixels.len().max(1) as f64
    }
    match image {
        Image::Grey8(plane) => of(plane.samples().as_chunks::<1>().0, u8::MAX),
        Image::Grey16(plane) => of(plane.samples().as_chunks::<1>().0, u16::MAX),
        Image::Rgb8(plane) => of(plane.samples(), u8::MAX),
        Image::Rgb16(plane) => of(plane.samples(), u16::MAX),
    }
}

/// How many of 16 bits samples between these two use, where they leave many unused, and do not fill so small a part of
/// the others that it is not bits which they lack.
fn few_of_16(levels: [u32; 2]) -> Option<u32> {
    let ([least, most], used) = (levels, bits_of(levels));
    let are_far_from_0 = least < most && (most - least) * PART_OF_BITS < 1 << used;
    ((1..=FEW_BITS).contains(&used) && !are_far_from_0).then_some(used)
}

/// How many bits the samples of each image of a pair use, where one leaves many of its 16 unused and the other does not.
fn unequal_bits(left: &Image, right: &Image) -> Option<[u32; 2]> {
    if left.depth().max(right.depth()) < u16::BITS {
        return None;
    }
    let used = |image: &Image| Some((bits_of(image.extremes()?), image.depth()));
    let [(left, of_left), (right, of_right)] = [used(left)?, used(right)?];
    let [unused, of_other] = [of_left.checked_sub(left)?, of_right.checked_sub(right)?];
    let is_few = |used: u32, depth: u32| depth == u16::BITS && (1..=FEW_BITS).contains(&used);
    let one_is = is_few(left, of_left) != is_few(right, of_right);
    (one_is && unused.abs_diff(of_other) >= UNEQUAL_BITS).then_some([left, right])
}

/// Between which levels all samples of a pair of one depth lie, where these are few and [`few_bits`] does not tell it.
fn few_levels(left: &Image, right: &Image) -> Option<[u32; 3]> {
    let levels = levels(left, right)?;
    let [least, most] = levels;
    let are_few = least < most
        && match (left.depth(), right.depth()) {
            (u8::BITS, u8::BITS) => most - least < FEW_OF_256,
            (u16::BITS, u16::BITS) => most - least < FEW_LEVELS && few_of_16(levels).is_none(),
            _ => false,
        };
    are_few.then_some([least, most, (1 << left.depth()) - 1])
}

/// The smallest and the largest sample of a pair.
fn levels(left: &Image, right: &Image) -> Option<[u32; 2]> {
    let [[least, most], [least_right, most_right]] = [left.extremes()?, right.extremes()?];
    Some([least.min(least_right), most.max(most_right)])
}

/// How many bits the largest sample takes.
fn bits_of([_, most]: [u32; 2]) -> u32 {
    u32::BITS - most.leading_zeros()
}

/// Which image of a pair is clearly less sharp, along their rows and down their columns.
fn blurred([left, right]: &[[Detail; 2]; 2]) -> Option<ImageDoubt> {
    let [along, down] = [0, 1].map(|way| left[way].fineness() / right[way].fineness());
    let [more, less] = [along.max(down), 1.0 / along.min(down)];
    if more.max(less) <= UNEQUAL || !more.max(less).is_finite() {
        return None;
    }
    Some(if more > less { ImageDoubt::RightBlurred(more) } else { ImageDoubt::LeftBlurred(less) })
}

#[cfg(test)]
mod tests {
    use raster::Plane;

    use super::super::detail::BLOCK;
    use super::*;

    #[test]
    fn few_of_16_bits_are_seen_unless_one_image_uses_more() {
        let deep = |largest| Image::Grey16(Plane::filled(2, 1, largest));
        assert_eq!(few_bits(&deep(0x0fff), &deep(3)), Some(12));
        assert_eq!(few_bits(&deep(0x3fff), &deep(3)), Some(14));
        assert_eq!(few_bits(&deep(0x4000), &deep(3)), None);
        assert_eq!(few_bits(&deep(3), &deep(0x4000)), None);
        assert_eq!(few_bits(&deep(0), &deep(0)), None);
        let [doubt] = image_doubts(&deep(0x0fff), &deep(3)).try_into().unwrap();
        assert_eq!(doubt, ImageDoubt::FewBits(12));
        assert!(doubt.to_string().ends_with("widen the samples from 12 bits"));
        let shallow = Image::Grey8(Plane::filled(2, 1, 3));
        assert_eq!(few_bits(&deep(3), &shallow), None);
        assert_eq!(few_bits(&shallow, &deep(3)), None);
        assert_eq!(few_levels(&deep(30_000), &deep(30_255)), Some([30_000, 30_255, 65_535]));
        // Of 14 bits, but it is not bits that they lack.
        assert_eq!(few_bits(&deep(8_000), &deep(8_300)), None);
        assert_eq!(few_levels(&deep(8_000), &deep(8_300)), Some([8_000, 8_300, 65_535]));
        assert_eq!(
            few_levels(&shallow, &Image::Grey8(Plane::filled(2, 1, 34))),
            Some([3, 34, 255])
        );
        assert_eq!(few_levels(&shallow, &Image::Grey8(Plane::filled(2, 1, 35))), None);
        assert_eq!(few_levels(&shallow, &shallow), None, "there is nothing to spread");
        assert_eq!(few_levels(&deep(30_000), &deep(34_096)), None);
        assert_eq!(few_levels(&deep(100), &deep(3255)), None, "few bits");
        assert_eq!(few_levels(&shallow, &deep(34)), None, "not of one depth");
        assert_eq!(few_levels(&deep(65_535), &deep(65_535)), None, "there is nothing to spread");
    }

    #[test]
    fn samples_of_other_bits_than_those_of_the_other_image_are_told() {
        let deep = |largest: u16| Image::Grey16(Plane::filled(2, 1, largest));
        let shallow = |largest: u8| Image::Grey8(Plane::filled(2, 1, largest));
        assert_eq!(unequal_bits(&deep(0x0fff), &deep(0xffff)), Some([12, 16]));
        assert_eq!(unequal_bits(&shallow(200), &deep(0x03ff)), Some([8, 10]));
        assert_eq!(image_doubts(&deep(7), &shallow(254)), [ImageDoubt::UnequalBits([3, 8])]);
        for (left, right) in [
            (deep(0x0fff), deep(0x03ff)),
            (deep(0x3fff), deep(0xffff)),
            (shallow(9), shallow(255)),
            (deep(0), deep(0xffff)),
            (shallow(12), deep(0x0fff)),
        ] {
            assert_eq!(unequal_bits(&left, &right), None);
        }
    }

    #[test]
    fn much_that_is_as_bright_as_can_be_is_told() {
        let bright = |part: usize| {
            let colour = |x: usize| if x < part { [255; 3] } else { [255, 9, (7 * x) as u8] };
            Image::Rgb8(Plane::from_fn(40, 2, |x, _| colour(x)))
        };
        assert_eq!(image_doubts(&bright(10), &bright(3)), []);
        let [doubt] = image_doubts(&bright(11), &bright(20)).try_into().unwrap();
        assert_eq!(doubt, ImageDoubt::Saturated([0.275, 0.5]));
        assert!(doubt.to_string().starts_with("28 % of the left and 50 % of the right"), "{doubt}");
    }

    /// Texture at several sizes.
    fn texture(x: usize, y: usize) -> f32 {
        let noise = |x: usize, y: usize| {
            let v = (x * 0x9E37 + y * 0x79B9).wrapping_mul(0x2545_F491_4F6C_DD1D);
            ((v ^ v >> 29).wrapping_mul(0x5851_F42D_4C95_7F2D) >> 56) as f32
        };
        0.2 * noise(x, y) + 0.3 * noise(x / 3, y / 3) + 0.5 * noise(x / 11, y / 11)
    }

    fn image(grey: impl Fn(usize, usize) -> f32) -> Image {
        Image::Grey8(Plane::from_fn(160, 120, |x, y| grey(x, y) as u8))
    }

    #[test]
    fn blocks_are_seen_where_both_images_have_them_in_both_directions() {
        // Every block is a little brighter or darker than what it shows.
        let shade = |x: usize, y: usize| (8 + (x / BLOCK * 5 + y / BLOCK * 3) % 7) as f32;
        let blocks = image(|x, y| 0.06 * texture(x, y) + shade(x, y));
        let clean = image(|x, y| 0.06 * texture(x, y));
        let stripes = image(|x, y| 0.06 * texture(x, y) + shade(x, 0));
        let are_compressed =
            |left, right| image_doubts(left, right).contains(&ImageDoubt::Compressed);
        assert!(are_compressed(&blocks, &blocks));
        for (left, right) in [(&clean, &blocks), (&blocks, &clean), (&stripes, &stripes)] {
            assert!(!are_compressed(left, right));
        }
        let black = image(|_, _| 0.0);
        assert!(!are_compressed(&black, &black));
    }

    #[test]
    fn the_image_with_less_fine_detail_is_told() {
        let sharp = image(texture);
        let soft = image(|x, y| (0..4).map(|i| texture(x + i, y)).sum::<f32>() / 4.0);
        assert_eq!(image_doubts(&sharp, &sharp), []);
        let ratio = match image_doubts(&sharp, &soft)[..] {
            [ImageDoubt::RightBlurred(ratio)] => ratio,
            ref other => panic!("{other:?}"),
        };
        let other = match image_doubts(&soft, &sharp)[..] {
            [ImageDoubt::LeftBlurred(ratio)] => ratio,
            ref other => panic!("{other:?}"),
        };
        assert!(ratio > 2.0 && (ratio - other).abs() < 1e-9, "{ratio}, {other}");
        // Half as bright is as sharp.
        assert_eq!(image_doubts(&sharp, &image(|x, y| 0.5 * texture(x, y))), []);
        let blank = image(|_, _| 7.0);
        for (left, right) in [(&sharp, &blank), (&blank, &sharp), (&blank, &blank)] {
            assert_eq!(image_doubts(left, right), []);
        }
    }
}
