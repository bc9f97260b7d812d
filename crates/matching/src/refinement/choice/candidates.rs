//! What a pixel can choose from, and what is known of each candidate.
//!
//! Candidates are the planes of the pixel itself and of 31 others around it, continued to where it
//! lies. Numbers of all candidates stand side by side, so that they are worked on together.

use raster::{Plane, Reason};

use super::edges::{Edges, way};
use crate::cost::looks::{LARGEST_STEP, Looks};
use crate::refinement::slopes::Slopes;

/// Candidates of a pixel.
pub const CANDIDATES: usize = 32;

/// Columns and rows from the pixel to where its candidates come from.
const PLACES: [(i32, i32); CANDIDATES] = [
    (0, 0),
    (2, 0),
    (-2, 0),
    (0, 2),
    (0, -2),
    (3, 3),
    (-3, -3),
    (3, -3),
    (-3, 3),
    (5, 0),
    (-5, 0),
    (0, 5),
    (0, -5),
    (7, 7),
    (-7, -7),
    (7, -7),
    (-7, 7),
    (11, 0),
    (-11, 0),
    (0, 11),
    (0, -11),
    (15, 15),
    (-15, -15),
    (15, -15),
    (-15, 15),
    (24, 0),
    (-24, 0),
    (0, 24),
    (0, -24),
    (48, 0),
    (-48, 0),
    (0, -48),
];

/// The ways that lead there.
const WAYS: [usize; CANDIDATES] = {
    let mut ways = [0; CANDIDATES];
    let mut k = 0;
    while k < CANDIDATES {
        ways[k] = way(PLACES[k]);
        k += 1;
    }
    ways
};

/// What is known of each candidate, in the order of [`Known::of_each`].
pub const OF_EACH: usize = 20;
/// What is known of the pixel, in the order of [`Known::of_pixel`].
pub const OF_PIXEL: usize = 6;

/// Candidates within so many pixels of disparity say the same.
const SAME: f32 = 1.0;
/// Where all candidates lie within so many pixels there is nothing to choose.
const CHOICE: f32 = 0.5;
/// The last of the candidates of the inner rings.
const NEAR: usize = 12;
/// A match that was never in doubt, and whose inner rings lie within so many pixels, is left alone.
const SETTLED: f32 = 1.0;
/// The 3 x 3 pixels that are compared with those of a match stand so far apart.
const APART: i64 = 2;

/// What is known of the images and of both views, and stays as it is.
pub(crate) struct Given<'a> {
    /// Where descriptors were asked; empty where nowhere.
    pub doubtful: &'a Plane<bool>,
    pub base: &'a Looks,
    pub other: &'a Looks,
    /// The disparities of the right view, in a mirror.
    pub right: &'a Plane<f32>,
    /// The column of the image at which the map begins.
    pub first: usize,
    pub least: f32,
    pub most: f32,
}

/// A map without holes, and all that is known of it.
pub(crate) struct Scene<'a> {
    pub values: &'a Plane<f32>,
    pub slopes: &'a Slopes,
    pub reasons: &'a Plane<Reason>,
    pub confidence: &'a Plane<f32>,
    pub edges: &'a Edges,
    pub given: &'a Given<'a>,
}

/// A pixel's candidates and what is known of them.
#[derive(Clone)]
pub struct Known {
    /// Of the candidates' planes, where the pixel lies.
    pub disparities: [f32; CANDIDATES],
    /// Whether they come from inside the map.
    pub inside: [bool; CANDIDATES],
    /// `of_each[i][k]` of candidate `k`:
    /// 0, 1: how far it lies from what the pixel has, with sign and without;
    /// 2 to 4: of where it comes from: confidence, whether filled, whether in doubt;
    /// 5: the difference of grey to there;
    /// 6 to 8: how badly the match fits: census and grey steps of 3 x 3 pixels, census of the pixel;
    /// 9, 10: how far the right view's disparity at the match lies from it;
    /// 11, 12: the share of candidates that say the same, and that of those of the same shade;
    /// 13, 14: how far it lies from the smallest and from the largest one;
    /// 15: whether the match lies outside the right image;
    /// 16: how steep its plane is;
    /// 17: how much the grey changes on the way to there;
    /// 18, 19: the share of candidates that say the same among the confident ones, and among those
    /// that no edge parts from the pixel.
    pub of_each: [[f32; CANDIDATES]; OF_EACH],
    /// Confidence; whether occluded, mismatched, outside the right image, in doubt; texture.
    pub of_pixel: [f32; OF_PIXEL],
}

impl Default for Known {
    fn default() -> Self {
        Self {
            disparities: [0.0; CANDIDATES],
            inside: [false; CANDIDATES],
            of_each: [[0.0; CANDIDATES]; OF_EACH],
            of_pixel: [0.0; OF_PIXEL],
        }
    }
}

/// Differences of disparity as a judge sees them: small ones halved, large ones by their root.
#[inline(always)]
fn bent(difference: f32) -> f32 {
    ((difference.abs() + 1.0).sqrt() - 1.0).copysign(difference)
}

#[inline(always)]
fn share(is: bool) -> f32 {
    if is { 1.0 } else { 0.0 }
}

/// How a pixel fits a match of a whole disparity.
#[derive(Clone, Copy, Default)]
struct Fit {
    disparity: i32,
    census: f32,
    census_here: f32,
    steps: f32,
    right: f32,
    outside: bool,
}

impl Scene<'_> {
    /// Finds the candidates of pixel `(x, y)`; says whether there is anything to choose. Only then is
    /// all else found too.
    #[inline(always)]
    pub fn know(&self, x: usize, y: usize, known: &mut Known) -> bool {
        let (columns, rows) = self.values.size();
        // All of one length: an index is checked once.
        let pixels = columns * rows;
        let values = &self.values.samples()[..pixels];
        let along = &self.slopes.along.samples()[..pixels];
        let down = &self.slopes.down.samples()[..pixels];
        let here = values[y * columns + x];
        let (mut smallest, mut largest) = (here, here);
        let mut places = [(0, 0); CANDIDATES];
        for k in 0..CANDIDATES {
            let (dx, dy) = PLACES[k];
            let (u, v) = (x as i64 + i64::from(dx), y as i64 + i64::from(dy));
            let inside = u >= 0 && v >= 0 && u < columns as i64 && v < rows as i64;
            let (u, v) = if inside { (u as usize, v as usize) } else { (x, y) };
            let i = v * columns + u;
            let steep = along[i] * dx as f32 + down[i] * dy as f32;
            let d = if inside { values[i] - steep } else { here };
            let d = if d < self.given.least { self.given.least } else { d };
            let d = if d > self.given.most { self.given.most } else { d };
            smallest = if d < smallest { d } else { smallest };
            largest = if d > largest { d } else { largest };
            (known.disparities[k], known.inside[k]) = (d, inside);
            places[k] = (u, v);
            if k == NEAR && largest - smallest <= SETTLED && self.is_settled(x, y) {
                return false;
            }
        }
        if largest - smallest <= CHOICE {
            return false;
        }
        self.look_at_places(x, y, &places, known);
        self.look_at_matches(x, y, known);
        for k in 0..CANDIDATES {
            let d = known.disparities[k];
            known.of_each[0][k] = bent(d - here);
            known.of_each[1][k] = bent((d - here).abs());
            known.of_each[13][k] = bent(d - smallest);
            known.of_each[14][k] = bent(largest - d);
        }
        count_same(known);
        true
    }

    /// Whether both views agreed on it whenever they were asked.
    #[inline(always)]
    fn is_settled(&self, x: usize, y: usize) -> bool {
        let i = y * self.values.columns() + x;
        self.reasons.samples()[i] == Reason::Matched && !self.is_doubtful(i)
    }

    #[inline(always)]
    fn is_doubtful(&self, i: usize) -> bool {
        self.given.doubtful.samples().get(i) == Some(&true)
    }

    /// What is known of the pixel, and of the places that its candidates come from.
    #[inline(always)]
    fn look_at_places(
        &self,
        x: usize,
        y: usize,
        places: &[(usize, usize); CANDIDATES],
        known: &mut Known,
    ) {
        let (columns, rows) = self.values.size();
        let pixels = columns * rows;
        let along = &self.slopes.along.samples()[..pixels];
        let down = &self.slopes.down.samples()[..pixels];
        let confidence = &self.confidence.samples()[..pixels];
        let reasons = &self.reasons.samples()[..pixels];
        let own = y * columns + x;
        let here = f32::from(self.given.base.grey(self.given.first + x, y));
        for k in 0..CANDIDATES {
            let (u, v) = places[k];
            let i = v * columns + u;
            let there = f32::from(self.given.base.grey(self.given.first + u, v));
            known.of_each[2][k] = confidence[i];
            known.of_each[3][k] = share(reasons[i] != Reason::Matched);
            known.of_each[4][k] = share(self.is_doubtful(i));
            known.of_each[5][k] = (there - here).abs() * 0.05;
            known.of_each[16][k] = 2.0 * (along[i].abs() + down[i].abs());
            known.of_each[17][k] = bent(f32::from(self.edges.between(own, i, WAYS[k])) * 0.05);
        }
        known.of_pixel[..5].copy_from_slice(&[
            confidence[own],
            share(reasons[own] == Reason::OccludedFilled),
            share(reasons[own] == Reason::MismatchedFilled),
            share(reasons[own] == Reason::OutsideRightFilled),
            share(self.is_doubtful(own)),
        ]);
    }

    /// What is known of the pixel's texture, and of the matches that candidates say it has.
    #[inline(always)]
    fn look_at_matches(&self, x: usize, y: usize, known: &mut Known) {
        let window = Window::new(self.given, x, y);
        known.of_pixel[5] = window.texture();
        let mut fits = [Fit::default(); CANDIDATES];
        let mut found = 0;
        for k in 0..CANDIDATES {
            // Many say the same.
            let disparity = (known.disparities[k] + 0.5).floor() as i32;
            let mut which = 0;
            while which < found && fits[which].disparity != disparity {
                which += 1;
            }
            if which == found {
                fits[found] = window.fit(self.given.right.row(y), disparity);
                found += 1;
            }
            let fit = &fits[which];
            known.of_each[6][k] = fit.census;
            known.of_each[7][k] = fit.steps;
            known.of_each[8][k] = fit.census_here;
            let right = if fit.outside { 0.0 } else { fit.right - known.disparities[k] };
            known.of_each[9][k] = bent(right);
            known.of_each[10][k] = bent(right.abs());
            known.of_each[15][k] = share(fit.outside);
        }
    }
}

/// The 3 x 3 pixels of an image that are looked at around a pixel, and the rows of the other image that
/// they are compared with. Beyond the ends both are repeated.
struct Window<'a> {
    /// Census words and grey steps.
    base: [[(u8, u8); 3]; 3],
    other: [[&'a [u8]; 2]; 3],
    /// Of the pixel in the image.
    column: i64,
}

impl<'a> Window<'a> {
    #[inline(always)]
    fn new(given: &Given<'a>, x: usize, y: usize) -> Self {
        let last = given.base.rows() as i64 - 1;
        let column = (given.first + x) as i64;
        let mut window = Self { base: [[(0, 0); 3]; 3], other: [[&[]; 2]; 3], column };
        for j in 0..3 {
            let row = (y as i64 + (j as i64 - 1) * APART).clamp(0, last) as usize;
            let [census, steps, _] = given.base.row(row);
            let [other_census, other_steps, _] = given.other.row(row);
            window.other[j] = [other_census, other_steps];
            let columns = columns_around(column, census.len());
            for i in 0..3 {
                window.base[j][i] = (census[columns[i]], steps[columns[i]]);
            }
        }
        window
    }

    /// The mean grey step along the row.
    #[inline(always)]
    fn texture(&self) -> f32 {
        let mut sum = 0;
        for (_, step) in self.base.as_flattened() {
            sum += u32::from(step.abs_diff(128).min(32));
        }
        sum as f32 / 90.0
    }

    /// How it fits, where `right` are the disparities of that row of the other view, in a mirror.
    #[inline(always)]
    fn fit(&self, right: &[f32], disparity: i32) -> Fit {
        let width = right.len() as i64;
        let at = self.column - i64::from(disparity);
        let columns = columns_around(at, right.len());
        let (mut bits, mut steps, mut here) = (0, 0, 0);
        for j in 0..3 {
            let [other_census, other_steps] = self.other[j];
            for i in 0..3 {
                let (census, step) = self.base[j][i];
                let unlike = (census ^ other_census[columns[i]]).count_ones();
                bits += unlike;
                here = if i == 1 && j == 1 { unlike } else { here };
                steps += u32::from(step.abs_diff(other_steps[columns[i]]).min(LARGEST_STEP));
            }
        }
        Fit {
            disparity,
            census: bits as f32 / 36.0,
            census_here: here as f32 / 4.0,
            steps: steps as f32 / 90.0,
            right: right[(width - 1 - at).clamp(0, width - 1) as usize],
            outside: at < 0 || at >= width,
        }
    }
}

/// The columns that are looked at around one, in an image of so many.
#[inline(always)]
fn columns_around(column: i64, columns: usize) -> [usize; 3] {
    let last = columns as i64 - 1;
    // Written out: what a closure does is not compiled for the level.
    let [before, here, after] = [column - APART, column, column + APART];
    [before.clamp(0, last) as usize, here.clamp(0, last) as usize, after.clamp(0, last) as usize]
}

/// Counts the candidates that say the same: all alike, and weighed by how far each is to be heard.
#[inline(always)]
fn count_same(known: &mut Known) {
    let Known { disparities, inside, of_each, .. } = known;
    let mut votes = [[0.0f32; CANDIDATES]; 4];
    let mut all = [CANDIDATES as f32, 0.0, 0.0, 0.0];
    for k in 0..CANDIDATES {
        if !inside[k] {
            continue;
        }
        // Of the same shade: 1 to 0 over 16 grey values.
        let shade = 1.0 - of_each[5][k] * 1.25;
        let shade = if shade < 0.05 { 0.05 } else { shade };
        let confident = of_each[2][k] + 0.01;
        let edges = of_each[17][k];
        let near = 1.0 / (1.0 + edges * edges);
        let there = disparities[k];
        let [any, alike, sure, joined] = &mut votes;
        for i in 0..CANDIDATES {
            let same = share((disparities[i] - there).abs() < SAME);
            any[i] += same;
            alike[i] += same * shade;
            sure[i] += same * confident;
            joined[i] += same * near;
        }
        all[1] += shade;
        all[2] += confident;
        all[3] += near;
    }
    for (place, (votes, all)) in [11, 12, 18, 19].into_iter().zip(votes.iter().zip(all)) {
        for i in 0..CANDIDATES {
            of_each[place][i] = votes[i] * (3.0 / all);
        }
    }
}
