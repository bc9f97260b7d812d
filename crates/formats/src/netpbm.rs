//! The text header that PGM, PPM and PFM share: words with white space between them.

/// Walks over the words of a header.
pub(crate) struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Words<'a> {
    /// Starts behind the two bytes of the magic number.
    pub fn after_magic(bytes: &'a [u8]) -> Self {
        Self { bytes, at: bytes.len().min(2) }
    }

    /// The next word, or `None` at the end. `#` starts a comment that ends with the line.
    pub fn next(&mut self) -> Option<&'a str> {
        while let Some(&byte) = self.bytes.get(self.at) {
            if byte == b'#' {
                let rest = &self.bytes[self.at..];
                self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            } else if is_space(byte) {
                self.at += 1;
            } else {
                break;
            }
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| is_space(b) || b == b'#').unwrap_or(rest.len());
        let word = &rest[..length];
        self.at += length;
        if word.is_empty() { None } else { std::str::from_utf8(word).ok() }
    }

    /// How many bytes have been consumed, from the start of the file.
    pub fn at(&self) -> usize {
        self.at
    }

    /// The bytes behind the single white space that ends a header, or `None` where there is none.
    pub fn data(&self) -> Option<&'a [u8]> {
        match self.bytes.get(self.at) {
            Some(&byte) if is_space(byte) => Some(&self.bytes[self.at + 1..]),
            _ => None,
        }
    }
}

fn is_space(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == 0x0b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_skip_space_and_comments() {
        let mut words = Words::after_magic(b"P5#a b\n # c\n\t12 #x\n34\n\nrest");
        assert_eq!(words.next(), Some("12"));
        assert_eq!(words.next(), Some("34"));
        assert_eq!(words.data(), Some(&b"\nrest"[..]));
        assert_eq!(words.next(), Some("rest"));
        assert_eq!((words.next(), words.data()), (None, None));
    }
}
