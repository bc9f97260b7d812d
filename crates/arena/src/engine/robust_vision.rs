//! Programs of the Robust Vision Challenge: one process per pair,
//! `METHOD im0.png im1.png NDISP OUTDIR`, which writes `disp0METHOD.pfm` and `timeMETHOD.txt`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use formats::{Encoding, read_disparity, write_image};

use super::attempt::Attempt;
use super::exchange::{self, Answer, Pair};
use super::limits::Limits;
use super::process::{self, Exit};
use super::status::Status;
use super::talk::{self, Log, PATIENCE, Stream};
use super::usage::{Meter, Usage};

/// How often the limits are looked at.
const POLL: Duration = Duration::from_millis(5);

/// Runs the program on one pair. Everything of the process counts, its start included, since the
/// convention knows no other moment. Of one that ends before it is first looked at the memory is not known.
pub(crate) fn run(
    mut command: Command,
    scratch: &Path,
    pair: &Pair<'_>,
    limits: Limits,
) -> Attempt {
    let log = Log::default();
    let mut usage = Usage::default();
    let outcome = prepare(&mut command, scratch, pair)
        .and_then(|out| watch(command, scratch, limits, &log, &mut usage).map(|()| out))
        .and_then(|out| {
            let answer = read(&out, pair).map_err(|message| Status::BadResult { message })?;
            Ok((answer, claimed_seconds(&out)))
        });
    let outcome = outcome.and_then(|(answer, claimed)| {
        Status::past_claim(claimed, &usage).map_or(Ok((answer, claimed)), Err)
    });
    let (status, answer, claimed_seconds) = match outcome {
        Ok((answer, claimed)) => (Status::Done, Some(answer), claimed),
        Err(status) => (status, None, None),
    };
    Attempt { status, usage, answer, claimed_seconds, log: log.text() }
}

/// Writes the images, empties the folder for the answer, and completes the command.
fn prepare(command: &mut Command, scratch: &Path, pair: &Pair<'_>) -> Result<PathBuf, Status> {
    if pair.range.min() != 0 {
        let message = format!(
            "programs of the Robust Vision form search from 0; this pair asks from {}",
            pair.range.min()
        );
        return Err(Status::Failed { message });
    }
    let failed = |problem: String| Status::NotAsked { message: problem };
    let out = scratch.join("out");
    exchange::remove(&out).map_err(|error| failed(error.to_string()))?;
    fs::create_dir(&out)
        .map_err(|error| failed(format!("{} cannot be made: {error}", out.display())))?;
    for (name, image) in [("im0.png", pair.left), ("im1.png", pair.right)] {
        let path = scratch.join(name);
        exchange::remove(&path).map_err(|error| failed(error.to_string()))?;
        write_image(&path, image).map_err(|error| failed(error.to_string()))?;
        command.arg(path);
    }
    command.arg((i64::from(pair.range.max()) + 1).to_string()).arg(&out);
    Ok(out)
}

fn watch(
    mut command: Command,
    scratch: &Path,
    limits: Limits,
    log: &Log,
    usage: &mut Usage,
) -> Result<(), Status> {
    command.current_dir(scratch).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let started = Instant::now();
    let mut child =
        process::start(&mut command).map_err(|error| Status::not_started(&command, &error))?;
    let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
    let stdout_closed =
        stdout.map(|stdout| talk::listen_to_log(stdout, Stream::Output, log.clone()));
    let stderr_closed =
        stderr.map(|stderr| talk::listen_to_log(stderr, Stream::Error, log.clone()));
    let mut meter = Meter::from_birth(child.id(), started);
    let past_limit = loop {
        let exited = process::wait_for_exit(&mut child, POLL);
        *usage = meter.sample();
        let past_limit = Status::past_limit(usage, limits.wall, limits.cpu)
            .or_else(|| Status::idle(meter.idle(), limits.idle));
        if exited || past_limit.is_some() {
            break past_limit;
        }
    };
    let exit = process::kill_group(&mut child);
    let deadline = Instant::now() + PATIENCE;
    for closed in [stdout_closed, stderr_closed].into_iter().flatten() {
        let _ = closed.recv_timeout(deadline.saturating_duration_since(Instant::now()));
    }
    match (past_limit, exit) {
        (Some(status), _) => Err(status),
        (None, Some(exit)) if exit.success() => Ok(()),
        (None, exit) => {
            let how = exit.map_or("it ended".into(), |exit| Exit(exit).to_string());
            Err(Status::crashed(how, log))
        }
    }
}

/// The only file `prefix*suffix` of the folder.
fn only_file(out: &Path, prefix: &str, suffix: &str) -> Result<PathBuf, String> {
    let files: Vec<_> = fs::read_dir(out)
        .map_err(|error| format!("its output folder cannot be read: {error}"))?
        .flatten()
        .filter(|entry| {
            let name = entry.file_name();
            let name = name.to_string_lossy();
            name.starts_with(prefix)
                && name.ends_with(suffix)
                && entry.file_type().is_ok_and(|kind| kind.is_file())
        })
        .map(|entry| entry.path())
        .collect();
    match &files[..] {
        [file] => Ok(file.clone()),
        _ => {
            Err(format!("it wrote {} files {prefix}*{suffix}; exactly one is needed", files.len()))
        }
    }
}

fn read(out: &Path, pair: &Pair<'_>) -> Result<Answer, String> {
    let path = only_file(out, "disp0", ".pfm")?;
    let limit = (pair.left.columns() as u64 * pair.left.rows() as u64) * 4 + 4096;
    if fs::metadata(&path).is_ok_and(|found| found.len() > limit) {
        return Err(format!("{} has more than {limit} bytes", path.display()));
    }
    let mut disparity =
        read_disparity(&path, Encoding::Pfm).map_err(|error| error.to_string())?.values;
    if disparity.size() != pair.left.size() {
        return Err(format!(
            "its disparity map is {} x {}, but the left image is {} x {}",
            disparity.columns(),
            disparity.rows(),
            pair.left.columns(),
            pair.left.rows()
        ));
    }
    disparity.fill_around(pair.bounds, f32::NAN);
    Ok(Answer { disparity, reasons: None, confidence: None })
}

fn claimed_seconds(out: &Path) -> Option<f64> {
    let path = only_file(out, "time", ".txt").ok()?;
    let small = fs::metadata(&path).is_ok_and(|found| found.len() < 4096);
    let text = small.then(|| fs::read_to_string(&path).ok())??;
    let seconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    (seconds.is_finite() && seconds >= 0.0).then_some(seconds)
}
