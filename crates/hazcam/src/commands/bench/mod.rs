//! `hazcam bench`: matchers on scenes with known truth, scored and timed.
//!
//! One file per question: which engines, which scenes ([`scenes`] on disk, [`rendered`] ones), how
//! they are run against each other ([`contest`]), where the results go ([`output`], [`pictures`]).

pub mod contest;
pub mod engines;
pub mod output;
pub mod pictures;
pub mod rendered;
pub mod scenes;

use std::path::PathBuf;
use std::process::ExitCode;

use arena::dataset::Purpose;
use arena::report::Format;

use crate::ui::Ui;
use engines::EngineArguments;
use output::Output;
use scenes::SceneArguments;

/// Run matchers on scenes with known truth: scores, times, memory
///
/// Every matcher runs in a process of its own that is measured from outside, hazcam's own ones
/// included. Without --matcher, all of hazcam's run; other programs join with --engine.
#[derive(clap::Args)]
#[command(after_help = "\
Engines that come with hazcam: fast, balanced, best, and OpenCV's matchers opencv-bm, opencv-sgbm,
opencv-3way, opencv-hh, opencv-3way-1x1, opencv-wls (Python with opencv-contrib-python-headless is
needed). Your own are TOML files in a folder, see --engines.

Examples:
  HAZCAM_DATA=~/stereo hazcam bench
  hazcam bench --use tuning --matcher best --reference opencv-wls
  hazcam bench --scenes 'course/*' --engine 'opencv-*' --out results --pictures
  hazcam bench --stress --format markdown")]
pub struct Args {
    #[command(flatten)]
    scenes: SceneArguments,

    /// Rendered scenes instead, each of which strains one assumption: exposure, noise, vertical
    /// offset, range, size, texture
    #[arg(long, conflicts_with_all = ["data", "purpose"], help_heading = "Scenes")]
    stress: bool,

    #[command(flatten)]
    engines: EngineArguments,

    /// Compare p_bad with this engine's, scene by scene; it joins the run
    #[arg(long, value_name = "ENGINE", help_heading = "Matchers")]
    reference: Option<String>,

    /// How to show the results
    #[arg(long, default_value = "text", help_heading = "Output")]
    #[arg(value_parser = super::choice(Format::NAMES))]
    format: String,

    /// Also write a JSON record for every scene and matcher, and the tables, into this folder
    #[arg(short, long, value_name = "DIR", help_heading = "Output")]
    out: Option<PathBuf>,

    /// Write left image, truth, disparities (turbo) and errors (KITTI's colours) there as well
    #[arg(long, requires = "out", help_heading = "Output")]
    pictures: bool,
}

/// Chooses scenes and engines, runs them, shows the tables.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let format: Format = args.format.parse().map_err(anyhow::Error::msg)?;
    let cases = match args.stress {
        true => scenes::matching(rendered::stress(), args.scenes.scenes.as_deref())?,
        false => args.scenes.cases(&[Purpose::Test, Purpose::Tuning, Purpose::Rendered])?,
    };
    let mut output = match args.out {
        Some(folder) => Output::in_folder(folder, args.pictures)?,
        None => Output::default(),
    };
    output.format = format;
    contest::run(cases, &args.engines, output, args.reference.as_deref(), ui)
}
