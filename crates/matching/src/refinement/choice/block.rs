//! What pixels can choose from, and what is known of each candidate.
//!
//! Candidates are the planes of a pixel itself and of others around it, continued to where it lies.
//! Neighbours of one row are looked at together: what they look at lies side by side too. Those that
//! have a choice are then worked on together, from a few rows. Where not all pixels are matched, maps hold those
//! that are.

use raster::{Plane, Reason, View};

use super::edges::WAYS;
use super::hint::{self, Hints};
use super::notes::Note;
use super::reach::{MOST, Place, Reach};
use super::relations::{Relations, SAME, in_turns};
use super::slopes::{rise, steep};
use super::strip::Strip;
use super::windows::{BITS, Fits, STEPS, Several, Window, Windows};
use crate::kernels::aligned::Line;
use crate::kernels::level::Level;
use crate::kernels::products::{Lanes, Numbers, Products, Sums};
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
    /// Columns in each.
    width: usize,
    /// A column of the map is every so many-th one of these.
    every: usize,
    pub base: &'a [Window],
    pub other: &'a [Window],
    /// The disparities of the right view, in a mirror.
    pub right: &'a [f32],
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
        let width = scene.given.right.columns();
        let right = &scene.given.right.samples()[first * width..][..rows * width];
        Self { width, every: strip.every(), base: base.get(), other: other.get(), right }
    }
}

/// Pixels of a row, their candidates and what is known of them. Neighbours first: then those that have
/// a choice are [taken](Block::take) into another block, where more is asked.
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
    notes: [[Note; LANES]; MOST],
    /// How the candidates lie to each other.
    pub relations: Relations,
    /// How far they are to be heard, two after the other.
    heard: [[Numbers; KINDS_OF_VOTES]; MOST / 2],
    votes: [[Sums; KINDS_OF_VOTES]; MOST],
    /// What makes votes shares.
    scales: [Lanes; KINDS_OF_VOTES],
    here: Lanes,
    smallest: Lanes,
    largest: Lanes,
    /// Confidence; whether occluded, mismatched, outside the right image, in doubt; texture.
    pub of_pixel: [Lanes; OF_PIXEL],
    windows: Several,
    /// Where candidates meet the other image: the windows there, what the right view says, whether it lies outside.
    met: [Several; MOST],
    right: [Lanes; MOST],
    outside: [Lanes; MOST],
    /// How many of the pixels are of interest.
    count: usize,
    /// Where the pixels lie in the map: columns, and rows counted from the first of those that are worked on.
    pub columns: [usize; LANES],
    pub rows: [usize; LANES],
    /// Their columns in the image, and where the rows begin that they are compared with.
    image_columns: [i32; LANES],
    begins: [usize; LANES],
    /// Whether there is a choice.
    pub open: [bool; LANES],
    y: usize,
    places: &'static [Place],
}

/// A candidate that is heard in full.
const HEARD: f32 = 16384.0;
/// How candidates are counted that say the same: all alike, by shade, by confidence, by edges.
const KINDS_OF_VOTES: usize = 4;

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

    /// Finds the candidates of pixels from `(x, y)` on, in a row counted from the first of some; says whether any
    /// that is marked has a choice.
    #[inline(always)]
    pub fn find(
        &mut self,
        scene: &Scene<'_>,
        reach: &Reach,
        marked: [bool; LANES],
        (x, y): (usize, usize),
        row: usize,
    ) -> bool {
        (self.y, self.places) = (y, reach.places);
        self.open = [false; LANES];
        self.rows = [row; LANES];
        for l in 0..LANES {
            self.columns[l] = x + l;
        }
        if marked == [false; LANES] {
            return false;
        }
        let (columns, rows) = scene.values.size();
        let (least, most) = (scene.given.least, scene.given.most);
        self.here = Line(run(scene.values.row(y), x as i64));
        let here = self.here;
        let notes = run(scene.strip.notes.row(scene.strip.row(y)), x as i64);
        let (mut smallest, mut largest) = (here, here);
        let mut undecided = [false; LANES];
        let mut ends = (NONE, Line([[0; 2]; LANES]));
        for (k, place) in reach.places.iter().enumerate() {
            let (u, row) = place.seen_from(x, y, rows);
            let v = row.unwrap_or(y);
            let values = run_in(scene.values.row(v), u, &mut ends.0);
            let slopes = run_in(scene.strip.slopes.row(scene.strip.row(v)), u, &mut ends.1);
            let way = place.pixels(reach.every);
            let inside = if row.is_some() { inside(u, columns) } else { NONE };
            let disparities = &mut self.disparities[k];
            for l in 0..LANES {
                let d = values[l] - rise(slopes[l], way);
                let d = if inside[l] > 0.0 { d } else { here[l] };
                let d = if d < least { least } else { d };
                disparities[l] = if d > most { most } else { d };
                self.steep[k][l] = steep(slopes[l]);
            }
            self.inside[k] = inside;
            for l in 0..LANES {
                let d = disparities[l];
                smallest[l] = if d < smallest[l] { d } else { smallest[l] };
                largest[l] = if d > largest[l] { d } else { largest[l] };
            }
            if k + 1 == reach.inner {
                let mut any = false;
                for l in 0..LANES {
                    undecided[l] =
                        !notes[l].is_settled() | (largest[l] - smallest[l] > reach.settled);
                    any |= undecided[l] & marked[l];
                }
                if !any {
                    return false;
                }
            }
        }
        (self.smallest, self.largest) = (smallest, largest);
        let mut any = false;
        for l in 0..LANES {
            let is_one = self.columns[l] < columns;
            let open =
                is_one & marked[l] & undecided[l] & (largest[l] - smallest[l] > reach.choice);
            self.open[l] = open;
            any |= open;
        }
        any
    }

    /// Looks at the pixels, and at where their candidates come from.
    #[inline(always)]
    pub fn look(&mut self, scene: &Scene<'_>) {
        let (x, y) = (self.columns[0], self.y);
        let strip = scene.strip;
        let grey_here = run(strip.grey.row(strip.row(y)), x as i64);
        let mut ends = (Line([Note::default(); LANES]), Line([0; LANES]));
        let mut sums_here = [[0; LANES]; WAYS];
        for (way, sums) in sums_here.iter_mut().enumerate() {
            *sums = run(strip.edges.row(way, strip.row(y)), x as i64);
        }
        for (k, place) in self.places.iter().enumerate() {
            let (u, row) = place.seen_from(x, y, scene.values.rows());
            let v = row.unwrap_or(y);
            let notes = run_in(strip.notes.row(strip.row(v)), u, &mut ends.0);
            let sums = run_in(strip.edges.row(place.way, strip.row(v)), u, &mut ends.1);
            for l in 0..LANES {
                let edges = (sums_here[place.way][l].wrapping_sub(sums[l]) as i16).unsigned_abs();
                self.notes[k][l] = notes[l].seen(grey_here[l], edges);
            }
        }
        let reasons = run(scene.reasons.row(y), x as i64);
        for l in 0..LANES {
            self.of_pixel[0][l] = self.notes[0][l].confidence();
            self.of_pixel[1][l] = share(reasons[l] == Reason::OccludedFilled);
            self.of_pixel[2][l] = share(reasons[l] == Reason::MismatchedFilled);
            self.of_pixel[3][l] = share(reasons[l] == Reason::OutsideRightFilled);
            self.of_pixel[4][l] = self.notes[0][l].doubt();
        }
    }

    /// Takes a pixel of another block, with all that was seen of it. Not compiled for every level: with
    /// instructions that gather and scatter the compiler would use them, which takes longer.
    #[inline(never)]
    pub fn take(&mut self, to: usize, other: &Block, from: usize) {
        self.places = other.places;
        self.columns[to] = other.columns[from];
        self.rows[to] = other.rows[from];
        self.here[to] = other.here[from];
        self.smallest[to] = other.smallest[from];
        self.largest[to] = other.largest[from];
        for i in 0..OF_PIXEL {
            self.of_pixel[i][to] = other.of_pixel[i][from];
        }
        for k in 0..other.places.len() {
            self.disparities[k][to] = other.disparities[k][from];
            self.inside[k][to] = other.inside[k][from];
            self.steep[k][to] = other.steep[k][from];
            self.notes[k][to] = other.notes[k][from];
        }
    }

    /// Compares the windows of the first pixels, so many, and their candidates with each other; then
    /// hints can be asked for. The other pixels are of no interest.
    #[inline(always)]
    pub fn compare(
        &mut self,
        products: impl Products,
        count: usize,
        given: &Given<'_>,
        compared: &Compared<'_>,
    ) {
        // They may lie beyond the ends of the map.
        for l in count..LANES {
            self.columns[l] = self.columns[0];
            self.rows[l] = self.rows[0];
        }
        let mut at = Line([0; LANES]);
        for l in 0..LANES {
            let column = given.first + compared.every * self.columns[l];
            self.image_columns[l] = column as i32;
            self.begins[l] = compared.width * self.rows[l];
            at[l] = self.begins[l] + column;
        }
        self.count = count;
        self.windows.take(compared.base, &at);
        let textures = self.windows.textures();
        for l in 0..LANES {
            self.of_pixel[5][l] = textures[l] * (1.0 / (10 * STEPS) as f32);
        }
        for k in 0..self.places.len() {
            self.meet(compared, k);
        }
        self.relations.find(&self.disparities[..self.places.len()], &self.here);
        self.count_votes(products);
    }

    /// Looks at where candidate `k` meets the other image. All candidates do that before anything is made of it:
    /// what was just written in parts cannot be read as a whole for a while.
    #[inline(always)]
    fn meet(&mut self, compared: &Compared<'_>, k: usize) {
        let disparities = &self.disparities[k];
        let last = compared.width as i32 - 1;
        let (mut at, mut mirrored) = (Line([0; LANES]), Line([0; LANES]));
        let mut outside = NONE;
        for l in 0..LANES {
            let column = self.image_columns[l] - nearest(disparities[l]);
            let clamped = if column < 0 { 0 } else { column };
            let clamped = if clamped > last { last } else { clamped };
            outside[l] = share(clamped != column);
            at[l] = self.begins[l] + clamped as usize;
            mirrored[l] = self.begins[l] + (last - clamped) as usize;
        }
        self.outside[k] = outside;
        self.met[k].take(compared.other, &at);
        for l in 0..LANES {
            self.right[k][l] = compared.right[mirrored[l]];
        }
    }

    /// Counts the candidates that say the same, each weighed by how far it is to be heard.
    #[inline(always)]
    fn count_votes(&mut self, products: impl Products) {
        let n = self.places.len();
        let mut all = [Line([0; LANES]); KINDS_OF_VOTES];
        for i in 0..n / 2 {
            let (one, other) = (self.weights(2 * i), self.weights(2 * i + 1));
            for vote in 0..KINDS_OF_VOTES {
                self.heard[i][vote] = in_turns(&one[vote], &other[vote]);
                for l in 0..LANES {
                    all[vote][l] += one[vote][l] + other[vote][l];
                }
            }
        }
        for (i, votes) in self.votes.as_chunks_mut::<2>().0[..n / 2].iter_mut().enumerate() {
            let [one, two] = self.relations.of(products, i);
            *votes = products.near([&one, &two], SAME, self.relations.pairs(), &self.heard);
        }
        for (scale, all) in self.scales.iter_mut().zip(&all) {
            for l in 0..LANES {
                scale[l] = 3.0 / all[l] as f32;
            }
        }
    }

    /// How far candidate `k` is to be heard by each kind of vote, in parts of [`HEARD`].
    #[inline(always)]
    fn weights(&self, k: usize) -> [Sums; KINDS_OF_VOTES] {
        let mut weights = [Line([0; LANES]); KINDS_OF_VOTES];
        for l in 0..LANES {
            let inside = self.inside[k][l] * HEARD;
            // Of the same shade: 1 to 0 over 16 grey values.
            let note = self.notes[k][l];
            let shade = 1.0 - note.shade() * 1.25;
            let shade = if shade < 0.05 { 0.05 } else { shade };
            let edges = changes(note);
            weights[0][l] = nearest(inside);
            weights[1][l] = nearest(inside * shade);
            weights[2][l] = nearest(inside * (note.confidence() + 0.01));
            weights[3][l] = nearest(inside / (1.0 + edges * edges));
        }
        weights
    }

    /// Writes what is known of candidate `k`: to make hints anew each time, they would be cleared before.
    #[inline(always)]
    pub fn hints(&self, k: usize, hints: &mut Hints) {
        let disparities = &self.disparities[k];
        let (right, outside) = (&self.right[k], &self.outside[k]);
        let Fits { bits, bits_here, steps } = self.windows.fit(&self.met[k], self.count);
        for l in 0..LANES {
            let apart = disparities[l] - self.here[l];
            hints[hint::APART][l] = bent(apart);
            hints[hint::FAR][l] = bent(apart).abs();
            hints[hint::CENSUS][l] = bits[l] * (2.0 / BITS as f32);
            hints[hint::GREY_STEPS][l] = steps[l] * (1.0 / (10 * STEPS) as f32);
            hints[hint::CENSUS_HERE][l] = bits_here[l] * 0.25;
            let off = if outside[l] > 0.0 { 0.0 } else { right[l] - disparities[l] };
            hints[hint::RIGHT_APART][l] = bent(off);
            hints[hint::RIGHT_FAR][l] = bent(off).abs();
            hints[hint::ABOVE_SMALLEST][l] = bent(disparities[l] - self.smallest[l]);
            hints[hint::BELOW_LARGEST][l] = bent(self.largest[l] - disparities[l]);
            hints[hint::STEEP][l] = 2.0 * self.steep[k][l];
            let note = self.notes[k][l];
            hints[hint::CONFIDENCE][l] = note.confidence();
            hints[hint::FILLED][l] = note.filled();
            hints[hint::DOUBT][l] = note.doubt();
            hints[hint::SHADE][l] = note.shade();
            hints[hint::CHANGES][l] = changes(note);
            hints[hint::VOTES][l] = self.votes[k][0][l] as f32 * self.scales[0][l];
            hints[hint::VOTES_OF_SHADE][l] = self.votes[k][1][l] as f32 * self.scales[1][l];
            hints[hint::VOTES_OF_CONFIDENT][l] = self.votes[k][2][l] as f32 * self.scales[2][l];
            hints[hint::VOTES_WITHOUT_EDGE][l] = self.votes[k][3][l] as f32 * self.scales[3][l];
        }
        hints[hint::OUTSIDE] = *outside;
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
fn changes(note: Note) -> f32 {
    bent(note.edges() * 0.05)
}

#[inline(always)]
fn share(is: bool) -> f32 {
    if is { 1.0 } else { 0.0 }
}

/// The samples of a row from `start` on; beyond its ends the row is repeated.
#[inline(always)]
pub(super) fn run<T: Copy>(row: &[T], start: i64) -> [T; LANES] {
    *run_in(row, start, &mut [row[0]; LANES])
}

/// The same where they lie, or else in `end`. Copied to the stack first, many of them are waited for: how long
/// depends on whether the copy lies across two cache lines.
#[inline(always)]
fn run_in<'a, T: Copy>(row: &'a [T], start: i64, end: &'a mut [T; LANES]) -> &'a [T; LANES] {
    match row.get(start as usize..).and_then(|row| row.first_chunk()) {
        Some(run) => run,
        None => {
            *end = run_at_end(row, start);
            end
        }
    }
}

#[cold]
#[inline(never)]
fn run_at_end<T: Copy>(row: &[T], start: i64) -> [T; LANES] {
    let length = row.len() as i64;
    let [from, to] = [start, start + LANES as i64].map(|end| end.clamp(0, length) as usize);
    if from == to {
        return [row[if start < 0 { 0 } else { row.len() - 1 }]; LANES];
    }
    let before = (from as i64 - start) as usize;
    let mut run = [row[to - 1]; LANES];
    run[..before].fill(row[from]);
    run[before..][..to - from].copy_from_slice(&row[from..to]);
    run
}

/// 1 for columns from `start` on that lie inside a row of so many, 0 for others.
#[inline(always)]
fn inside(start: i64, columns: usize) -> Lanes {
    let mut inside = Line([1.0; LANES]);
    if start < 0 || start + LANES as i64 > columns as i64 {
        for l in 0..LANES {
            inside[l] = share((0..columns as i64).contains(&(start + l as i64)));
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_repeat_the_ends_of_a_row() {
        for length in [1, 5, LANES, 40] {
            let row: Vec<usize> = (0..length).collect();
            for start in -40..60 {
                let expected: [usize; LANES] = std::array::from_fn(|l| {
                    (start + l as i64).clamp(0, length as i64 - 1) as usize
                });
                assert_eq!(run(&row, start), expected, "from {start} of {length}");
            }
        }
    }
}
