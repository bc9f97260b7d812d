//! Writes what `choice.py` learns from: candidates of pixels of many pairs, with all that a
//! preset knows of them when the judges that it has so far have spoken, and the truth.
//!
//! ```text
//! cargo run --release -p hazcam-training -- --preset best --out target/choices.bin
//! ```
//!
//! Pairs: the tuning scenes of `$HAZCAM_DATA` as they are, their twins as other cameras would have seen them
//! (in a mirror, upside down, from farther away), strained (light, noise, vertical offset), and rendered scenes
//! whose seeds no measurement uses.

mod lessons;
mod strain;
mod twin;

use std::error::Error;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use arena::dataset::{self, Case, CaseData, Purpose};
use clap::Parser;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use formats::write_atomically;
use matching::Preset;
use scenes::{Kind, Random, Settings};
use strain::Strain;
use twin::Twin;

/// Writes what `choice.py` learns from.
#[derive(Parser)]
struct Arguments {
    /// Whose judge is to learn.
    #[arg(long, value_parser = PossibleValuesParser::new(JUDGED).try_map(|name| name.parse::<Preset>()))]
    preset: Preset,
    /// The folder with `scenes.json`.
    #[arg(long, env = "HAZCAM_DATA")]
    data: PathBuf,
    /// Tuning scenes to leave out: parts of their names.
    #[arg(long, num_args = 0..)]
    without: Vec<String>,
    /// Of the tuning scenes one half alone, 1 or 2; those that differ by a suffix after - or _ are in
    /// one half. Rendered scenes belong to the first.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=2))]
    half: Option<u8>,
    /// About how many pixels of a pair; as many of its mirror image, half as many of each other twin, twice
    /// as many of all these where there is no mirror image; a quarter of a strained or rendered pair.
    #[arg(long, default_value_t = 18000)]
    pixels: usize,
    /// How often each tuning scene is strained.
    #[arg(long, default_value_t = 2)]
    strained: u64,
    /// Rendered scenes of each kind.
    #[arg(long, default_value_t = 8)]
    rendered: u64,
    /// Where the samples go.
    #[arg(long)]
    out: PathBuf,
}

/// Presets that have judges.
const JUDGED: [&str; 2] = ["balanced", "best"];
/// Rendered scenes with smaller seeds are for measurements.
const FIRST_SEED: u64 = 1000;
/// Keeps this program's chances apart from those of the scenes.
const PURPOSE: &str = "training";

type Failure = Box<dyn Error + Send + Sync>;

/// A rendered pair, under circumstances that come by chance.
fn rendered(kind: Kind, seed: u64, random: &mut Random) -> Result<CaseData, Failure> {
    let mut settings = Settings::new(kind, seed);
    settings.noise = random.pick(&[0.5, 1.0, 2.0, 5.0, 20.0]);
    settings.vertical_offset = random.pick(&[0.0, 0.0, 0.5, 1.0, 2.0]);
    settings.contrast = random.between(0.2, 1.0);
    settings.exposure = random.pick(&[1.0, 1.0, 1.0, 4.0, 16.0]);
    settings.right_exposure = random.between(0.8, 1.2);
    settings.max_disparity = random.pick(&[32, 64, 64, 100]);
    let scene = scenes::render(&settings)?;
    let mut data = CaseData::new(scene.left, scene.right, scene.range);
    data.truth = Some(scene.truth_left);
    Ok(data)
}

/// Errors where a part of a name is not that of a tuning scene: a scene would be learned from in silence.
fn check(without: &[String], cases: &[&Case]) -> Result<(), Failure> {
    let is_known = |part: &&String| cases.iter().any(|case| case.id.contains(*part));
    match without.iter().find(|part| !is_known(part)) {
        None => Ok(()),
        Some(part) => {
            let all: Vec<_> = cases.iter().map(|case| case.id.as_str()).collect();
            let all = all.join(", ");
            Err(format!("--without: no tuning scene has {part:?} in its name; {all}").into())
        }
    }
}

/// Which half each scene belongs to: every second one that is of something else than those before it.
fn halves(ids: &[&str]) -> Vec<u8> {
    let mut known = Vec::new();
    let half = |id: &&str| {
        // Of `middlebury2005/Art-half` or `lunar/nadir_1` all before the suffix.
        let name = id.rfind('/').map_or(0, |slash| slash + 1);
        let end = name + id[name..].find(['-', '_']).unwrap_or(id.len() - name);
        let what = id[..end].to_owned();
        let place = known.iter().position(|other| *other == what).unwrap_or_else(|| {
            known.push(what);
            known.len() - 1
        });
        1 + (place % 2) as u8
    };
    ids.iter().map(half).collect()
}

/// Writes the samples, lesson after lesson; how many pixels they are.
fn write(arguments: &Arguments, cases: &[&Case], out: &mut dyn Write) -> Result<usize, Failure> {
    let mut all = 0;
    let mut add = |name: &str, data: &CaseData, pixels: usize, random: Random| {
        let lesson = lessons::lesson(arguments.preset, data, pixels, random)?;
        let mut numbers = lesson.iter().flatten();
        numbers.try_for_each(|number| out.write_all(&number.to_le_bytes()))?;
        all += lesson.len();
        println!("{name}: {} pixels", lesson.len());
        Ok::<_, Failure>(())
    };
    let is_asked = |half: u8| arguments.half.is_none_or(|asked| asked == half);
    let ids: Vec<_> = cases.iter().map(|case| case.id.as_str()).collect();
    for ((seed, case), half) in (1..).zip(cases).zip(halves(&ids)) {
        if !is_asked(half) || arguments.without.iter().any(|part| case.id.contains(part)) {
            continue;
        }
        // The views of the moon are much alike.
        let pixels = arguments.pixels / if case.family() == "lunar" { 4 } else { 1 };
        let (data, mut random) = (case.load()?, Random::new(seed, PURPOSE));
        for Twin { name, data, worth } in twin::family(case, &data, &mut random.clone())? {
            add(&name, &data, (pixels as f64 * worth) as usize, random.clone())?;
        }
        for _ in 0..arguments.strained {
            let strain = Strain::by_chance(&mut random);
            let images = strain.apply(&data.left, &data.right, &mut random);
            let mut strained = data.clone();
            [strained.left, strained.right] = images;
            add(&format!("{} {strain:?}", case.id), &strained, pixels / 4, random.clone())?;
        }
    }
    for kind in Kind::NAMED.into_iter().filter(|_| is_asked(1)) {
        for seed in FIRST_SEED..FIRST_SEED + arguments.rendered {
            let mut random = Random::new(seed, PURPOSE);
            let data = rendered(kind, seed, &mut random)?;
            add(&format!("{kind} {seed}"), &data, arguments.pixels / 4, random)?;
        }
    }
    if all == 0 {
        return Err("no pixel is left to learn from: leave out fewer scenes".into());
    }
    Ok(all)
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    let cases = dataset::open(&arguments.data)?;
    let (cases, without): (Vec<_>, Vec<_>) = cases
        .iter()
        .filter(|case| case.purpose == Purpose::Tuning)
        .partition(|case| case.has_truth());
    if !without.is_empty() {
        println!("{} tuning scenes have no truth to learn from", without.len());
    }
    check(&arguments.without, &cases)?;
    let (mut pixels, mut failure) = (0, None);
    // The file is begun first, so that a folder that is missing is noticed at once.
    let written = write_atomically(&arguments.out, |writer| {
        pixels = write(arguments, &cases, writer).map_err(|error| match error.downcast() {
            Ok(error) => *error,
            // What is no failure to write must not be told as one.
            Err(other) => io::Error::other(failure.insert(other).to_string()),
        })?;
        Ok(())
    });
    failure.map_or(Ok(()), Err)?;
    written?;
    println!("{pixels} pixels; {} written", arguments.out.display());
    Ok(())
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("hazcam-training: {error}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_scene_in_two_sizes_is_in_one_half() {
        let ids = ["a/Art", "a/Books", "a/Dolls", "a/Art-half", "b_c/Books", "b_c/Dolls_1"];
        assert_eq!(halves(&ids), [1, 2, 1, 1, 2, 1]);
    }
}
