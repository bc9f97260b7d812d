//! `hazcam score`: a disparity map against ground truth.

mod report;
pub mod threshold;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, bail};
use arena::record::RANKED_BAD;
use arena::report::Format;
use formats::{Encoding, ReadDisparity};
use score::{Evaluation, Pixels, RankedError, Region, sparsification, suspected_scale};

use crate::arguments::{self, GivenBox};
use crate::cli::THRESHOLD_FAILED;
use crate::ui::Ui;
use report::{Map, Ranking, Report};
use threshold::Threshold;

/// Score a disparity map against ground truth
///
/// Prints the course's two numbers (E_RMS, p_bad), then the community's (bad, avgerr, A50 ... of
/// Middlebury, D1 of KITTI, end-point errors), each family with its protocol: which pixels were
/// counted, what a hole counts as, the thresholds. With a confidence, how well it ranks errors.
#[derive(clap::Args)]
#[command(after_help = "\
Encodings:
  auto        by content; what had to be assumed is told
  png8/K      8 bit, disparity = value / K, 0 is none: png8/4 for Cones and Teddy, png8/3 and
              png8/2 for Middlebury 2005 and 2006 at third and half size
  png16/K     16 bit, disparity = value / K, 0 is none: png16/256 for KITTI
  pfm, npy, tiff   numbers, none where not finite

Exit status: 0 done, 1 a score is over its threshold, 2 error.

Examples:
  hazcam score disparity.pfm truth.pfm --mask mask0nocc.png
  hazcam score cones.png cones_disp_02.png --truth-encoding png8/4 --box cones_02_bounds.npy
  hazcam score d.pfm disp_occ/000070_10.png --fail-over p_bad=0.05 --fail-over D1=6%
  hazcam score d.pfm truth.pfm --confidence sure.pfm --format json")]
pub struct Args {
    /// The disparity map to score: .pfm, .npy, .tiff or grey .png
    estimate: PathBuf,

    /// The true disparities, of the same size
    truth: PathBuf,

    /// How sure each pixel of the estimate is, more is surer, on any scale: .pfm, .npy or .tiff. ROC
    /// and sparsification: AUC and AUSE of bad 2 and of the error, in JSON with their curves
    #[arg(long, value_name = "FILE", help_heading = "Input")]
    confidence: Option<PathBuf>,

    /// How the estimate's file stands for disparities
    #[arg(long, value_name = "ENCODING", default_value = "auto", help_heading = "Input")]
    estimate_encoding: Encoding,

    /// How the truth's file stands for disparities
    #[arg(long, value_name = "ENCODING", default_value = "auto", help_heading = "Input")]
    truth_encoding: Encoding,

    /// Score only these pixels: x0,y0,x1,y1, inclusive, or the course's *_bounds.npy [default:
    /// the whole image]
    #[arg(long = "box", value_name = "BOX", value_parser = arguments::bounding_box)]
    #[arg(allow_hyphen_values = true)]
    #[arg(help_heading = "Region")]
    bounds: Option<GivenBox>,

    /// Score only pixels where this 8-bit picture is 255: mask0nocc.png of Middlebury and ETH3D
    #[arg(long, value_name = "FILE", help_heading = "Region")]
    mask: Option<PathBuf>,

    /// Clip estimates to 0 ... N before Middlebury's measures, as its benchmark does with the
    /// scene's range [default: no clipping]
    #[arg(long, value_name = "N", help_heading = "Region", allow_hyphen_values = true)]
    max_disparity: Option<f64>,

    /// What to print: text to be read, a Markdown table, CSV with a line for each measure, or JSON, every
    /// number with its protocol
    #[arg(long, default_value = "text", help_heading = "Output")]
    #[arg(value_parser = super::choice(Format::NAMES))]
    format: String,

    /// End with status 1 when MEASURE, named as in the output (but not density, AUC and AUSE), is over VALUE,
    /// which may be a share (0.05) or per cent (5%); a bias counts by its size. May be given several
    /// times
    #[arg(long, value_name = "MEASURE=VALUE", help_heading = "Output")]
    fail_over: Vec<Threshold>,
}

/// A share of the truth that no estimate can reach.
const WORTH_TELLING: f64 = 0.01;

/// Reads both maps, scores, prints, compares with the thresholds.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let estimate = formats::read_disparity(&args.estimate, args.estimate_encoding)?;
    let truth = formats::read_disparity(&args.truth, args.truth_encoding)?;
    let mask = args.mask.as_ref().map(formats::read_mask).transpose()?;
    let notes = [(&args.estimate, &estimate.note), (&args.truth, &truth.note)];
    for (path, note) in notes {
        if let Some(note) = note {
            ui.note(format_args!("{}: {note}", path.display()));
        }
    }

    let zeros = truth.values.samples().iter().filter(|&&value| value == 0.0).count();
    let share = zeros as f64 / truth.values.samples().len() as f64;
    if share > WORTH_TELLING {
        ui.note(format_args!(
            "{}: {:.1} % of the truth is exactly 0, which is unknown in the course's two numbers and a disparity in \
             all others: where it stands for unknown, store NaN instead",
            args.truth.display(),
            100.0 * share
        ));
    }

    let region = match (&mask, &args.mask) {
        (Some(mask), Some(path)) => Region::masked(path.display().to_string(), mask),
        _ => Region::whole(),
    };
    let region = region.within(args.bounds.as_ref().map(|given| given.bounds));
    let context =
        || format!("cannot score {} against {}", args.estimate.display(), args.truth.display());
    let evaluation = Evaluation::new(&estimate.values, &truth.values).with_context(context)?;
    let evaluation = evaluation.clipped_to(args.max_disparity);
    let scores = evaluation.scores(&region).with_context(context)?;

    let pixels = evaluation.pixels(&region)?;
    if let Some(most) = args.max_disparity {
        let truths = pixels.iter().map(|pixel| pixel.truth as f32);
        let share = score::share_outside(truths, f32::NEG_INFINITY..=most as f32 + 1.0);
        if share > WORTH_TELLING {
            ui.note(format_args!(
                "{:.1} % of the truth lies beyond --max-disparity {most}, to which estimates are clipped: they count \
                 as wrong there",
                100.0 * share
            ));
        }
    }
    let suspected_scale = suspected_scale(&pixels);
    if let Some(factor) = suspected_scale {
        ui.warn(scale_warning(&args, factor, estimate.encoding, truth.encoding));
    }
    let ranking = args.confidence.as_deref().map(|path| rank(&pixels, path)).transpose()?;
    let report = Report {
        hazcam: env!("CARGO_PKG_VERSION"),
        estimate: Map::new(&args.estimate, estimate.encoding),
        truth: Map::new(&args.truth, truth.encoding),
        scores,
        ranking,
        suspected_scale,
    };
    let format: Format = args.format.parse().map_err(anyhow::Error::msg)?;
    ui.print(&report.render(format)?)?;

    let mut failed = false;
    for threshold in &args.fail_over {
        if let Some(message) = threshold.exceeded_by(&report.scores) {
            ui.fail(message);
            failed = true;
        }
    }
    Ok(if failed { ExitCode::from(THRESHOLD_FAILED) } else { ExitCode::SUCCESS })
}

/// How well the confidence of a file ranks the pixels' errors.
fn rank(pixels: &Pixels<'_>, path: &Path) -> anyhow::Result<Ranking> {
    // Not what had to be assumed: a picture holds whole numbers, which are on no scale of a confidence.
    let ReadDisparity { values, encoding, .. } = formats::read_disparity(path, Encoding::Auto)?;
    if !matches!(encoding, Encoding::Pfm | Encoding::Npy | Encoding::Tiff) {
        bail!(
            "--confidence {}: a picture holds no numbers that rank pixels; give a .pfm, .npy or .tiff, as `hazcam \
             match --confidence` writes",
            path.display()
        );
    }
    let ranked = |error| {
        let context = || format!("cannot rank pixels by --confidence {}", path.display());
        sparsification(pixels, &values, error).with_context(context)
    };
    Ok(Ranking {
        path: path.to_owned(),
        bad: ranked(RankedError::Bad(RANKED_BAD))?,
        error: ranked(RankedError::EndPoint)?,
    })
}

/// Which of the two files seems to be read at the wrong scale, and what to say instead.
fn scale_warning(args: &Args, factor: f64, estimate: Encoding, truth: Encoding) -> String {
    let estimate = (&args.estimate, estimate, "--estimate-encoding");
    let truth = (&args.truth, truth, "--truth-encoding");
    if factor < 0.0 {
        let estimate = estimate.0.display();
        return format!(
            "most disparities are bad, but would not be with the other sign: {estimate} seems to say right less left, \
             and disparities are left less right"
        );
    }
    let times = factor.max(1.0 / factor);
    let (larger, smaller) = if factor > 1.0 { (estimate, truth) } else { (truth, estimate) };
    let divided_by = |(_, encoding, option): (_, Encoding, &str), times: f64| {
        let (kind, divisor) = match encoding {
            Encoding::Png8 { divisor } => ("png8", divisor),
            Encoding::Png16 { divisor } => ("png16", divisor),
            _ => return None,
        };
        Some(format!("read it with {option} {kind}/{}", f64::from(divisor) * times))
    };
    // A file that has a divisor may have been read with another one than it was written with.
    let change = match (divided_by(larger, times), divided_by(smaller, 1.0 / times)) {
        (Some(remedy), _) => format!("{} were divided by {times}: {remedy}", larger.0.display()),
        (None, Some(remedy)) => {
            format!("{} were multiplied by {times}: {remedy}", smaller.0.display())
        }
        (None, None) => format!(
            "{} were divided by {times}, or those of {} multiplied",
            larger.0.display(),
            smaller.0.display()
        ),
    };
    format!("most disparities are bad, but would not be if those of {change}")
}
