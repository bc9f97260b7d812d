//! From files to planes: truth, masks, box and range, checked against each other.

use std::path::Path;

use formats::{read_bounding_box, read_calibration, read_disparity, read_image, read_mask};
use raster::{BoundingBox, DisparityRange, Image, Plane};
use score::masks::{SAME_SURFACE, non_occluded};

use super::case::{CaseData, CaseRegion, Files, TruthFile};
use super::error::DatasetError;

/// What the protocol says where nothing else tells the range.
pub const RANGE_BY_TRUTH: &str =
    "range by the largest true disparity, and the smallest where many are below 0";
/// What a protocol says of a range that nothing states.
pub const RANGE_BY_WIDTH: &str = "range: a quarter of the width";
/// What the protocol calls it.
const TRUTH_RIGHT: &str = "truth of the right view";

/// What a protocol says of the truth that nobody is asked for, behind how much of it that is.
pub const BEYOND_THE_RANGE: &str =
    "of the truth lies more than a pixel outside the disparities that are searched";
/// It is said of so much of the truth, which may be wrong here and there.
const WORTH_TELLING: f64 = 0.01;

/// Opens the files of a scene. `range` is what the data set states, if it does.
pub(super) fn files(
    files: &Files,
    range: Option<DisparityRange>,
) -> Result<CaseData, DatasetError> {
    let left = read_image(&files.left)?;
    let right = read_image(&files.right)?;
    let size = left.size();
    check_size(&files.right, right.size(), size)?;
    let [left_kind, kind] = [&left, &right].map(Image::kind);
    if kind != left_kind {
        return Err(DatasetError::KindsDiffer { path: files.right.clone(), kind, left_kind });
    }
    let mut protocol = Vec::new();

    let truth = match &files.truth {
        Some(file) => Some(read_truth(file, size, "truth", &mut protocol)?),
        None => None,
    };
    let regions = match &truth {
        Some(truth) => regions(files, truth, size, &mut protocol)?,
        None => Vec::new(),
    };
    let bounds = match &files.bounds {
        Some(path) => {
            let bounds = read_bounding_box(path)?;
            let within = bounds.check_within(size.0, size.1);
            within.map_err(|source| DatasetError::Box { path: path.clone(), source })?;
            protocol.push(format!("box {bounds} (inclusive), {}", name(path)));
            bounds
        }
        None => {
            protocol.push("whole image, the left strip included".into());
            BoundingBox::whole(size.0, size.1)
        }
    };
    if let (Some(file), Some(truth)) = (&files.truth, &truth) {
        let mut rows = (bounds.y0..=bounds.y1).map(|y| &truth.row(y)[bounds.x0..=bounds.x1]);
        if rows.all(|row| row.iter().all(|value| !value.is_finite())) {
            return Err(DatasetError::NothingKnown { path: file.path.clone(), bounds });
        }
    }
    let range = match range {
        Some(range) => range,
        None => assumed_range(files, truth.as_ref(), size, &mut protocol)?,
    };
    if let Some(truth) = &truth {
        protocol.extend(beyond(truth, bounds, range));
    }
    // Of files nothing asks for more than disparities: their calibrations are not looked for.
    Ok(CaseData { bounds, truth, regions, protocol, ..CaseData::new(left, right, range) })
}

/// Says how much of the truth no matcher can find, if that is much.
fn beyond(truth: &Plane<f32>, bounds: BoundingBox, range: DisparityRange) -> Option<String> {
    let (min, max) = (range.min() as f32 - 1.0, range.max() as f32 + 1.0);
    let rows = (bounds.y0..=bounds.y1).map(|y| &truth.row(y)[bounds.x0..=bounds.x1]);
    let known = rows.flatten().copied().filter(|value| value.is_finite());
    let share = score::share_outside(known, min..=max);
    (share > WORTH_TELLING).then(|| {
        let (share, min, max) = (100.0 * share, range.min(), range.max());
        format!("{share:.1} % {BEYOND_THE_RANGE}, {min} to {max}")
    })
}

/// The file with its folder, which in some data sets alone says what it holds.
fn name(path: &Path) -> String {
    let parts: Vec<_> = path.iter().collect();
    let last: Vec<_> =
        parts.iter().rev().take(2).rev().map(|part| part.to_string_lossy()).collect();
    last.join("/")
}

fn check_size(
    path: &Path,
    (columns, rows): (usize, usize),
    (left_columns, left_rows): (usize, usize),
) -> Result<(), DatasetError> {
    if (columns, rows) == (left_columns, left_rows) {
        return Ok(());
    }
    let path = path.to_owned();
    Err(DatasetError::SizesDiffer { path, columns, rows, left_columns, left_rows })
}

/// The truth of a right image of so many columns and rows.
pub(super) fn truth_right(
    file: &TruthFile,
    size: (usize, usize),
) -> Result<Plane<f32>, DatasetError> {
    read_truth(file, size, TRUTH_RIGHT, &mut Vec::new())
}

fn read_truth(
    file: &TruthFile,
    size: (usize, usize),
    what: &str,
    protocol: &mut Vec<String>,
) -> Result<Plane<f32>, DatasetError> {
    let truth = read_disparity(&file.path, file.encoding)?;
    check_size(&file.path, truth.values.size(), size)?;
    protocol.push(format!("{what} {} ({})", name(&file.path), truth.encoding));
    protocol.extend(truth.note);
    if !file.zero_is_none {
        return Ok(truth.values);
    }
    Ok(truth.values.map(|&value| if value == 0.0 { f32::NAN } else { value }))
}

/// The pixels that both cameras see, and the others, from whatever the data set tells about them.
fn regions(
    files: &Files,
    truth: &Plane<f32>,
    size: (usize, usize),
    protocol: &mut Vec<String>,
) -> Result<Vec<CaseRegion>, DatasetError> {
    let known = |plane: &Plane<f32>| plane.map(|value| value.is_finite());
    let (mask, own_truth) = if let Some(file) = &files.truth_noc {
        if files.truth.as_ref().is_some_and(|truth| truth.path == file.path) {
            protocol.push("the truth holds non-occluded pixels only".into());
            let mask = known(truth);
            return Ok(vec![CaseRegion { name: "non-occluded", mask, truth: None }]);
        }
        let truth_noc = read_truth(file, size, "non-occluded truth", protocol)?;
        (known(&truth_noc), Some(truth_noc))
    } else if let Some(path) = &files.mask_nocc {
        let mask = read_mask(path)?;
        check_size(path, mask.size(), size)?;
        protocol.push(format!("non-occluded where {} is 255", name(path)));
        (mask, None)
    } else if let Some(file) = &files.truth_right {
        let right = read_truth(file, size, TRUTH_RIGHT, protocol)?;
        protocol.push(format!(
            "non-occluded where the truths of both views agree within {SAME_SURFACE} px"
        ));
        (non_occluded(truth, &right, SAME_SURFACE), None)
    } else {
        return Ok(Vec::new());
    };
    let occluded =
        Plane::from_fn(size.0, size.1, |x, y| truth.row(y)[x].is_finite() && !mask.row(y)[x]);
    Ok(vec![
        CaseRegion { name: "non-occluded", mask, truth: own_truth },
        CaseRegion { name: "occluded", mask: occluded, truth: None },
    ])
}

/// A range for a scene whose data set states none: by its calibration, else by its truth, else a
/// quarter of the width.
fn assumed_range(
    files: &Files,
    truth: Option<&Plane<f32>>,
    size: (usize, usize),
    protocol: &mut Vec<String>,
) -> Result<DisparityRange, DatasetError> {
    let columns = size.0;
    if let Some(path) = &files.calibration {
        match read_calibration(path) {
            Ok(calibration) => {
                // Some data sets put the image's width here, which says nothing.
                if let Some(count @ 1..) = calibration.ndisp.filter(|&count| count < columns) {
                    if let Some(stated) = calibration.width.zip(calibration.height)
                        && stated != size
                    {
                        let path = path.clone();
                        return Err(DatasetError::OfOtherImages { path, stated, size });
                    }
                    protocol.push(format!("range by ndisp in {}", name(path)));
                    return Ok(DisparityRange::new(0, count as i32 - 1)?);
                }
            }
            Err(error) => return Err(error.into()),
        }
    }
    let ends = truth.map(|truth| {
        let known = truth.samples().iter().copied().filter(|value| value.is_finite());
        let (least, most) =
            known.clone().fold((0f32, 0f32), |(least, most), d| (least.min(d), most.max(d)));
        // A few that are wrong make no range that many programs do not know.
        let below = known.clone().filter(|&d| d < 0.0).count() as f64;
        let is_signed = below > WORTH_TELLING * known.count() as f64;
        // Beyond the width nothing has a match.
        let farthest = columns as f32 - 1.0;
        (if is_signed { least.max(-farthest) } else { 0.0 }, most.min(farthest))
    });
    let (least, most) = match ends {
        Some((least, most)) => {
            protocol.push(RANGE_BY_TRUTH.into());
            (least.floor() as i32, most.ceil() as i32)
        }
        None => {
            protocol.push(RANGE_BY_WIDTH.into());
            (0, (columns / 4) as i32)
        }
    };
    Ok(DisparityRange::new(least, most.max(1))?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_beyond_the_range_is_told_where_it_is_much() {
        let range = DisparityRange::new(0, 9).unwrap();
        let told = |beyond_it: usize, values: [f32; 2]| {
            let truth = Plane::from_fn(100, 3, |x, y| match () {
                () if y != 1 => 99.0,
                () if x < beyond_it => values[0],
                () if x < 50 => values[1],
                () => f32::NAN,
            });
            beyond(&truth, BoundingBox::new(0, 1, 99, 1).unwrap(), range)
        };
        let note = told(5, [30.0, 4.0]).unwrap();
        assert!(note.starts_with("10.0 %") && note.ends_with("0 to 9"), "{note}");
        assert!(told(5, [-2.5, 4.0]).is_some());
        // A pixel more or less is searched by nearly all, and one of a hundred is nothing.
        assert_eq!(told(5, [10.0, -1.0]), None);
        assert_eq!(told(0, [30.0, 4.0]), None);
    }

    #[test]
    fn a_range_by_truth_ends_where_the_image_does() {
        let truth = Plane::from_fn(100, 2, |x, _| if x == 3 { 1e30 } else { 7.5 });
        let mut protocol = Vec::new();
        let range = assumed_range(&Files::default(), Some(&truth), (100, 2), &mut protocol);
        assert_eq!(range.unwrap(), DisparityRange::new(0, 99).unwrap());
        let truth = truth.map(|&d| -d);
        let range = assumed_range(&Files::default(), Some(&truth), (100, 2), &mut protocol);
        assert_eq!(range.unwrap(), DisparityRange::new(-99, 1).unwrap());
    }
}
