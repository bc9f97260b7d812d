//! Every matcher on a pair whose answer is known.

use matching::{Matcher, Options, Preset};
use raster::{BoundingBox, DisparityRange, Image, Plane};
use score::{Region, evaluate};

use super::Finding;
use crate::clock::Stopwatch;

/// Size of the pair in pixels: small enough for a second with every matcher.
const SIZE: (usize, usize) = (160, 96);
/// Disparity of the wall, and of the card in front of it.
const WALL: usize = 4;
const CARD: usize = 11;

/// Noise without any structure, so that every match is unique.
fn texture(x: usize, y: usize) -> u8 {
    let mixed = (x as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ (y as u64 + 1).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    (mixed.wrapping_mul(mixed >> 29 | 1) >> 56) as u8
}

fn on_card(x: usize, y: usize) -> bool {
    (60..110).contains(&x) && (30..70).contains(&y)
}

/// A wall with a card before it, as the left and the right camera see them, and the truth.
fn pair() -> (Image, Image, Plane<f32>) {
    let (columns, rows) = SIZE;
    let card = |x: usize, y: usize| texture(x + 1000, y);
    let left =
        Plane::from_fn(
            columns,
            rows,
            |x, y| if on_card(x, y) { card(x, y) } else { texture(x, y) },
        );
    let right = Plane::from_fn(columns, rows, |x, y| match on_card(x + CARD, y) {
        true => card(x + CARD, y),
        false => texture(x + WALL, y),
    });
    let truth =
        Plane::from_fn(columns, rows, |x, y| if on_card(x, y) { CARD as f32 } else { WALL as f32 });
    (Image::Grey8(left), Image::Grey8(right), truth)
}

/// One finding per matcher: right when at most one pixel in ten is off by more than 2 px. Where the
/// wall is hidden behind the card, and at the edges of the card, every matcher may err.
pub fn run() -> Vec<Finding> {
    let (left, right, truth) = pair();
    Preset::ALL
        .map(|preset| match check(preset, &left, &right, &truth) {
            Ok(detail) => Finding::ok(topic(preset), detail),
            Err(detail) => Finding::wrong(topic(preset), detail),
        })
        .into()
}

fn topic(preset: Preset) -> &'static str {
    match preset {
        Preset::Fast => "self-match fast",
        Preset::Balanced => "self-match balanced",
        Preset::Best => "self-match best",
    }
}

fn check(
    preset: Preset,
    left: &Image,
    right: &Image,
    truth: &Plane<f32>,
) -> Result<String, String> {
    let range = DisparityRange::new(0, 15).map_err(|e| e.to_string())?;
    let stopwatch = Stopwatch::start();
    let mut matcher = Matcher::new(Options::new(preset, range)).map_err(|e| e.to_string())?;
    let map = matcher.compute(left, right, None).map_err(|e| e.to_string())?;
    let seconds = stopwatch.elapsed().wall_s;
    // Left of this column the match lies outside the right image.
    let bounds = BoundingBox { x0: CARD, y0: 0, x1: SIZE.0 - 1, y1: SIZE.1 - 1 };
    let scores = evaluate(&map.values, truth, &Region::whole().within(Some(bounds)))
        .map_err(|e| e.to_string())?;
    let bad = scores.middlebury.bad[2].totbad;
    let detail = format!("{:.1} % of pixels off by > 2 px, {seconds:.3} s", 100.0 * bad);
    if bad <= 0.1 { Ok(detail) } else { Err(format!("{detail}; at most 10 % are to be expected")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pair_is_what_its_truth_says() {
        let (left, right, truth) = pair();
        let (Image::Grey8(left), Image::Grey8(right)) = (left, right) else { unreachable!() };
        let mut differing = 0;
        for y in 0..SIZE.1 {
            for x in CARD..SIZE.0 {
                let d = truth.row(y)[x] as usize;
                differing += usize::from(left.row(y)[x] != right.row(y)[x - d]);
            }
        }
        // Only the strip of wall that the card hides from the right camera, and where the texture
        // agrees by chance not even that.
        assert!((200..=(CARD - WALL) * 40).contains(&differing), "{differing}");
    }
}
