//! Which pixels show nothing: all grey around them is one value, as in a sky that is too bright or a shadow that is
//! too dark. No disparity fits better than another there, and what paths and choices carry in from beside it is a
//! guess, however smooth and sure. Where a camera is within its range its noise tells otherwise.

use raster::{Reason, View};

use crate::kernels::level::{Level, at_every_level};
use crate::prepare::grey::GreyView;
use crate::profile::Work;

/// A window reaches so far: 9 x 9 pixels, of which the part within the image counts.
const REACH: usize = 4;
const ACROSS: usize = 2 * REACH + 1;
/// So many columns are looked at together.
const BLOCK: usize = 64;

/// Takes the matches of a row of a map, which begins at column `first` of row `y` of the image, for guesses where they
/// show nothing.
pub(crate) fn reject(
    level: Level,
    image: GreyView<'_>,
    (first, y): (usize, usize),
    reasons: &mut [Reason],
) {
    match image {
        GreyView::Depth8(view) => reject_8_bit(level, &around(view, y), first, reasons),
        GreyView::Depth16(view) => reject_16_bit(level, &around(view, y), first, reasons),
    }
}

/// What [`reject`] does to a pixel at the least: its row is read, of which the lowest and the highest are found.
pub(crate) fn work(image: GreyView<'_>) -> Work {
    let sample = image.bytes(1) / image.size().0;
    Work::bytes(sample + 2 * size_of::<Reason>()) + Work::operations(2 * ACROSS * sample)
}

/// The rows of a window; of those beyond the image the nearest one.
fn around<T>(view: View<'_, T>, y: usize) -> [&[T]; ACROSS] {
    let last = view.rows() - 1;
    std::array::from_fn(|i| view.row((y + i).saturating_sub(REACH).min(last)))
}

at_every_level! {
    fn reject_8_bit(rows: &[&[u8]; ACROSS], first: usize, reasons: &mut [Reason]) {
        reject_row(rows, u8::MIN..=u8::MAX, first, reasons);
    }

    fn reject_16_bit(rows: &[&[u16]; ACROSS], first: usize, reasons: &mut [Reason]) {
        reject_row(rows, u16::MIN..=u16::MAX, first, reasons);
    }
}

/// Of samples from the least that there may be to the most.
#[inline(always)]
fn reject_row<T: Copy + Ord>(
    rows: &[&[T]; ACROSS],
    all: std::ops::RangeInclusive<T>,
    first: usize,
    reasons: &mut [Reason],
) {
    for (start, reasons) in (first..).step_by(BLOCK).zip(reasons.chunks_mut(BLOCK)) {
        // Hardly a row of an image with texture has so many alike: the others need not be looked at then.
        let [lowest, highest] = extremes(&rows[REACH..][..1], &all, start);
        let alike = lowest.iter().zip(&highest).fold(false, |any, (l, h)| any | (l == h));
        if !alike {
            continue;
        }
        let [lowest, highest] = extremes(rows, &all, start);
        for ((reason, lowest), highest) in reasons.iter_mut().zip(&lowest).zip(&highest) {
            let guessed = (lowest == highest) & (*reason == Reason::Matched);
            *reason = if guessed { Reason::MismatchedFilled } else { *reason };
        }
    }
}

/// The lowest and the highest sample of the windows around the columns of a block, in some rows.
#[inline(always)]
fn extremes<T: Copy + Ord>(
    rows: &[&[T]],
    all: &std::ops::RangeInclusive<T>,
    start: usize,
) -> [[T; BLOCK]; 2] {
    const SEEN: usize = BLOCK + 2 * REACH;
    let (from, to) = (start.saturating_sub(REACH), (start + BLOCK + REACH).min(rows[0].len()));
    let (mut least, mut most) = ([*all.end(); SEEN], [*all.start(); SEEN]);
    let inside = from + REACH - start..to + REACH - start;
    for row in rows {
        let bounds = least[inside.clone()].iter_mut().zip(&mut most[inside.clone()]);
        for ((least, most), &sample) in bounds.zip(&row[from..to]) {
            (*least, *most) = (sample.min(*least), sample.max(*most));
        }
    }
    let (mut lowest, mut highest) = ([*all.end(); BLOCK], [*all.start(); BLOCK]);
    for shift in 0..ACROSS {
        let (least, most) = (&least[shift..][..BLOCK], &most[shift..][..BLOCK]);
        for i in 0..BLOCK {
            (lowest[i], highest[i]) = (lowest[i].min(least[i]), highest[i].max(most[i]));
        }
    }
    [lowest, highest]
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::Plane;

    #[test]
    fn where_all_around_is_one_grey_nothing_is_matched_at_every_level() {
        use Reason::{Matched, MismatchedFilled, OccludedFilled};
        // A textured bar in a white image, and a dot that 9 columns and 9 rows see.
        let grey = |x: usize, y: usize| match () {
            () if (100..120).contains(&x) => (x * 37 + y * 11) as u8 % 200,
            () if (x, y) == (30, 9) => 254,
            () => 255,
        };
        let (columns, rows) = (200, 14);
        let shallow = Plane::from_fn(columns, rows, grey);
        // The same with the dot in the lower bits alone.
        let deep = Plane::from_fn(columns, rows, |x, y| match grey(x, y) {
            254 => 0xFFFE,
            grey => u16::from(grey) * 257,
        });
        let is_blank = |x: usize, y: usize| {
            let seen = |at: usize, end: usize| at.saturating_sub(REACH)..(at + REACH + 1).min(end);
            seen(y, rows).all(|v| seen(x, columns).all(|u| grey(u, v) == 255))
        };
        for level in Level::available() {
            eprintln!("level {}", level.name());
            for image in [GreyView::Depth8(shallow.view()), GreyView::Depth16(deep.view())] {
                for (first, count) in [(0, columns), (3, 150), (60, 140), (199, 1)] {
                    for y in 0..rows {
                        let before =
                            |x: usize| if x.is_multiple_of(5) { OccludedFilled } else { Matched };
                        let mut reasons: Vec<_> = (first..first + count).map(before).collect();
                        reject(level, image, (first, y), &mut reasons);
                        for (x, &reason) in (first..).zip(&reasons) {
                            let guessed = is_blank(x, y) && before(x) == Matched;
                            let expected = if guessed { MismatchedFilled } else { before(x) };
                            assert_eq!(reason, expected, "column {x}, row {y}");
                        }
                    }
                }
            }
        }
    }
}
