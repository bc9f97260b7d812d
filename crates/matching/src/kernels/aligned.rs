//! Samples of which the first lies where a cache line begins.
//!
//! A vector that lies across two lines takes two loads. What is read and written in whole vectors all
//! the time begins at a line: how fast a kernel is then does not depend on what the allocator gives.

use std::ops::{Deref, DerefMut};

/// Bytes of a cache line, and of the widest vectors.
pub(crate) const LINE: usize = 64;

/// Samples in a row, from the beginning of a line on.
#[derive(Debug, Default)]
pub(crate) struct Aligned<T> {
    /// With room for a line more.
    samples: Vec<T>,
    start: usize,
    length: usize,
}

/// A vector that begins where a cache line does. Local ones would begin anywhere on the stack: most of those of 64
/// bytes lie across two lines then, which made choices up to 8 % slower in one build than in the next.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Line<A>(pub A);

/// Makes the frame of the function that this becomes a part of begin where a cache line does: what its registers have
/// no room for is kept there, and where frames begin anywhere half of that may lie across two lines.
#[inline(always)]
pub(crate) fn align_frame() {
    // It may be changed for all that the compiler knows, so it has to be there.
    std::hint::black_box(&mut Line(0u8));
}

impl<A> Deref for Line<A> {
    type Target = A;

    #[inline(always)]
    fn deref(&self) -> &A {
        &self.0
    }
}

impl<A> DerefMut for Line<A> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut A {
        &mut self.0
    }
}

impl<T: Copy> Aligned<T> {
    /// So many samples of one value.
    pub fn refill(&mut self, length: usize, value: T) {
        self.samples.clear();
        self.samples.resize(length + LINE / size_of::<T>(), value);
        self.start = self.samples.as_ptr().align_offset(LINE);
        self.length = length;
    }

    /// So many samples, whatever their values; these stay if there are as many already.
    pub fn resize(&mut self, length: usize, value: T) {
        if self.length != length {
            self.refill(length, value);
        }
    }
}

impl<T> Deref for Aligned<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        &self.samples[self.start..][..self.length]
    }
}

impl<T> DerefMut for Aligned<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.samples[self.start..][..self.length]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_sample_begins_a_line_however_often_they_are_refilled() {
        let mut samples = Aligned::<u16>::default();
        assert!(samples.is_empty());
        for length in [1, 1000, 31, 0, 64, 100_000] {
            samples.refill(length, 7);
            assert_eq!(samples.as_ptr().addr() % LINE, 0);
            assert_eq!(samples[..], vec![7; length]);
            samples.fill(8);
        }
    }
}
