//! The files of the stereo community, read strictly and written whole.
//!
//! What a file is, its first bytes decide; the extension decides only what is written. A file that
//! breaks its format's rules, claims more than it holds, or holds something else than is needed is
//! an error that names the file, the value, what is allowed and the remedy. Nothing is repaired,
//! and no memory is taken on the word of a file. What cannot be noticed is damage within the compressed
//! data of a JPEG that still has its end: the format has no checksum.
//!
//! # Pictures: [`read_image`], [`write_image`]
//!
//! | format | extension | pixels | written |
//! | --- | --- | --- | --- |
//! | PNG | `.png` | grey, colour, palette, with or without alpha (dropped); 1 to 16 bit | yes, 8 and 16 bit |
//! | PGM, PPM (P2, P3, P5, P6) | `.pgm`, `.ppm` | grey, colour; maxval 1 to 65535 (scaled to 255 or 65535) | yes, 8 and 16 bit |
//! | JPEG | `.jpg` | grey, colour; baseline and progressive, 8 bit; of several pictures (MPO) the first | no |
//! | TIFF | `.tif`, `.tiff` | grey, colour, with or without alpha (dropped); 8 and 16 bit | no |
//!
//! # Disparity maps: [`read_disparity`], [`write_disparity`]
//!
//! In memory a disparity is `f32` in pixels, `x_right = x_left - d`, and NaN is "no value".
//!
//! | format | [`Encoding`] | sample | no value | written |
//! | --- | --- | --- | --- | --- |
//! | PFM (Middlebury, ETH3D) | `pfm` | float32, bottom row first, byte order by the scale's sign | `INF`, NaN | `.pfm`, `+INF` |
//! | NumPy | `npy` | integers, float16 to float64, `rows x columns` | infinite, NaN | `.npy`, float32, NaN |
//! | KITTI | `png16/256` | uint16 / 256 | 0 | `.png`, 0 |
//! | Middlebury 2003 (Cones, Teddy) | `png8/4` | uint8 / 4 | 0 | no |
//! | Middlebury 2005 and 2006 | `png8/3`, `png8/2`, `png8/1` at third, half, full size | uint8 / 3, / 2, / 1 | 0 | no |
//! | TIFF | `tiff` | float16 to float64 | infinite, NaN | `.tiff`, `.tif`, float32, NaN |
//!
//! Integers do not say their scale, and a map at the wrong scale looks right and scores as almost
//! all wrong: [`ReadDisparity::note`] tells what was assumed.
//!
//! # Depth: [`write_depth`], [`write_points`], [`write_view`]
//!
//! | what | extension | content |
//! | --- | --- | --- |
//! | depth map | `.pfm`, `.npy`, `.tiff` | metres, float32 |
//! | depth map | `.png` | millimetres, 16 bit, 0 where there is none |
//! | points | `.ply` | metres and colours, binary |
//! | points beside the map | `.html` | a page for a browser, complete in itself |
//!
//! # What goes with them
//!
//! | file | reader | content |
//! | --- | --- | --- |
//! | `mask0nocc.png` | [`read_mask`] | 255 = seen by both cameras |
//! | pictures of `hazcam match --reasons` | [`read_reasons`] | why each pixel has its value or none |
//! | `*_bounds.npy` | [`read_bounding_box`] | `[[x0, x1], [y0, y1]]`, inclusive |
//! | calibrations of Middlebury, ETH3D, KITTI, OpenCV, ROS | [`read_calibration`], and [`write_calibration`] as Middlebury has them | a [`camera::StereoCamera`] |
//! | any of them | [`inspect`] | what is in it, in numbers |
//! | `.npy` arrays between processes | [`npy`] | numbers of one stated type and shape |
//!
//! [`picture`] draws maps for people. Everything is written by [`write_atomically`]: a file appears
//! whole or not at all; several do so together by [`write_all_or_none`].
//!
//! ```
//! # fn main() -> Result<(), formats::FormatError> {
//! # let folder = tempfile::tempdir().unwrap();
//! # let path = folder.path().join("teddy.png");
//! use formats::{Encoding, picture, read_disparity, write_disparity};
//! use raster::Plane;
//!
//! let map = Plane::new(3, 1, vec![1.5, f32::NAN, 20.0]).unwrap();
//! write_disparity(&path, &map)?;
//! let read = read_disparity(&path, Encoding::Png16 { divisor: 256.0 })?;
//! assert!(read.values.samples()[1].is_nan());
//! let colours = picture::disparity(&read.values, 0.0, 20.0, picture::ColourMap::Turbo);
//! picture::write_png_rgb(path.with_extension("preview.png"), &colours)?;
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

mod all_or_none;
mod atomic;
mod bounding_box;
mod calibration;
mod depth;
mod disparity;
mod encoding;
mod error;
mod image;
mod inspect;
mod jpeg;
pub mod markup;
mod mask;
mod netpbm;
pub mod npy;
mod numbers;
mod passing;
mod path_text;
mod pfm;
pub mod picture;
mod ply;
mod png;
mod pnm;
mod reasons;
mod source;
mod tiff;
mod unused;
mod view;

pub use all_or_none::{Writer, try_to_write, write_all_or_none};
pub use atomic::{destination, write_atomically};
pub use bounding_box::{parse_bounding_box, read_bounding_box};
pub use calibration::{Calibration, CalibrationLayout, read_calibration, write_calibration};
pub use depth::{MOST_METRES_IN_PNG, write_depth};
pub use disparity::{ReadDisparity, read_disparity, write_disparity};
pub use encoding::Encoding;
pub use error::FormatError;
pub use image::{read_image, read_image_and_bytes, write_image};
pub use inspect::{DisparityReading, FileContent, FileInfo, Statistics, inspect, inspect_bytes};
pub use mask::read_mask;
pub use passing::remove_passing_files;
pub use path_text::path_as_text;
pub use ply::{Point, write_points};
pub use reasons::read_reasons;
pub use source::{Container, MAX_FILE_BYTES, MAX_PIXELS};
pub use unused::unused;
pub use view::{View, write_view};
