//! Coloured points as PLY (G. Turk, *The PLY polygon file format*, 1994), which viewers and point cloud
//! libraries read.

use std::io::{self, Write};
use std::path::Path;

use crate::atomic::write_atomically;
use crate::{FormatError, image};

/// A point with the colour that was seen there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// X, Y, Z in metres.
    pub position: [f32; 3],
    /// Red, green, blue.
    pub colour: [u8; 3],
}

/// Writes points as binary little-endian PLY, whole or not at all: `x y z` as float32, `red green blue` as
/// uchar, in the order given. No points make a file of none.
///
/// Errors: [`FormatError::UnknownExtension`] unless the path ends in `.ply`, [`FormatError::Write`].
pub fn write_points(path: impl AsRef<Path>, points: &[Point]) -> Result<(), FormatError> {
    let path = path.as_ref();
    if image::extension(path).as_deref() != Some("ply") {
        return Err(FormatError::UnknownExtension { path: path.to_owned(), known: ".ply" });
    }
    write_atomically(path, |writer| encode(points, writer))
}

fn encode(points: &[Point], writer: &mut dyn Write) -> io::Result<()> {
    write!(
        writer,
        "ply\n\
         format binary_little_endian 1.0\n\
         comment metres; X to the right, Y down, Z forward\n\
         element vertex {}\n\
         property float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         end_header\n",
        points.len()
    )?;
    for Point { position, colour } in points {
        for coordinate in position {
            writer.write_all(&coordinate.to_le_bytes())?;
        }
        writer.write_all(colour)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_and_fifteen_bytes_a_point() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cloud.ply");
        let points = [
            Point { position: [0.5, -1.0, 2.0], colour: [1, 2, 3] },
            Point { position: [0.0, 0.0, 80.0], colour: [255, 0, 9] },
        ];
        write_points(&path, &points).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let end = bytes.windows(11).position(|part| part == b"end_header\n").unwrap() + 11;
        let header = std::str::from_utf8(&bytes[..end]).unwrap();
        assert!(header.starts_with("ply\nformat binary_little_endian 1.0\n"));
        assert!(header.contains("\nelement vertex 2\nproperty float x\n"));
        assert_eq!(bytes.len(), end + 2 * 15);
        assert_eq!(bytes[end..][..4], 0.5f32.to_le_bytes());
        assert_eq!(bytes[end + 15 + 8..], [&80f32.to_le_bytes()[..], &[255, 0, 9]].concat());
    }

    #[test]
    fn another_extension_is_refused() {
        let error = write_points("cloud.pcd", &[]).unwrap_err();
        assert!(matches!(error, FormatError::UnknownExtension { known: ".ply", .. }));
    }
}
