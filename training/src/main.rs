//! Writes what `choice.py` learns from: candidates of pixels of many pairs, with all that `best` knows
//! of them when the judges that it has so far have spoken, and the truth.
//!
//! ```text
//! cargo run --release -p hazcam-training -- --out target/choices.bin
//! ```
//!
//! Pairs: the tuning scenes of `$HAZCAM_DATA`, and rendered scenes whose seeds no measurement uses.

mod lessons;
mod random;

use std::error::Error;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use arena::dataset::{self, CaseData, Purpose};
use clap::Parser;
use scenes::{Kind, Settings};

use crate::random::Random;

/// Writes what `choice.py` learns from.
#[derive(Parser)]
struct Arguments {
    /// The folder with `scenes.json`.
    #[arg(long, env = "HAZCAM_DATA")]
    data: PathBuf,
    /// Tuning scenes to leave out: parts of their names.
    #[arg(long, num_args = 0..)]
    without: Vec<String>,
    /// About how many pixels of a pair.
    #[arg(long, default_value_t = 9000)]
    pixels: usize,
    /// Rendered scenes of each kind.
    #[arg(long, default_value_t = 4)]
    rendered: u64,
    /// Where the samples go.
    #[arg(long)]
    out: PathBuf,
}

/// Rendered scenes with smaller seeds are for measurements.
const FIRST_SEED: u64 = 1000;

/// A rendered pair, under the circumstances that its seed gives it.
fn rendered(kind: Kind, seed: u64) -> Result<CaseData, Box<dyn Error>> {
    let mut random = Random::new(seed);
    let mut settings = Settings::new(kind, seed);
    settings.noise = [0.5, 1.0, 2.0, 5.0][random.below(4)];
    settings.contrast = 0.2 + 0.8 * f64::from(random.unit());
    settings.right_exposure = 0.8 + 0.4 * f64::from(random.unit());
    settings.max_disparity = [32, 64, 64, 100][random.below(4)];
    let scene = scenes::render(&settings)?;
    let mut data = CaseData::new(scene.left, scene.right, scene.range);
    data.truth = Some(scene.truth_left);
    Ok(data)
}

fn write(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let part = arguments.out.with_extension("part");
    let mut out = BufWriter::new(File::create(&part)?);
    let mut all = 0;
    let mut add = |name: &str, data: &CaseData, pixels: usize, seed: u64| {
        let lesson = lessons::lesson(data, pixels, seed)?;
        all += lesson.len() / lessons::NUMBERS;
        lesson.iter().try_for_each(|number| out.write_all(&number.to_le_bytes()))?;
        println!("{name}: {} pixels", lesson.len() / lessons::NUMBERS);
        Ok::<_, Box<dyn Error>>(())
    };
    let cases = dataset::open(&arguments.data)?;
    let cases = cases.iter().filter(|case| case.purpose == Purpose::Tuning);
    for (seed, case) in (1..).zip(cases) {
        if arguments.without.iter().any(|part| case.id.contains(part)) {
            continue;
        }
        let data = case.load()?;
        // The views of the moon are much alike.
        let pixels = arguments.pixels / if case.family() == "lunar" { 4 } else { 1 };
        add(&case.id, &data, pixels, seed)?;
    }
    for kind in Kind::NAMED {
        for seed in FIRST_SEED..FIRST_SEED + arguments.rendered {
            add(&format!("{kind} {seed}"), &rendered(kind, seed)?, arguments.pixels / 4, seed)?;
        }
    }
    out.flush()?;
    fs::rename(&part, &arguments.out)?;
    println!("{all} pixels; {} written", arguments.out.display());
    Ok(())
}

fn main() -> ExitCode {
    match write(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("choices: {error}");
            ExitCode::FAILURE
        }
    }
}
