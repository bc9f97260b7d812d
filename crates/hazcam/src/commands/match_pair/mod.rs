//! `hazcam match`: two images in, a disparity map out.

mod bits;
mod doubts;
mod outputs;
mod profile;
mod sidecar;

use std::panic::resume_unwind;
use std::path::PathBuf;
use std::process::ExitCode;
use std::thread;

use anyhow::{Context, bail};
use formats::FormatError;
use matching::{Holes, Matcher, Options, Preset, VerticalDisparity};
use raster::{BoundingBox, DisparityRange, Image};

use crate::arguments::{self, GivenBox};
use crate::clock::Stopwatch;
use crate::ui::Ui;
use outputs::Outputs;
use sidecar::{Input, Inputs, Sidecar};

/// Match two rectified images: a disparity for every pixel of the left one
///
/// The images must be rectified: a point of the scene lies in the same row of both. What rectification
/// left of that, up to 24 rows, balanced and best find and mend. A disparity d says that left (x, y) shows what right
/// (x - d, y) shows; it is in pixels.
#[derive(clap::Args)]
#[command(after_help = "\
The format of OUT follows its extension:
  .pfm   float32, infinity where there is no disparity (Middlebury, ETH3D)
  .npy   float32, NaN where there is none (NumPy)
  .tiff  float32, NaN where there is none
  .png   16 bit, 256 d, 0 where there is none (KITTI): 0 to below 256 pixels; less than 1/512 is 1/256
OUT.json beside it records version, options, the inputs' SHA-256, times, the vertical disparity that
was mended, and the share of pixels per reason. On an error nothing is written.
Things stood lower in the right image by constant + x X + y Y + xy X Y + yy Y^2 + xx X^2 pixels,
where X is column / columns - 0.5 and Y is row / rows - 0.5; the factors are its `coefficients`.

Environment:
  HAZCAM_CPU  vector instructions to use instead of the best, see `hazcam doctor`

Examples:
  hazcam match left.png right.png -o disparity.pfm --max-disparity 63
  hazcam match im0.png im1.png -o d.png --matcher best --preview d-colours.png
  hazcam match left.png right.png -o d.npy --holes keep --reasons why.png --box 50,10,440,360")]
pub struct Args {
    /// Left image: PNG, PGM/PPM, JPEG or TIFF, 8 or 16 bit, grey or colour
    left: PathBuf,

    /// Right image, of the same size
    right: PathBuf,

    /// Where to write the disparities: .pfm, .npy, .tiff, or .png as KITTI's 16 bit
    #[arg(short, long, value_name = "OUT", help_heading = "Output")]
    output: PathBuf,

    /// Also write the disparities as a picture in colours (turbo): .png or .ppm
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    preview: Option<PathBuf>,

    /// Also write the confidence, 0 to 1: .pfm, .npy, .tiff, or .png as grey picture
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    confidence: Option<PathBuf>,

    /// Also write why each pixel has its value or none: .png or .ppm. Grey is matched, blue
    /// occluded, orange mismatched, purple outside the right image; bright is filled, dark a hole
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    reasons: Option<PathBuf>,

    /// Which matcher; `hazcam explain MATCHER` says what each does
    #[arg(short, long, default_value = "balanced", help_heading = "Matching")]
    #[arg(value_parser = super::choice(Preset::ALL.map(Preset::name)))]
    matcher: String,

    /// Largest disparity to look for, in pixels. It is searched too: 63 makes 64 disparities, and multiples
    /// of 32 are quickest [default: the smallest one + N - 1, where N is a quarter of the width as a
    /// multiple of 16, from 16 to 256]
    #[arg(short = 'd', long, value_name = "N", help_heading = "Matching")]
    #[arg(value_parser = arguments::disparity, allow_negative_numbers = true)]
    max_disparity: Option<i32>,

    /// Smallest disparity to look for, in pixels; may be negative
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Matching")]
    #[arg(value_parser = arguments::disparity, allow_negative_numbers = true)]
    min_disparity: i32,

    /// Answer only these pixels: x0,y0,x1,y1, inclusive, or the course's *_bounds.npy [default:
    /// the whole image]
    #[arg(long = "box", value_name = "BOX", value_parser = arguments::bounding_box)]
    #[arg(allow_hyphen_values = true)]
    #[arg(help_heading = "Matching")]
    bounds: Option<GivenBox>,

    /// What becomes of pixels without a trustworthy match: filled from their surroundings, or left
    /// without a value
    #[arg(long, value_enum, default_value = "fill", help_heading = "Matching")]
    holes: HolesArgument,

    /// How many bits the camera gave the samples of 16-bit images, where they are stored as they are: 10
    /// and 12 are usual. They are spread over all 16 [default: 16]
    #[arg(long, value_name = "N", help_heading = "Matching")]
    #[arg(value_parser = bits::number, allow_negative_numbers = true)]
    bits: Option<u32>,

    /// Threads to use; the answer does not depend on it [default: one per core]
    #[arg(long, value_name = "N", env = "HAZCAM_THREADS", help_heading = "Matching")]
    #[arg(value_parser = arguments::threads, hide_env_values = true)]
    #[arg(allow_negative_numbers = true)]
    threads: Option<usize>,

    /// Memory to take at most for matching, such as 400MB or 1.5GiB: with less, balanced and best
    /// take more time, up to about half as much again; the answer does not depend on it [default:
    /// 200MB, or what is needed with 100MB for the sums of semi-global matching]
    #[arg(long, value_name = "SIZE", help_heading = "Matching")]
    #[arg(value_parser = arguments::memory, allow_negative_numbers = true)]
    memory: Option<usize>,

    /// Match once more, now that the memory is there, and print where the time goes: for each stage
    /// milliseconds on the wall, bytes and operations, the time that this machine needs for these at
    /// the least, which is measured too, and how many times as long the stage took
    #[arg(long)]
    profile: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum HolesArgument {
    Fill,
    Keep,
}

/// Checks everything that can be checked, matches, then writes all files or none.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let outputs = Outputs {
        disparity: args.output.clone(),
        preview: args.preview.clone(),
        confidence: args.confidence.clone(),
        reasons: args.reasons.clone(),
    };
    let file_of_box = args.bounds.as_ref().and_then(|given| given.file.as_ref());
    let inputs = [Some(&args.left), Some(&args.right), file_of_box].into_iter().flatten();
    outputs.check(&inputs.map(PathBuf::as_path).collect::<Vec<_>>())?;

    let [(mut left, left_read), (mut right, right_read)] = read_both(&args)?;
    check_pair(&args, &left, &right)?;
    for (path, read) in [(&args.left, &left_read), (&args.right, &right_read)] {
        for what in &read.unused {
            ui.note(format_args!("{}: {what}", path.display()));
        }
    }
    if let Some(bits) = args.bits {
        [left, right] = bits::widened(bits, [(&args.left, left), (&args.right, right)])?;
    }
    for doubt in doubts::of_images([(&args.left, &left), (&args.right, &right)], args.bits) {
        ui.note(doubt);
    }
    let (options, assumed) = options(&args, left.columns())?;
    if let Some(assumed) = assumed {
        ui.note(assumed);
    }
    outputs.check_range(options.range)?;
    let mut matcher = Matcher::new(options.clone())?;

    let spinner = ui.spinner(format!("matching ({})", options.preset));
    let stopwatch = Stopwatch::start();
    let given = args.bounds.as_ref().map(|given| given.bounds);
    matcher.compute(&left, &right, given)?;
    let elapsed = stopwatch.elapsed();
    spinner.finish_and_clear();

    let bounds = given.unwrap_or(BoundingBox::whole(left.columns(), left.rows()));
    let (map, vertical) = (matcher.map(), matcher.vertical_disparity());
    let inputs = Inputs { left: left_read, right: right_read, bits: args.bits };
    let sidecar = Sidecar::new(inputs, &outputs, &options, bounds, map, vertical, elapsed)?;
    outputs.write(map, options.range, &sidecar)?;
    if let Some(vertical) = vertical {
        let words = doubts::of_rows(&args.right, vertical);
        // What is not mended shows in no confidence.
        match vertical.disparity_error() > VerticalDisparity::TELLING {
            true => ui.warn(words),
            false => ui.note(words),
        }
    }
    ui.note(format_args!(
        "{}: {}, disparities {} to {} in {:.3} s; {:.1} % matched{}",
        outputs.disparity.display(),
        options.preset,
        options.range.min(),
        options.range.max(),
        elapsed.wall_s,
        100.0 * sidecar.matched(),
        if options.holes == Holes::Fill { ", the rest filled" } else { ", the rest left open" },
    ));
    if left == right {
        let (left_file, right_file) = (args.left.display(), args.right.display());
        match left.extremes() {
            Some([least, most]) if least == most => ui.warn(format_args!(
                "all samples of {left_file} and {right_file} are {most}, so there is nothing to match: was a cap on, or \
                 the exposure far off?"
            )),
            _ => ui.warn(format_args!(
                "{left_file} and {right_file} hold the same image: a pair shows the scene from two places"
            )),
        }
    }
    for doubt in matching::doubts(map, bounds, options.range) {
        doubts::tell(doubt, &args, options.range, ui);
    }
    if args.profile {
        // The first frame is also the one for which memory is fetched.
        matcher.compute(&left, &right, given)?;
        ui.print(&profile::table(&matcher, bounds))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The left and the right image, at the same time where there may be two threads and the system has one.
fn read_both(args: &Args) -> Result<[(Image, Input); 2], FormatError> {
    let Args { left, right, threads, .. } = args;
    if *threads == Some(1) {
        return Ok([Input::read(left)?, Input::read(right)?]);
    }
    thread::scope(|scope| {
        let reading = thread::Builder::new().spawn_scoped(scope, || Input::read(right));
        let left = Input::read(left)?;
        let right = match reading {
            Ok(reading) => reading.join().unwrap_or_else(|panic| resume_unwind(panic)),
            Err(_) => Input::read(right),
        };
        Ok([left, right?])
    })
}

/// Errors that name the files rather than "left" and "right".
fn check_pair(args: &Args, left: &Image, right: &Image) -> anyhow::Result<()> {
    if left.size() != right.size() {
        bail!(
            "{} is {} x {} but {} is {} x {}: a rectified pair has one size; rectify first, crop, or take both at one resolution",
            args.left.display(),
            left.columns(),
            left.rows(),
            args.right.display(),
            right.columns(),
            right.rows()
        );
    }
    if left.kind() != right.kind() {
        bail!(
            "{} is {} but {} is {}: a pair is of one kind; read both alike, or make both grey",
            args.left.display(),
            left.kind(),
            args.right.display(),
            right.kind()
        );
    }
    if let Some(GivenBox { bounds, .. }) = &args.bounds {
        bounds
            .check_within(left.columns(), left.rows())
            .with_context(|| format!("--box does not fit {}", args.left.display()))?;
    }
    Ok(())
}

/// The matcher's options, and in words what had to be assumed.
fn options(args: &Args, columns: usize) -> anyhow::Result<(Options, Option<String>)> {
    let preset: Preset = args.matcher.parse()?;
    let min = args.min_disparity;
    let (max, assumed) = match args.max_disparity {
        Some(max) => (max, None),
        None => {
            let max = min.saturating_add(default_count(columns) - 1);
            let note = format!(
                "disparities from {min} to {max} were assumed from the width of {columns}; \
                 anything nearer is missed, and anything of less than {min}: give --max-disparity and \
                 --min-disparity if you know them"
            );
            (max, Some(note))
        }
    };
    let range =
        DisparityRange::new(min, max).context("--min-disparity and --max-disparity do not fit")?;
    let mut options = Options::new(preset, range);
    if let Some(threads) = args.threads {
        options.threads = threads;
    }
    options.memory = args.memory;
    options.holes = match args.holes {
        HolesArgument::Fill => Holes::Fill,
        HolesArgument::Keep => Holes::Keep,
    };
    Ok((options, assumed))
}

/// How many disparities: a quarter of the width, up to the next multiple of 16, from 16 to 256, which are what a
/// PNG of KITTI's holds. That covers, with room, what the usual scenes need (Cones and Teddy 60 of 450 columns, KITTI
/// 192 of 1242); a camera that looks at its own wheels may need more, which is why the assumption is told.
fn default_count(columns: usize) -> i32 {
    columns.div_ceil(4).next_multiple_of(16).clamp(16, 256) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_range_is_a_quarter_of_the_width() {
        let counts = [1, 64, 450, 1242, 3000, usize::MAX / 2].map(default_count);
        assert_eq!(counts, [16, 16, 128, 256, 256, 256]);
    }
}
