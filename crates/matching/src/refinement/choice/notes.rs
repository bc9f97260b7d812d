//! What is known of a pixel from which a candidate comes, in sixteen bytes: judges look at many of them, which lie
//! far apart, so all that is known of one lies in one place, and four vectors of one kind are made of sixteen.

use raster::{Plane, Reason};
use rayon::prelude::*;

use super::block::{LANES, NONE};
use super::certainty;
use super::edges::Edges;
use super::slopes::{Slope, Slopes};
use crate::kernels::aligned::Line;
use crate::kernels::level::{Level, at_every_level};
use crate::kernels::products::Lanes;
use crate::kernels::records::{Places, Record, Records};
use crate::profile::Work;

/// A word each of the disparity of a pixel, of the slopes there, of its [mark](Mark), and of the sums of the steps
/// before it along its row and its column.
#[inline(always)]
fn note(disparity: f32, slope: Slope, mark: Mark, sums: [u16; 2]) -> Record {
    let both = |one: u32, other: u32| u64::from(one) | u64::from(other) << 32;
    let slope = word(slope.map(|slope| slope as u16));
    Record([both(disparity.to_bits(), slope), both(mark.0, word(sums))])
}

/// What is noted of some pixels, word by word.
pub(super) struct Noted {
    pub disparities: Lanes,
    slopes: Line<[u32; LANES]>,
    marks: Line<[u32; LANES]>,
    sums: Line<[u32; LANES]>,
}

impl Noted {
    /// Those that lie at some places.
    #[inline(always)]
    pub fn of(records: impl Records, notes: &[Record], places: &Places) -> Self {
        let [bits, slopes, marks, sums] = records.fourths(notes, places);
        let mut disparities = NONE;
        for l in 0..LANES {
            disparities[l] = f32::from_bits(bits[l]);
        }
        Self { disparities, slopes, marks, sums }
    }

    #[inline(always)]
    pub fn slope(&self, l: usize) -> Slope {
        halves(self.slopes[l]).map(|half| half as i16)
    }

    #[inline(always)]
    pub fn mark(&self, l: usize) -> Mark {
        Mark(self.marks[l])
    }

    /// The sums of the steps before them along their rows, or else down their columns.
    #[inline(always)]
    pub fn sums(&self, along_rows: bool) -> [u16; LANES] {
        let shift = if along_rows { 0 } else { u16::BITS };
        let mut sums = [0; LANES];
        for l in 0..LANES {
            sums[l] = (self.sums[l] >> shift) as u16;
        }
        sums
    }
}

/// Two numbers of 16 bits in one word, the first in the lower half.
#[inline(always)]
fn word([one, other]: [u16; 2]) -> u32 {
    u32::from(one) | u32::from(other) << 16
}

#[inline(always)]
fn halves(word: u32) -> [u16; 2] {
    [word as u16, (word >> 16) as u16]
}

/// From the lowest bit on the grey value of a pixel, how sure it is, ten bits that are free, whether it was
/// filled, and whether it is in doubt. [Seen](Mark::seen) from another pixel, the difference of grey to
/// that, and in the free bits how much the grey changes on the way.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Mark(u32);

impl Mark {
    #[inline(always)]
    pub fn new(grey: u8, certainty: u8, filled: bool, doubtful: bool) -> Self {
        let sure = u32::from(grey) | u32::from(certainty) << 8;
        Self(sure | u32::from(filled) << 26 | u32::from(doubtful) << 27)
    }

    /// Of a pixel that was not [seen](Self::seen) from another one.
    #[inline(always)]
    pub fn grey(self) -> u8 {
        self.0 as u8
    }

    /// From a pixel of this grey value, when the grey changes by so much on the way.
    #[inline(always)]
    pub fn seen(self, grey: u8, edges: u16) -> Self {
        // More does not count.
        let edges = if edges < 1023 { edges } else { 1023 };
        let apart = (self.0 & 0xff).abs_diff(u32::from(grey));
        Self(self.0 & !0xff | apart | u32::from(edges) << 16)
    }

    #[inline(always)]
    pub fn shade(self) -> f32 {
        (self.0 & 0xff) as f32 * 0.05
    }

    #[inline(always)]
    pub fn confidence(self) -> f32 {
        certainty::share((self.0 >> 8) as u8)
    }

    /// In grey values.
    #[inline(always)]
    pub fn edges(self) -> f32 {
        (self.0 >> 16 & 0x3ff) as f32
    }

    #[inline(always)]
    pub fn filled(self) -> f32 {
        (self.0 >> 26 & 1) as f32
    }

    #[inline(always)]
    pub fn doubt(self) -> f32 {
        (self.0 >> 27 & 1) as f32
    }
}

/// What there is to be noted of the pixels of a map: of all of them their disparities, how sure they are, their
/// reasons, and where descriptors were asked, which may be nowhere; of some rows grey values, slopes and edges.
#[derive(Clone, Copy)]
pub(crate) struct Sources<'a> {
    pub values: &'a Plane<f32>,
    pub certainty: &'a Plane<u8>,
    pub reasons: &'a Plane<Reason>,
    pub doubtful: &'a Plane<bool>,
    pub grey: &'a Plane<u8>,
    pub slopes: &'a Slopes,
    pub edges: &'a Edges,
}

/// A note of every pixel of some rows of a map.
#[derive(Default)]
pub(crate) struct Notes(Plane<Record>);

impl Notes {
    /// What they take for so many pixels.
    pub fn bytes(pixels: usize) -> usize {
        size_of::<Record>() * pixels
    }

    /// Notes what is known of the rows from `top` on.
    pub fn take(&mut self, level: Level, top: usize, sources: Sources<'_>) -> Work {
        let Sources { values, certainty, reasons, doubtful, grey, slopes, edges } = sources;
        let (columns, rows) = grey.size();
        self.0.reshape(columns, rows, Record::default());
        let notes = self.0.samples_mut().par_chunks_mut(columns).enumerate();
        notes.for_each(|(row, notes)| {
            let y = top + row;
            let doubtful = if doubtful.samples().is_empty() { &[] } else { doubtful.row(y) };
            let of_plane = (values.row(y), slopes.row(row));
            let of_mark = (grey.row(row), certainty.row(y), reasons.row(y), doubtful);
            let of_edges = [0, 1].map(|way| edges.row(way, row));
            notes_of_row(level, of_plane, of_mark, of_edges, notes);
        });
        let read = size_of::<f32>() + size_of::<Slope>() + 3 + 2 * size_of::<u16>();
        Work::bytes((read + size_of::<Record>()) * columns * rows + doubtful.samples().len())
    }

    #[inline(always)]
    pub fn samples(&self) -> &[Record] {
        self.0.samples()
    }
}

at_every_level! {
    /// Of a row, of which no pixel is in doubt where nothing is said of that.
    fn notes_of_row(
        of_plane: (&[f32], &[Slope]),
        of_mark: (&[u8], &[u8], &[Reason], &[bool]),
        of_edges: [&[u16]; 2],
        notes: &mut [Record],
    ) {
        let columns = notes.len();
        let (values, slopes) = (&of_plane.0[..columns], &of_plane.1[..columns]);
        let (grey, certainty, reasons, doubtful) = of_mark;
        let (grey, certainty, reasons) =
            (&grey[..columns], &certainty[..columns], &reasons[..columns]);
        let [along, down] = of_edges.map(|sums| &sums[..columns]);
        for x in 0..columns {
            let mark = Mark::new(grey[x], certainty[x], reasons[x] != Reason::Matched, false);
            notes[x] = note(values[x], slopes[x], mark, [along[x], down[x]]);
        }
        for (note, &doubtful) in notes.iter_mut().zip(doubtful) {
            note.0[1] |= u64::from(doubtful) << 27;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::kernels::products::Plain;

    #[test]
    fn a_mark_says_what_was_noted_and_what_lies_between() {
        let mark = Mark::new(200, 51, true, false);
        let told = |mark: Mark| {
            [mark.shade(), mark.confidence(), mark.edges(), mark.filled(), mark.doubt()]
        };
        assert_eq!(mark.grey(), 200);
        assert_eq!(told(mark.seen(160, 7)), [2.0, certainty::share(51), 7.0, 1.0, 0.0]);
        assert_eq!(told(mark.seen(255, 60_000)), [2.75, certainty::share(51), 1023.0, 1.0, 0.0]);
        assert_eq!(told(Mark::new(0, 255, false, true).seen(0, 0)), [0.0, 1.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn every_pixel_is_noted_at_every_level() {
        let (columns, rows, top) = (71, 6, 2);
        let mut chance = Chance(6);
        let values = Plane::from_fn(columns, rows, |_, _| 60.0 * chance.share());
        let grey = Plane::from_fn(columns, rows - top, |_, _| chance.bits(8) as u8);
        let certainty = Plane::from_fn(columns, rows, |_, _| chance.bits(8) as u8);
        let reasons = [Reason::Matched, Reason::OccludedFilled, Reason::MismatchedFilled];
        let reasons = Plane::from_fn(columns, rows, |_, _| reasons[chance.below(3) as usize]);
        let some = Plane::from_fn(columns, rows, |_, _| chance.below(2) == 1);
        for (level, doubtful) in Level::available()
            .into_iter()
            .flat_map(|level| [(level, some.clone()), (level, Plane::default())])
        {
            eprintln!("level {}", level.name());
            let (mut slopes, mut edges) = (Slopes::default(), Edges::default());
            slopes.compute(level, &values, 1, top..rows);
            edges.compute(level, &grey);
            let sources = Sources {
                values: &values,
                certainty: &certainty,
                reasons: &reasons,
                doubtful: &doubtful,
                grey: &grey,
                slopes: &slopes,
                edges: &edges,
            };
            let mut notes = Notes::default();
            notes.take(level, top, sources);
            for (y, x) in (0..rows - top).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                let filled = reasons.row(top + y)[x] != Reason::Matched;
                let doubtful = !doubtful.samples().is_empty() && doubtful.row(top + y)[x];
                let words =
                    Noted::of(Plain, notes.samples(), &Line([(y * columns + x) as u32; LANES]));
                let l = x % LANES;
                assert_eq!(words.disparities[l], values.row(top + y)[x]);
                assert_eq!(words.slope(l), slopes.row(y)[x]);
                let mark = Mark::new(grey.row(y)[x], certainty.row(top + y)[x], filled, doubtful);
                assert_eq!(words.mark(l), mark, "column {x}, row {y}");
                let sums = [true, false].map(|along_rows| words.sums(along_rows)[l]);
                assert_eq!(sums, [0, 1].map(|way| edges.row(way, y)[x]));
            }
        }
    }
}
