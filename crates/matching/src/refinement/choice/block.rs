//! What pixels can choose from, and what is known of each candidate.
//!
//! Candidates are the planes of a pixel itself and of others around it, continued to where it lies. Pixels of a few
//! rows are worked on together, those that are not settled and no others. Where not all pixels are matched, maps hold
//! those that are.

use raster::{Plane, Reason, View};

use super::hint::{self, Hints};
use super::notes::{Mark, Noted};
use super::reach::{MOST, Place, Reach};
use super::relations::{Relations, SAME, in_turns};
use super::slopes::{continued, steep};
use super::strip::Strip;
use super::undecided;
use super::windows::{BITS, Fits, STEPS, Several, Windows};
use crate::kernels::aligned::Line;
use crate::kernels::level::Level;
use crate::kernels::products::{Lanes, Numbers, Products, Sums};
use crate::kernels::records::{Places, Record};
use crate::kernels::rounding::nearest;

/// Pixels that are worked on together.
pub(crate) const LANES: usize = 16;

/// What is known of the pixel, in the order of [`Block::of_pixel`].
pub(super) const OF_PIXEL: usize = 6;

/// What is known of the images and of both views, and stays as it is.
pub(crate) struct Given<'a> {
    /// Where descriptors were asked, of the pixels of the map; empty where nowhere.
    pub doubtful: &'a Plane<bool>,
    /// The upper 8 bits of both images.
    pub grey: [View<'a, u8>; 2],
    /// The disparities of the right view, in a mirror, in the rows of the map.
    pub right: &'a Plane<f32>,
    /// The column and the row of the image at which the map begins.
    pub first: usize,
    pub top: usize,
    pub least: f32,
    pub most: f32,
}

/// A map without holes, and all that is known of it.
pub(crate) struct Scene<'a> {
    pub values: &'a Plane<f32>,
    pub reasons: &'a Plane<Reason>,
    /// How sure pixels are, in bytes.
    pub certainty: &'a Plane<u8>,
    /// Around the rows that are worked on.
    pub strip: &'a Strip,
    pub given: &'a Given<'a>,
}

/// A few rows of both images, one after the other, that pixels are compared with.
#[derive(Clone, Copy)]
pub(super) struct Compared<'a> {
    /// The first of them, counted in the map.
    first: usize,
    /// Columns in each.
    width: usize,
    /// A column of the map is every so many-th one of these.
    every: usize,
    base: &'a [Record],
    other: &'a [Record],
    /// The disparities of the right view, in a mirror.
    right: &'a [f32],
}

impl<'a> Compared<'a> {
    /// So many rows of the map from `first` on, with the windows of either image. Only those that are `wanted`,
    /// counted from there, are looked at.
    pub fn rows(
        level: Level,
        scene: &Scene<'a>,
        [base, other]: &'a mut [Windows; 2],
        (first, rows): (usize, usize),
        wanted: impl Fn(usize) -> bool,
    ) -> Self {
        let strip = scene.strip;
        for place in (0..rows).filter(|&row| wanted(row)) {
            let row = strip.row(first + place);
            base.compute(level, &strip.base, row, place);
            other.compute(level, &strip.other, row, place);
        }
        let (width, every) = (scene.given.right.columns(), strip.every());
        let right = &scene.given.right.samples()[first * width..][..rows * width];
        Self { first, width, every, base: base.get(), other: other.get(), right }
    }
}

/// Pixels of a few rows, their candidates and what is known of them.
///
/// Lanes lie as they are written here, each where a cache line begins: across two of them, a vector takes two
/// loads.
#[derive(Default)]
#[repr(C, align(64))]
pub(super) struct Block {
    /// Of the candidates' planes, where the pixels lie.
    pub disparities: [Lanes; MOST],
    /// 1 where they come from inside the map, else 0.
    pub inside: [Lanes; MOST],
    steep: [Lanes; MOST],
    marks: [[Mark; LANES]; MOST],
    /// How the candidates lie to each other.
    pub relations: Relations,
    /// How far they are to be heard, two after the other.
    heard: [[Numbers; KINDS_OF_VOTES]; MOST / 2],
    /// What makes votes shares.
    scales: [Lanes; KINDS_OF_VOTES],
    here: Lanes,
    smallest: Lanes,
    largest: Lanes,
    /// Confidence; whether occluded, mismatched, outside the right image, in doubt; texture.
    pub of_pixel: [Lanes; OF_PIXEL],
    windows: Several,
    /// Where the pixels lie in the map.
    columns: Line<[i32; LANES]>,
    rows: Line<[i32; LANES]>,
    /// Their columns in the image, and where the rows begin that they are compared with.
    image_columns: Line<[i32; LANES]>,
    begins: Line<[i32; LANES]>,
    /// Whether there is a choice.
    pub open: [bool; LANES],
    places: &'static [Place],
}

/// A candidate that is heard in full.
const HEARD: f32 = 16384.0;
/// How candidates are counted that say the same: all alike, by shade, by confidence, by edges.
const KINDS_OF_VOTES: usize = 4;
type Votes = [Sums; KINDS_OF_VOTES];

pub(super) const NONE: Lanes = Line([0.0; LANES]);

impl Block {
    /// With candidates of the map.
    #[cfg(test)]
    pub fn of(reach: &Reach, disparities: [Lanes; MOST]) -> Self {
        let inside = [Line([1.0; LANES]); MOST];
        let mut block = Self { places: reach.places, disparities, inside, ..Self::default() };
        block.relations.find(&disparities[..reach.places.len()], &block.here);
        block
    }

    /// How many candidates a pixel has.
    #[inline(always)]
    pub fn candidates(&self) -> usize {
        self.places.len()
    }

    /// Finds the candidates of some pixels, and says whether any has a choice.
    #[inline(always)]
    pub fn find(
        &mut self,
        products: impl Products,
        scene: &Scene<'_>,
        reach: &Reach,
        pixels: &[undecided::At],
    ) -> bool {
        self.places = reach.places;
        for l in 0..LANES {
            let [column, row] = pixels[if l < pixels.len() { l } else { 0 }];
            (self.columns[l], self.rows[l]) = (column, row);
        }
        let Strip { notes, edges, .. } = scene.strip;
        let (least, most) = (scene.given.least, scene.given.most);
        // The first candidate is the pixel's own.
        let (at_own, _) = self.seen(scene, &reach.places[0]);
        let own = Noted::of(products, notes.samples(), &at_own);
        let here = own.disparities;
        let sums_here = [
            own.sums(true),
            own.sums(false),
            *products.samples(edges.samples(2), &at_own),
            *products.samples(edges.samples(3), &at_own),
        ];
        let (mut smallest, mut largest) = (here, here);
        for (k, place) in reach.places.iter().enumerate() {
            let (at, inside) = self.seen(scene, place);
            let words = Noted::of(products, notes.samples(), &at);
            let sums = match place.way {
                way @ ..2 => words.sums(way == 0),
                way => *products.samples(edges.samples(way), &at),
            };
            let way = place.pixels(reach.every);
            for l in 0..LANES {
                let plane = (words.disparities[l], words.slope(l));
                let d = continued(plane, way, inside[l] > 0.0, here[l], [least, most]);
                self.disparities[k][l] = d;
                self.inside[k][l] = inside[l];
                self.steep[k][l] = steep(words.slope(l));
                smallest[l] = if d < smallest[l] { d } else { smallest[l] };
                largest[l] = if d > largest[l] { d } else { largest[l] };
            }
            let sums_here = &sums_here[place.way];
            for l in 0..LANES {
                let edges = (sums_here[l].wrapping_sub(sums[l]) as i16).unsigned_abs();
                self.marks[k][l] = words.mark(l).seen(own.mark(l).grey(), edges);
            }
        }
        (self.here, self.smallest, self.largest) = (here, smallest, largest);
        self.know_pixels(scene);
        let mut any = false;
        for l in 0..LANES {
            self.open[l] = largest[l] - smallest[l] > reach.choice;
            any |= self.open[l];
        }
        any
    }

    /// Where the notes of the pixels at a place lie as these see it, and 1 for those inside the map, else 0. Beyond the
    /// ends of the map its rows are repeated. Maps have less than 2^31 pixels.
    #[inline(always)]
    fn seen(&self, scene: &Scene<'_>, place: &Place) -> (Places, Lanes) {
        let (columns, rows) = scene.values.size();
        let (columns, rows) = (columns as i32, rows as i32);
        let top = scene.strip.top() as i32;
        let (mut at, mut inside) = (Line([0; LANES]), NONE);
        for l in 0..LANES {
            let (column, row) = (self.columns[l] + place.columns, self.rows[l] + place.rows);
            let is_in_rows = (row >= 0) & (row < rows);
            let row = if is_in_rows { row } else { self.rows[l] };
            let clamped = if column < 0 { 0 } else { column };
            let clamped = if clamped < columns { clamped } else { columns - 1 };
            inside[l] = share(is_in_rows & (clamped == column));
            at[l] = ((row - top) * columns + clamped) as u32;
        }
        (at, inside)
    }

    /// What is known of the pixels, but for their texture.
    #[inline(always)]
    fn know_pixels(&mut self, scene: &Scene<'_>) {
        let mut reasons = [Reason::Matched; LANES];
        for l in 0..LANES {
            reasons[l] = scene.reasons.row(self.rows[l] as usize)[self.columns[l] as usize];
        }
        for l in 0..LANES {
            self.of_pixel[0][l] = self.marks[0][l].confidence();
            self.of_pixel[1][l] = share(reasons[l] == Reason::OccludedFilled);
            self.of_pixel[2][l] = share(reasons[l] == Reason::MismatchedFilled);
            self.of_pixel[3][l] = share(reasons[l] == Reason::OutsideRightFilled);
            self.of_pixel[4][l] = self.marks[0][l].doubt();
        }
    }

    /// Compares the windows of the pixels and their candidates with each other; then hints can be asked for.
    #[inline(always)]
    pub fn compare(&mut self, products: impl Products, given: &Given<'_>, compared: &Compared<'_>) {
        let mut at = Line([0; LANES]);
        for l in 0..LANES {
            let column = given.first as i32 + compared.every as i32 * self.columns[l];
            self.image_columns[l] = column;
            self.begins[l] = compared.width as i32 * (self.rows[l] - compared.first as i32);
            at[l] = (self.begins[l] + column) as u32;
        }
        self.windows = Several::at(products, compared.base, &at);
        let textures = self.windows.textures(products);
        for l in 0..LANES {
            self.of_pixel[5][l] = textures[l] as f32 * (1.0 / (10 * STEPS) as f32);
        }
        self.relations.find(&self.disparities[..self.places.len()], &self.here);
        self.weigh();
    }

    /// Weighs all candidates by how far they are to be heard.
    #[inline(always)]
    fn weigh(&mut self) {
        let mut all = [Line([0; LANES]); KINDS_OF_VOTES];
        for i in 0..self.places.len() / 2 {
            let (one, other) = (self.weights(2 * i), self.weights(2 * i + 1));
            for vote in 0..KINDS_OF_VOTES {
                self.heard[i][vote] = in_turns(&one[vote], &other[vote]);
                for l in 0..LANES {
                    all[vote][l] += one[vote][l] + other[vote][l];
                }
            }
        }
        for (scale, all) in self.scales.iter_mut().zip(&all) {
            for l in 0..LANES {
                scale[l] = 3.0 / all[l] as f32;
            }
        }
    }

    /// The candidates that say the same as a pair of them, each by its weight.
    #[inline(always)]
    pub fn votes(&self, products: impl Products, pair: usize) -> [Votes; 2] {
        let [one, two] = self.relations.of(products, pair);
        products.near([&one, &two], SAME, self.relations.pairs(), &self.heard)
    }

    /// How far candidate `k` is to be heard by each kind of vote, in parts of [`HEARD`].
    #[inline(always)]
    fn weights(&self, k: usize) -> Votes {
        let mut weights = [Line([0; LANES]); KINDS_OF_VOTES];
        for l in 0..LANES {
            let inside = self.inside[k][l] * HEARD;
            // Of the same shade: 1 to 0 over 16 grey values.
            let mark = self.marks[k][l];
            let shade = 1.0 - mark.shade() * 1.25;
            let shade = if shade < 0.05 { 0.05 } else { shade };
            let edges = changes(mark);
            weights[0][l] = nearest(inside);
            weights[1][l] = nearest(inside * shade);
            weights[2][l] = nearest(inside * (mark.confidence() + 0.01));
            weights[3][l] = nearest(inside / (1.0 + edges * edges));
        }
        weights
    }

    /// Writes what is known of candidate `k`, which got these votes: to make hints anew each time, they would be
    /// cleared before.
    #[inline(always)]
    pub fn hints(
        &self,
        products: impl Products,
        compared: &Compared<'_>,
        k: usize,
        votes: &Votes,
        hints: &mut Hints,
    ) {
        let disparities = &self.disparities[k];
        // Where it meets the other image.
        let last = compared.width as i32 - 1;
        let (mut at, mut mirrored, mut outside) = (Line([0; LANES]), Line([0; LANES]), NONE);
        for l in 0..LANES {
            let column = self.image_columns[l] - nearest(disparities[l]);
            let clamped = if column < 0 { 0 } else { column };
            let clamped = if clamped > last { last } else { clamped };
            outside[l] = share(clamped != column);
            at[l] = (self.begins[l] + clamped) as u32;
            mirrored[l] = (self.begins[l] + (last - clamped)) as u32;
        }
        let right = products.numbers(compared.right, &mirrored);
        let met = Several::at(products, compared.other, &at);
        let Fits { bits, bits_here, steps } = self.windows.fit(products, &met);
        for l in 0..LANES {
            let apart = disparities[l] - self.here[l];
            hints[hint::APART][l] = bent(apart);
            hints[hint::FAR][l] = bent(apart).abs();
            hints[hint::CENSUS][l] = bits[l] as f32 * (2.0 / BITS as f32);
            hints[hint::GREY_STEPS][l] = steps[l] as f32 * (1.0 / (10 * STEPS) as f32);
            hints[hint::CENSUS_HERE][l] = bits_here[l] as f32 * 0.25;
            let off = if outside[l] > 0.0 { 0.0 } else { right[l] - disparities[l] };
            hints[hint::RIGHT_APART][l] = bent(off);
            hints[hint::RIGHT_FAR][l] = bent(off).abs();
            hints[hint::ABOVE_SMALLEST][l] = bent(disparities[l] - self.smallest[l]);
            hints[hint::BELOW_LARGEST][l] = bent(self.largest[l] - disparities[l]);
            hints[hint::STEEP][l] = 2.0 * self.steep[k][l];
            let mark = self.marks[k][l];
            hints[hint::CONFIDENCE][l] = mark.confidence();
            hints[hint::FILLED][l] = mark.filled();
            hints[hint::DOUBT][l] = mark.doubt();
            hints[hint::SHADE][l] = mark.shade();
            hints[hint::CHANGES][l] = changes(mark);
            hints[hint::VOTES][l] = votes[0][l] as f32 * self.scales[0][l];
            hints[hint::VOTES_OF_SHADE][l] = votes[1][l] as f32 * self.scales[1][l];
            hints[hint::VOTES_OF_CONFIDENT][l] = votes[2][l] as f32 * self.scales[2][l];
            hints[hint::VOTES_WITHOUT_EDGE][l] = votes[3][l] as f32 * self.scales[3][l];
        }
        hints[hint::OUTSIDE] = outside;
    }
}

/// Differences of disparity as a judge sees them: what is large counts less.
#[inline(always)]
fn bent(difference: f32) -> f32 {
    let far = difference.abs();
    let near = if far < 3.0 { far } else { 3.0 };
    let far = if far < 48.0 { far } else { 48.0 };
    (0.4 * near + 0.05 * far).copysign(difference)
}

/// How much the grey changes on the way to a candidate, as a judge sees it.
#[inline(always)]
fn changes(mark: Mark) -> f32 {
    bent(mark.edges() * 0.05)
}

#[inline(always)]
fn share(is: bool) -> f32 {
    if is { 1.0 } else { 0.0 }
}
