//! An engine at work: one process for many pairs, started again after a crash.

use std::io;

use super::attempt::Attempt;
use super::definition::{Definition, Kind};
use super::exchange::{self, Pair};
use super::launch::{self, Programs};
use super::limits::Limits;
use super::robust_vision;
use super::session::Session;
use super::status::Status;
use super::usage::Usage;
use crate::interrupt::Scratch;

/// Runs one engine on one pair after the other, in a scratch folder of its own.
#[derive(Debug)]
pub struct Worker {
    definition: Definition,
    programs: Programs,
    limits: Limits,
    threads: usize,
    // Before the folder: fields are dropped in this order, and the process lives in the folder.
    session: Option<Session>,
    scratch: Scratch,
    given_up: Option<Status>,
    version: Option<String>,
    startup: Option<Usage>,
    /// Jobs that the running process has been given.
    jobs: u64,
}

impl Worker {
    /// Prepares an engine; its process starts with the first pair. `threads` is how many threads
    /// it may use.
    ///
    /// Errors when no scratch folder can be made.
    pub fn new(
        definition: Definition,
        programs: Programs,
        limits: Limits,
        threads: usize,
    ) -> io::Result<Self> {
        let scratch = Scratch::new("hazcam-engine-")?;
        Ok(Self {
            definition,
            programs,
            limits,
            threads,
            session: None,
            scratch,
            given_up: None,
            version: None,
            startup: None,
            jobs: 0,
        })
    }

    /// What it runs.
    pub fn definition(&self) -> &Definition {
        &self.definition
    }

    /// How many threads it may use.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// The version that the engine states, once it has been ready.
    pub fn version(&self) -> Option<&str> {
        self.version.as_deref()
    }

    /// What the engine's last start used until it was ready; `None` before that, and for programs
    /// whose start is part of every pair.
    pub fn startup(&self) -> Option<Usage> {
        self.startup
    }

    /// Starts the process if it is not running, so that its absence shows before the first pair.
    pub fn start(&mut self) -> Result<(), Status> {
        match self.definition.kind {
            Kind::Protocol => self.session().map(|_| ()),
            Kind::RobustVision => self.command().map(|_| ()),
        }
    }

    /// Matches a pair. An engine that speaks the protocol and could not be started once is not tried again.
    pub fn run(&mut self, pair: &Pair<'_>) -> Attempt {
        match self.definition.kind {
            Kind::Protocol => self.run_protocol(pair),
            Kind::RobustVision => self.run_robust_vision(pair),
        }
    }

    /// Asks the process to end and waits for it, two seconds at most.
    pub fn end(mut self) {
        if let Some(session) = self.session.take() {
            session.end();
        }
    }

    fn command(&mut self) -> Result<std::process::Command, Status> {
        launch::command(&self.definition, &self.programs, self.scratch.path(), self.threads)
    }

    fn session(&mut self) -> Result<&mut Session, Status> {
        if let Some(status) = &self.given_up {
            return Err(status.clone());
        }
        if !self.session.as_ref().is_some_and(Session::is_alive) {
            self.session = None;
            let started = self
                .command()
                .and_then(|command| Session::start(command, self.scratch.path(), self.limits));
            let session = started.inspect_err(|status| {
                // What kept it from being asked may pass.
                if !matches!(status, Status::NotAsked { .. }) {
                    self.given_up = Some(status.clone());
                }
            })?;
            self.version = session.ready().version.clone();
            self.startup = Some(session.startup());
            self.jobs = 0;
            self.session = Some(session);
        }
        Ok(self.session.as_mut().expect("it has just been started"))
    }

    fn run_protocol(&mut self, pair: &Pair<'_>) -> Attempt {
        if let Err(status) = self.session() {
            return Attempt::without_answer(status, Usage::default());
        }
        self.jobs += 1;
        let written = exchange::write_job(self.scratch.path(), self.jobs, pair, self.threads);
        let ready = written
            .map_err(|error| Status::NotAsked { message: error.to_string() })
            .and_then(|job| Ok((job, self.session()?)));
        let (job, session) = match ready {
            Ok(ready) => ready,
            Err(status) => return Attempt::without_answer(status, Usage::default()),
        };
        let (status, usage) = session.run(&job);
        let claimed_seconds = session.claimed_seconds();
        let log = if session.is_alive() {
            session.log()
        } else {
            self.session.take().map_or_else(String::new, Session::last_words)
        };
        let answer = match status {
            Status::Done => exchange::read_answer(&job),
            other => return Attempt { log, ..Attempt::without_answer(other, usage) },
        };
        match answer {
            Ok(answer) => {
                Attempt { status: Status::Done, usage, answer: Some(answer), claimed_seconds, log }
            }
            Err(message) => {
                // It may be in any state; the next pair gets a new process.
                self.session = None;
                Attempt { log, ..Attempt::without_answer(Status::BadResult { message }, usage) }
            }
        }
    }

    fn run_robust_vision(&mut self, pair: &Pair<'_>) -> Attempt {
        let command = match self.command() {
            Ok(command) => command,
            Err(status) => return Attempt::without_answer(status, Usage::default()),
        };
        robust_vision::run(command, self.scratch.path(), pair, self.limits)
    }
}
