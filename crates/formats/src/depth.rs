//! Depth maps out. In memory a depth is in metres along the optical axis and NaN means "no value".

use std::path::Path;

use raster::Plane;

use crate::FormatError;
use crate::numbers::Numbers;

/// The largest depth that a `.png` of millimetres holds, in metres.
pub const MOST_METRES_IN_PNG: f64 = 65.535;

/// How depths stand in files.
const DEPTHS: Numbers = Numbers {
    known: ".pfm, .npy (float32, metres), .png (16 bit, millimetres), .tiff (float32, metres)",
    finite: "a depth is finite, or NaN for no value",
    scale: 1000.0,
    below: 65.5355,
    png: "a 16-bit PNG of millimetres holds 0 to 65.535 m: write .pfm, .npy or .tiff instead, or make NaN \
          of what lies beyond that (`hazcam depth --max-depth 65`)",
};

/// Writes a depth map, its format by extension, whole or not at all.
///
/// | extension | what is written | no value |
/// | --- | --- | --- |
/// | `.pfm` | metres, little-endian float32, bottom-up | `+INF` |
/// | `.npy` | metres, float32, `rows x columns` | NaN |
/// | `.png` | 16-bit grey, millimetres (as ROS REP 118 has it) | 0 |
/// | `.tiff`, `.tif` | metres, float32 | NaN |
///
/// In a `.png` a depth below half a millimetre would round to 0 and so vanish; it is stored as 1.
///
/// Errors: as [`write_disparity`](crate::write_disparity), for depths in a `.png` that would not round into
/// `[0, 65.535]` m.
pub fn write_depth(path: impl AsRef<Path>, metres: &Plane<f32>) -> Result<(), FormatError> {
    DEPTHS.write(path.as_ref(), metres)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Encoding, read_disparity, read_image};
    use raster::Image;

    #[test]
    fn metres_stay_metres_and_become_millimetres_in_a_png() {
        let folder = tempfile::tempdir().unwrap();
        let depth = Plane::new(4, 1, vec![0.0001, f32::NAN, 1.2344, 65.535]).unwrap();
        for name in ["depth.pfm", "depth.npy", "depth.tiff"] {
            let path = folder.path().join(name);
            write_depth(&path, &depth).unwrap();
            let read = read_disparity(&path, Encoding::Auto).unwrap().values;
            let same = |(a, b): (&f32, &f32)| a == b || (a.is_nan() && b.is_nan());
            assert!(read.samples().iter().zip(depth.samples()).all(same), "{name}");
        }
        let path = folder.path().join("depth.png");
        write_depth(&path, &depth).unwrap();
        let expected = Plane::new(4, 1, vec![1u16, 0, 1234, 65535]).unwrap();
        assert_eq!(read_image(&path).unwrap(), Image::Grey16(expected));
    }

    #[test]
    fn what_does_not_fit_is_an_error_that_names_the_pixel() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("depth.png");
        let far = Plane::new(2, 1, vec![1.0, 65.536]).unwrap();
        let error = write_depth(&path, &far).unwrap_err().to_string();
        assert!(error.contains("column 1, row 0") && error.contains("65.535 m"), "{error}");
        let error = write_depth(folder.path().join("d.pfm"), &far.map(|_| f32::INFINITY));
        assert!(error.unwrap_err().to_string().contains("a depth is finite"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
