//! The files through which images and answers travel.
//!
//! Answers are read as if an enemy had written them: a regular file, of the size that the answer
//! must have at most, of exactly the right type and shape, without infinite values.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use formats::{FormatError, npy};
use raster::{BoundingBox, DisparityRange, Image, Plane, Reason};

use super::protocol::Job;

/// A header of `.npy` has at most this many bytes here; NumPy writes 128.
const HEADER_LIMIT: u64 = 4096;

/// What an engine is asked.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// The left image.
    pub left: &'a Image,
    /// The right image, of the same size and kind.
    pub right: &'a Image,
    /// The pixels of the left image to answer.
    pub bounds: BoundingBox,
    /// The disparities to search.
    pub range: DisparityRange,
}

/// What an engine answered. All planes have the size of the left image.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Disparity in pixels, NaN where there is none, and outside the box.
    pub disparity: Plane<f32>,
    /// Why each pixel has its value, if the engine says so.
    pub reasons: Option<Plane<Reason>>,
    /// How sure each value is, 0 to 1, if the engine says so.
    pub confidence: Option<Plane<f32>>,
}

/// Writes the images into `scratch`, removes what is left of earlier jobs, and says what to do.
pub fn write_job(
    scratch: &Path,
    number: u64,
    pair: &Pair<'_>,
    threads: usize,
) -> Result<Job, FormatError> {
    let place = |name: &str| scratch.join(name);
    let job = Job {
        job: number,
        left: place("left.npy"),
        right: place("right.npy"),
        columns: pair.left.columns(),
        rows: pair.left.rows(),
        bounds: [pair.bounds.x0, pair.bounds.y0, pair.bounds.x1, pair.bounds.y1],
        min_disparity: pair.range.min(),
        max_disparity: pair.range.max(),
        threads,
        disparity: place("disparity.npy"),
        reasons: place("reasons.npy"),
        confidence: place("confidence.npy"),
    };
    for file in [&job.left, &job.right, &job.disparity, &job.reasons, &job.confidence] {
        remove(file)?;
    }
    write_image(&job.left, pair.left)?;
    write_image(&job.right, pair.right)?;
    Ok(job)
}

/// Removes what an earlier job left at this place, a folder with all that is in it as well: one in
/// an answer's place would keep the engine from every further job. That there is nothing is fine.
pub(super) fn remove(path: &Path) -> Result<(), FormatError> {
    let is_folder = fs::symlink_metadata(path).is_ok_and(|found| found.is_dir());
    let removed = if is_folder { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    match removed {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(FormatError::Write {
            path: path.to_owned(),
            problem: format!("what is left of an earlier job cannot be removed: {error}"),
            os_error: error.raw_os_error(),
            source: Some(error),
        }),
        _ => Ok(()),
    }
}

fn write_image(path: &Path, image: &Image) -> Result<(), FormatError> {
    match image {
        Image::Grey8(plane) => npy::write(path, plane),
        Image::Grey16(plane) => npy::write(path, plane),
        Image::Rgb8(plane) => npy::write(path, plane),
        Image::Rgb16(plane) => npy::write(path, plane),
    }
}

/// Reads the images of a job, on the engine's side.
pub fn read_images(job: &Job) -> Result<(Image, Image), FormatError> {
    Ok((read_image(&job.left)?, read_image(&job.right)?))
}

fn read_image(path: &Path) -> Result<Image, FormatError> {
    let npy::Array { shape, samples } = npy::read(path)?;
    let wrong = |found: String| FormatError::WrongKind {
        path: path.to_owned(),
        found,
        needed:
            "an image is needed: uint8 or uint16 of shape (rows, columns) or (rows, columns, 3)"
                .into(),
    };
    let found = format!("an array of {} with shape {shape:?}", samples.dtype());
    let image = match (&shape[..], samples) {
        (&[rows, columns], npy::Samples::Uint8(samples)) => {
            Plane::new(columns, rows, samples).ok().map(Image::Grey8)
        }
        (&[rows, columns], npy::Samples::Uint16(samples)) => {
            Plane::new(columns, rows, samples).ok().map(Image::Grey16)
        }
        (&[rows, columns, 3], npy::Samples::Uint8(samples)) => {
            Plane::new(columns, rows, samples.as_chunks().0.to_vec()).ok().map(Image::Rgb8)
        }
        (&[rows, columns, 3], npy::Samples::Uint16(samples)) => {
            Plane::new(columns, rows, samples.as_chunks().0.to_vec()).ok().map(Image::Rgb16)
        }
        _ => None,
    };
    image.ok_or_else(|| wrong(found))
}

/// Writes an answer, on the engine's side: the planes of an [`Answer`].
pub fn write_answer(
    job: &Job,
    disparity: &Plane<f32>,
    reasons: Option<&Plane<Reason>>,
    confidence: Option<&Plane<f32>>,
) -> Result<(), FormatError> {
    if let Some(reasons) = reasons {
        npy::write(&job.reasons, &reasons.map(|&reason| reason as u8))?;
    }
    if let Some(confidence) = confidence {
        npy::write(&job.confidence, confidence)?;
    }
    npy::write(&job.disparity, disparity)
}

/// Reads and checks the answer to a job. The error says what is wrong with it, in words for the
/// engine's author.
pub fn read_answer(job: &Job) -> Result<Answer, String> {
    let bounds = job.bounding_box().map_err(|error| error.to_string())?;
    let mut disparity = read_plane::<f32>(job, "disparity", &job.disparity)?
        .ok_or_else(|| format!("it wrote no disparity file ({})", file_name(&job.disparity)))?;
    if let Some((x, y)) = bounds.pixels().find(|&(x, y)| disparity.row(y)[x].is_infinite()) {
        return Err(format!(
            "the disparity at column {x}, row {y} is infinite; give NaN where there is none"
        ));
    }
    let mut reasons = match read_plane::<u8>(job, "reasons", &job.reasons)? {
        Some(bytes) => {
            let unknown = |&(x, y): &(usize, usize)| Reason::from_byte(bytes.row(y)[x]).is_none();
            if let Some((x, y)) = bounds.pixels().find(unknown) {
                let byte = bytes.row(y)[x];
                return Err(format!(
                    "{byte}, at column {x}, row {y}, is no reason; they go from 0 to 7"
                ));
            }
            Some(bytes.map(|&byte| Reason::from_byte(byte).unwrap_or_default()))
        }
        None => None,
    };
    let contradicted = |reasons: &Plane<Reason>| {
        bounds
            .pixels()
            .find(|&(x, y)| reasons.row(y)[x].has_value() == disparity.row(y)[x].is_nan())
    };
    if let Some(plane) = &reasons
        && let Some((x, y)) = contradicted(plane)
    {
        let reason = plane.row(y)[x];
        return Err(format!(
            "the reason at column {x}, row {y} is {} ({}), but the disparity there is {}",
            reason as u8,
            reason.name(),
            disparity.row(y)[x]
        ));
    }
    let mut confidence = read_plane::<f32>(job, "confidence", &job.confidence)?;
    if let Some(plane) = &confidence
        && let Some((x, y)) =
            bounds.pixels().find(|&(x, y)| !(0.0..=1.0).contains(&plane.row(y)[x]))
    {
        let sure = plane.row(y)[x];
        return Err(format!(
            "the confidence at column {x}, row {y} is {sure}; it must be from 0 to 1"
        ));
    }
    // Nobody is to score by what was not asked for: holes are filled from around them.
    disparity.fill_around(bounds, f32::NAN);
    if let Some(reasons) = &mut reasons {
        reasons.fill_around(bounds, Reason::OutsideBox);
    }
    if let Some(confidence) = &mut confidence {
        confidence.fill_around(bounds, 0.0);
    }
    Ok(Answer { disparity, reasons, confidence })
}

/// A file of the answer; `None` when it is not there.
fn read_plane<T: npy::Element>(
    job: &Job,
    what: &str,
    path: &PathBuf,
) -> Result<Option<Plane<T>>, String> {
    let name = file_name(path);
    let cannot = |error| format!("its {what} file cannot be read: {error}");
    let regular = |found: fs::Metadata| match found.is_file() {
        true => Ok(found.len()),
        false => Err(format!("{name} is no regular file (links are not followed)")),
    };
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        found => regular(found.map_err(cannot)?)?,
    };
    // The engine lives on and may put something else in its place: what counts is what was opened.
    let file = open(path).map_err(cannot)?;
    let length = regular(file.metadata().map_err(cannot)?)?;
    let pixels = job.columns as u64 * job.rows as u64;
    let limit = pixels * size_of::<T>() as u64 + HEADER_LIMIT;
    let mut bytes = Vec::new();
    file.take(limit + 1).read_to_end(&mut bytes).map_err(cannot)?;
    // It may have grown meanwhile.
    let length = length.max(bytes.len() as u64);
    if length > limit {
        return Err(format!(
            "{name} has {length} bytes, but the {what} of {} x {} pixels takes at most {limit}: \
             write {} of shape ({}, {})",
            job.columns,
            job.rows,
            T::DTYPE,
            job.rows,
            job.columns
        ));
    }
    let plane = npy::plane_of_bytes::<T>(path, bytes).map_err(|error| error.to_string())?;
    if plane.size() != (job.columns, job.rows) {
        return Err(format!(
            "{name} has the shape ({}, {}), but the left image has ({}, {}): answer the whole \
             image, whatever the box",
            plane.rows(),
            plane.columns(),
            job.rows,
            job.columns
        ));
    }
    Ok(Some(plane))
}

/// Opens a file, not what a link leads to, and waits for nobody who would write into a pipe.
fn open(path: &Path) -> io::Result<fs::File> {
    let mut options = fs::OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
        std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, flags.bits() as i32);
    }
    options.open(path)
}

fn file_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job_in(scratch: &Path) -> Job {
        let image = Image::Grey8(Plane::filled(3, 2, 7));
        let pair = Pair {
            left: &image,
            right: &image,
            bounds: BoundingBox::whole(3, 2),
            range: DisparityRange::new(0, 4).unwrap(),
        };
        write_job(scratch, 1, &pair, 1).unwrap()
    }

    #[test]
    fn images_of_every_kind_arrive_as_they_were() {
        let scratch = tempfile::tempdir().unwrap();
        let images = [
            Image::Grey8(Plane::from_fn(3, 2, |x, y| (x + 10 * y) as u8)),
            Image::Grey16(Plane::from_fn(3, 2, |x, y| (x + 1000 * y) as u16)),
            Image::Rgb8(Plane::from_fn(3, 2, |x, y| [x as u8, y as u8, 9])),
            Image::Rgb16(Plane::from_fn(3, 2, |x, y| [x as u16, y as u16, 999])),
        ];
        for image in images {
            let path = scratch.path().join("image.npy");
            write_image(&path, &image).unwrap();
            assert_eq!(read_image(&path).unwrap(), image);
        }
    }

    #[test]
    fn an_answer_survives_the_files_and_is_gone_for_the_next_job() {
        let scratch = tempfile::tempdir().unwrap();
        let job = job_in(scratch.path());
        let answer = Answer {
            disparity: Plane::new(3, 2, vec![0.0, 1.5, 2.0, 3.0, 4.0, 99.0]).unwrap(),
            reasons: Some(Plane::filled(3, 2, Reason::OccludedFilled)),
            confidence: Some(Plane::filled(3, 2, 0.25)),
        };
        let Answer { disparity, reasons, confidence } = &answer;
        write_answer(&job, disparity, reasons.as_ref(), confidence.as_ref()).unwrap();
        assert_eq!(read_answer(&job).unwrap(), answer);
        let error = read_answer(&job_in(scratch.path())).unwrap_err();
        assert!(error.contains("no disparity file"), "{error}");
    }

    #[test]
    fn every_wrong_answer_is_named() {
        let scratch = tempfile::tempdir().unwrap();
        let job = job_in(scratch.path());
        let refused = |words: &str| {
            let error = read_answer(&job).unwrap_err();
            assert!(error.contains(words), "{error}");
        };
        npy::write(&job.disparity, &Plane::filled(2, 3, 0f32)).unwrap();
        refused("has the shape (3, 2), but the left image has (2, 3)");
        npy::write(&job.disparity, &Plane::filled(3, 2, 0f64)).unwrap();
        refused("float64");
        npy::write(&job.disparity, &Plane::filled(300, 200, 0f32)).unwrap();
        refused("takes at most");
        npy::write(&job.disparity, &Plane::filled(3, 2, f32::INFINITY)).unwrap();
        refused("column 0, row 0 is infinite");
        fs::write(&job.disparity, "garbage").unwrap();
        refused("disparity.npy");
        npy::write(&job.disparity, &Plane::filled(3, 2, 0f32)).unwrap();
        npy::write(&job.confidence, &Plane::filled(3, 2, f32::NAN)).unwrap();
        refused("is NaN; it must be from 0 to 1");
        fs::remove_file(&job.confidence).unwrap();
        npy::write(&job.reasons, &Plane::filled(3, 2, 8u8)).unwrap();
        refused("8, at column 0, row 0, is no reason");
        npy::write(&job.reasons, &Plane::filled(3, 2, Reason::MismatchedHole as u8)).unwrap();
        refused(
            "the reason at column 0, row 0 is 6 (mismatched-hole), but the disparity there is 0",
        );
        npy::write(&job.disparity, &Plane::filled(3, 2, f32::NAN)).unwrap();
        npy::write(&job.reasons, &Plane::filled(3, 2, Reason::Matched as u8)).unwrap();
        refused("is 1 (matched), but the disparity there is NaN");
        fs::remove_file(&job.reasons).unwrap();
        fs::remove_file(&job.disparity).unwrap();
        fs::create_dir(&job.disparity).unwrap();
        refused("no regular file");
    }

    #[test]
    fn what_lies_outside_the_box_is_ignored() {
        let scratch = tempfile::tempdir().unwrap();
        let job = Job { bounds: [1, 0, 1, 1], ..job_in(scratch.path()) };
        let outside =
            |inside, other| Plane::from_fn(3, 2, |x, _| if x == 1 { inside } else { other });
        npy::write(&job.disparity, &outside(2.5, f32::INFINITY)).unwrap();
        npy::write(&job.confidence, &outside(0.5, 7.0)).unwrap();
        let reasons = Plane::from_fn(3, 2, |x, y| if x == 1 { 1u8 } else { [99, 2][y] });
        npy::write(&job.reasons, &reasons).unwrap();
        let answer = read_answer(&job).unwrap();
        let (around, within) = (Reason::OutsideBox, Reason::Matched);
        assert_eq!(answer.reasons.unwrap().samples(), [around, within, around].repeat(2));
        assert_eq!(answer.confidence.unwrap().samples(), [0.0, 0.5, 0.0].repeat(2));
        for row in answer.disparity.samples().chunks(3) {
            assert!(row[0].is_nan() && row[1] == 2.5 && row[2].is_nan(), "{row:?}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_are_not_followed() {
        let scratch = tempfile::tempdir().unwrap();
        let job = job_in(scratch.path());
        let elsewhere = scratch.path().join("elsewhere.npy");
        npy::write(&elsewhere, &Plane::filled(3, 2, 0f32)).unwrap();
        std::os::unix::fs::symlink(&elsewhere, &job.disparity).unwrap();
        assert!(read_answer(&job).unwrap_err().contains("links are not followed"));
        assert!(open(&job.disparity).is_err(), "nor where one comes between two looks");
    }

    #[cfg(unix)]
    #[test]
    fn nobody_waits_at_a_pipe() {
        let scratch = tempfile::tempdir().unwrap();
        let job = job_in(scratch.path());
        nix::unistd::mkfifo(&job.disparity, nix::sys::stat::Mode::S_IRWXU).unwrap();
        assert!(read_answer(&job).unwrap_err().contains("no regular file"));
        assert!(!open(&job.disparity).unwrap().metadata().unwrap().is_file());
    }
}
