//! One engine process in a sandbox with folders of its own, from its start to its end.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::engine::protocol::Job;
use crate::engine::{self, Session, Status, THREAD_VARIABLES, Usage};
use crate::interrupt::Scratch;
use crate::sandbox::{self, Excess, Policy, Watch};

/// What an entrant may use, besides CPU time, which each test sets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowance {
    /// Wall time until it is ready: imports belong here.
    pub start: Duration,
    /// Address space in bytes.
    pub memory_bytes: u64,
    /// Bytes that it may write, in total and to one file.
    pub disk_bytes: u64,
}

impl Default for Allowance {
    /// A minute to start, 4 GiB of memory, 256 MiB of files.
    fn default() -> Self {
        Self { start: Duration::from_secs(60), memory_bytes: 4 << 30, disk_bytes: 256 << 20 }
    }
}

/// So long may an entrant compute nothing: one that sleeps would else hold up a class for three times what it may
/// compute.
const IDLE: Duration = Duration::from_secs(60);

/// How entrants are run.
#[derive(Debug, Clone)]
pub struct Confinement {
    /// A binary with the command `sandbox-exec`; `None` runs entrants without a sandbox.
    pub helper: Option<PathBuf>,
    /// What they may use.
    pub allowance: Allowance,
}

/// The folders of one run. They are removed with everything in them when it is dropped.
///
/// ```text
/// root/pid      the process number, for the watch; out of the entrant's reach
/// root/home     working folder, home and place for temporary files; a submission's files are here
/// root/hidden   the images until the entrant is ready; out of its reach
/// root/job      images in, answer out
/// ```
#[derive(Debug)]
pub(super) struct Workplace {
    root: Scratch,
}

impl Workplace {
    pub fn new() -> io::Result<Self> {
        let root = Scratch::new("hazcam-grade-")?;
        let this = Self { root };
        for folder in [this.home(), this.hidden(), this.job()] {
            fs::create_dir(folder)?;
        }
        Ok(this)
    }

    pub fn home(&self) -> PathBuf {
        self.root.path().join("home")
    }

    pub fn job(&self) -> PathBuf {
        self.root.path().join("job")
    }

    pub fn hidden(&self) -> PathBuf {
        self.root.path().join("hidden")
    }

    /// The job in the folder that the entrant reaches, instead of the hidden one.
    pub fn shown(&self, hidden: &Job) -> Job {
        let moved = |path: &Path| self.job().join(path.file_name().unwrap_or_default());
        Job {
            left: moved(&hidden.left),
            right: moved(&hidden.right),
            disparity: moved(&hidden.disparity),
            reasons: moved(&hidden.reasons),
            confidence: moved(&hidden.confidence),
            ..hidden.clone()
        }
    }

    /// Moves the images of a hidden job to where the entrant reaches them. Fails when the entrant
    /// made a folder of their name there.
    pub fn show(&self, hidden: &Job, shown: &Job) -> io::Result<()> {
        fs::rename(&hidden.left, &shown.left)?;
        fs::rename(&hidden.right, &shown.right)
    }

    fn pid_file(&self) -> PathBuf {
        self.root.path().join("pid")
    }
}

/// An engine process, ready for its job.
pub(super) struct Confined {
    session: Session,
    watch: Watch,
}

/// What came of it.
pub(super) struct Ended {
    pub status: Status,
    pub usage: Usage,
    pub startup: Usage,
    /// What was said besides messages.
    pub log: String,
    /// What it was killed for by the watch.
    pub excess: Option<Excess>,
}

impl Ended {
    fn before_any_start(status: Status) -> Self {
        let (usage, startup) = (Usage::default(), Usage::default());
        Self { status, usage, startup, log: String::new(), excess: None }
    }
}

impl Confinement {
    /// Starts `command`, which may read `readable` besides its own folders and the system's.
    pub(super) fn start(
        &self,
        command: Command,
        readable: &[PathBuf],
        place: &Workplace,
        cpu: Duration,
    ) -> Result<Confined, Box<Ended>> {
        let command = match self.prepare(command, readable, place, cpu) {
            Ok(command) => command,
            Err(status) => return Err(Box::new(Ended::before_any_start(status))),
        };
        let watch = self.watch(place);
        match Session::start(command, &place.home(), self.limits(cpu)) {
            Ok(session) => Ok(Confined { session, watch }),
            Err(status) => {
                let excess = watch.stop();
                Err(Box::new(Ended { excess, ..Ended::before_any_start(status) }))
            }
        }
    }

    /// Watches over what is about to be started in these folders.
    pub(super) fn watch(&self, place: &Workplace) -> Watch {
        Watch::start(place.pid_file(), place.root.path().into(), self.allowance.disk_bytes)
    }

    /// The command with its environment, in the sandbox if there is to be one.
    pub(super) fn prepare(
        &self,
        command: Command,
        readable: &[PathBuf],
        place: &Workplace,
        cpu: Duration,
    ) -> Result<Command, Status> {
        let mut command = with_environment(command, &place.home());
        let Some(helper) = &self.helper else { return Ok(command) };
        // By this the runner of submissions knows that it may forbid itself more.
        command.env("HAZCAM_SANDBOX", "1");
        sandbox::confine(&command, &self.policy(readable, place, cpu), helper)
            .map_err(|error| Status::not_started(&command, &error))
    }

    /// The limits of time.
    pub(super) fn limits(&self, cpu: Duration) -> engine::Limits {
        let wall = cpu * 3 + Duration::from_secs(10);
        engine::Limits { start: self.allowance.start, wall, cpu: Some(cpu), idle: Some(IDLE) }
    }

    /// What an entrant with these folders may touch.
    pub(super) fn policy(&self, readable: &[PathBuf], place: &Workplace, cpu: Duration) -> Policy {
        Policy {
            readable: readable.to_vec(),
            writable: vec![place.home(), place.job()],
            limits: sandbox::Limits {
                // A second line of defence: imports, and one second for the first line to act.
                cpu_seconds: (self.allowance.start + cpu).as_secs_f64().ceil() as u64 + 1,
                memory_bytes: self.allowance.memory_bytes,
                file_bytes: self.allowance.disk_bytes,
                ..sandbox::Limits::default()
            },
            token: sandbox::token().into(),
            pid_file: place.pid_file(),
        }
    }
}

impl Confined {
    /// The name that the engine gave itself.
    pub fn name(&self) -> Option<&str> {
        self.session.ready().name.as_deref()
    }

    /// Runs one job and ends the process, so that nothing changes its answer afterwards.
    pub fn finish(mut self, job: &Job) -> Ended {
        let (status, usage) = self.session.run(job);
        let (startup, log) = (self.session.startup(), self.session.last_words());
        Ended { status, usage, startup, log, excess: self.watch.stop() }
    }
}

/// The same command in an environment of its own: nothing inherited, one thread for every library
/// that has its own idea, a home that it may write to, no window to draw in. What was set on the
/// command stays.
fn with_environment(mut command: Command, home: &Path) -> Command {
    let own: Vec<(OsString, OsString)> = command
        .get_envs()
        .filter_map(|(name, value)| Some((name.to_owned(), value?.to_owned())))
        .collect();
    command.env_clear().env("PATH", "/usr/local/bin:/usr/bin:/bin").env("LANG", "C.UTF-8");
    for variable in ["HOME", "TMPDIR", "MPLCONFIGDIR", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR"] {
        command.env(variable, home);
    }
    for variable in THREAD_VARIABLES {
        command.env(variable, "1");
    }
    command.env("MPLBACKEND", "Agg").env("PYTHONHASHSEED", "0").envs(own);
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_inherited_and_what_was_set_stays() {
        let mut command = Command::new("/usr/bin/env");
        command.env("OMP_NUM_THREADS", "7").env("MINE", "1");
        let command = with_environment(command, Path::new("/home/of/entrant"));
        let confinement = Confinement { helper: None, allowance: Allowance::default() };
        assert_eq!(confinement.limits(Duration::from_secs(2)).wall, Duration::from_secs(16));
        let set = |name: &str| {
            command.get_envs().find(|(n, _)| *n == name).and_then(|(_, v)| v).unwrap().to_owned()
        };
        assert_eq!((set("OMP_NUM_THREADS"), set("MINE")), ("7".into(), "1".into()));
        assert_eq!(set("HOME"), "/home/of/entrant");
        #[cfg(unix)]
        {
            let output = { command }.output().unwrap();
            let text = String::from_utf8(output.stdout).unwrap();
            assert!(text.contains("MINE=1") && !text.contains("CARGO"), "{text}");
        }
    }
}
