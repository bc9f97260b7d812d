//! `hazcam engine`: a preset behind the engine protocol, so that it is measured like any other
//! program.

use std::io;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::Context;
use arena::engine::protocol::Job;
use arena::engine::{serve, write_answer};
use matching::{Ingredient, Matcher, Options, Preset};
use raster::{DisparityRange, Image};

use crate::arguments;
use crate::ui::Ui;

/// Serve a matcher over the engine protocol, on stdin and stdout
///
/// The benchmark and the grader start hazcam's own matchers with this command. Jobs name .npy
/// files; the protocol is described in PROTOCOL.md of the crate `hazcam-arena`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  hazcam engine --matcher fast < jobs.jsonl")]
pub struct Args {
    /// Which matcher
    #[arg(short, long, value_parser = super::choice(Preset::ALL.map(Preset::name)))]
    matcher: String,

    /// What to leave out of it, as `hazcam bench --ablation` does
    #[arg(long, value_name = "INGREDIENT", value_delimiter = ',')]
    without: Vec<Ingredient>,

    /// Threads to use, whatever the jobs allow [default: as many as the job allows]
    #[arg(long, value_name = "N", value_parser = arguments::threads)]
    #[arg(allow_negative_numbers = true)]
    threads: Option<usize>,
}

/// Answers jobs until stdin ends.
pub fn run(args: Args, _ui: &Ui) -> anyhow::Result<ExitCode> {
    let preset: Preset = args.matcher.parse()?;
    // Any range and number of threads: each job has its own.
    let mut options = Options::new(preset, DisparityRange::new(0, 0)?);
    options.without = args.without;
    options.check()?;
    let mut kept = None;
    serve(
        io::stdin().lock(),
        io::stdout().lock(),
        &format!("hazcam {preset}"),
        env!("CARGO_PKG_VERSION"),
        |job, left, right| {
            let threads = args.threads.unwrap_or(job.threads);
            answer(&mut kept, &options, threads, job, left, right)
        },
    )
    .context("the engine protocol was broken")?;
    Ok(ExitCode::SUCCESS)
}

/// A matcher for as long as jobs ask for the same range and threads: its memory is reused then.
type Kept = Option<(DisparityRange, usize, Matcher)>;

fn answer(
    kept: &mut Kept,
    options: &Options,
    threads: usize,
    job: &Job,
    left: &Image,
    right: &Image,
) -> Result<Duration, String> {
    let range = job.range().map_err(|error| error.to_string())?;
    let bounds = job.bounding_box().map_err(|error| error.to_string())?;
    if !matches!(kept, Some((known, count, _)) if *known == range && *count == threads) {
        let mut options = options.clone();
        (options.range, options.threads) = (range, threads);
        let matcher = Matcher::new(options).map_err(|error| error.to_string())?;
        *kept = Some((range, threads, matcher));
    }
    let (_, _, matcher) = kept.as_mut().expect("it has just been made");
    let started = Instant::now();
    let map = matcher.compute(left, right, Some(bounds)).map_err(|error| error.to_string())?;
    let took = started.elapsed();
    // As it lies in the matcher: a copy would be a good part of what a large frame takes.
    write_answer(job, &map.values, Some(&map.reasons), Some(&map.confidence))
        .map_err(|error| error.to_string())?;
    Ok(took)
}
