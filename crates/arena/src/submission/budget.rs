//! What an archive may make its reader read.
//!
//! The library for tar reads the headers of an entry, long names and extended attributes among them,
//! into memory before it shows the entry, whatever their size; and what is left out (caches, folders)
//! is read as well, since an archive has no index. Three megabytes of gzip can hold gigabytes of
//! either. So whoever reads says what is being read, and [`Bounded`] ends with an error before memory
//! or time do.

use std::cell::Cell;
use std::io::{self, Read};

/// Bytes of an archive, decompressed: what is taken, what is left out, and all headers.
const TOTAL: u64 = 256 << 20;

/// Bytes of what may stand before an entry: its name and attributes, where they have headers of their
/// own.
const EXTENSIONS: u64 = 64 << 10;

/// Bytes beyond these that are always read: the blocks of the headers themselves, and the rest of the
/// last block of each.
const BLOCKS: u64 = 8 * 512;

/// How much may still be read.
#[derive(Debug)]
pub(super) struct Budget {
    total: Cell<u64>,
    /// While headers are read: how much of them is left.
    headers: Cell<Option<u64>>,
}

impl Budget {
    pub fn new() -> Self {
        Self { total: Cell::new(TOTAL), headers: Cell::new(None) }
    }

    /// From here on headers of one entry are read.
    pub fn begin_headers(&self) {
        self.headers.set(Some(EXTENSIONS + BLOCKS));
    }

    /// From here on an entry's content is read.
    pub fn begin_content(&self) {
        self.headers.set(None);
    }

    /// What was too much, if reading ended for that.
    pub fn excess(&self) -> Option<String> {
        if self.headers.get() == Some(0) {
            return Some(format!(
                "a name or the attributes of a file take more than {} KiB; pack the Python files \
                 alone, under short names",
                EXTENSIONS >> 10
            ));
        }
        (self.total.get() == 0).then(|| {
            format!(
                "with what is left out it unpacks to more than {} MiB; hand in the Python files \
                 alone",
                TOTAL >> 20
            )
        })
    }

    fn left(&self) -> u64 {
        self.total.get().min(self.headers.get().unwrap_or(u64::MAX))
    }

    fn spend(&self, bytes: u64) {
        self.total.set(self.total.get() - bytes);
        self.headers.set(self.headers.get().map(|left| left - bytes));
    }
}

/// A reader that fails where its budget ends.
pub(super) struct Bounded<'a, R> {
    reader: R,
    budget: &'a Budget,
}

impl<'a, R: Read> Bounded<'a, R> {
    pub fn new(reader: R, budget: &'a Budget) -> Self {
        Self { reader, budget }
    }
}

impl<R: Read> Read for Bounded<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if let Some(excess) = self.budget.excess() {
            return Err(io::Error::other(excess));
        }
        let most = usize::try_from(self.budget.left()).unwrap_or(usize::MAX).min(buffer.len());
        let read = self.reader.read(&mut buffer[..most])?;
        self.budget.spend(read as u64);
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_and_all_of_it_end_somewhere() {
        let budget = Budget::new();
        let mut reader = Bounded::new(io::repeat(7), &budget);
        let mut read = |bytes: u64| io::copy(&mut reader.by_ref().take(bytes), &mut io::sink());
        for _ in 0..3 {
            budget.begin_headers();
            assert_eq!(read(EXTENSIONS).unwrap(), EXTENSIONS);
            budget.begin_content();
            assert_eq!(read(1 << 20).unwrap(), 1 << 20);
        }
        budget.begin_headers();
        assert!(read(1 << 20).unwrap_err().to_string().contains("more than 64 KiB"));
        budget.begin_content();
        assert_eq!(budget.excess(), None);
        assert!(read(TOTAL).unwrap_err().to_string().contains("more than 256 MiB"));
    }
}
