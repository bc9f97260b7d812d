//! `hazcam view`: a disparity map as a page that shows its points in space.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::bail;
use camera::DISPARITY_ERROR;
use formats::{Encoding, View, write_view};
use raster::Plane;

use crate::arguments;
use crate::map::Map;
use crate::outputs::{self, Output};
use crate::rig::CameraArguments;
use crate::ui::Ui;

/// Show a disparity map as points in space, on a page that opens in any browser without a network
///
/// A picture of disparities looks smooth where depth is not. The page shows the points themselves, to be
/// turned around, beside the left image and the map; whatever one points at tells its disparity, depth,
/// confidence, reason and error. Without a camera it shows a relief: pixels, as high as their disparity.
#[derive(clap::Args)]
#[command(after_help = "\
The page is one HTML file, complete in itself. It needs WebGL 2 and DecompressionStream, which
all browsers have since 2023.
No point is left out: expect about 2 bytes a pixel for the disparities, 1 for the confidence, 3 for
the image, 4 for the truth. With all of these a map of 3000 x 2000 pixels makes 40 to 60 MB, which
browsers open within seconds, one of 450 x 375 about 1.5 MB.

Examples:
  hazcam view disparity.pfm --calibration calib.txt --image left.png -o view.html
  hazcam view d.pfm --focal 721.5 --baseline 0.54 --image left.png --confidence sure.pfm \\
      --min-confidence 0.5 --reasons why.png -o street.html
  hazcam view cones.pfm --truth cones_disp_02.png --truth-encoding png8/4 -o relief.html")]
pub struct Args {
    /// The disparity map: .pfm, .npy, .tiff or grey .png
    disparity: PathBuf,

    /// How its file stands for disparities, see `hazcam score --help`
    #[arg(long, value_name = "ENCODING", default_value = "auto")]
    encoding: Encoding,

    #[command(flatten)]
    rig: CameraArguments,

    /// The left image, for the colours of points
    #[arg(long, value_name = "FILE", help_heading = "What is shown")]
    image: Option<PathBuf>,

    /// How sure each pixel is, from `hazcam match --confidence`: .pfm, .npy or .tiff
    #[arg(long, value_name = "FILE", help_heading = "What is shown")]
    confidence: Option<PathBuf>,

    /// Hide points less sure than this, from 0 to 1, until the page is told otherwise
    #[arg(long, value_name = "SHARE", help_heading = "What is shown", requires = "confidence")]
    #[arg(value_parser = arguments::share, default_value_t = 0.0)]
    min_confidence: f32,

    /// Why each pixel has its value or none, from `hazcam match --reasons`: .png or .ppm
    #[arg(long, value_name = "FILE", help_heading = "What is shown")]
    reasons: Option<PathBuf>,

    /// The true disparities, for the colours of errors
    #[arg(long, value_name = "FILE", help_heading = "What is shown")]
    truth: Option<PathBuf>,

    /// How the truth's file stands for disparities
    #[arg(long, value_name = "ENCODING", default_value = "auto", help_heading = "What is shown")]
    #[arg(requires = "truth")]
    truth_encoding: Encoding,

    /// By how much disparities are off, in pixels: what that is worth in depth is told
    #[arg(long, value_name = "PX", default_value_t = DISPARITY_ERROR, help_heading = "What is shown")]
    #[arg(value_parser = arguments::positive, requires = "CameraArguments")]
    #[arg(allow_hyphen_values = true)]
    disparity_error: f64,

    /// Where to write the page: .html
    #[arg(short, long, value_name = "OUT", help_heading = "Output")]
    output: PathBuf,
}

/// Reads everything, writes the page, says how many points are on it.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let overlays = [&args.image, &args.confidence, &args.reasons, &args.truth];
    let inputs = overlays.into_iter().map(Option::as_ref);
    let inputs = inputs.chain([Some(&args.disparity), args.rig.file()]).flatten();
    let inputs: Vec<&Path> = inputs.map(PathBuf::as_path).collect();
    outputs::check(&[page(&args.output, &View::new("", &Plane::filled(1, 1, 1.0)))], &inputs)?;

    let map = Map::read(&args.disparity, args.encoding, ui)?;
    let image = args.image.as_ref().map(|path| map.image(path, ui)).transpose()?;
    let confidence = args.confidence.as_ref().map(|path| map.confidence(path)).transpose()?;
    let reasons = args.reasons.as_ref().map(|path| map.reasons(path)).transpose()?;
    let truth = args.truth.as_ref().map(|path| map.truth(path, args.truth_encoding, ui));
    let truth = truth.transpose()?;
    let camera = args.rig.camera(Some(map.disparities.size()), args.image.as_deref(), ui)?;

    let title = args.disparity.file_name().unwrap_or_default().to_string_lossy();
    let mut view = View::new(&title, &map.disparities);
    if let Some(camera) = camera {
        view = view.with_camera(camera, args.disparity_error);
    }
    if let Some(image) = &image {
        view = view.with_image(image)?;
    }
    if let Some(confidence) = &confidence {
        view = view.with_confidence(confidence, args.min_confidence)?;
    }
    if let Some(reasons) = &reasons {
        view = view.with_reasons(reasons)?;
    }
    if let Some(truth) = &truth {
        view = view.with_truth(truth)?;
    }
    if view.points() == 0 {
        let values = map.disparities.samples().iter().filter(|value| !value.is_nan()).count();
        let why = match camera {
            Some(_) if values > 0 => {
                "none of its disparities is of anything in front of the cameras"
            }
            _ => "no pixel of it has a disparity",
        };
        bail!("{}: {why}, so there is nothing to show", args.disparity.display());
    }
    outputs::write_all_or_none(&[page(&args.output, &view)])?;
    match &camera {
        Some(camera) => {
            if let Some(doubt) = camera.doubt_of(&map.disparities) {
                ui.warn(doubt);
            }
        }
        None => ui.note(
            "without --calibration, or --focal and --baseline, the page shows a relief in pixels",
        ),
    }
    if confidence.is_none() && reasons.is_none() {
        map.tell_guesses(ui, format_args!("--confidence or --reasons shows which"));
    }
    ui.note(format_args!(
        "{} shows {} points of {} pixels",
        args.output.display(),
        view.shown(),
        map.disparities.samples().len()
    ));
    Ok(ExitCode::SUCCESS)
}

fn page<'a>(path: &Path, view: &'a View<'a>) -> Output<'a> {
    Output::new("--output", path, |path| write_view(path, view))
}
