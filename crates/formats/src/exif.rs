//! How a picture is to be turned to be looked at, by what its camera noted in EXIF: told, and never done.

use std::io::Cursor;

use exif::{In, Reader, Tag};

/// The orientation in EXIF's numbers, from 2 to 8, of a picture that is to be shown otherwise than its pixels lie; `None`
/// where they lie as they are to be shown, or nothing is said of it. `bytes` are those of a file.
pub fn exif_orientation(bytes: &[u8]) -> Option<u8> {
    let noted = Reader::new().read_from_container(&mut Cursor::new(bytes)).ok()?;
    let orientation = noted.get_field(Tag::Orientation, In::PRIMARY)?.value.get_uint(0)?;
    u8::try_from(orientation).ok().filter(|orientation| (2..=8).contains(orientation))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A JPEG's beginning and end around what EXIF says of its orientation.
    fn noting(orientation: u8) -> Vec<u8> {
        let tiff = [
            *b"II*\0\x08\0\0\0\x01\0",
            // One short number under the tag 0x112.
            [0x12, 0x01, 3, 0, 1, 0, 0, 0, orientation, 0],
            [0; 10],
        ];
        let exif = [&b"Exif\0\0"[..], tiff.as_flattened()].concat();
        let length = (exif.len() as u16 + 2).to_be_bytes();
        [&b"\xff\xd8\xff\xe1"[..], &length, &exif, b"\xff\xd9"].concat()
    }

    #[test]
    fn orientations_are_told_but_for_the_usual_one() {
        assert_eq!(
            [6, 8, 2, 1, 9].map(|number| exif_orientation(&noting(number))),
            [Some(6), Some(8), Some(2), None, None]
        );
        for nothing in [&b""[..], b"\xff\xd8\xff\xd9", b"P5 1 1 255\na"] {
            assert_eq!(exif_orientation(nothing), None);
        }
    }
}
