//! Disparities of both views, and how sure they are, from the sums of one row after the other.
//!
//! The confidence of a winner whose sum lies `m` below that of any other disparity is
//! `m / (m + HALF_SURE)`: the maximum margin (Hu & Mordohai, *A quantitative evaluation of confidence
//! measures for stereo vision*, PAMI 2012), brought to 0 to 1 by a formula of our own.

use crate::cost::SearchSpace;
use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;
use crate::selection::winner::{self, Key, Winners, tip_of_v};

/// A winner whose sum is so much below that of any other disparity has confidence 1/2.
const HALF_SURE: f32 = 60.0;

/// Of so few disparities a winner may have none to be compared with but its neighbours.
const FEW: usize = 3;

/// Some rows that are selected, in any order.
pub(crate) struct Selection<'a> {
    pub level: Level,
    pub space: &'a SearchSpace,
    /// How much [pixel locking](unlocked) to take out of fractions; without it disparities have none.
    pub sub_pixel: Option<f32>,
    /// Winners of the left view with a smaller margin are no matches; of [`FEW`] disparities those that no
    /// other one exceeds by as much.
    pub least_margin: u16,
    /// The first of the rows.
    pub first: usize,
    /// Per row `space.columns()` disparities of the left view.
    pub left: &'a mut [f32],
    /// The confidence of each.
    pub confidence: &'a mut [f32],
    /// Per row `space.width` disparities of the right view, as it looks in a mirror.
    pub right: &'a mut [f32],
    /// Scratch.
    pub winners: &'a mut Winners,
}

impl Selection<'_> {
    /// What a row amounts to besides its sums: two disparities and a confidence are written.
    pub fn work(space: &SearchSpace) -> Work {
        let written = size_of::<f32>() * (2 * space.columns() + space.width);
        Work::bytes(written) + Work::operations(winner::OPERATIONS) * space.pairs()
    }

    /// Selects row `y` from its sums.
    pub fn row(&mut self, y: usize, sums: &[u16]) {
        let (space, row, columns) = (self.space, y - self.first, self.space.columns());
        self.winners.select(self.level, space, sums);
        let left = &mut self.left[row * columns..][..columns];
        let confidence = &mut self.confidence[row * columns..][..columns];
        let winners = (&self.winners.left[..], &self.winners.margins[..]);
        let Self { level, sub_pixel, least_margin, .. } = *self;
        let has_others = space.count > FEW;
        let margin = if has_others { least_margin } else { 0 };
        left_row(level, space, sub_pixel, margin, sums, winners, left, confidence);
        if !has_others {
            reject_flat(space, least_margin, sums, left);
        }
        let right = &mut self.right[row * space.width..][..space.width];
        right_row(level, space, sub_pixel, sums, self.winners.right(space), right);
    }
}

/// Takes out the winners of columns whose sums differ by less than `least`.
fn reject_flat(space: &SearchSpace, least: u16, sums: &[u16], values: &mut [f32]) {
    let columns = sums.chunks_exact(space.lanes).zip(values).enumerate();
    for (column, (sums, value)) in columns {
        let tried = sums.get(space.candidates(space.in_image(column))).unwrap_or_default();
        let ends = tried.iter().max().zip(tried.iter().min());
        if ends.is_some_and(|(most, fewest)| most - fewest < least) {
            *value = f32::NAN;
        }
    }
}

/// So many winners are reckoned with together; only their sums are looked up one by one.
const BLOCK: usize = 64;

/// What a block of winners comes to.
struct Found {
    /// Disparities, counted from the smallest.
    disparity: [u16; BLOCK],
    is_match: [bool; BLOCK],
    /// The matched columns in which their sums lie, where both disparities beside them are tried.
    column: [u32; BLOCK],
    is_inner: [bool; BLOCK],
    /// The sums before, at and after the winner; all zero at the ends of the range, where there is no
    /// fraction.
    sums: [[u16; BLOCK]; 3],
}

impl Found {
    /// The matches among some winners. `inner` gets the disparity and the place among them of each, and says in
    /// which column its sum lies and whether disparities on both sides are tried there.
    #[inline(always)]
    fn among(
        winners: [Key; BLOCK],
        is_sure: [bool; BLOCK],
        inner: impl Fn(i32, i32) -> (i32, bool),
    ) -> Self {
        let mut found = Self {
            disparity: [0; BLOCK],
            is_match: [false; BLOCK],
            column: [0; BLOCK],
            is_inner: [false; BLOCK],
            sums: [[0; BLOCK]; 3],
        };
        for i in 0..BLOCK {
            let is_match = (winners[i] != Key::NONE) & is_sure[i];
            let disparity = winners[i].index();
            let (column, is_inner) = inner(i32::from(disparity), i as i32);
            found.disparity[i] = disparity;
            found.is_match[i] = is_match;
            found.column[i] = column as u32;
            found.is_inner[i] = is_match & is_inner;
        }
        found
    }

    /// Looks up the sums of winners with disparities on both sides, which lie so far apart.
    #[inline(always)]
    fn look_up(&mut self, sums: &[u16], lanes: usize, apart: usize) {
        for i in 0..BLOCK {
            if self.is_inner[i] {
                let place = self.column[i] as usize * lanes + usize::from(self.disparity[i]);
                self.sums[0][i] = sums[place - apart];
                self.sums[1][i] = sums[place];
                self.sums[2][i] = sums[place + apart];
            }
        }
    }

    /// The disparities in pixels, NaN where there is none.
    #[inline(always)]
    fn in_pixels(&self, min: i32, sub_pixel: Option<f32>, out: &mut [f32; BLOCK]) {
        let [before, least, after] = &self.sums;
        let (has_fraction, locking) = (sub_pixel.is_some(), sub_pixel.unwrap_or_default());
        for i in 0..BLOCK {
            let tip = tip_of_v(f32::from(before[i]), f32::from(least[i]), f32::from(after[i]));
            let whole = (min + i32::from(self.disparity[i])) as f32;
            let value = whole + if has_fraction { unlocked(tip, locking) } else { 0.0 };
            out[i] = if self.is_match[i] { value } else { f32::NAN };
        }
    }
}

/// A fraction of a pixel, from -1/2 to 1/2, without pixel locking. Penalties for changes of disparity make the V around
/// the winner steeper on both sides: its tip comes nearer to the whole disparity than it should. A curve takes it back,
/// which leaves alone where that is right, at 0 and at a half; at 1 it goes twice as far from 0.
#[inline(always)]
fn unlocked(tip: f32, locking: f32) -> f32 {
    tip + locking * tip * (1.0 - 2.0 * tip.abs())
}

at_every_level! {
    /// The disparities of a row of the left view and their confidence. Winners with a margin below
    /// `least_margin` are no matches.
    fn left_row(
        space: &SearchSpace,
        sub_pixel: Option<f32>,
        least_margin: u16,
        sums: &[u16],
        winners: (&[Key], &[u16]),
        values: &mut [f32],
        confidence: &mut [f32],
    ) {
        let (winners, differences) = winners;
        let (mut pixels, mut sure) = ([0.0; BLOCK], [0.0; BLOCK]);
        let blocks = values.chunks_mut(BLOCK).zip(confidence.chunks_mut(BLOCK));
        for (block, (values, confidence)) in blocks.enumerate() {
            let first = block * BLOCK;
            let (mut keys, mut margins) = ([Key::NONE; BLOCK], [0u16; BLOCK]);
            keys[..values.len()].copy_from_slice(&winners[first..][..values.len()]);
            margins[..values.len()].copy_from_slice(&differences[first..][..values.len()]);
            let is_sure = margins.map(|margin| margin >= least_margin);
            let in_image = |column: i32| space.first as i32 + space.apart as i32 * column;
            let mut found = Found::among(keys, is_sure, |disparity, i| {
                let column = first as i32 + i;
                let [lowest, highest] = space.ends(in_image(column));
                (column, (disparity > lowest) & (disparity < highest))
            });
            found.look_up(sums, space.lanes, 1);
            found.in_pixels(space.min, sub_pixel, &mut pixels);
            for i in 0..BLOCK {
                sure[i] = f32::from(margins[i]) / (f32::from(margins[i]) + HALF_SURE);
            }
            values.copy_from_slice(&pixels[..values.len()]);
            confidence.copy_from_slice(&sure[..confidence.len()]);
        }
    }

    /// The disparities of a row of the right view, as it looks in a mirror.
    fn right_row(
        space: &SearchSpace,
        sub_pixel: Option<f32>,
        sums: &[u16],
        winners: &[Key],
        values: &mut [f32],
    ) {
        let (last, columns) = (space.count as i32 - 1, space.columns() as i32);
        // The left column that disparity 0 of the first pixel meets.
        let meets = space.mirrored(space.first) as i32;
        // Their sums stand along a diagonal, of which every second column has but one: the others are those of the
        // pixels beside it then. Where one of these is less the fraction lies beyond a half, and confirms nobody.
        let (shift, apart) = if space.apart == 1 { (0, space.lanes + 1) } else { (1, 1) };
        let mut pixels = [0.0; BLOCK];
        for (block, values) in values.chunks_mut(BLOCK).enumerate() {
            let first = block * BLOCK;
            let mut keys = [Key::NONE; BLOCK];
            keys[..values.len()].copy_from_slice(&winners[first..][..values.len()]);
            let mut found = Found::among(keys, [true; BLOCK], |disparity, i| {
                let column = (meets - first as i32 - i + disparity) >> shift;
                let inside = (column > 0) & (column + 1 < columns);
                (column, inside & (disparity > 0) & (disparity < last))
            });
            found.look_up(sums, space.lanes, apart);
            found.in_pixels(space.min, sub_pixel, &mut pixels);
            values.copy_from_slice(&pixels[..values.len()]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use raster::{BoundingBox, DisparityRange};

    /// Pixel by pixel, from the sums of three disparities.
    fn definition(selection: &Selection<'_>, sums: &[u16]) -> [Vec<f32>; 3] {
        let (space, winners) = (selection.space, &selection.winners);
        let sum = |column: usize, k: usize| f32::from(sums[column * space.lanes + k]);
        let value = |k: usize, tip: f32| {
            let fraction = selection.sub_pixel.map(|locking| unlocked(tip, locking));
            (space.min + k as i32) as f32 + fraction.unwrap_or_default()
        };
        let known = winners.left.iter().zip(&winners.margins);
        let left = known.enumerate().map(|(x, (winner, &margin))| {
            let candidates = space.candidates(space.in_image(x));
            let Some(k) = winner.disparity() else { return f32::NAN };
            let spread = candidates.clone().map(|other| (sum(x, other) - sum(x, k)) as u16).max();
            let margin = if space.count > 3 { Some(margin) } else { spread };
            if margin < Some(selection.least_margin) {
                return f32::NAN;
            }
            let inner = k > candidates.start && k + 1 < candidates.end;
            value(k, if inner { tip_of_v(sum(x, k - 1), sum(x, k), sum(x, k + 1)) } else { 0.0 })
        });
        let confidence =
            winners.margins.iter().map(|&margin| f32::from(margin) / (f32::from(margin) + 60.0));
        let right = winners.right(space).iter().zip((0..space.width).rev()).map(|(winner, x)| {
            let Some(k) = winner.disparity() else { return f32::NAN };
            let column = (x as i64 + i64::from(space.min) + k as i64) as usize - space.first;
            let column = column / space.apart;
            let inner = (1..space.columns() - 1).contains(&column) && k > 0 && k + 1 < space.count;
            let way = usize::from(space.apart == 1);
            let tip =
                || tip_of_v(sum(column - way, k - 1), sum(column, k), sum(column + way, k + 1));
            value(k, if inner { tip() } else { 0.0 })
        });
        [left.collect(), right.collect(), confidence.collect()]
    }

    #[test]
    fn both_views_are_the_definitions_at_every_level() {
        let mut chance = Chance(5);
        let mut random = |n: u32| chance.below(n) as u16;
        for (width, columns, range) in [
            (150, (0, 149), (0, 36)),
            (90, (7, 81), (-9, 30)),
            (20, (3, 12), (8, 60)),
            (9, (0, 8), (2, 2)),
            (90, (0, 89), (-1, 1)),
            (70, (5, 60), (4, 5)),
        ] {
            let bounds = BoundingBox::new(columns.0, 0, columns.1, 0).unwrap();
            let range = DisparityRange::new(range.0, range.1).unwrap();
            let spaces = [1, 2].map(|apart| SearchSpace::of_every(apart, width, bounds, range));
            let pairs = spaces[0].columns() * spaces[0].lanes;
            let many = if range.count() > 3 { 400 } else { 4 };
            let sums: Vec<u16> = (0..pairs).map(|_| random(many)).collect();
            let fractions = [None, Some(0.0), Some(0.5)];
            let cases =
                spaces.iter().flat_map(|space| fractions.map(|sub_pixel| (space, sub_pixel)));
            let levels = Level::available().into_iter();
            for (level, (space, sub_pixel)) in
                levels.flat_map(|l| cases.clone().map(move |case| (l, case)))
            {
                eprintln!("level {}, every {}", level.name(), space.apart);
                let sums = &sums[..space.columns() * space.lanes];
                let mut winners = Winners::default();
                let (mut left, mut right) = (vec![9.0; space.columns()], vec![9.0; width]);
                let mut confidence = vec![9.0; space.columns()];
                let mut selection = Selection {
                    level,
                    space,
                    sub_pixel,
                    least_margin: 2,
                    first: 5,
                    left: &mut left,
                    right: &mut right,
                    confidence: &mut confidence,
                    winners: &mut winners,
                };
                selection.row(5, sums);
                let expected = definition(&selection, sums);
                for (found, expected) in [left, right, confidence].iter().zip(&expected) {
                    let bits =
                        |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                    assert_eq!(bits(found), bits(expected), "{space:?}");
                }
            }
        }
    }
}
