//! One engine process from its start to its end.

use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError};
use std::time::{Duration, Instant};

use super::limits::Limits;
use super::process::{self, Exit};
use super::protocol::{self, FromEngine, Job, Ready, ToEngine};
use super::status::Status;
use super::talk::{self, Heard, Log, PATIENCE, Stream};
use super::usage::{Meter, Usage};

/// How often the limits are looked at while an engine works.
const POLL: Duration = Duration::from_millis(25);
/// How long an engine may take to exit once its standard input is closed.
const FAREWELL: Duration = Duration::from_secs(2);

/// An engine that is ready for jobs. Dropping it kills the process and its whole group.
#[derive(Debug)]
pub struct Session {
    child: Child,
    /// Lines for its standard input, which closes when this goes.
    told: Option<Sender<String>>,
    /// Whether it has closed that itself.
    deaf: Arc<AtomicBool>,
    heard: Receiver<Heard>,
    stderr_closed: Receiver<()>,
    log: Log,
    ready: Ready,
    startup: Usage,
    claimed_seconds: Option<f64>,
    limits: Limits,
    exited: bool,
}

impl Session {
    /// Starts `command` in the folder `scratch` and waits until it is ready.
    ///
    /// The command's standard streams, working folder and process group are set here; program,
    /// arguments and environment are the caller's. On failure the status says why ([`Status::Absent`]
    /// or [`Status::NotReady`]) and nothing is left running.
    pub fn start(mut command: Command, scratch: &Path, limits: Limits) -> Result<Self, Status> {
        command
            .current_dir(scratch)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let started = Instant::now();
        let mut child =
            process::start(&mut command).map_err(|error| Status::not_started(&command, &error))?;
        let log = Log::default();
        let (stdin, stdout, stderr) =
            (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(stdin), Some(stdout), Some(stderr)) = (stdin, stdout, stderr) else {
            unreachable!("all streams were asked for as pipes")
        };
        let (told, deaf) = talk::tell(stdin);
        let mut session = Self {
            stderr_closed: talk::listen_to_log(stderr, Stream::Error, log.clone()),
            heard: talk::listen(stdout, log.clone()),
            ready: Ready::default(),
            startup: Usage::default(),
            claimed_seconds: None,
            exited: false,
            child,
            told: Some(told),
            deaf,
            log,
            limits,
        };
        let mut meter = Meter::from_birth(session.child.id(), started);
        let message = session
            .wait_for_message(&mut meter, session.limits.start, None)
            .map_err(Status::before_ready)?;
        session.startup = meter.sample();
        match message {
            FromEngine::Ready(ready) if ready.protocol == protocol::VERSION => {
                session.ready = ready;
                Ok(session)
            }
            FromEngine::Ready(ready) => Err(Status::NotReady {
                message: format!(
                    "it speaks version {} of the engine protocol, but this arena speaks {}",
                    ready.protocol,
                    protocol::VERSION
                ),
            }),
            FromEngine::Absent { message } => Err(Status::Absent { message }),
            FromEngine::Done { .. } | FromEngine::Failed { .. } => Err(Status::NotReady {
                message: "it answered a job before it said that it is ready".into(),
            }),
        }
    }

    /// How the engine introduced itself.
    pub fn ready(&self) -> &Ready {
        &self.ready
    }

    /// What it used until it was ready.
    pub fn startup(&self) -> Usage {
        self.startup
    }

    /// How long its last answer says that the matching alone took, in seconds.
    pub fn claimed_seconds(&self) -> Option<f64> {
        self.claimed_seconds
    }

    /// What the engine said besides messages, on each of its streams the last 16 KiB, errors last. While it
    /// lives, what it said in the last moment may still be on its way.
    pub fn log(&self) -> String {
        self.log.text()
    }

    /// Kills what is left, and returns all that the engine said besides messages, as [`Session::log`].
    pub fn last_words(mut self) -> String {
        self.kill();
        // Both streams end with the process, unless a child of it holds them open elsewhere.
        let deadline = Instant::now() + PATIENCE;
        let left = || deadline.saturating_duration_since(Instant::now());
        while !left().is_zero() {
            if let Ok(Heard::Closed) | Err(_) = self.heard.recv_timeout(left()) {
                break;
            }
        }
        let _ = self.stderr_closed.recv_timeout(left());
        self.log()
    }

    /// Whether the next job can be sent. After a crash, a timeout or a protocol error it cannot.
    pub fn is_alive(&self) -> bool {
        !self.exited
    }

    /// Sends a job and waits for its answer, at most as long as the limits allow.
    ///
    /// [`Status::Done`] says only that the engine claims to have written its answer; reading and
    /// checking the files is the caller's next step. After [`Status::Done`] and
    /// [`Status::Failed`] the engine takes the next job; after anything else it has been killed.
    pub fn run(&mut self, job: &Job) -> (Status, Usage) {
        if self.exited {
            let message = "the engine has ended; start a new session".into();
            return (Status::Crashed { message }, Usage::default());
        }
        let mut meter = Meter::from_now(self.child.id());
        let answer = self.exchange(job, &mut meter);
        let usage = meter.sample();
        let status = match answer {
            // An answer that came between two looks at the clock may still have come too late.
            Ok(status) => Status::past_claim(self.claimed_seconds, &usage)
                .or_else(|| Status::past_limit(&usage, self.limits.wall, self.limits.cpu))
                .unwrap_or(status),
            Err(status) => status,
        };
        if !status.leaves_engine_ready() {
            self.kill();
        }
        (status, usage)
    }

    fn exchange(&mut self, job: &Job, meter: &mut Meter) -> Result<Status, Status> {
        self.claimed_seconds = None;
        loop {
            match self.heard.try_recv() {
                Ok(Heard::Behind(_)) => {}
                Err(TryRecvError::Empty) => break,
                Ok(Heard::Message(_) | Heard::Broken(_)) => {
                    let message = "it sent a message before it was asked for anything".into();
                    return Err(Status::ProtocolError { message });
                }
                Ok(Heard::Closed) | Err(TryRecvError::Disconnected) => {
                    return Err(self.crashed(meter));
                }
            }
        }
        self.send(&ToEngine::Job(job.clone()), meter)?;
        let message = self.wait_for_message(meter, self.limits.wall, self.limits.cpu)?;
        Err(Status::ProtocolError {
            message: match message {
                FromEngine::Done { job: number, seconds } if number == job.job => match seconds {
                    Some(seconds) if seconds < 0.0 => {
                        format!(
                            "it says that matching took {seconds} s, which must not be negative"
                        )
                    }
                    _ => {
                        self.claimed_seconds = seconds;
                        return Ok(Status::Done);
                    }
                },
                FromEngine::Failed { job: number, message } if number == job.job => {
                    return Ok(Status::Failed { message });
                }
                FromEngine::Done { job: number, .. } | FromEngine::Failed { job: number, .. } => {
                    format!("it answered job {number} when job {} was asked for", job.job)
                }
                FromEngine::Ready(_) => "it said `ready` a second time".into(),
                FromEngine::Absent { .. } => "it said `absent` after it had said `ready`".into(),
            },
        })
    }

    fn send(&mut self, message: &ToEngine, meter: &mut Meter) -> Result<(), Status> {
        let mut line = serde_json::to_string(message).map_err(|error| Status::NotAsked {
            message: format!("the job cannot be put into a message: {error}"),
        })?;
        line.push('\n');
        if line.len() > protocol::LINE_LIMIT {
            let message = format!(
                "the job's message has {} bytes, but {} are allowed: use a scratch folder with a \
                 shorter path",
                line.len(),
                protocol::LINE_LIMIT
            );
            return Err(Status::NotAsked { message });
        }
        let sent = self.told.as_ref().is_some_and(|told| told.send(line).is_ok());
        if sent { Ok(()) } else { Err(self.crashed(meter)) }
    }

    /// The next message, or the status that ends the wait.
    fn wait_for_message(
        &mut self,
        meter: &mut Meter,
        wall: Duration,
        cpu: Option<Duration>,
    ) -> Result<FromEngine, Status> {
        let (mut last_look, mut behind) = (false, None);
        loop {
            match self.heard.recv_timeout(if last_look { PATIENCE } else { POLL }) {
                Ok(Heard::Message(message)) => return Ok(message),
                Ok(Heard::Broken(why)) => {
                    let message = format!("it sent a message that cannot be understood: {why}");
                    return Err(Status::ProtocolError { message });
                }
                Ok(Heard::Behind(before)) => behind = Some(before),
                Ok(Heard::Closed) | Err(RecvTimeoutError::Disconnected) => {
                    return Err(self.crashed(meter));
                }
                // The process is gone, and what it said before its end has been heard by now; but
                // a child of it may hold its standard output open.
                Err(RecvTimeoutError::Timeout) if last_look => return Err(self.crashed(meter)),
                Err(RecvTimeoutError::Timeout) => {}
            }
            let usage = meter.sample();
            let past_limit = Status::past_limit(&usage, wall, cpu);
            if let Some(status) =
                past_limit.or_else(|| Status::idle(meter.idle(), self.limits.idle))
            {
                return Err(status);
            }
            // Who logs messages goes on; who meant one waits for the next job.
            if let Some(before) = behind.as_ref().filter(|_| meter.idle() > Some(PATIENCE)) {
                return Err(Status::ProtocolError {
                    message: format!(
                        "a message is a line of its own, but `{before}` stands before one, and none came after it: end \
                         what is printed with a newline"
                    ),
                });
            }
            if self.deaf.load(Ordering::Relaxed) {
                return Err(self.crashed(meter));
            }
            last_look = process::has_exited(&mut self.child);
        }
    }

    /// The status of a process that went without an answer.
    fn crashed(&mut self, meter: &mut Meter) -> Status {
        let exited = process::wait_for_exit(&mut self.child, PATIENCE);
        meter.sample();
        let how = match self.kill() {
            Some(status) if exited => Exit(status).to_string(),
            _ => "it closed its standard input or output without an answer".into(),
        };
        // Its last words may still be on their way through the pipe.
        let _ = self.stderr_closed.recv_timeout(PATIENCE);
        Status::crashed(how, &self.log)
    }

    /// Asks the engine to end, waits two seconds for it, and kills what is left.
    pub fn end(mut self) {
        self.told = None;
        process::wait_for_exit(&mut self.child, FAREWELL);
    }

    /// Kills what is left; the status is that of the process, if it had ended by itself, its own.
    fn kill(&mut self) -> Option<ExitStatus> {
        if self.exited {
            return None;
        }
        self.exited = true;
        self.told = None;
        process::kill_group(&mut self.child)
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.kill();
    }
}
