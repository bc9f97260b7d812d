//! `hazcam depth`: a disparity map and a camera in, depth and points out.

mod kept;
mod points;
mod reach;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, bail};
use camera::{DISPARITY_ERROR, StereoCamera};
use formats::{Encoding, MOST_METRES_IN_PNG, Point, write_depth, write_points};
use raster::{DisparityMap, Plane};

use crate::arguments;
use crate::map::Map;
use crate::outputs::{self, Output};
use crate::rig::CameraArguments;
use crate::ui::Ui;
use kept::Limits;
use reach::Reach;

/// Turn a disparity map into depth and points, and say how good they are at which range
///
/// Without a map it says how good depth can be with a camera, before one has it.
///
/// Depth is Z = f B / (d + doffs), in metres along the optical axis: f is the focal length in pixels, B
/// the distance between the cameras. An error of e pixels in disparity is one of Z^2 e / (f B) in depth, so
/// it grows with the square of the range.
#[derive(clap::Args)]
#[command(after_help = "\
The format of a depth map follows its extension:
  .pfm   metres, float32, infinity where there is none
  .npy   metres, float32, NaN where there is none
  .tiff  metres, float32, NaN where there is none
  .png   millimetres, 16 bit, 0 where there is none (as ROS has it): up to 65.535 m
Points are in the left camera's axes, in metres: X to the right, Y down, Z forward.
Pixels that were filled without a match count like the others, though their depth is a guess: leave
them out by --confidence and --min-confidence, or keep holes when you match.

Examples:
  hazcam depth d.pfm --calibration calib.txt --confidence sure.pfm --min-confidence 0.5 -o depth.npy
  hazcam depth disparity.pfm --calibration calib.txt -o depth.pfm --uncertainty off.pfm
  hazcam depth d.pfm --focal 721.5 --baseline 0.54 --points street.ply --image left.png
  hazcam depth --focal 700 --baseline 0.12 --disparity-error 0.5")]
pub struct Args {
    /// The disparity map: .pfm, .npy, .tiff or grey .png; none for what the camera can do
    disparity: Option<PathBuf>,

    /// How its file stands for disparities, see `hazcam score --help`
    #[arg(long, value_name = "ENCODING", default_value = "auto")]
    encoding: Encoding,

    #[command(flatten)]
    rig: CameraArguments,

    /// How sure each pixel is, from `hazcam match --confidence`: .pfm, .npy or .tiff
    #[arg(long, value_name = "FILE", help_heading = "Which pixels")]
    #[arg(requires_all = ["min_confidence", "disparity"])]
    confidence: Option<PathBuf>,

    /// Leave out pixels less sure than this, from 0 to 1
    #[arg(long, value_name = "SHARE", help_heading = "Which pixels", requires = "confidence")]
    #[arg(value_parser = arguments::share)]
    min_confidence: Option<f32>,

    /// Leave out what is farther away than this, in metres
    #[arg(long, value_name = "M", help_heading = "Which pixels", value_parser = arguments::positive)]
    #[arg(allow_hyphen_values = true, requires = "disparity")]
    max_depth: Option<f64>,

    /// Where to write the depth: .pfm, .npy, .tiff, or .png in millimetres
    #[arg(short, long, value_name = "OUT", help_heading = "Output", requires = "disparity")]
    output: Option<PathBuf>,

    /// Where to write points with their colours: .ply
    #[arg(long, value_name = "FILE", help_heading = "Output", requires = "disparity")]
    points: Option<PathBuf>,

    /// The left image, for the colours of points [default: near is red, far is blue]
    #[arg(long, value_name = "FILE", help_heading = "Output", requires = "disparity")]
    image: Option<PathBuf>,

    /// Where to write by how much each pixel's depth is off when its disparity is off by
    /// --disparity-error: as the depth
    #[arg(long, value_name = "FILE", help_heading = "Output", requires = "disparity")]
    uncertainty: Option<PathBuf>,

    /// By how much disparities are off, in pixels. Of pixels that balanced and best are sure of, from 0.5 on,
    /// 93 of 100 are off by less than 1, half of them by less than 0.3, in pictures that are sharp and have little noise
    #[arg(long, value_name = "PX", default_value_t = DISPARITY_ERROR, help_heading = "Output")]
    #[arg(value_parser = arguments::positive, allow_hyphen_values = true)]
    disparity_error: f64,

    /// Print JSON
    #[arg(long, help_heading = "Output")]
    json: bool,
}

const NO_CAMERA: &str =
    "depth needs a camera: give --calibration FILE, or --focal in pixels and --baseline in metres";

/// Reads everything, writes all files or none, prints how far depth is good.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let Some(disparity) = &args.disparity else {
        let camera = args.rig.camera(None, None, ui)?.context(NO_CAMERA)?;
        let reach = Reach::of_camera(&camera, args.rig.has_principal_point(), args.disparity_error);
        show(&reach, &args, ui)?;
        return Ok(ExitCode::SUCCESS);
    };
    let inputs = [Some(disparity), args.confidence.as_ref(), args.image.as_ref(), args.rig.file()];
    let inputs: Vec<&Path> = inputs.into_iter().flatten().map(PathBuf::as_path).collect();
    let anything = Plane::filled(1, 1, 1.0);
    outputs::check(&all(&args, [&anything, &anything], &[]), &inputs)?;

    let map = Map::read(disparity, args.encoding, ui)?;
    let image = args.image.as_ref().map(|path| map.image(path, ui)).transpose()?;
    let confidence = args.confidence.as_ref().map(|path| map.confidence(path)).transpose()?;
    let camera = args.rig.camera(Some(map.disparities.size()), args.image.as_deref(), ui)?;
    let camera = camera.context(NO_CAMERA)?;
    let limits = Limits {
        confidence: confidence.as_ref().zip(args.min_confidence),
        max_depth: args.max_depth,
    };
    let (depths, counts) = kept::depths(&map.disparities, &camera, &limits);
    check_uncertainty(&args, &camera, &depths)?;

    let points = args
        .points
        .as_ref()
        .map(|_| points::points(&map.disparities, &depths, &camera, image.as_ref()));
    let uncertainty = args
        .uncertainty
        .as_ref()
        .map(|_| camera.depth_uncertainty_map(&depths, args.disparity_error))
        .unwrap_or_default();
    let points = points.as_deref().unwrap_or_default();
    outputs::write_all_or_none(&all(&args, [&depths, &uncertainty], points))?;
    let doubt = camera.doubt_of(&map.disparities);
    if let Some(doubt) = &doubt {
        ui.warn(doubt);
    }
    let most = DisparityMap::MOST_OF_A_GUESS;
    if counts.kept == 0 {
        // Where all is behind the cameras that has been told.
        if doubt.is_none() {
            ui.warn(format_args!("{}: {}", disparity.display(), counts.nothing_left()));
        }
    } else if args.min_confidence.is_none_or(|least| least <= most) {
        map.tell_guesses(
            ui,
            format_args!(
                "leave them out by --confidence and a --min-confidence above {most}, or match with --holes keep"
            ),
        );
    }
    let reach = Reach::new(&camera, &depths, counts, args.disparity_error);
    show(&reach, &args, ui)?;
    Ok(ExitCode::SUCCESS)
}

fn show(reach: &Reach, args: &Args, ui: &Ui) -> anyhow::Result<()> {
    match args.json {
        true => ui.print(&(serde_json::to_string_pretty(reach)? + "\n")),
        false => ui.print(&reach.text()),
    }
}

/// Errors where depths are off by more than a picture of millimetres holds.
fn check_uncertainty(
    args: &Args,
    camera: &StereoCamera,
    depths: &Plane<f32>,
) -> anyhow::Result<()> {
    let is_png = |path: &&PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    let Some(path) = args.uncertainty.as_ref().filter(is_png) else { return Ok(()) };
    // Where `Z^2 e / (f B)` is as much.
    let reach = MOST_METRES_IN_PNG * camera.focal_px * camera.baseline_m / args.disparity_error;
    let most = depths.samples().iter().copied().fold(0.0, f32::max);
    if f64::from(most) > reach.sqrt() {
        bail!(
            "--uncertainty {}: depths of more than {:.1} m are off by more than the {MOST_METRES_IN_PNG} m that a \
             16-bit PNG of millimetres holds, and the farthest is {most:.1} m: write .pfm, .npy or .tiff, or leave \
             out what is that far (--max-depth)",
            path.display(),
            reach.sqrt()
        );
    }
    Ok(())
}

/// Every file that was asked for, and what goes into it.
fn all<'a>(
    args: &'a Args,
    [depths, uncertainty]: [&'a Plane<f32>; 2],
    points: &'a [Point],
) -> Vec<Output<'a>> {
    let mut all = Vec::new();
    if let Some(path) = &args.output {
        all.push(Output::new("--output", path, |path| write_depth(path, depths)));
    }
    if let Some(path) = &args.uncertainty {
        all.push(Output::new("--uncertainty", path, |path| write_depth(path, uncertainty)));
    }
    if let Some(path) = &args.points {
        all.push(Output::new("--points", path, |path| write_points(path, points)));
    }
    all
}
