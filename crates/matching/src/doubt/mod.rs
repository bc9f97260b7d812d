//! What makes an answer doubtful though no rule was broken: little matched, or what matched
//! piles up at an end of the range, or does not thin out towards it. What makes images doubtful stands in [`images`].

mod detail;
mod images;

use std::fmt;

use raster::{BoundingBox, DisparityMap, DisparityRange, Reason};

pub use images::{ImageDoubt, few_bits, image_doubts};

/// With a smaller share of the answered pixels matched, the two are hardly a pair with that range. Of
/// Middlebury's, KITTI's and ETH3D's scenes 38 % and more are matched; of exchanged images, and of rows that are off
/// by more than can be mended, mostly 3 to 20, and up to 33.
const FEW: f64 = 0.33;
/// An answer of fewer columns says nothing about the pair: a box may be all wall or all shadow, and in a
/// small image the windows and what only one camera sees are most of it.
const NARROW: usize = 64;
/// With a larger share of the matched pixels at the last disparity, things go on beyond it. Cones, which
/// reach 54.7, have 5 to 7 % there with a range to 40, none with 64; ranges that just hold their scene
/// leave up to 2 %.
const MANY: f64 = 0.03;
/// With a smaller share of the answered pixels matched, and at least so many times as many of them in the nearest tenth
/// of the range as if they were spread evenly, things may go on beyond it: a near one finds no match, and is filled as
/// if it were far. In half of their own range, that, [`MANY`] and [`FEW`] tell of 36 of 52 tuning scenes with `fast` and
/// of 48 with `balanced`; in their own, of 2 and 1 (a blank wall, a lattice).
const NOT_MANY: f64 = 0.6;
const DENSE: f64 = 0.7;
/// What a tenth of a shorter range holds says little.
const LEAST_RANGE: usize = 16;
/// With a larger share of the matched pixels within half a pixel of disparity 0, much is infinitely far.
const MANY_INFINITE: f64 = 0.2;

/// What there is to doubt about an answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Doubt {
    /// So small a share of the answered pixels is matched.
    HardlyMatched(f64),
    /// So large a share of the matched pixels lies at the largest disparity.
    Nearer(f64),
    /// So small a share of the answered pixels is matched, and the matched ones do not thin out towards the largest
    /// disparity.
    PerhapsNearer(f64),
    /// So large a share of the matched pixels lies at the smallest disparity.
    Farther(f64),
    /// So large a share of the matched pixels lies at disparity 0, infinitely far. What stays in one place of both
    /// images is matched there too: the blocks of a compressed picture, dust, vignetting.
    Infinite(f64),
}

/// What it is, what it may come from, and what to do.
impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let per_cent = |share: f64| 100.0 * share;
        match *self {
            Self::HardlyMatched(share) => write!(
                f,
                "only {:.1} % of the pixels are matched: the images may be exchanged or no rectified pair of one scene, \
                 things may lie outside of the range of disparities, or have no texture",
                per_cent(share)
            ),
            Self::Nearer(share) => write!(
                f,
                "{:.1} % of the matched pixels lie at the largest disparity: there may be nearer things that are missed, \
                 so search further",
                per_cent(share)
            ),
            Self::PerhapsNearer(share) => write!(
                f,
                "only {:.1} % of the pixels are matched, and they do not thin out towards the largest disparity: there may \
                 be nearer things, which are filled as if they were far where holes are filled, so search further",
                per_cent(share)
            ),
            Self::Farther(share) => write!(
                f,
                "{:.1} % of the matched pixels lie at the smallest disparity: there may be farther things that are \
                 missed, so begin lower",
                per_cent(share)
            ),
            Self::Infinite(share) => write!(
                f,
                "{:.1} % of the matched pixels lie at disparity 0, infinitely far: if nothing is, blocks of compression, \
                 dust or vignetting were matched",
                per_cent(share)
            ),
        }
    }
}

/// Doubts about a matcher's answer in a box, all of which was answered, for disparities of a range. Where
/// little matched, it is not asked where that lies.
///
/// # Panics
///
/// If the box leaves the map, or the map's planes are not of one size.
pub fn doubts(map: &DisparityMap, bounds: BoundingBox, range: DisparityRange) -> Vec<Doubt> {
    let (columns, rows) = map.values.size();
    bounds.check_within(columns, rows).expect("the box lies in the map");
    let answered = bounds.columns() * bounds.rows();
    let (min, max) = (range.min() as f32, range.max() as f32);
    let tenth = range.count() as f32 / 10.0;
    let [mut matched, mut nearest, mut near, mut farthest, mut infinite] = [0; 5];
    for y in bounds.y0..=bounds.y1 {
        let part = bounds.x0..=bounds.x1;
        let pixels = map.values.row(y)[part.clone()].iter().zip(&map.reasons.row(y)[part]);
        for (&value, &reason) in pixels {
            let count = |there: bool| u64::from((reason == Reason::Matched) & there);
            matched += count(true);
            nearest += count(value >= max - 0.5);
            near += count(value >= max - tenth);
            farthest += count(value <= min + 0.5);
            infinite += count(value.abs() < 0.5);
        }
    }
    let share = matched as f64 / answered as f64;
    // Nothing at all is nothing, whatever it is of.
    if matched == 0 || share < FEW && bounds.columns() >= NARROW {
        return vec![Doubt::HardlyMatched(share)];
    }
    if bounds.columns() < NARROW {
        return Vec::new();
    }
    // In a short range the last disparity is a large share of it, whatever is seen.
    let many = MANY.max(1.0 / range.count() as f64);
    let [nearest, near, farthest, infinite] =
        [nearest, near, farthest, infinite].map(|count: u64| count as f64 / matched as f64);
    let mut doubts = Vec::new();
    if nearest > many {
        doubts.push(Doubt::Nearer(nearest));
    } else if range.count() >= LEAST_RANGE && share < NOT_MANY && near > DENSE / 10.0 {
        doubts.push(Doubt::PerhapsNearer(share));
    }
    // At 0 things are infinitely far: nothing is behind that.
    if range.min() != 0 && farthest > many {
        doubts.push(Doubt::Farther(farthest));
    }
    // Who searches below 0 has a pair that is cropped or turned inwards, and sees infinity elsewhere.
    if range.min() == 0 && infinite > MANY_INFINITE {
        doubts.push(Doubt::Infinite(infinite));
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The doubts about 100 columns of which some are matched, each at a disparity.
    fn about(columns: usize, disparities: &[(usize, f32)], range: (i32, i32)) -> Vec<Doubt> {
        let mut map = DisparityMap::empty(columns, 1);
        map.reasons.samples_mut().fill(Reason::MismatchedFilled);
        map.values.samples_mut().fill(range.1 as f32);
        let all = disparities.iter().flat_map(|&(count, value)| std::iter::repeat_n(value, count));
        for (x, value) in all.enumerate() {
            map.values.samples_mut()[x] = value;
            map.reasons.samples_mut()[x] = Reason::Matched;
        }
        let range = DisparityRange::new(range.0, range.1).unwrap();
        doubts(&map, BoundingBox::whole(columns, 1), range)
    }

    #[test]
    fn few_matches_are_doubted_but_not_in_a_narrow_image() {
        let words = Doubt::HardlyMatched(0.32).to_string();
        assert!(words.starts_with("only 32.0 % of the pixels are matched: "), "{words}");
        assert_eq!(about(100, &[(32, 40.0)], (0, 40)), [Doubt::HardlyMatched(0.32)]);
        assert_eq!(about(100, &[(33, 20.0)], (0, 40)), []);
        assert_eq!(about(64, &[], (0, 40)), [Doubt::HardlyMatched(0.0)]);
        assert_eq!(about(63, &[(1, 20.0)], (0, 40)), []);
        assert_eq!(about(1, &[], (0, 40)), [Doubt::HardlyMatched(0.0)], "nothing at all");
    }

    #[test]
    fn matches_that_do_not_thin_out_are_doubted_where_there_are_few() {
        // In a range of 41 a tenth begins at 35.9, and 7.2 % of all is .7 times as many as evenly spread.
        let nearer = Doubt::PerhapsNearer(0.55);
        assert_eq!(about(100, &[(51, 10.0), (4, 36.0)], (0, 40)), [nearer]);
        assert_eq!(about(100, &[(52, 10.0), (3, 36.0)], (0, 40)), []);
        assert_eq!(about(100, &[(51, 10.0), (4, 35.8)], (0, 40)), []);
        assert_eq!(about(100, &[(54, 10.0), (6, 36.0)], (0, 40)), []);
        assert_eq!(about(100, &[(51, -25.0), (4, -4.0)], (-40, 0)), [nearer]);
        for count in 1..LEAST_RANGE as i32 {
            let all_over = about(100, &[(50, 1.0)], (1, count));
            assert!(!all_over.contains(&Doubt::PerhapsNearer(0.5)), "{all_over:?}");
        }
        let words = nearer.to_string();
        assert!(
            words.contains("55.0 % of the pixels are matched, and they do not thin"),
            "{words}"
        );
    }

    #[test]
    fn many_matches_at_an_end_of_the_range_are_doubted() {
        let at = |value| [(48, 10.0), (2, value)];
        assert_eq!(about(100, &at(39.5), (0, 40)), [Doubt::Nearer(0.04)]);
        assert_eq!(about(100, &at(39.4), (0, 40)), []);
        assert_eq!(about(100, &at(0.0), (0, 40)), []);
        assert_eq!(about(100, &[(40, 10.0), (11, 0.4)], (0, 40)), [Doubt::Infinite(11.0 / 51.0)]);
        assert_eq!(about(100, &[(40, 10.0), (10, 0.4)], (0, 40)), []);
        assert_eq!(about(100, &[(40, 10.0), (11, 0.4)], (-20, 40)), []);
        assert_eq!(about(100, &at(5.5), (5, 40)), [Doubt::Farther(0.04)]);
        assert_eq!(about(100, &at(-7.0), (-7, 40)), [Doubt::Farther(0.04)]);
        assert_eq!(about(100, &[(49, 10.0), (1, 40.0)], (0, 40)), []);
        assert_eq!(about(100, &at(14.0), (0, 14)), []);
        let four = 4.0 / 52.0;
        assert_eq!(about(100, &[(48, 10.0), (4, 14.0)], (0, 14)), [Doubt::Nearer(four)]);
    }
}
