//! What is known of a pixel from which a candidate comes, in one word: judges look at many of them, which
//! lie far apart, so what is known of one pixel lies in one place; and a word is taken from block to block
//! quickly.

use raster::{Plane, Reason};
use rayon::prelude::*;

use super::certainty;
use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;

/// From the lowest bit on the grey value, how sure the pixel is, ten bits that are free, whether it was
/// filled, and whether it is in doubt. [Seen](Note::seen) from another pixel, the difference of grey to
/// that, and in the free bits how much the grey changes on the way.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Note(u32);

impl Note {
    #[inline(always)]
    pub fn new(grey: u8, certainty: u8, filled: bool, doubtful: bool) -> Self {
        let sure = u32::from(grey) | u32::from(certainty) << 8;
        Self(sure | u32::from(filled) << 26 | u32::from(doubtful) << 27)
    }

    /// Whether both views agreed on the pixel whenever they were asked.
    #[inline(always)]
    pub fn is_settled(self) -> bool {
        self.0 >> 26 == 0
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

/// A note of every pixel of some rows of a map.
#[derive(Default)]
pub(crate) struct Notes(Plane<Note>);

impl Notes {
    /// What they take for so many pixels.
    pub fn bytes(pixels: usize) -> usize {
        size_of::<Note>() * pixels
    }

    /// Notes what is known of the rows from `top` on: their grey values, how sure all pixels of the map are,
    /// their reasons, and where descriptors were asked, which may be nowhere.
    pub fn take(
        &mut self,
        level: Level,
        top: usize,
        grey: &Plane<u8>,
        certainty: &Plane<u8>,
        reasons: &Plane<Reason>,
        doubtful: &Plane<bool>,
    ) -> Work {
        let (columns, rows) = grey.size();
        self.0.reshape(columns, rows, Note::default());
        let notes = self.0.samples_mut().par_chunks_mut(columns).enumerate();
        notes.for_each(|(y, notes)| {
            let (grey, y) = (grey.row(y), top + y);
            let doubtful = if doubtful.samples().is_empty() { &[] } else { doubtful.row(y) };
            notes_of_row(level, grey, certainty.row(y), reasons.row(y), doubtful, notes);
        });
        Work::bytes((3 + size_of::<Note>()) * columns * rows + doubtful.samples().len())
    }

    #[inline(always)]
    pub fn row(&self, y: usize) -> &[Note] {
        self.0.row(y)
    }
}

at_every_level! {
    /// Of a row, of which no pixel is in doubt where nothing is said of that.
    fn notes_of_row(
        grey: &[u8],
        certainty: &[u8],
        reasons: &[Reason],
        doubtful: &[bool],
        notes: &mut [Note],
    ) {
        let known = grey.iter().zip(certainty).zip(reasons);
        for (note, ((&grey, &certainty), &reason)) in notes.iter_mut().zip(known) {
            *note = Note::new(grey, certainty, reason != Reason::Matched, false);
        }
        for (note, &doubtful) in notes.iter_mut().zip(doubtful) {
            note.0 |= u32::from(doubtful) << 27;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    #[test]
    fn a_note_says_what_was_noted_and_what_lies_between() {
        let note = Note::new(200, 51, true, false);
        let told = |note: Note| {
            [note.shade(), note.confidence(), note.edges(), note.filled(), note.doubt()]
        };
        assert_eq!(told(note.seen(160, 7)), [2.0, certainty::share(51), 7.0, 1.0, 0.0]);
        assert_eq!(told(note.seen(255, 60_000)), [2.75, certainty::share(51), 1023.0, 1.0, 0.0]);
        let settled = [(false, false), (true, false), (false, true)]
            .map(|(filled, doubtful)| Note::new(255, 255, filled, doubtful).is_settled());
        assert_eq!(settled, [true, false, false]);
        assert_eq!(told(Note::new(0, 255, false, true).seen(0, 0)), [0.0, 1.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn every_pixel_is_noted_at_every_level() {
        let (columns, rows, top) = (71, 6, 2);
        let mut chance = Chance(6);
        let grey = Plane::from_fn(columns, rows - top, |_, _| chance.bits(8) as u8);
        let certainty = Plane::from_fn(columns, rows, |_, _| chance.bits(8) as u8);
        let reasons = [Reason::Matched, Reason::OccludedFilled, Reason::MismatchedFilled];
        let reasons = Plane::from_fn(columns, rows, |_, _| reasons[chance.below(3) as usize]);
        let doubtful = Plane::from_fn(columns, rows, |_, _| chance.below(2) == 1);
        for (level, doubtful) in Level::available()
            .into_iter()
            .flat_map(|level| [(level, doubtful.clone()), (level, Plane::default())])
        {
            eprintln!("level {}", level.name());
            let mut notes = Notes::default();
            notes.take(level, top, &grey, &certainty, &reasons, &doubtful);
            for (y, x) in (0..rows - top).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                let filled = reasons.row(top + y)[x] != Reason::Matched;
                let doubtful = !doubtful.samples().is_empty() && doubtful.row(top + y)[x];
                let expected =
                    Note::new(grey.row(y)[x], certainty.row(top + y)[x], filled, doubtful);
                assert_eq!(notes.row(y)[x], expected, "column {x}, row {y}");
            }
        }
    }
}
