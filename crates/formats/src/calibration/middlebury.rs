//! Middlebury's `calib.txt`, also ETH3D's, and the lunar set's own keys.

use std::num::NonZero;
use std::str::FromStr;

use camera::StereoCamera;
use raster::DisparityRange;

use super::{Calibration, CalibrationLayout, Entries};
use crate::FormatError;

/// `doffs` may differ from the difference of principal points by so many pixels: files are rounded.
const ROUNDED: f64 = 0.1;
const SIZE: &str = "a whole number of pixels";

/// `cam0`, `cam1`, `doffs`, `baseline` in millimetres, and what helps with display.
pub(super) fn parse(entries: &Entries<'_>) -> Result<Calibration, FormatError> {
    let cam0: [f64; 9] = entries.numbers("cam0")?;
    let cam1: [f64; 9] = entries.numbers("cam1")?;
    entries.rectified(["cam0", "cam1"], &[cam0, cam1])?;
    let doffs = doffs(entries, cam1[2] - cam0[2])?;
    let baseline_m = entries.number("baseline")? / 1000.0;
    let camera = entries.camera(cam0[0], baseline_m, doffs, cam0[2], cam0[5])?;
    with_extent(entries, Calibration::of(CalibrationLayout::Middlebury, camera))
}

/// With the images' size and what helps with display, where they are there.
fn with_extent(
    entries: &Entries<'_>,
    calibration: Calibration,
) -> Result<Calibration, FormatError> {
    let isint: Option<Flag> = entries.optional("isint", "0 or 1")?;
    let stated = [entries.optional("width", SIZE)?, entries.optional("height", SIZE)?];
    let size = entries.size(["width", "height"], stated)?;
    let ndisp: Option<NonZero<usize>> = entries.optional("ndisp", "a whole number, 1 or more")?;
    let (vmin, vmax) =
        (entries.optional("vmin", "a number")?, entries.optional("vmax", "a number")?);
    if let (Some(vmin), Some(vmax)) = (vmin, vmax)
        && vmin > vmax
    {
        let problem =
            format!("`vmin` is {vmin}, above `vmax`, which is {vmax}: are they exchanged?");
        return Err(entries.fail(None, problem));
    }
    Ok(Calibration {
        ndisp: ndisp.map(NonZero::get),
        isint: isint.map(|flag| flag.0),
        vmin,
        vmax,
        ..calibration.sized(size)
    })
}

/// By how far the principal points are apart, as `doffs` says it where it is there. Errors where it says something else.
fn doffs(entries: &Entries<'_>, apart: f64) -> Result<f64, FormatError> {
    if !entries.has("doffs") {
        return Ok(apart);
    }
    let doffs = entries.number("doffs")?;
    if (doffs - apart).abs() <= ROUNDED {
        return Ok(doffs);
    }
    let remedy = match (doffs + apart).abs() > ROUNDED {
        true => "one of them is wrong",
        false => "are cam0, the left camera, and cam1 exchanged?",
    };
    let problem = format!(
        "`doffs` is {doffs}, but the principal point of cam1 less that of cam0 is {apart}: {remedy}"
    );
    Err(entries.fail(None, problem))
}

/// `0` or `1`.
struct Flag(bool);

impl FromStr for Flag {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        match text {
            "0" => Ok(Self(false)),
            "1" => Ok(Self(true)),
            _ => Err(()),
        }
    }
}

/// `f`, `cx0`, `cx1`, `cy`, `doffs`, `baseline_m`, and the rest as Middlebury has it.
pub(super) fn parse_lunar(entries: &Entries<'_>) -> Result<Calibration, FormatError> {
    let cx0 = entries.number("cx0")?;
    let doffs = doffs(entries, entries.number("cx1")? - cx0)?;
    let (focal, baseline) = (entries.number("f")?, entries.number("baseline_m")?);
    let camera = entries.camera(focal, baseline, doffs, cx0, entries.number("cy")?)?;
    with_extent(entries, Calibration::of(CalibrationLayout::Lunar, camera))
}

/// What [`parse`] reads.
pub(super) fn text(
    camera: &StereoCamera,
    (width, height): (usize, usize),
    range: DisparityRange,
) -> String {
    let StereoCamera { focal_px: f, baseline_m, doffs, cx, cy, .. } = camera;
    let (right, baseline, ndisp) = (cx + doffs, 1000.0 * baseline_m, i64::from(range.max()) + 1);
    format!(
        "cam0=[{f} 0 {cx}; 0 {f} {cy}; 0 0 1]\ncam1=[{f} 0 {right}; 0 {f} {cy}; 0 0 1]\n\
         doffs={doffs}\nbaseline={baseline}\nwidth={width}\nheight={height}\nndisp={}\n",
        ndisp.max(1)
    )
}

#[cfg(test)]
mod tests {
    use super::super::tests::{read, refused};
    use super::*;

    const SAMPLE: &str = "cam0=[ 1038.018 0 322.037 ; 0 1038.018 243.393 ; 0 0 1 ] \n\
        cam1=[1038.018 0 375.308; 0 1038.018 243.393; 0 0 1]\r\n doffs= 53.271 \n\
        baseline= 176.25\n width= 718\nheight= 496\n ndisp= 73\n isint=0\n vmin= 8 \nvmax= 65\n \
        dyavg= 0.184\n";

    #[test]
    fn millimetres_become_metres_and_spaces_do_not_matter() {
        let calibration = read(SAMPLE).unwrap();
        let expected = StereoCamera::new(1038.018, 0.17625, 53.271, 322.037, 243.393).unwrap();
        assert_eq!(calibration.camera, expected);
        assert_eq!((calibration.width, calibration.height), (Some(718), Some(496)));
        assert_eq!((calibration.ndisp, calibration.isint), (Some(73), Some(false)));
        assert_eq!((calibration.vmin, calibration.vmax), (Some(8.0), Some(65.0)));
    }

    #[test]
    fn a_mark_of_byte_order_is_no_letter_and_pixels_are_square() {
        assert_eq!(read(&format!("\u{feff}{SAMPLE}")).unwrap(), read(SAMPLE).unwrap());
        let error = read(&SAMPLE.replace("; 0 1038.018 243.393 ;", "; 0 2000 243.393 ;"));
        let error = error.unwrap_err().to_string();
        assert!(
            error.contains("cam0 has the focal lengths 1038.018 across and 2000 down"),
            "{error}"
        );
    }

    #[test]
    fn what_is_written_is_read() {
        let camera = StereoCamera::new(712.25, 0.1193, 3.7, 310.5, 170.25).unwrap();
        let range = DisparityRange::new(-4, 63).unwrap();
        let calibration = read(&text(&camera, (640, 350), range)).unwrap();
        let same = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        same(calibration.camera.focal_px, camera.focal_px);
        same(calibration.camera.baseline_m, camera.baseline_m);
        same(calibration.camera.doffs, camera.doffs);
        same(calibration.camera.cx, camera.cx);
        same(calibration.camera.cy, camera.cy);
        assert_eq!((calibration.width, calibration.height), (Some(640), Some(350)));
        assert_eq!(calibration.ndisp, Some(64));
        let below_0 = DisparityRange::new(-20, -4).unwrap();
        assert_eq!(read(&text(&camera, (640, 350), below_0)).unwrap().ndisp, Some(1));
    }

    #[test]
    fn without_doffs_the_principal_points_tell() {
        let text = SAMPLE.replace(" doffs= 53.271 \n", "");
        assert!((read(&text).unwrap().camera.doffs - 53.271).abs() < 1e-9);
    }

    #[test]
    fn broken_lines_are_named() {
        let changes = [
            ("baseline= 176.25", "", "`baseline` is missing"),
            ("[1038.018 0 375.308;", "[1038.018 nan 375.308;", "row 1, column 2"),
            (
                "375.308; 0 1038.018 243.393",
                "375.308; 0 1038.018 nan",
                "principal points in the rows",
            ),
            ("baseline= 176.25", "baseline= -1", "baseline in metres"),
            ("baseline= 176.25", "baseline= x", "`baseline` is `x`"),
            ("0 0 1 ]", "0 0 ]", "must be 9 numbers"),
            ("ndisp= 73", "ndisp= 7.3", "near byte"),
            ("width= 718", "height= 718", "twice"),
            ("isint=0", "isint=7", "`isint` is `7`, but must be 0 or 1"),
            ("cam1=[1038.018", "cam1=[1038.5", "focal lengths"),
            (
                "375.308; 0 1038.018 243.393",
                "375.308; 0 1038.018 253.393",
                "the rows 243.393 and 253.393",
            ),
            ("cam1=[1038.018 0 ", "cam1=[1038.018 0.3 ", "cam1 has 0.3 in row 1, column 2"),
            ("doffs= 53.271", "doffs= 10", "`doffs` is 10"),
            ("doffs= 53.271", "doffs= -53.271", "cam1 exchanged?"),
            ("cam1=[1038.018", "cam1=[nan", "cam1 has the focal length NaN"),
            (
                "375.308; 0 1038.018",
                "375.308; 0 2000",
                "cam1 has the focal lengths 1038.018 across",
            ),
            ("375.308; 0 1038.018", "375.308; 0 nan", "cam1 has the focal lengths 1038.018 across"),
            ("width= 718", "width= 0", "`width` is 0"),
            ("width= 718", "width= 71.8", "`width` is 71.8"),
            ("ndisp= 73", "ndisp= 0", "`ndisp` is `0`"),
            ("vmin= 8", "vmin= 80", "`vmin` is 80, above `vmax`"),
        ];
        refused(SAMPLE, &changes);
    }

    #[test]
    fn lunar_keys_are_in_metres() {
        let text = "f=618.5\ncx0=231.5\ncx1=264.5\ncy=254.25\ndoffs=33\nbaseline_m=2164.5\n";
        let calibration = read(text).unwrap();
        assert_eq!(calibration.layout, CalibrationLayout::Lunar);
        let expected = StereoCamera::new(618.5, 2164.5, 33.0, 231.5, 254.25).unwrap();
        assert_eq!(calibration.camera, expected);
        let without = read(&text.replace("doffs=33\n", "")).unwrap();
        assert_eq!(without.camera, expected);
        let sized = read(&format!("{text}width=463\nheight=508\nndisp=64\n")).unwrap();
        assert_eq!((sized.width, sized.height, sized.ndisp), (Some(463), Some(508), Some(64)));
        assert!(
            read(&format!("{text}width=0\nheight=508\n")).unwrap_err().contains("`width` is 0")
        );
        assert!(read(&text.replace("cy", "cz")).unwrap_err().contains("`cy` is missing"));
        assert!(read(&text.replace("=33", "=0")).unwrap_err().contains("`doffs` is 0"));
    }
}
