//! Writes what `choice.py` learns from: candidates of pixels of many pairs, with all that `best` knows
//! of them when the judges that it has so far have spoken, and the truth.
//!
//! ```text
//! cargo run --release -p hazcam-training -- --out target/choices.bin
//! ```
//!
//! Pairs: the tuning scenes of `$HAZCAM_DATA`, and rendered scenes whose seeds no measurement uses.

mod lessons;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use arena::dataset::{self, CaseData, Purpose};
use clap::Parser;
use formats::write_atomically;
use scenes::{Kind, Random, Settings};

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
/// Keeps this program's chances apart from those of the scenes.
const PURPOSE: &str = "training";

/// A rendered pair, under circumstances that come by chance.
fn rendered(kind: Kind, seed: u64, random: &mut Random) -> Result<CaseData, Box<dyn Error>> {
    let mut settings = Settings::new(kind, seed);
    settings.noise = random.pick(&[0.5, 1.0, 2.0, 5.0]);
    settings.contrast = random.between(0.2, 1.0);
    settings.right_exposure = random.between(0.8, 1.2);
    settings.max_disparity = random.pick(&[32, 64, 64, 100]);
    let scene = scenes::render(&settings)?;
    let mut data = CaseData::new(scene.left, scene.right, scene.range);
    data.truth = Some(scene.truth_left);
    Ok(data)
}

fn write(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let mut samples = Vec::new();
    let mut add = |name: &str, data: &CaseData, pixels: usize, random: Random| {
        let lesson = lessons::lesson(data, pixels, random)?;
        println!("{name}: {} pixels", lesson.len() / lessons::NUMBERS);
        samples.extend(lesson);
        Ok::<_, Box<dyn Error>>(())
    };
    let cases = dataset::open(&arguments.data)?;
    let cases = cases.iter().filter(|case| case.purpose == Purpose::Tuning);
    for (seed, case) in (1..).zip(cases) {
        if arguments.without.iter().any(|part| case.id.contains(part)) {
            continue;
        }
        // The views of the moon are much alike.
        let pixels = arguments.pixels / if case.family() == "lunar" { 4 } else { 1 };
        add(&case.id, &case.load()?, pixels, Random::new(seed, PURPOSE))?;
    }
    for kind in Kind::NAMED {
        for seed in FIRST_SEED..FIRST_SEED + arguments.rendered {
            let mut random = Random::new(seed, PURPOSE);
            let data = rendered(kind, seed, &mut random)?;
            add(&format!("{kind} {seed}"), &data, arguments.pixels / 4, random)?;
        }
    }
    write_atomically(&arguments.out, |writer| {
        samples.iter().try_for_each(|number| writer.write_all(&number.to_le_bytes()))
    })?;
    let pixels = samples.len() / lessons::NUMBERS;
    println!("{pixels} pixels; {} written", arguments.out.display());
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
