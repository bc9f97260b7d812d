//! Calibration files of rectified pairs: Middlebury and ETH3D, KITTI, OpenCV, ROS, and the rendered lunar set.
//!
//! | layout | camera | baseline | right camera |
//! | --- | --- | --- | --- |
//! | Middlebury, ETH3D `calib.txt` | `cam0=[f 0 cx; 0 f cy; 0 0 1]` | `baseline`, millimetres | `doffs = cx1 - cx0` |
//! | KITTI | `P0`..`P3` or `P_rect_00`..`P_rect_03`, 3 x 4 | `(P_left[0][3] - P_right[0][3]) / f`, metres | `doffs = P_right[0][2] - P_left[0][2]` |
//! | OpenCV's YAML, JSON or XML, or lists of its numbers | `P1` and `P2` of `stereoRectify`, 3 x 4 | `-P2[0][3] / f`, in the unit of its board, taken as metres | `doffs = P2[0][2] - P1[0][2]` |
//! | the same without one of these | `Q` of `stereoRectify`, 4 x 4 | `1 / Q[3][2]`, in that unit | `doffs = Q[3][3] / Q[3][2]` |
//! | ROS's YAML of the right camera | `projection_matrix`, 3 x 4; `P` or `p` of a `CameraInfo` that was printed | `-P[0][3] / f`, metres | as the left one, `doffs = 0` |
//! | lunar | `f`, `cx0`, `cy` | `baseline_m`, metres | `doffs` |
//!
//! `width`, `height`, `ndisp`, `isint`, `vmin` and `vmax` are read from the first layout and the last.

mod kitti;
mod matrix;
mod middlebury;
mod opencv;
mod ros;
mod xml;
mod yaml;

use std::ffi::OsStr;
use std::path::Path;

use camera::StereoCamera;
use raster::{DisparityRange, Image};

use crate::FormatError;
use crate::atomic::{in_its_folder, write_atomically};
use crate::source::{Container, LONGEST_TEXT, Source};

/// What a calibration file says.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Calibration {
    /// How the file is laid out.
    pub layout: CalibrationLayout,
    /// The pair. For KITTI the grey one (cameras 0 and 1) where the file has it, else the colour
    /// one; see [`Calibration::camera_of`].
    pub camera: StereoCamera,
    /// KITTI's colour pair (cameras 2 and 3), whose baseline differs by some millimetres.
    pub colour_camera: Option<StereoCamera>,
    /// Columns of the images.
    pub width: Option<usize>,
    /// Rows of the images.
    pub height: Option<usize>,
    /// A bound on the number of disparities: they lie within `0..=ndisp - 1`.
    pub ndisp: Option<usize>,
    /// Whether the truth has whole disparities only.
    pub isint: Option<bool>,
    /// A tight bound on the smallest disparity, meant for display.
    pub vmin: Option<f64>,
    /// A tight bound on the largest disparity, meant for display.
    pub vmax: Option<f64>,
}

/// How a calibration file is laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum CalibrationLayout {
    /// Middlebury 2014, MiddEval3 and ETH3D.
    Middlebury,
    /// KITTI 2012, 2015 and raw.
    Kitti,
    /// `P1` and `P2`, or `Q`, in a file of OpenCV's. It does not say in which unit the baseline is: that of the
    /// squares that the cameras were calibrated with. It is taken as metres.
    OpenCv,
    /// `projection_matrix` in the YAML file of a pair's right camera, as ROS keeps it, or its `CameraInfo` as it is
    /// printed. It does not tell of the left camera: that it has its principal point in the same column is assumed.
    Ros,
    /// `f`, `cx0`, `cx1`, `cy`, `doffs`, `baseline_m`.
    Lunar,
}

impl Calibration {
    /// With columns and rows of images, where a file states them.
    fn sized(self, [width, height]: [Option<usize>; 2]) -> Self {
        Self { width, height, ..self }
    }

    /// A camera, and nothing else.
    fn of(layout: CalibrationLayout, camera: StereoCamera) -> Self {
        Self {
            layout,
            camera,
            colour_camera: None,
            width: None,
            height: None,
            ndisp: None,
            isint: None,
            vmin: None,
            vmax: None,
        }
    }

    /// The camera of a left image, by the folder it lies in: KITTI's `image_2` and `colored_0`, and
    /// `image_02` with the folder `data` that raw recordings have in it, belong to the colour pair, and so does a
    /// coloured picture in a folder of another name, which is read to see that; everything else, what cannot be read
    /// included, to [`Calibration::camera`]. Where the file lacks the pair that the image belongs to, the camera is of the
    /// other one, and a sentence says so.
    pub fn camera_of(&self, left: impl AsRef<Path>) -> (StereoCamera, Option<String>) {
        let left = left.as_ref();
        if self.layout != CalibrationLayout::Kitti {
            return (self.camera, None);
        }
        let is_colour = is_colour(left);
        let lacking = match is_colour {
            Some(true) if self.colour_camera.is_none() => Some(["P2", "P3"]),
            Some(false) if self.colour_camera == Some(self.camera) => Some(["P0", "P1"]),
            _ => None,
        };
        let doubt = lacking.map(|[one, other]| {
            format!(
                "{one} and {other}, of the pair that {} belongs to by its folder or its colours, are not both there: \
                 the cameras of the other pair were taken, whose baseline differs by about a per cent",
                left.display()
            )
        });
        let colour = self.colour_camera.filter(|_| is_colour == Some(true));
        (colour.unwrap_or(self.camera), doubt)
    }
}

/// Whether a left image of KITTI's belongs to the colour pair or to the grey one, where its folder tells, or else
/// whether it has colours.
fn is_colour(left: &Path) -> Option<bool> {
    is_colour_by_folder(left).or_else(|| {
        let image = crate::read_image(left).ok()?;
        matches!(image, Image::Rgb8(_) | Image::Rgb16(_)).then_some(true)
    })
}

fn is_colour_by_folder(left: &Path) -> Option<bool> {
    // A name from the folder itself does not have it; the file may be a link from elsewhere, or not be there.
    let placed = in_its_folder(left);
    let left = placed.as_deref().unwrap_or(left);
    let folder = left.parent().map(|parent| match parent.file_name() {
        Some(name) if name == "data" => parent.parent().unwrap_or(parent),
        _ => parent,
    });
    match folder?.file_name().and_then(OsStr::to_str)? {
        "image_2" | "image_02" | "colored_0" => Some(true),
        "image_0" | "image_00" => Some(false),
        _ => None,
    }
}

/// By so much of themselves focal lengths are rounded at the most.
const ROUNDED: f64 = 1e-3;

/// Zeros and ones of matrices may be off by so much: they were computed.
const EXACT: f64 = 1e-6;

/// Principal points of a rectified pair may differ by so many rows: files are rounded.
const SAME_ROW: f64 = 0.5;

/// Reads a calibration file; which layout it has is decided by its content.
///
/// Errors: [`FormatError::WrongKind`] when it is no text, has none of the layouts, or lacks something that a pair
/// needs, [`FormatError::Malformed`] with the line's offset when a number is not usable.
pub fn read_calibration(path: impl AsRef<Path>) -> Result<Calibration, FormatError> {
    parse(&Source::open(path.as_ref())?)
}

/// Writes the calibration of images of this size (columns, rows) in Middlebury's layout, whole or not at all. Of the
/// range only the largest disparity can be told, and not if it is negative: `ndisp` then is 1.
///
/// Errors: [`FormatError::Write`], also for images without pixels.
pub fn write_calibration(
    path: impl AsRef<Path>,
    camera: &StereoCamera,
    size: (usize, usize),
    range: DisparityRange,
) -> Result<(), FormatError> {
    if size.0 == 0 || size.1 == 0 {
        let images = format!("images of {} x {} have", size.0, size.1);
        return Err(FormatError::no_pixels(path.as_ref(), &images));
    }
    let text = middlebury::text(camera, size, range);
    write_atomically(path, |writer| writer.write_all(text.as_bytes()))
}

/// What a file that is no calibration would have to be.
const NEEDED: &str = "a calibration needs cam0=[f 0 cx; ...] (Middlebury, ETH3D), P0: to P3: or \
                      P_rect_02: and P_rect_03: (KITTI), P1 and P2 or Q in a .yml, .json or .xml of OpenCV's, the \
                      projection_matrix of ROS's right camera, or f=, cx0=, cx1=, cy= and baseline_m=; or \
                      give the focal length in pixels and the baseline in metres";

/// Whether an error of [`parse`] says no more than that a file is no calibration.
pub(crate) fn is_none(error: &FormatError) -> bool {
    matches!(error, FormatError::WrongKind { needed, .. } if needed == NEEDED)
}

/// The calibration in a file's text.
pub(crate) fn parse(source: &Source) -> Result<Calibration, FormatError> {
    let text = match std::str::from_utf8(&source.bytes) {
        Ok(text) if text.len() as u64 <= LONGEST_TEXT => text,
        Ok(_) => return Err(source.wrong_kind("no short text", NEEDED)),
        Err(_) => {
            let found = match Container::of(&source.bytes) {
                Some(format) => format!("a {} file", format.name()),
                None => source.describe().to_owned(),
            };
            return Err(source.wrong_kind(found, NEEDED));
        }
    };
    // Some editors begin a text with a mark that is none of its letters.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let entries = Entries::of(source, text);
    if opencv::is_opencv(&entries, text) {
        return opencv::parse(&entries, text);
    }
    if entries.has("T_cn_cnm1") || (entries.has("intrinsics") && entries.has("camera_model")) {
        return Err(source.wrong_kind(
            "Kalibr's calibration of cameras that are not rectified yet",
            "rectified ones are needed: rectify the images first (OpenCV: stereoRectify, \
             initUndistortRectifyMap, remap), then give the P1 and P2 of stereoRectify, or the focal \
             length in pixels and the baseline in metres",
        ));
    }
    if entries.has("cam0") {
        middlebury::parse(&entries)
    } else if entries.has("baseline_m") {
        middlebury::parse_lunar(&entries)
    } else if ros::is_file(&entries) || ros::is_message(&entries) {
        ros::parse(&entries, text)
    } else if kitti::is_kitti(&entries) {
        kitti::parse(&entries)
    } else {
        Err(source.wrong_kind("a text without a camera", NEEDED))
    }
}

/// The lines of a file as key and value, split at the first `=` or `:`.
struct Entries<'a> {
    source: &'a Source,
    entries: Vec<Entry<'a>>,
}

struct Entry<'a> {
    key: &'a str,
    value: &'a str,
    /// Where the line begins.
    at: u64,
}

impl<'a> Entries<'a> {
    fn of(source: &'a Source, text: &'a str) -> Self {
        let mut at = (source.bytes.len() - text.len()) as u64;
        let mut entries = Vec::new();
        for line in text.split_inclusive('\n') {
            if let Some((key, value)) = line.split_once(['=', ':']) {
                entries.push(Entry { key: key.trim(), value: value.trim(), at });
            }
            at += line.len() as u64;
        }
        Self { source, entries }
    }

    fn has(&self, key: &str) -> bool {
        self.entries.iter().any(|entry| entry.key == key)
    }

    /// What all lines of this key say.
    fn values(&self, key: &str) -> impl Iterator<Item = &str> {
        self.entries.iter().filter(move |entry| entry.key == key).map(|entry| entry.value)
    }

    /// The one entry with this key, or `None`; two of them are an error.
    fn find(&self, key: &str) -> Result<Option<&Entry<'a>>, FormatError> {
        let mut found = self.entries.iter().filter(|entry| entry.key == key);
        let first = found.next();
        match found.next() {
            None => Ok(first),
            Some(second) => Err(self.fail(second.at, format!("`{key}` is there twice"))),
        }
    }

    fn need(&self, key: &str) -> Result<&Entry<'a>, FormatError> {
        self.find(key)?.ok_or_else(|| {
            let remedy = match key {
                "baseline" => ": give the distance between the cameras in millimetres",
                "baseline_m" => ": give the distance between the cameras in metres",
                _ => "",
            };
            self.lacks(format!("`{key}` is missing{remedy}"))
        })
    }

    /// A value that may be missing, but not be anything else than a `T`.
    fn optional<T: std::str::FromStr>(
        &self,
        key: &str,
        what: &str,
    ) -> Result<Option<T>, FormatError> {
        let Some(entry) = self.find(key)? else { return Ok(None) };
        let value = entry.value.parse().map_err(|_| {
            self.fail(entry.at, format!("`{key}` is `{}`, but must be {what}", entry.value))
        })?;
        Ok(Some(value))
    }

    /// A number that must be there.
    fn number(&self, key: &str) -> Result<f64, FormatError> {
        self.need(key)?;
        Ok(self.optional(key, "a number")?.expect("it is there"))
    }

    /// Columns and rows of images, each under its name, where they are stated.
    fn size(
        &self,
        names: [&str; 2],
        stated: [Option<f64>; 2],
    ) -> Result<[Option<usize>; 2], FormatError> {
        let mut size = [None; 2];
        for (size, (name, stated)) in size.iter_mut().zip(names.into_iter().zip(stated)) {
            let Some(number) = stated else { continue };
            if !((1.0..1e9).contains(&number) && number.fract() == 0.0) {
                let problem = format!(
                    "`{name}` is {number}, but must be a whole number of pixels, 1 or more"
                );
                return Err(self.fail(None, problem));
            }
            *size = Some(number as usize);
        }
        Ok(size)
    }

    /// Exactly `N` numbers; brackets, commas and semicolons between them do not matter.
    fn numbers<const N: usize>(&self, key: &str) -> Result<[f64; N], FormatError> {
        let entry = self.need(key)?;
        let words = entry.value.split(|c: char| c.is_whitespace() || "[];,".contains(c));
        let numbers: Option<Vec<f64>> =
            words.filter(|word| !word.is_empty()).map(|word| word.parse().ok()).collect();
        numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| {
            self.fail(entry.at, format!("`{key}` is `{}`, but must be {N} numbers", entry.value))
        })
    }

    /// Errors where a camera's focal lengths, across and down, differ by more than rounding: points would be too high
    /// or too low.
    fn square(&self, name: &str, [across, down]: [f64; 2]) -> Result<(), FormatError> {
        if (across - down).abs() <= ROUNDED * across.abs() {
            return Ok(());
        }
        let problem = format!(
            "{name} has the focal lengths {across} across and {down} down: only square pixels are known here"
        );
        Err(self.fail(None, problem))
    }

    /// Errors unless a matrix has in a row and a column what that of a rectified pair has there.
    fn holds(
        &self,
        name: &str,
        (row, column): (usize, usize),
        number: f64,
        expected: f64,
    ) -> Result<(), FormatError> {
        // Not where it is no number.
        if (number - expected).abs() <= EXACT {
            return Ok(());
        }
        let problem = format!(
            "{name} has {number} in row {}, column {}: the camera of a rectified pair has {expected} there",
            row + 1,
            column + 1
        );
        Err(self.fail(None, problem))
    }

    /// Errors unless two matrices of three rows, which begin as `[f 0 cx; 0 f cy; ..]` does, are those of a rectified
    /// pair: of one focal length, with things in the same rows of both images.
    fn rectified<const N: usize>(
        &self,
        names: [&str; 2],
        matrices: &[[f64; N]; 2],
    ) -> Result<(), FormatError> {
        let of_both = |at: usize| matrices.each_ref().map(|matrix| matrix[at]);
        let (second_row, third_row) = (N / 3, 2 * (N / 3));
        let [name, other] = names;
        let fixed = [
            (1, 0.0),
            (second_row, 0.0),
            (third_row, 0.0),
            (third_row + 1, 0.0),
            (third_row + 2, 1.0),
        ];
        for (at, expected) in fixed {
            for (name, number) in names.into_iter().zip(of_both(at)) {
                let place = (at / second_row, at % second_row);
                self.holds(name, place, number, expected)?;
            }
        }
        let [focal, of_other] = of_both(0);
        for (name, focal) in names.into_iter().zip([focal, of_other]) {
            if !(focal.is_finite() && focal > 0.0) {
                let problem = format!(
                    "{name} has the focal length {focal}, but it must be a finite number of pixels above 0"
                );
                return Err(self.fail(None, problem));
            }
        }
        if focal != of_other {
            let problem = format!(
                "{name} and {other} have the focal lengths {focal} and {of_other}: a rectified pair \
                 has one"
            );
            return Err(self.fail(None, problem));
        }
        for (name, down) in names.into_iter().zip(of_both(second_row + 1)) {
            self.square(name, [focal, down])?;
        }
        let [row, of_other] = of_both(second_row + 2);
        let is_one = (row - of_other).abs() <= SAME_ROW;
        if !is_one {
            let problem = format!(
                "{name} and {other} have their principal points in the rows {row} and {of_other}: a \
                 rectified pair has them in one"
            );
            return Err(self.fail(None, problem));
        }
        Ok(())
    }

    /// The pair of two projections `[f 0 cx -f b; 0 f cy 0; 0 0 1 0]`, where `b` is the camera's place to the right.
    fn projected(
        &self,
        names: [&str; 2],
        matrices: &[[f64; 12]; 2],
    ) -> Result<StereoCamera, FormatError> {
        self.rectified(names, matrices)?;
        let [left, right] = matrices;
        let baseline = (left[3] - right[3]) / left[0];
        self.camera(left[0], baseline, right[2] - left[2], left[2], left[6])
    }

    fn camera(
        &self,
        focal_px: f64,
        baseline_m: f64,
        doffs: f64,
        cx: f64,
        cy: f64,
    ) -> Result<StereoCamera, FormatError> {
        StereoCamera::new(focal_px, baseline_m, doffs, cx, cy).map_err(|error| {
            let exchanged = focal_px > 0.0 && baseline_m < 0.0;
            let remedy =
                if exchanged { ": are the left and the right camera exchanged?" } else { "" };
            self.fail(None, format!("{error}{remedy}"))
        })
    }

    /// What is said of a calibration that is sound, but does not tell of a pair.
    fn lacks(&self, needed: String) -> FormatError {
        self.source.wrong_kind("a calibration", needed)
    }

    fn fail(&self, at: impl Into<Option<u64>>, problem: String) -> FormatError {
        self.source.malformed("calibration", at, problem)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn read(text: &str) -> Result<Calibration, String> {
        parse(&Source::of("calib.txt", text.as_bytes())).map_err(|e| e.to_string())
    }

    /// Each change of a text, from one part to another, ends in an error with these words.
    pub(super) fn refused(text: &str, changes: &[(&str, &str, &str)]) {
        for (from, to, words) in changes {
            assert!(text.contains(from), "{from}");
            let error = read(&text.replace(from, to)).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }

    #[test]
    fn kalibr_has_no_rectified_cameras() {
        let one = "cam0:\n  camera_model: pinhole\n  intrinsics: [700, 700, 320, 240]\n";
        assert!(read(one).unwrap_err().contains("rectify the images first"));
        let text = "cam0:\n  intrinsics: [700, 700, 320, 240]\ncam1:\n  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.1]\n";
        assert!(read(text).unwrap_err().contains("rectify the images first"));
    }

    #[test]
    fn what_was_rounded_is_believed_to_its_bound_and_no_further() {
        let text = "cam0=[1000 0 320; 0 1000 240; 0 0 1]\ncam1=[1000 0 330; 0 1000 240; 0 0 1]\n\
                    doffs=10\nbaseline=100\n";
        for (from, within, beyond, words) in [
            ("doffs=10", "doffs=10.099", "doffs=10.101", "`doffs` is 10.101"),
            ("doffs=10", "doffs=9.901", "doffs=9.899", "`doffs` is 9.899"),
            ("320; 0 1000", "320; 0 1000.9", "320; 0 1001.1", "only square pixels"),
            ("320; 0 1000", "320; 0 999.1", "320; 0 998.9", "only square pixels"),
            ("1000 0 330", "1000 9e-7 330", "1000 1.1e-6 330", "cam1 has 0.0000011 in row 1"),
            ("0 0 1]\nd", "0 0 0.9999991]\nd", "0 0 0.9999989]\nd", "cam1 has 0.9999989 in row 3"),
            ("240; 0 0 1]\nd", "240.49; 0 0 1]\nd", "240.51; 0 0 1]\nd", "principal points"),
            ("240; 0 0 1]\nd", "239.51; 0 0 1]\nd", "239.49; 0 0 1]\nd", "principal points"),
        ] {
            let read_with = read(&text.replace(from, within));
            assert!(read_with.is_ok(), "{within}: {read_with:?}");
            refused(text, &[(from, beyond, words)]);
        }
    }

    #[test]
    fn images_without_pixels_have_no_calibration() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("calib.txt");
        let camera = StereoCamera::new(700.0, 0.1, 0.0, 320.0, 240.0).unwrap();
        let range = DisparityRange::new(0, 63).unwrap();
        for size in [(0, 480), (640, 0)] {
            let error = write_calibration(&path, &camera, size, range).unwrap_err().to_string();
            let images = format!("images of {} x {} have", size.0, size.1);
            assert!(error.contains(&images) && !path.exists(), "{error}");
        }
        write_calibration(&path, &camera, (1, 1), range).unwrap();
        assert_eq!(read_calibration(&path).unwrap().width, Some(1));
    }

    #[test]
    fn what_is_no_calibration_is_refused() {
        for text in ["", "hello", "a=1\nb=2\n", "P7: 1 2 3\n"] {
            assert!(read(text).unwrap_err().contains("without a camera"), "{text}");
        }
        for (bytes, found) in [
            (&b"\xff\xfef\0=\0"[..], "is text in UTF-16 (save it as UTF-8)"),
            (b"\x89PNG\r\n\x1a\n", "is a PNG file"),
            (&[b'a'; LONGEST_TEXT as usize + 1], "is no short text"),
        ] {
            let error = parse(&Source::of("calib.txt", bytes)).unwrap_err().to_string();
            assert!(error.contains(found), "{error}");
        }
    }
}
