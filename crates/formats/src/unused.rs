//! What the file of a picture holds beside the samples that are read, and is told, and never made use of.

use std::io::Cursor;

use exif::{In, Reader, Tag};

use crate::{jpeg, png};

/// What the file whose `bytes` these are holds that nothing is made of: an orientation noted in EXIF, more pictures than
/// one. A sentence for each.
pub fn unused(bytes: &[u8]) -> Vec<String> {
    let orientation = exif_orientation(bytes).map(|orientation| {
        format!(
            "its EXIF says that it is to be turned for a viewer (orientation {orientation}), which is not done here, but \
             by OpenCV and others: the rows of its pixels must be those along which the cameras stand; store both \
             images the way they were calibrated"
        )
    });
    let others = (jpeg::goes_on(bytes) || png::is_animated(bytes)).then(|| {
        "it holds more than one picture, of which the first one is read: store each in a file of its own".to_owned()
    });
    orientation.into_iter().chain(others).collect()
}

/// The orientation in EXIF's numbers, from 2 to 8, of a picture that is to be shown otherwise than its pixels lie; `None`
/// where they lie as they are to be shown, or nothing is said of it.
fn exif_orientation(bytes: &[u8]) -> Option<u8> {
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

    #[test]
    fn a_second_picture_is_told() {
        let picture = b"\xff\xd8\xff\xe0\0\x04\xff\xd8\xff\xd9".to_vec();
        let told = |bytes: &[u8]| unused(bytes).concat();
        assert_eq!(told(&picture), "");
        // What stands behind a picture is none, unless it begins like one.
        assert_eq!(told(&[&picture[..], b"\0\0\xff\xd8"].concat()), "");
        let both = told(&[&picture[..], b"\0\0", &picture].concat());
        assert!(both.contains("more than one picture"), "{both}");
    }

    #[test]
    fn an_animation_is_told() {
        let chunk = |name: &[u8; 4], data: &[u8]| {
            [&(data.len() as u32).to_be_bytes(), &name[..], data, &[0; 4]].concat()
        };
        let of_frames = |frames: u32| {
            let control = [frames.to_be_bytes(), [0; 4]].concat();
            let chunks = [chunk(b"IHDR", &[0; 13]), chunk(b"acTL", &control), chunk(b"IDAT", &[])];
            [b"\x89PNG\r\n\x1a\n", &chunks.concat()[..]].concat()
        };
        assert_eq!([1, 2].map(|frames| unused(&of_frames(frames)).len()), [0, 1]);
        for end in 8..40 {
            assert!(unused(&of_frames(2)[..end]).is_empty());
        }
    }
}
