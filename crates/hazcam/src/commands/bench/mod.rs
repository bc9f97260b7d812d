//! `hazcam bench`: matchers on scenes with known truth, scored and timed.
//!
//! One file per question: which engines, which scenes ([`scenes`] on disk, [`rendered`] ones, with [`obstacles`]), how
//! they are run against each other ([`contest`]), what they are held to ([`limits`]), how the
//! results are shown ([`tables`]) and where they go ([`output`], [`pictures`], [`into`]); and how fast
//! they are ([`speed`]), and what each of their ingredients gives ([`ablation`]).

pub mod ablation;
pub mod contest;
pub mod engines;
pub mod into;
pub mod limits;
pub mod obstacles;
pub mod output;
pub mod pictures;
pub mod rendered;
mod scales;
pub mod scenes;
pub mod speed;
pub mod tables;

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::bail;
use arena::dataset::{Case, Purpose};
use arena::report::Format;

use crate::arguments;
use crate::ui::Ui;
use contest::Contest;
use engines::EngineArguments;
use into::Page;
use limits::Limits;
use output::Output;
use scenes::SceneArguments;
use speed::SpeedArguments;
use tables::View;

/// Engines that stand beside hazcam's own unless the user chooses: the plain window matcher, the
/// usual semi-global one, and the most accurate one that OpenCV has.
const BESIDE: [&str; 3] = ["opencv-bm", "opencv-sgbm", "opencv-wls"];

/// Run matchers on scenes with known truth: scores, times, memory
///
/// Every matcher runs in a process of its own that is measured from outside, hazcam's own ones
/// included. Without --matcher and --engine, all of hazcam's run, and beside them OpenCV's BM, SGBM
/// and WLS where Python with OpenCV is found.
#[derive(clap::Args)]
#[command(after_help = "\
Engines that come with hazcam: fast, balanced, best, and OpenCV's matchers opencv-bm, opencv-sgbm,
opencv-bm-9x9, opencv-3way, opencv-hh, opencv-3way-1x1, opencv-wls (Python with
opencv-contrib-python-headless is needed). Your own are TOML files in a folder, see --engines.

Environment:
  HAZCAM_PYTHON  the Python that runs OpenCV's matchers, instead of python3 on PATH

Examples:
  HAZCAM_DATA=~/stereo hazcam bench
  hazcam bench --use tuning --matcher best --reference opencv-wls
  hazcam bench --scenes 'course/*' --engine 'opencv-*' --out results --pictures
  hazcam bench --stress --format markdown
  hazcam bench --scenes 'course/*' --limits benchmarks/course.toml
  hazcam bench --speed --threads 2 --record benchmarks/speed.json --into README.md
  hazcam bench --speed --sweep --matcher fast
  hazcam bench --reliability --use tuning --matcher best
  hazcam bench --obstacles --use tuning --matcher balanced
  hazcam bench --ablation --matcher balanced --scenes 'middlebury*' --jobs 2")]
pub struct Args {
    #[command(flatten)]
    scenes: SceneArguments,

    /// Rendered scenes instead, each of which strains one assumption: exposure, noise, vertical
    /// offset, range, size, texture, slopes
    #[arg(long, conflicts_with_all = ["data", "purpose"], help_heading = "Scenes")]
    stress: bool,

    #[command(flatten)]
    engines: EngineArguments,

    /// Compare p_bad with this engine's, scene by scene; it joins the run
    #[arg(long, value_name = "ENGINE", help_heading = "Matchers")]
    reference: Option<String>,

    /// End with status 1 when a figure is over its limit: a TOML file with tables like
    /// [fast."course/cones"] and lines like p_bad = 0.083
    #[arg(long, value_name = "FILE", help_heading = "Matchers")]
    limits: Option<PathBuf>,

    /// How many matchers work at once; with more than one, times are longer than they are alone
    #[arg(long, value_name = "N", default_value = "1", help_heading = "Matchers")]
    #[arg(value_parser = arguments::jobs)]
    jobs: NonZeroUsize,

    #[command(flatten)]
    speed: SpeedArguments,

    /// Show what each ingredient of balanced and best gives, by leaving out one at a time, on the
    /// tuning scenes unless --use says otherwise; `hazcam engine --without` runs one such variant
    #[arg(long, help_heading = "Ablation")]
    #[arg(conflicts_with_all = ["stress", "reference", "limits", "engine"])]
    ablation: bool,

    /// Show how reliable disparities are by how sure matchers are of them: how many pixels are as sure,
    /// and how many of these are wrong
    #[arg(long, help_heading = "Reliability")]
    #[arg(conflicts_with_all = ["stress", "ablation", "reference", "limits"])]
    reliability: bool,

    /// Lay small obstacles over each scene, pieces of itself that are nearer than what is behind them,
    /// and show how much of them matchers miss (pixels whose disparity is nearer to that of what is
    /// behind, or is missing), how many they overlook, and how much around them looks nearer than it
    /// is; with --ablation also without each ingredient. Images become grey
    #[arg(long, help_heading = "Reliability")]
    #[arg(conflicts_with_all = ["stress", "reliability", "reference", "limits"])]
    obstacles: bool,

    /// How to show the results
    #[arg(long, default_value = "text", help_heading = "Output")]
    #[arg(value_parser = super::choice(Format::NAMES))]
    format: String,

    /// Also write a JSON record for every scene and matcher, and the tables (scores.md, .csv and
    /// .json, or reliability, obstacles, ablation), into this folder
    #[arg(short, long, value_name = "DIR", help_heading = "Output")]
    out: Option<PathBuf>,

    /// Write left image, truth, disparities (turbo) and errors (KITTI's colours) there as well; with
    /// --obstacles also where these are seen (green) and missed (red), and what looks 1.5 px nearer
    /// than it is and more (yellow)
    #[arg(long, requires = "out", help_heading = "Output")]
    pictures: bool,

    /// Put an overview into a Markdown page, between its lines <!-- results --> and
    /// <!-- /results -->, with --speed between <!-- speed --> and <!-- /speed -->, with
    /// --ablation between <!-- ablation --> and <!-- /ablation -->, with --reliability between
    /// <!-- reliability --> and <!-- /reliability -->, with --obstacles between
    /// <!-- obstacles --> and <!-- /obstacles -->
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    into: Option<PathBuf>,
}

/// Chooses scenes and engines, runs them, shows the tables.
pub fn run(args: Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    let format: Format = args.format.parse().map_err(anyhow::Error::msg)?;
    if args.speed.speed {
        let page = args.into.map(|path| Page::open(path, "speed")).transpose()?;
        return args.speed.run(&args.scenes, &args.engines, format, page, ui);
    }
    let cases = match args.stress {
        true => {
            scenes::matching(rendered::stress(), |case| &case.id, args.scenes.scenes.as_deref())?
        }
        false if args.ablation => args.scenes.cases(&[Purpose::Tuning], ui)?,
        false => args.scenes.cases(&[Purpose::Test, Purpose::Tuning, Purpose::Rendered], ui)?,
    };
    for (asked, option) in [(args.reliability, "--reliability"), (args.obstacles, "--obstacles")] {
        if asked && !cases.iter().any(Case::has_truth) {
            bail!(
                "none of these scenes has truth, by which {option} tells what is wrong: choose others"
            );
        }
    }
    let cases = match args.obstacles {
        true => cases.into_iter().filter(Case::has_truth).map(obstacles::with_obstacles).collect(),
        false => cases,
    };
    let contest = Contest {
        cases,
        engines: match args.ablation {
            true => ablation::engines(&args.engines.presets()?)?,
            false => args.engines.definitions(&BESIDE, args.reference.as_deref())?,
        },
        reference: args.reference,
        limits: args.limits.as_deref().map(Limits::read).transpose()?,
        jobs: args.jobs,
    };
    let (view, marker) = if args.stress {
        (View::Strains, "results")
    } else if args.obstacles {
        (View::Obstacles, "obstacles")
    } else if args.ablation {
        (View::Ablation, "ablation")
    } else if args.reliability {
        (View::Reliability, "reliability")
    } else {
        (View::Scores, "results")
    };
    let page = args.into.map(|path| Page::open(path, marker)).transpose()?;
    let mut output = match args.out {
        Some(folder) => Output::in_folder(folder, view, args.pictures)?,
        None => Output::default(),
    };
    output.admit(&contest.cases)?;
    (output.view, output.format, output.page) = (view, format, page);
    contest.run(&args.engines, output, ui)
}
