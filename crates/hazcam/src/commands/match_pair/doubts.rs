//! What is doubtful about a pair and its answer, what it may come from, and what to do, in words.

use std::path::{Display, Path};

use matching::{Doubt, ImageDoubt, VerticalDisparity, image_doubts};
use raster::{DisparityRange, Image};

use super::{Args, HolesArgument};
use crate::ui::Ui;

/// What is doubtful about the images of two files, whose samples were said to have so many `bits`.
pub fn of_images(
    [(left, of_left), (right, of_right)]: [(&Path, &Image); 2],
    bits: Option<u32>,
) -> Vec<String> {
    let (left, right) = (left.display(), right.display());
    let less_sharp = |less: &Display<'_>, more: &Display<'_>, ratio: f64| {
        format!(
            "{more} has {ratio:.1} times as much fine detail as {less}: is one out of focus, moved, of another \
             resolution or noisier? Where edges are blurred in one image alone matches are off, and may be sure"
        )
    };
    // Who says how many bits there are knows.
    let is_news = |doubt: &ImageDoubt| bits.is_none() || !matches!(doubt, ImageDoubt::FewBits(_));
    let doubts = image_doubts(of_left, of_right).into_iter().filter(is_news);
    let in_words = doubts.map(|doubt| match doubt {
        ImageDoubt::FewBits(used) => format!(
            "{left} and {right}: of 16 bits the upper {} are never used, which makes matches worse; if the camera \
             gives {used} bits, say --bits {used}",
            u16::BITS - used,
        ),
        ImageDoubt::FewLevels([least, most, all]) => format!(
            "{left} and {right}: all samples lie from {least} to {most}, of 0 to {all}, which makes matches worse; expose \
             for longer, or spread them over all before"
        ),
        ImageDoubt::UnequalBits([of_left, of_right]) => format!(
            "the samples of {left} use {of_left} bits, those of {right} {of_right}: steps of grey are far smaller in one \
             of them, which makes matches worse; store both alike, over all bits"
        ),
        ImageDoubt::Saturated(shares) => {
            let [of_left, of_right] = shares.map(|share| 100.0 * share);
            format!(
                "{of_left:.0} % of {left} and {of_right:.0} % of {right} are as bright as samples can be, where nothing \
                 is matched: expose for shorter"
            )
        }
        ImageDoubt::Compressed => format!(
            "{left} and {right} show the blocks of 8 x 8 pixels of a compression, which are in the same places of \
             both and are matched at multiples of 8 pixels: take pictures without, or of a better quality"
        ),
        ImageDoubt::LeftBlurred(ratio) => less_sharp(&left, &right, ratio),
        ImageDoubt::RightBlurred(ratio) => less_sharp(&right, &left, ratio),
    });
    in_words.collect()
}

/// How far the rows of a right image were off, and what that says of the cameras.
pub fn of_rows(right: &Path, vertical: &VerticalDisparity) -> String {
    let off = vertical.disparity_error();
    let advice = match vertical.largest() > VerticalDisparity::BADLY_RECTIFIED {
        _ if off > VerticalDisparity::TELLING => format!(
            "; for the same reason disparities may be off by up to {off:.1} px towards the edges, which is not \
             mended and which confidence does not know: rectify the cameras anew"
        ),
        true => "; rectify the cameras anew if you can".into(),
        false => String::new(),
    };
    let turned = vertical.common_disparity().map(|off| {
        format!(
            "; a lens may have done that, or cameras that are turned against each other about the upright axis: then all \
             disparities are off by some {off:.0} px (where the focal length is the images' width), which nothing in them \
             shows: compare a distance that you know"
        )
    });
    format!(
        "{}: things stand up to {:.1} px higher or lower than on the left ({:.2} px rms), which was mended{advice}{}",
        right.display(),
        vertical.largest(),
        vertical.root_mean_square(),
        turned.unwrap_or_default(),
    )
}

/// Says what is doubtful about the answer.
pub fn tell(doubt: Doubt, args: &Args, range: DisparityRange, ui: &Ui) {
    let (min, max) = (range.min(), range.max());
    match doubt {
        Doubt::HardlyMatched(share) => ui.warn(format_args!(
            "only {:.1} % of the pixels are matched, so {} is to be doubted. Either {} is not \
             the left image of the two (exchange them), or things lie outside disparities {min} to \
             {max} (raise --max-disparity, lower --min-disparity), or the two are no rectified pair \
             of one scene (rectify them{}), or they have no texture{}",
            100.0 * share,
            args.output.display(),
            args.left.display(),
            match args.matcher.as_str() {
                "fast" => "; where rows alone are off, --matcher balanced mends them",
                _ => "",
            },
            match args.matcher.as_str() {
                "best" => "",
                _ => ", or so much of it that more effort is needed (--matcher best)",
            },
        )),
        Doubt::Nearer(share) => ui.warn(format_args!(
            "{:.1} % of the matched pixels lie at the largest disparity, {max}: there may be \
             nearer things that are missed; raise --max-disparity",
            100.0 * share,
        )),
        Doubt::PerhapsNearer(share) => ui.warn(format_args!(
            "only {:.1} % of the pixels are matched, and they do not thin out towards the largest disparity, {max}: \
             there may be nearer things{}; raise --max-disparity",
            100.0 * share,
            match args.holes {
                HolesArgument::Fill => ", which are filled as if they were far",
                HolesArgument::Keep => " that are missed",
            },
        )),
        Doubt::Farther(share) => ui.warn(format_args!(
            "{:.1} % of the matched pixels lie at the smallest disparity, {min}: there may be \
             farther things that are missed; lower --min-disparity",
            100.0 * share,
        )),
        Doubt::Infinite(share) => ui.note(format_args!(
            "{:.1} % of the matched pixels lie at disparity 0, infinitely far. If nothing is, the two show what \
             belongs to the cameras: blocks of compressed pictures, dust on lenses, vignetting",
            100.0 * share,
        )),
    }
}
