//! `hazcam demo`: rendered scenes, every matcher, a table and pictures, without any data.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use super::bench::contest::Contest;
use super::bench::engines::EngineArguments;
use super::bench::output::Output;
use super::bench::tables::View;
use super::bench::{rendered, scenes};
use crate::ui::Ui;

/// Render scenes with exact truth, run every matcher on them, and show how well they do
///
/// For each scene the folder holds the pair with its truth, mask and calibration as Middlebury lays them out
/// (im0.png, im1.png, disp0GT.pfm, mask0nocc.png, calib.txt), the true disparities as a picture (turbo), and for each
/// matcher its disparities, its errors in KITTI's colours (blue is right, red is wrong, dark is
/// seen by one camera only), a page of its points in space for a browser, and a JSON record.
#[derive(clap::Args)]
#[command(after_help = "\
Environment:
  HAZCAM_PYTHON  the Python that runs OpenCV's matchers, instead of python3 on PATH

Examples:
  hazcam demo
  hazcam demo --matcher fast,best --out /tmp/demo
  hazcam demo --engine 'opencv-*' --scenes '*mars*'
  hazcam bench --data hazcam-demo --matcher best

The folder is a data set by itself, which bench, match, score, depth and view read.")]
pub struct Args {
    /// Folder for pictures, pages and records; it is made if it is not there
    #[arg(short, long, value_name = "DIR", default_value = "hazcam-demo")]
    out: PathBuf,

    /// Only scenes whose id matches, `*` and `?` as in a shell
    #[arg(long, value_name = "GLOB")]
    scenes: Option<String>,

    #[command(flatten)]
    engines: EngineArguments,
}

/// Renders, matches, shows.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let cases = scenes::matching(rendered::demo(), |case| &case.id, args.scenes.as_deref())?;
    let engines = args.engines.definitions(&[], None)?;
    let mut output = Output::in_folder(args.out, View::Regions, true)?;
    output.in_full = true;
    let jobs = NonZeroUsize::MIN;
    Contest { cases, engines, reference: None, limits: None, jobs }.run(&args.engines, output, ui)
}
