//! How vertical disparity changes over an image, and the robust fit of it.
//!
//! A camera that is turned a little moves a point at `(x, y)` from the middle, in focal lengths, down by
//! (Longuet-Higgins & Prazdny, *The interpretation of a moving retinal image*, 1980)
//!
//! ```text
//! dy = pitch (1 + y^2) + yaw x y + roll x
//! ```
//!
//! and one with another focal length by `c y`. A lens whose elements are not in one line moves it by
//! `p1 (x^2 + 3 y^2) + 2 p2 x y` (Brown, *Decentering Distortion of Lenses*, 1966). Neither angles nor focal lengths nor
//! lenses have to be known for that: the six shapes `1, x, y, x y, y^2, x^2` are fitted as they come. How far away things
//! are does not matter, as long as the cameras stand side by side. The same turns change disparity too, by
//! `yaw (1 + x^2)` and `roll y`, which nothing in the images tells apart from depth: that stays.

use super::correspondence::Correspondence;

/// The shapes that vertical disparity is made of.
const SHAPES: usize = 6;
/// All but the last one, which only lenses make: rectified pairs mostly have none of it, and what noise says of it then
/// is left out. It counts where it comes to so many pixels (root of the mean square over the image, without its mean).
const OF_CAMERAS: usize = SHAPES - 1;
const BENT: f64 = 0.1;
/// That of `x^2` where `x` runs from -0.5 to 0.5: the root of 1/80 - 1/144.
const OF_SQUARE: f64 = 0.0745;
/// Correspondences farther off than this, in pixels, or than so many standard deviations do not count.
const LEAST_OUTLIER: f64 = 0.15;
const OUTLIER: f64 = 3.0;
const ROUNDS: usize = 12;
/// From there on one shape more.
const MORE_ROUNDS: usize = 4;
/// The standard deviation of normal errors over the median of their sizes.
const DEVIATION: f64 = 1.4826;
/// The fit holds when at least so many correspondences lie within so many pixels of it, and this part
/// of all.
const AGREEING: usize = 30;
const AGREEMENT: f64 = 0.3;
const AGREEING_PART: f64 = 0.5;
/// In so many of the four quarters of the image so many of them: beyond what is seen the fit means
/// nothing.
const QUARTERS: usize = 3;
const OF_QUARTER: usize = 4;
/// Pulls shapes of which little is seen towards zero: as many correspondences without any.
const RIDGE: f64 = 0.02;

/// How far things stand lower in the right image than in the left one, in pixels: a smooth function of
/// the column in the right image and the row in the left one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerticalDisparity {
    size: (usize, usize),
    coefficients: [f64; SHAPES],
}

/// Vertical disparity along a row: that at its first column, and how it changes from column to column.
#[derive(Clone, Copy)]
pub(crate) struct AlongRow {
    first: f32,
    change: f32,
    bend: f32,
}

impl AlongRow {
    #[inline(always)]
    pub fn at(self, column: usize) -> f32 {
        self.between(column as f32)
    }

    #[inline(always)]
    fn between(self, column: f32) -> f32 {
        self.first + (self.change + self.bend * column) * column
    }

    /// The least and the most of so many columns: it stands at their ends or where the bend turns.
    pub fn extremes(self, columns: usize) -> [f32; 2] {
        let last = (columns - 1) as f32;
        // Without a bend that is nowhere, which no minimum counts.
        let turn = (-0.5 * self.change / self.bend).clamp(0.0, last);
        let all = [0.0, turn, last].map(|column| self.between(column));
        [
            all.into_iter().fold(f32::INFINITY, f32::min),
            all.into_iter().fold(f32::NEG_INFINITY, f32::max),
        ]
    }
}

impl VerticalDisparity {
    /// A pair with more than this somewhere ([`Self::largest`]), in pixels, was not rectified for its
    /// cameras as they are.
    pub const BADLY_RECTIFIED: f64 = 1.5;

    /// The shapes at a place, which runs from -0.5 to 0.5 over the image.
    #[inline(always)]
    fn shapes(x: f64, y: f64) -> [f64; SHAPES] {
        [1.0, x, y, x * y, y * y, x * x]
    }

    #[inline(always)]
    fn place(&self, x: f64, y: f64) -> (f64, f64) {
        (x / self.size.0 as f64 - 0.5, y / self.size.1 as f64 - 0.5)
    }

    /// That at column `x` of the right image and row `y` of the left one.
    #[inline(always)]
    pub fn at(&self, x: f64, y: f64) -> f64 {
        let (x, y) = self.place(x, y);
        Self::shapes(x, y)
            .iter()
            .zip(self.coefficients)
            .map(|(shape, coefficient)| shape * coefficient)
            .sum()
    }

    /// What it is made of, in pixels: the factors of `1`, `x`, `y`, `x y`, `y^2` and `x^2`, where `x` is the
    /// column over the number of columns and `y` the row over that of rows, both less 0.5.
    pub fn coefficients(&self) -> [f64; 6] {
        self.coefficients
    }

    /// From so many pixels on [`Self::disparity_error`] is worth telling: of pairs that were rectified well enough none
    /// of Middlebury's, KITTI's and ETH3D's comes to that.
    pub const TELLING: f64 = 1.0;

    /// By how many pixels disparities may be off towards the edges for the same reason, which is not mended: cameras
    /// that are turned about their axes against each other, or see things larger than the other, move them along the
    /// rows as they move them across, and along the rows depth does so too.
    pub fn disparity_error(&self) -> f64 {
        let [_, across, down, ..] = self.coefficients;
        let [columns, rows] = [self.size.0, self.size.1].map(|size| size as f64);
        across.abs() / columns * rows / 2.0 + down.abs() / rows * columns / 2.0
    }

    /// A factor of `x y` beyond this is worth telling: none of Middlebury's, ETH3D's and KITTI 2015's pairs comes to that.
    const TURNED: f64 = 2.0;

    /// By about how many pixels all disparities are off, where that is worth telling, if cameras that are turned against
    /// each other about the upright axis made vertical disparity what it is, and their focal length is the width of the
    /// images; with half as long a one it is a quarter. Nothing in the images tells that from depth, and a lens may
    /// have done it instead: KITTI's pair 000070 of 2012 looks turned and is not.
    pub fn common_disparity(&self) -> Option<f64> {
        let [_, _, _, turned, ..] = self.coefficients;
        let [columns, rows] = [self.size.0, self.size.1].map(|size| size as f64);
        (turned.abs() > Self::TURNED).then(|| turned.abs() * columns / rows)
    }

    /// That along row `y`.
    #[inline(always)]
    pub(crate) fn along_row(&self, y: usize) -> AlongRow {
        let [first, next, after] = [0.0, 1.0, 2.0].map(|x| self.at(x, y as f64));
        let bend = 0.5 * (after - 2.0 * next + first);
        AlongRow { first: first as f32, change: (next - first - bend) as f32, bend: bend as f32 }
    }

    #[cfg(test)]
    pub(crate) fn of_shapes(size: (usize, usize), coefficients: [f64; SHAPES]) -> Self {
        Self { size, coefficients }
    }

    /// Rows of the image.
    pub(crate) fn rows(&self) -> usize {
        self.size.1
    }

    /// Evenly spread places of the image.
    fn places(&self) -> impl Iterator<Item = f64> {
        let [columns, rows] = [self.size.0, self.size.1].map(|size| size.saturating_sub(1) as f64);
        let part = |i: i32| f64::from(i) / 8.0;
        (0..=8)
            .flat_map(move |j| (0..=8).map(move |i| (part(i) * columns, part(j) * rows)))
            .map(|(x, y)| self.at(x, y))
    }

    /// The root of its mean square over the image, in pixels.
    pub fn root_mean_square(&self) -> f64 {
        let (sum, count) = self.places().fold((0.0, 0), |(sum, n), dy| (sum + dy * dy, n + 1));
        (sum / f64::from(count)).sqrt()
    }

    /// The largest one in the image, up or down, in pixels.
    pub fn largest(&self) -> f64 {
        self.places().fold(0.0, |largest, dy| f64::max(largest, dy.abs()))
    }

    /// Fits it to correspondences in an image of a size, by least squares, again and again with weights
    /// by how far off each one is (Tukey's biweight: Beaton & Tukey, Technometrics 1974). None where too few
    /// agree.
    pub(super) fn fit<'a>(
        found: impl Iterator<Item = &'a Correspondence> + Clone,
        size: (usize, usize),
        residuals: &mut Vec<f64>,
    ) -> Option<Self> {
        let mut model = Self { size, coefficients: [0.0; SHAPES] };
        residuals.clear();
        residuals.extend(found.clone().map(|one| one.down));
        if residuals.len() < AGREEING {
            return None;
        }
        // From the middle one on: a fit to all of them would follow those that are wrong.
        model.coefficients[0] = *middle(residuals);
        let count = residuals.len();
        let straight = model.fitted(found.clone(), OF_CAMERAS, ROUNDS, residuals);
        let bent = straight.fitted(found.clone(), SHAPES, MORE_ROUNDS, residuals);
        let is_bent = OF_SQUARE * bent.coefficients[OF_CAMERAS].abs() >= BENT;
        if is_bent && bent.holds(found.clone(), count) {
            return Some(bent);
        }
        straight.holds(found, count).then_some(straight)
    }

    /// The fit by the first few shapes, so many rounds from this one on.
    fn fitted<'a>(
        mut self,
        found: impl Iterator<Item = &'a Correspondence> + Clone,
        shapes: usize,
        rounds: usize,
        residuals: &mut Vec<f64>,
    ) -> Self {
        for _ in 0..rounds {
            residuals.clear();
            residuals.extend(found.clone().map(|one| self.off(one).abs()));
            let outlier = (OUTLIER * DEVIATION * *middle(residuals)).max(LEAST_OUTLIER);
            self = self.fitted_again(found.clone(), shapes, outlier);
        }
        self
    }

    /// How far off a correspondence is.
    fn off(&self, one: &Correspondence) -> f64 {
        one.down - self.at(f64::from(one.column), f64::from(one.row))
    }

    /// The fit of the first few shapes to correspondences that are off by less than an outlier is, weighted by how far.
    fn fitted_again<'a>(
        &self,
        found: impl Iterator<Item = &'a Correspondence>,
        used: usize,
        outlier: f64,
    ) -> Self {
        let mut equations = [[0.0; SHAPES + 1]; SHAPES];
        for one in found {
            let far = self.off(one) / outlier;
            if far.abs() >= 1.0 {
                continue;
            }
            let near = 1.0 - far * far;
            let weight = near * near;
            let (x, y) = self.place(f64::from(one.column), f64::from(one.row));
            let mut shapes = Self::shapes(x, y);
            shapes[used..].fill(0.0);
            for (equation, shape) in equations.iter_mut().zip(shapes) {
                for (sum, other) in equation.iter_mut().zip(shapes) {
                    *sum += weight * shape * other;
                }
                equation[SHAPES] += weight * shape * one.down;
            }
        }
        for (i, equation) in equations.iter_mut().enumerate().skip(1) {
            equation[i] += RIDGE;
        }
        Self { coefficients: solved(equations), ..*self }
    }

    /// Whether enough of so many correspondences agree with it, in enough quarters of the image.
    fn holds<'a>(&self, found: impl Iterator<Item = &'a Correspondence>, count: usize) -> bool {
        let mut agreeing = [0; 4];
        for one in found.filter(|one| self.off(one).abs() < AGREEMENT) {
            let (x, y) = self.place(f64::from(one.column), f64::from(one.row));
            agreeing[usize::from(x > 0.0) + 2 * usize::from(y > 0.0)] += 1;
        }
        let enough = (AGREEING_PART * count as f64).max(AGREEING as f64);
        let spread = agreeing.iter().filter(|&&quarter| quarter >= OF_QUARTER).count();
        let all = agreeing.iter().sum::<usize>();
        all as f64 >= enough && spread >= QUARTERS
    }
}

/// The middle one by size.
fn middle(numbers: &mut [f64]) -> &mut f64 {
    let half = numbers.len() / 2;
    numbers.select_nth_unstable_by(half, f64::total_cmp).1
}

/// Solves equations whose matrix is symmetric and positive: Gauss & Jordan without a search for pivots.
fn solved(mut equations: [[f64; SHAPES + 1]; SHAPES]) -> [f64; SHAPES] {
    for i in 0..SHAPES {
        let pivot = equations[i].map(|number| number / equations[i][i]);
        for (k, equation) in equations.iter_mut().enumerate() {
            let factor = if k == i { 0.0 } else { equation[i] };
            for (number, pivot) in equation.iter_mut().zip(pivot) {
                *number -= factor * pivot;
            }
        }
        equations[i] = pivot;
    }
    equations.map(|equation| equation[SHAPES])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    const SIZE: (usize, usize) = (1000, 400);

    fn truth() -> VerticalDisparity {
        VerticalDisparity { size: SIZE, coefficients: [0.4, -0.6, 0.3, 2.0, -0.8, 2.4] }
    }

    /// Correspondences with noise, of which a part is anything.
    fn correspondences(count: usize, wrong: f32) -> Vec<Correspondence> {
        let mut chance = Chance(11);
        let mut one = || {
            let [x, y] = [SIZE.0, SIZE.1].map(|size| chance.share() * size as f32);
            let noise = f64::from(chance.share() - 0.5);
            let is_wrong = chance.share() < wrong;
            let down =
                truth().at(f64::from(x), f64::from(y)) + noise * if is_wrong { 8.0 } else { 0.2 };
            Correspondence { column: x, row: y, down, noise: 0.0 }
        };
        (0..count).map(|_| one()).collect()
    }

    fn fitted(found: &[Correspondence]) -> Option<VerticalDisparity> {
        VerticalDisparity::fit(found.iter(), SIZE, &mut Vec::new())
    }

    #[test]
    fn a_third_of_wrong_ones_does_not_move_the_fit() {
        let model = fitted(&correspondences(400, 0.33)).expect("most agree");
        for (x, y) in [(0.0, 0.0), (999.0, 0.0), (0.0, 399.0), (999.0, 399.0), (500.0, 200.0)] {
            let off = model.at(x, y) - truth().at(x, y);
            assert!(off.abs() < 0.08, "({x}, {y}): {off}");
        }
        assert!((model.root_mean_square() - truth().root_mean_square()).abs() < 0.02);
        assert!((model.largest() - truth().largest()).abs() < 0.08);
        let [one, x, y, xy, yy, xx] = model.coefficients();
        let (right, down) = (0.25, -0.25);
        let squares = yy * down * down + xx * right * right;
        let sum = one + x * right + y * down + xy * right * down + squares;
        assert!((sum - model.at(750.0, 100.0)).abs() < 1e-12);
        for column in [0, 1, 300, 700, 999] {
            let along = truth().along_row(100).at(column);
            assert!((f64::from(along) - truth().at(column as f64, 100.0)).abs() < 1e-4);
        }
    }

    #[test]
    fn a_lens_that_bends_is_told_from_noise() {
        for bend in [-2.0, -0.5, 0.5, 2.0, 6.0] {
            let mut found = correspondences(400, 0.2);
            for one in &mut found {
                let x = f64::from(one.column) / SIZE.0 as f64 - 0.5;
                one.down += (bend - truth().coefficients[OF_CAMERAS]) * x * x;
            }
            let model = fitted(&found).expect("most agree");
            let is_seen = model.coefficients[OF_CAMERAS];
            let expected = if bend.abs() < 1.0 { 0.0 } else { bend };
            assert!((is_seen - expected).abs() < 0.15, "{bend}: {is_seen}");
        }
    }

    #[test]
    fn who_turns_or_enlarges_an_image_moves_it_along_the_rows_too() {
        let (columns, rows) = (1000.0, 400.0);
        for (turn, scale) in [(0.01f64, 1.0), (0.0, 1.005), (-0.01, 0.995)] {
            // From the middle to where a point comes, and how far that is, at the corners.
            let moved = |x: f64, y: f64| {
                let (sine, cosine) = turn.sin_cos();
                let to = [scale * (cosine * x - sine * y), scale * (sine * x + cosine * y)];
                [to[0] - x, to[1] - y]
            };
            let corners = [(-500.0, -200.0), (500.0, -200.0), (-500.0, 200.0), (500.0, 200.0)];
            let along = corners.map(|(x, y)| moved(x, y)[0].abs()).into_iter().fold(0.0, f64::max);
            let across = moved(500.0, 0.0)[1] - moved(-500.0, 0.0)[1];
            let down = moved(0.0, 200.0)[1] - moved(0.0, -200.0)[1];
            let coefficients = [0.0, across, down, 0.0, 0.0, 0.0];
            let model = VerticalDisparity { size: (columns as usize, rows as usize), coefficients };
            assert!((model.disparity_error() - along).abs() < 0.05, "{along}");
        }
    }

    #[test]
    fn who_turns_a_camera_moves_all_along_the_rows() {
        // By an angle, in focal lengths, which is the width: down by `f yaw x y`, along by `f yaw (1 + x^2)`.
        let (columns, rows) = (800.0, 600.0);
        for (yaw, is_told) in [(0.0005, false), (0.005, true), (-0.01, true)] {
            let f = columns;
            let turned = f * yaw * (columns / f) * (rows / f);
            let coefficients = [0.0, 0.0, 0.0, turned, 0.0, 0.0];
            let model = VerticalDisparity { size: (800, 600), coefficients };
            let told = model.common_disparity();
            assert_eq!(told.is_some(), is_told);
            assert!(
                told.is_none_or(|told| (told - (f * yaw).abs()).abs() < 1e-9),
                "{yaw}: {told:?}"
            );
        }
    }

    #[test]
    fn few_or_contradicting_ones_tell_nothing() {
        assert_eq!(fitted(&[]), None);
        assert_eq!(fitted(&correspondences(29, 0.0)), None);
        assert_eq!(fitted(&correspondences(400, 0.95)), None);
    }

    #[test]
    fn those_of_a_part_of_the_image_tell_nothing_of_the_rest() {
        let mut found = correspondences(400, 0.0);
        for one in &mut found {
            one.column *= 0.5;
        }
        assert_eq!(fitted(&found), None);
        found[..20].iter_mut().for_each(|one| one.column += 500.0);
        let lower = |one: &Correspondence| one.row > 200.0;
        assert!(found[..20].iter().filter(|one| lower(one)).count() > OF_QUARTER);
        found.iter_mut().for_each(|one| one.down = 0.5);
        assert!((fitted(&found).expect("three quarters are seen").largest() - 0.5).abs() < 0.05);
    }
}
