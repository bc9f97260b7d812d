//! The header of a `.npy` file: a Python dictionary with the three keys `descr`, `fortran_order`
//! and `shape`, and nothing else. Nothing is evaluated; what is not exactly that is refused.

use std::fmt;

/// The type of an array's elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Dtype {
    /// Truth values, one byte each.
    Bool,
    /// Unsigned, 8 bit.
    Uint8,
    /// Signed, 8 bit.
    Int8,
    /// Unsigned, 16 bit.
    Uint16,
    /// Signed, 16 bit.
    Int16,
    /// Unsigned, 32 bit.
    Uint32,
    /// Signed, 32 bit.
    Int32,
    /// Unsigned, 64 bit.
    Uint64,
    /// Signed, 64 bit.
    Int64,
    /// IEEE 754, 16 bit.
    Float16,
    /// IEEE 754, 32 bit.
    Float32,
    /// IEEE 754, 64 bit.
    Float64,
}

impl Dtype {
    /// Bytes an element.
    pub fn size(self) -> usize {
        match self {
            Self::Bool | Self::Uint8 | Self::Int8 => 1,
            Self::Uint16 | Self::Int16 | Self::Float16 => 2,
            Self::Uint32 | Self::Int32 | Self::Float32 => 4,
            Self::Uint64 | Self::Int64 | Self::Float64 => 8,
        }
    }

    /// NumPy's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bool => "bool",
            Self::Uint8 => "uint8",
            Self::Int8 => "int8",
            Self::Uint16 => "uint16",
            Self::Int16 => "int16",
            Self::Uint32 => "uint32",
            Self::Int32 => "int32",
            Self::Uint64 => "uint64",
            Self::Int64 => "int64",
            Self::Float16 => "float16",
            Self::Float32 => "float32",
            Self::Float64 => "float64",
        }
    }

    /// Whether the elements are whole numbers (truth values are not).
    pub fn is_integer(self) -> bool {
        !matches!(self, Self::Bool | Self::Float16 | Self::Float32 | Self::Float64)
    }

    /// The code in `descr` behind the byte order.
    fn from_code(code: &str) -> Option<Self> {
        Some(match code {
            "b1" => Self::Bool,
            "u1" => Self::Uint8,
            "i1" => Self::Int8,
            "u2" => Self::Uint16,
            "i2" => Self::Int16,
            "u4" => Self::Uint32,
            "i4" => Self::Int32,
            "u8" => Self::Uint64,
            "i8" => Self::Int64,
            "f2" => Self::Float16,
            "f4" => Self::Float32,
            "f8" => Self::Float64,
            _ => return None,
        })
    }

    /// `descr` as this crate writes it.
    pub(crate) fn descr(self) -> &'static str {
        match self {
            Self::Bool => "|b1",
            Self::Uint8 => "|u1",
            Self::Int8 => "|i1",
            Self::Uint16 => "<u2",
            Self::Int16 => "<i2",
            Self::Uint32 => "<u4",
            Self::Int32 => "<i4",
            Self::Uint64 => "<u8",
            Self::Int64 => "<i8",
            Self::Float16 => "<f2",
            Self::Float32 => "<f4",
            Self::Float64 => "<f8",
        }
    }
}

impl fmt::Display for Dtype {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What a `.npy` file says about itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Header {
    pub dtype: Dtype,
    pub big_endian: bool,
    pub fortran_order: bool,
    pub shape: Vec<usize>,
    /// Where the elements begin.
    pub data_at: usize,
}

/// Why a header is refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// It breaks the rules, at a byte of the file.
    Malformed(usize, String),
    /// It is sound, but holds what is not read.
    WrongKind(String),
}

/// More than this many bytes of header are not believed; NumPy's own limit is 10000.
const LONGEST_HEADER: usize = 1 << 16;

impl Header {
    /// Reads the header at the start of a file.
    pub fn parse(bytes: &[u8]) -> Result<Self, Refusal> {
        let cut = || Refusal::Malformed(bytes.len(), "the file ends inside its header".to_owned());
        let version = *bytes.get(6).ok_or_else(cut)?;
        let (length, start) = match version {
            1 => {
                let raw = bytes.get(8..10).ok_or_else(cut)?;
                (usize::from(u16::from_le_bytes([raw[0], raw[1]])), 10)
            }
            2 | 3 => {
                let raw = bytes.get(8..12).ok_or_else(cut)?;
                (u32::from_le_bytes([raw[0], raw[1], raw[2], raw[3]]) as usize, 12)
            }
            other => {
                let problem = format!("version {other} is unknown: 1, 2 and 3 are read");
                return Err(Refusal::Malformed(6, problem));
            }
        };
        if length > LONGEST_HEADER {
            let problem = format!("a header of {length} bytes; at most {LONGEST_HEADER} are read");
            return Err(Refusal::Malformed(8, problem));
        }
        let text = bytes.get(start..start + length).ok_or_else(cut)?;
        let mut parser = Parser { text, start, at: 0 };
        parser.dictionary(start + length)
    }
}

/// Reads just as much Python as NumPy writes.
struct Parser<'a> {
    text: &'a [u8],
    /// Where the text begins in the file.
    start: usize,
    at: usize,
}

impl Parser<'_> {
    fn dictionary(&mut self, data_at: usize) -> Result<Header, Refusal> {
        let (mut dtype, mut fortran_order, mut shape) = (None, None, None);
        self.expect(b'{')?;
        while !self.take(b'}') {
            let key = self.string()?;
            self.expect(b':')?;
            match key.as_str() {
                "descr" if dtype.is_none() => dtype = Some(self.descr()?),
                "fortran_order" if fortran_order.is_none() => fortran_order = Some(self.boolean()?),
                "shape" if shape.is_none() => shape = Some(self.shape()?),
                _ => return Err(self.fail(format!("the key `{key}` is unknown or there twice"))),
            }
            if !self.take(b',') {
                self.expect(b'}')?;
                break;
            }
        }
        if self.peek().is_some() {
            let problem = "behind the dictionary only white space is allowed".to_owned();
            return Err(self.fail(problem));
        }
        match (dtype, fortran_order, shape) {
            (Some((dtype, big_endian)), Some(fortran_order), Some(shape)) => {
                Ok(Header { dtype, big_endian, fortran_order, shape, data_at })
            }
            _ => Err(self.fail("descr, fortran_order and shape must all be there".to_owned())),
        }
    }

    fn fail(&self, problem: String) -> Refusal {
        Refusal::Malformed(self.start + self.at, format!("in the header: {problem}"))
    }

    /// The next byte that is not white space.
    fn peek(&mut self) -> Option<u8> {
        while self.text.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    fn take(&mut self, byte: u8) -> bool {
        let found = self.peek() == Some(byte);
        self.at += usize::from(found);
        found
    }

    fn expect(&mut self, byte: u8) -> Result<(), Refusal> {
        if self.take(byte) {
            Ok(())
        } else {
            Err(self.fail(format!("`{}` is missing", char::from(byte))))
        }
    }

    /// The bytes up to the first that is not `wanted`.
    fn run(&mut self, wanted: impl Fn(u8) -> bool) -> String {
        self.peek();
        let rest = &self.text[self.at..];
        let length = rest.iter().position(|&b| !wanted(b)).unwrap_or(rest.len());
        self.at += length;
        String::from_utf8_lossy(&rest[..length]).into_owned()
    }

    fn string(&mut self) -> Result<String, Refusal> {
        let quote = match self.peek() {
            Some(quote @ (b'\'' | b'"')) => quote,
            _ => return Err(self.fail("a quoted word is missing".to_owned())),
        };
        self.at += 1;
        let rest = &self.text[self.at..];
        let length = rest
            .iter()
            .position(|&b| b == quote)
            .ok_or_else(|| self.fail("a quotation does not end".to_owned()))?;
        self.at += length + 1;
        Ok(String::from_utf8_lossy(&rest[..length]).into_owned())
    }

    fn boolean(&mut self) -> Result<bool, Refusal> {
        match self.run(|b| b.is_ascii_alphabetic()).as_str() {
            "True" => Ok(true),
            "False" => Ok(false),
            _ => Err(self.fail("fortran_order must be True or False".to_owned())),
        }
    }

    fn shape(&mut self) -> Result<Vec<usize>, Refusal> {
        self.expect(b'(')?;
        let mut shape = Vec::new();
        while !self.take(b')') {
            let digits = self.run(|b| b.is_ascii_digit());
            let side = digits
                .parse()
                .map_err(|_| self.fail("the shape must be a tuple of whole numbers".to_owned()))?;
            shape.push(side);
            if shape.len() > 32 {
                return Err(self.fail("more than 32 dimensions".to_owned()));
            }
            if !self.take(b',') {
                self.expect(b')')?;
                break;
            }
        }
        Ok(shape)
    }

    /// The element type, and whether its bytes are big endian.
    fn descr(&mut self) -> Result<(Dtype, bool), Refusal> {
        if self.peek() == Some(b'[') {
            return Err(Refusal::WrongKind("a structured array (fields with names)".to_owned()));
        }
        let descr = self.string()?;
        let code = descr.strip_prefix(['<', '>', '|', '=']).unwrap_or(&descr);
        let found = match code.as_bytes().first() {
            Some(b'O') => "an array of Python objects (pickle), which is never loaded".to_owned(),
            Some(b'c') => format!("an array of complex numbers ({descr})"),
            Some(b'U' | b'S' | b'a') => format!("an array of strings ({descr})"),
            Some(b'M' | b'm') => format!("an array of dates or times ({descr})"),
            Some(b'V') => format!("an array of raw records ({descr})"),
            _ => format!("an array of the unknown type `{descr}`"),
        };
        // `=` means the byte order of the machine that wrote it, which the file does not tell.
        match Dtype::from_code(code) {
            Some(dtype) if !descr.starts_with('=') || dtype.size() == 1 => {
                Ok((dtype, descr.starts_with('>')))
            }
            _ => Err(Refusal::WrongKind(found)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(dictionary: &str) -> Result<Header, Refusal> {
        let mut bytes = b"\x93NUMPY\x01\0".to_vec();
        bytes.extend((dictionary.len() as u16).to_le_bytes());
        bytes.extend(dictionary.as_bytes());
        Header::parse(&bytes)
    }

    #[test]
    fn what_numpy_writes_is_read() {
        let header =
            parse("{'descr': '>i2', 'fortran_order': True, 'shape': (3, 4), }   \n").unwrap();
        assert_eq!((header.dtype, header.big_endian), (Dtype::Int16, true));
        assert_eq!((header.fortran_order, header.shape), (true, vec![3, 4]));
        let header = parse(r#"{"shape":(),"descr":"|u1","fortran_order":False}"#).unwrap();
        assert_eq!((header.dtype, header.shape), (Dtype::Uint8, vec![]));
        let header = parse("{'descr': '<f8', 'fortran_order': False, 'shape': (7,)}").unwrap();
        assert_eq!(header.shape, [7]);
    }

    #[test]
    fn a_header_is_believed_to_the_longest_one() {
        let of_length = |length: usize| {
            let mut bytes = b"\x93NUMPY\x02\0".to_vec();
            bytes.extend((length as u32).to_le_bytes());
            bytes.extend(b"{'descr': '<f4', 'fortran_order': False, 'shape': (7,)}");
            bytes.resize(12 + length, b' ');
            Header::parse(&bytes)
        };
        assert_eq!(of_length(LONGEST_HEADER).unwrap().data_at, 12 + 65536);
        match of_length(LONGEST_HEADER + 1) {
            Err(Refusal::Malformed(8, problem)) => assert!(problem.contains("at most 65536")),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn objects_and_other_kinds_are_named() {
        for (descr, word) in [
            ("'|O'", "pickle"),
            ("'<c8'", "complex"),
            ("'<U3'", "strings"),
            ("[('x', '<f4')]", "structured"),
            ("'<q9'", "unknown type"),
            ("'<>|=<f4'", "unknown type"),
            ("'<<f4'", "unknown type"),
        ] {
            let text = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (1,), }}");
            match parse(&text) {
                Err(Refusal::WrongKind(found)) => assert!(found.contains(word), "{found}"),
                other => panic!("{descr}: {other:?}"),
            }
        }
    }

    #[test]
    fn anything_else_is_refused_at_its_place() {
        for text in [
            "",
            "{",
            "{}",
            "{'descr': '<f4', 'fortran_order': False}",
            "{'descr': '<f4', 'fortran_order': 0, 'shape': (1,)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (-1,)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999,)}",
            "{'descr': '<f4', 'descr': '<f4', 'fortran_order': False, 'shape': (1,)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (1,), 'x': __import__('os')}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (1,)} and more",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (1,), }}\n",
            "{'descr': '<f4",
        ] {
            let refusal = parse(text).unwrap_err();
            assert!(
                matches!(refusal, Refusal::Malformed(at, _) if at >= 10),
                "{text}: {refusal:?}"
            );
        }
    }
}
