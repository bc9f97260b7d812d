//! The engine's side of the protocol, for engines written in Rust.

use std::io::{self, BufRead, Write};
use std::time::Duration;

use raster::Image;

use super::exchange::read_images;
use super::protocol::{self, FromEngine, Job, Ready, ToEngine};

/// Says that the engine is ready, then answers jobs until the input ends.
///
/// `matcher` gets the job and its images, writes its answer ([`write_answer`](super::write_answer)) and
/// returns the time that the matching alone took; what it returns as an error becomes the message of
/// `failed`. Errors when a line is no message, or when nobody listens any more.
pub fn serve(
    input: impl BufRead,
    mut output: impl Write,
    name: &str,
    version: &str,
    mut matcher: impl FnMut(&Job, &Image, &Image) -> Result<Duration, String>,
) -> io::Result<()> {
    let ready = Ready {
        protocol: protocol::VERSION,
        name: Some(name.into()),
        version: Some(version.into()),
    };
    say(&mut output, &FromEngine::Ready(ready))?;
    for line in input.lines() {
        let line = line?;
        let ToEngine::Job(job) = serde_json::from_str(&line)
            .map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
        let written = read_images(&job)
            .map_err(|error| error.to_string())
            .and_then(|(left, right)| matcher(&job, &left, &right));
        let message = match written {
            Ok(took) => FromEngine::Done { job: job.job, seconds: Some(took.as_secs_f64()) },
            Err(message) => FromEngine::Failed { job: job.job, message },
        };
        say(&mut output, &message)?;
    }
    Ok(())
}

fn say(output: &mut impl Write, message: &FromEngine) -> io::Result<()> {
    writeln!(output, "{}", serde_json::to_string(message)?)?;
    output.flush()
}

#[cfg(test)]
mod tests {
    use raster::{BoundingBox, DisparityRange, Plane};

    use super::super::exchange::{Pair, read_answer, write_answer, write_job};
    use super::*;

    #[test]
    fn jobs_are_answered_and_failures_told() {
        let scratch = tempfile::tempdir().unwrap();
        let image = Image::Grey8(Plane::filled(4, 3, 9));
        let pair = Pair {
            left: &image,
            right: &image,
            bounds: BoundingBox::whole(4, 3),
            range: DisparityRange::new(0, 2).unwrap(),
        };
        let job = write_job(scratch.path(), 1, &pair, 1).unwrap();
        let line = |job: &Job| serde_json::to_string(&ToEngine::Job(job.clone())).unwrap();
        let input = format!("{}\n{}\n", line(&job), line(&Job { job: 2, ..job.clone() }));
        let mut output = Vec::new();
        serve(input.as_bytes(), &mut output, "test", "1", |job, left, _| match job.job {
            1 => {
                let disparity = Plane::filled(left.columns(), left.rows(), 1.0);
                write_answer(job, &disparity, None, None).unwrap();
                Ok(Duration::from_millis(250))
            }
            _ => Err("no more".into()),
        })
        .unwrap();
        let said: Vec<FromEngine> = String::from_utf8(output)
            .unwrap()
            .lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect();
        assert!(matches!(&said[0], FromEngine::Ready(ready) if ready.protocol == 1));
        assert_eq!(said[1], FromEngine::Done { job: 1, seconds: Some(0.25) });
        assert_eq!(said[2], FromEngine::Failed { job: 2, message: "no more".into() });
        assert_eq!(read_answer(&job).unwrap().disparity.samples()[0], 1.0);
    }
}
