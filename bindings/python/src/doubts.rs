//! What is doubtful about an answer, in words for Python programmers.

use matching::{Doubt, ImageDoubt, VerticalDisparity, doubts, few_bits, image_doubts};
use raster::{BoundingBox, DisparityRange, Image};

/// Says what is doubtful, what it may come from, and what to do. The same doubts about another frame
/// have the same words, so that Python shows them once for a line of a program, not with each frame.
pub fn in_words(
    matcher: &matching::Matcher,
    left: &Image,
    right: &Image,
    bounds: Option<BoundingBox>,
) -> Vec<String> {
    let range = matcher.options().range;
    let bounds = bounds.unwrap_or(BoundingBox::whole(left.columns(), left.rows()));
    let mut words: Vec<String> = few_bits(left, right).map(of_bits).into_iter().collect();
    words.extend(matcher.vertical_disparity().and_then(of_rows));
    words.extend(doubts(matcher.map(), bounds, range).into_iter().map(|doubt| of(doubt, range)));
    words
}

/// What is doubtful about the images themselves, which takes a while to see.
pub fn of_images(left: &Image, right: &Image) -> Vec<String> {
    // The number of bits is asked for with each frame.
    let is_news = |doubt: &ImageDoubt| !matches!(doubt, ImageDoubt::FewBits(_));
    image_doubts(left, right).into_iter().filter(is_news).map(of_image).collect()
}

fn of_image(doubt: ImageDoubt) -> String {
    let less_sharp = |less, more| {
        format!(
            "`{more}` has much more fine detail than `{less}`: is one out of focus, moved, of another resolution or \
             noisier? Where edges are blurred in one image alone matches are off, and may be sure"
        )
    };
    match doubt {
        ImageDoubt::FewBits(used) => of_bits(used),
        ImageDoubt::FewLevels(_) => "all samples of `left` and `right` lie in a small part of what they hold, which makes \
                                     matches worse; spread them over all of it, alike in both"
            .to_owned(),
        ImageDoubt::UnequalBits([left, right]) => format!(
            "the samples of `left` use {left} bits, those of `right` {right}: steps of grey are far smaller in one of \
             them, which makes matches worse; give both over all bits"
        ),
        ImageDoubt::Saturated(shares) => format!(
            "more than a quarter of `{}` is as bright as samples can be, where nothing is matched: expose for shorter",
            if shares[0] >= shares[1] { "left" } else { "right" }
        ),
        ImageDoubt::Compressed => "`left` and `right` show the blocks of 8 x 8 pixels of a compression, which are in \
                                   the same places of both and are matched at multiples of 8 pixels: take pictures \
                                   without, or of a better quality"
            .to_owned(),
        ImageDoubt::LeftBlurred(_) => less_sharp("left", "right"),
        ImageDoubt::RightBlurred(_) => less_sharp("right", "left"),
    }
}

fn of_bits(used: u32) -> String {
    let unused = u16::BITS - used;
    format!(
        "of the 16 bits of `left` and `right` the upper {unused} are never used, which makes \
         matches worse; if the camera gives {used} bits, give left << numpy.uint16({unused}) and \
         the right one alike"
    )
}

fn of_rows(vertical: &VerticalDisparity) -> Option<String> {
    if let Some(off) = vertical.common_disparity() {
        return Some(format!(
            "things stand higher or lower in `right` than in `left`, which was mended (`vertical_disparity` tells how \
             far); a lens may have done that, or cameras that are turned against each other about the upright axis: then \
             all disparities are off by some {off:.0} px (where the focal length is the images' width), which nothing in \
             them shows: compare a distance that you know, or rectify the cameras anew"
        ));
    }
    if vertical.disparity_error() > VerticalDisparity::TELLING {
        return Some(
            "things stand higher or lower in `right` than in `left`, which was mended (`vertical_disparity` tells how \
             far); for the same reason disparities may be off towards the edges, which is not mended and which \
             confidence does not know: rectify the cameras anew"
                .to_owned(),
        );
    }
    let limit = VerticalDisparity::BADLY_RECTIFIED;
    (vertical.largest() > limit).then(|| {
        format!(
            "things stand more than {limit} pixels higher or lower in `right` than in `left`, which \
             was mended (`vertical_disparity` tells how far); rectify the cameras anew if you can"
        )
    })
}

fn of(doubt: Doubt, range: DisparityRange) -> String {
    let (min, max) = (range.min(), range.max());
    match doubt {
        Doubt::HardlyMatched(_) => format!(
            "few pixels are matched, so this is to be doubted. Either `left` is not the \
             left image of the two (exchange them), or things lie outside disparities {min} to {max} \
             (raise `max_disparity`, lower `min_disparity`), or the two are no rectified pair of one \
             scene (rectify them), or they have no texture, or so much of it that more effort is needed \
             (preset 'best')"
        ),
        Doubt::Nearer(_) => format!(
            "many of the matched pixels lie at the largest disparity, {max}: there may be nearer \
             things that are missed; raise `max_disparity`"
        ),
        Doubt::PerhapsNearer(_) => format!(
            "many of the pixels are not matched, and those that are do not thin out towards the largest disparity, {max}: \
             there may be nearer things that are missed, and filled as if they were far where holes are filled; raise \
             `max_disparity`"
        ),
        Doubt::Farther(_) => format!(
            "many of the matched pixels lie at the smallest disparity, {min}: there may be farther \
             things that are missed; lower `min_disparity`"
        ),
        Doubt::Infinite(_) => "many of the matched pixels lie at disparity 0, infinitely far. If nothing is, the two \
                               show what belongs to the cameras: blocks of compressed pictures, dust on lenses, \
                               vignetting"
            .to_owned(),
    }
}
