//! How a job ended.

use std::fmt;
use std::io;
use std::process::Command;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::talk::Log;
use super::usage::Usage;

// Grading reads these messages to judge an end. They may close with words of the process's own, so
// only what stands before such words can be trusted.

/// What begins the message about a process that was started and never became ready.
pub(crate) const BEFORE_READY: &str = "before it was ready, ";
/// What begins the message about a process that was killed for the time that it took.
pub(crate) const PAST_LIMIT: &str = "it had used ";
/// What stands between how a process ended and the last line that it wrote.
pub(crate) const LAST_WORDS: &str = "; its last words: ";
/// What stands between the name of a program that cannot be started and the reason.
pub(crate) const NOT_STARTED: &str = " could not be started: ";

/// How a job ended, with a message that its author can act on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "status", rename_all = "kebab-case")]
pub enum Status {
    /// There is an answer.
    Done,
    /// The engine said that there will be no answer.
    Failed {
        /// Its reason.
        message: String,
    },
    /// The process ended without an answer.
    Crashed {
        /// Signal or exit status, and its last words.
        message: String,
    },
    /// It ran past a limit and was killed.
    Timeout {
        /// Which limit.
        message: String,
    },
    /// The answer's files are not what the protocol asks for.
    BadResult {
        /// What is wrong with them.
        message: String,
    },
    /// It broke the protocol and was killed.
    ProtocolError {
        /// What it said.
        message: String,
    },
    /// It never became ready.
    NotReady {
        /// Why, as far as known.
        message: String,
    },
    /// It was not given the pair, which is no fault of its own: files could not be written, say.
    NotAsked {
        /// Why.
        message: String,
    },
    /// Something that it needs is not installed on this machine.
    Absent {
        /// What, and how to get it.
        message: String,
    },
}

/// The message of a status, borrowed as the status is.
macro_rules! message_of {
    ($status:expr) => {
        match $status {
            Self::Done => None,
            Self::Failed { message }
            | Self::Crashed { message }
            | Self::Timeout { message }
            | Self::BadResult { message }
            | Self::ProtocolError { message }
            | Self::NotReady { message }
            | Self::NotAsked { message }
            | Self::Absent { message } => Some(message),
        }
    };
}

impl Status {
    /// The name used in tables and files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Failed { .. } => "failed",
            Self::Crashed { .. } => "crashed",
            Self::Timeout { .. } => "timeout",
            Self::BadResult { .. } => "bad-result",
            Self::ProtocolError { .. } => "protocol-error",
            Self::NotReady { .. } => "not-ready",
            Self::NotAsked { .. } => "not-asked",
            Self::Absent { .. } => "absent",
        }
    }

    /// Why there is no answer; `None` when there is one.
    pub fn message(&self) -> Option<&str> {
        message_of!(self).map(String::as_str)
    }

    /// The same of a run that others, which had an answer, came before.
    pub(crate) fn after_answers(mut self, answers: usize) -> Self {
        if let Some(message) = message_of!(&mut self) {
            let runs = if answers == 1 { "run" } else { "runs" };
            *message = format!("after {answers} {runs} with an answer, {message}");
        }
        self
    }

    /// Whether the engine takes another job after this.
    pub(crate) fn leaves_engine_ready(&self) -> bool {
        matches!(self, Self::Done | Self::Failed { .. })
    }

    /// The status of a program that the system does not start.
    pub(crate) fn not_started(command: &Command, error: &io::Error) -> Self {
        let program = command.get_program().to_string_lossy();
        Self::NotReady { message: format!("{program}{NOT_STARTED}{error}") }
    }

    /// The status of a process that ended like this, after it had written `log`.
    pub(crate) fn crashed(how: String, log: &Log) -> Self {
        let message = match log.last_line() {
            Some(line) => format!("{how}{LAST_WORDS}{line}"),
            None => how,
        };
        Self::Crashed { message }
    }

    /// The same story, told about a process that was not ready yet.
    pub(crate) fn before_ready(self) -> Self {
        match self.message() {
            Some(message) => Self::NotReady { message: format!("{BEFORE_READY}{message}") },
            None => self,
        }
    }

    /// The status of an engine that says of its matching alone that it took longer than the whole job.
    pub(crate) fn past_claim(claimed_seconds: Option<f64>, usage: &Usage) -> Option<Self> {
        /// By so much of a time, and by so many seconds, may an engine's clock differ from this one's.
        const CLOCKS_DIFFER: (f64, f64) = (0.01, 0.002);
        let all = usage.wall_seconds;
        let (part, more) = CLOCKS_DIFFER;
        let claimed = claimed_seconds.filter(|claimed| *claimed > all * (1.0 + part) + more)?;
        let message = format!(
            "it says that matching took {claimed} s, but its answer was there after {all:.6} s: give seconds of a \
             monotonic clock"
        );
        Some(Self::ProtocolError { message })
    }

    /// The status of a process that has used more than it may.
    pub(crate) fn past_limit(usage: &Usage, wall: Duration, cpu: Option<Duration>) -> Option<Self> {
        let (used, limit, clock) = match (usage.cpu_seconds, cpu) {
            (Some(used), Some(limit)) if used > limit.as_secs_f64() => (used, limit, "CPU"),
            _ if usage.wall_seconds > wall.as_secs_f64() => (usage.wall_seconds, wall, "wall"),
            _ => return None,
        };
        let limit = limit.as_secs_f64();
        Some(Self::Timeout {
            message: format!(
                "{PAST_LIMIT}{used:.1} s of {clock} time when it was killed; the limit is {limit} s"
            ),
        })
    }
}

impl Status {
    /// The status of a process that has computed nothing for longer than it may.
    pub(crate) fn idle(idle: Option<Duration>, limit: Option<Duration>) -> Option<Self> {
        let limit = limit.filter(|limit| idle.is_some_and(|idle| idle > *limit))?.as_secs_f64();
        Some(Self::Timeout {
            message: format!(
                "{PAST_LIMIT}no CPU time for {limit} s when it was killed: it sleeps or waits for something"
            ),
        })
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.message() {
            Some(message) => write!(f, "{}: {message}", self.name()),
            None => f.write_str(self.name()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_status_is_one_flat_object() {
        let status = Status::BadResult { message: "shape".into() };
        let text = serde_json::to_string(&status).unwrap();
        assert_eq!(text, r#"{"status":"bad-result","message":"shape"}"#);
        assert_eq!(serde_json::from_str::<Status>(&text).unwrap(), status);
        assert_eq!(serde_json::to_string(&Status::Done).unwrap(), r#"{"status":"done"}"#);
    }

    #[test]
    fn limits_name_the_clock_that_ran_out() {
        let usage = Usage { cpu_seconds: Some(3.0), wall_seconds: 2.0, peak_memory_bytes: None };
        let second = Duration::from_secs(1);
        let text = |wall, cpu| Status::past_limit(&usage, wall, cpu).unwrap().to_string();
        assert!(text(second * 9, Some(second)).contains("3.0 s of CPU time"));
        assert!(text(second, None).contains("2.0 s of wall time"));
        assert_eq!(Status::past_limit(&usage, second * 9, Some(second * 9)), None);
        let unknown = Usage { cpu_seconds: None, ..usage };
        assert_eq!(Status::past_limit(&unknown, second * 9, Some(second)), None);
    }
}
