//! From how a process ended to an outcome with a message for its author.

use std::time::Duration;

use super::confined::Ended;
use super::outcome::Outcome;
use crate::engine::Status;
use crate::engine::process::exited_with;
use crate::engine::status::{BEFORE_READY, LAST_WORDS, NOT_STARTED, PAST_LIMIT};
use crate::sandbox;

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Failure {
    pub outcome: Outcome,
    pub message: String,
}

impl Failure {
    pub fn new(outcome: Outcome, message: impl Into<String>) -> Self {
        Self { outcome, message: message.into() }
    }
}

/// What became of a process; `Ok` says that it claims to have answered.
pub(super) fn judge(ended: &Ended, start_limit: Duration) -> Result<(), Failure> {
    if let Some(excess) = ended.excess {
        return Err(Failure::new(Outcome::Re, format!("it was killed: {excess}")));
    }
    Err(match &ended.status {
        Status::Done => return Ok(()),
        Status::Failed { message } => from_runner(message),
        Status::Timeout { message } => Failure::new(Outcome::To, timed_out(message)),
        Status::BadResult { message } => Failure::new(Outcome::Bad, message),
        Status::ProtocolError { message } => Failure::new(
            Outcome::Bad,
            format!("it does not keep to the engine protocol (PROTOCOL.md): {message}"),
        ),
        Status::NotAsked { message } | Status::Absent { message } => {
            Failure::new(Outcome::Xx, message)
        }
        Status::Crashed { message } => crashed(message),
        Status::NotReady { message } => not_ready(message, start_limit),
    })
}

fn timed_out(message: &str) -> String {
    let hint = match message.contains(" of CPU time ") {
        true => "loops over pixels in plain Python are slow: let numpy work on whole images",
        false => "it waits or sleeps instead of computing, or the machine is very busy",
    };
    format!("{message}\nhint: {hint}")
}

/// The runner puts the outcome's code before its message; other engines know no codes.
fn from_runner(message: &str) -> Failure {
    for outcome in [Outcome::Re, Outcome::Ml, Outcome::Bad] {
        if let Some(text) = message.strip_prefix(outcome.code()).and_then(|m| m.strip_prefix(": "))
        {
            return Failure::new(outcome, text);
        }
    }
    Failure::new(Outcome::Re, message)
}

fn not_ready(message: &str, start_limit: Duration) -> Failure {
    let (what, graders_fault) = match message.strip_prefix(BEFORE_READY) {
        Some(what) => (what, sandbox_failure(what)),
        // It has said nothing, so none of these words are its own.
        None => (message, message.contains(NOT_STARTED).then(|| message.to_owned())),
    };
    if let Some(fault) = graders_fault {
        return Failure::new(Outcome::Xx, fault);
    }
    if what.starts_with(PAST_LIMIT) {
        let seconds = start_limit.as_secs_f64();
        return Failure::new(
            Outcome::To,
            format!(
                "importing it took longer than {seconds} s: do the work in the function and not \
                 in the file around it"
            ),
        );
    }
    let Failure { outcome, message } = crashed(what);
    Failure::new(outcome, format!("while it was imported, {message}"))
}

/// What the sandbox's helper says, where the process ended as that does when it cannot become the program.
fn sandbox_failure(what: &str) -> Option<String> {
    let words = what.strip_prefix(&exited_with(sandbox::EXIT_STATUS.into()))?;
    let error =
        words.strip_prefix(LAST_WORDS)?.strip_prefix(&sandbox::failure(sandbox::token(), ""))?;
    Some(format!("the sandbox failed: {error}"))
}

fn crashed(message: &str) -> Failure {
    let Some(rest) = message.strip_prefix("it was ended by the signal ") else {
        return Failure::new(Outcome::Re, message);
    };
    let signal = rest.split([';', ' ']).next().unwrap_or(rest);
    let (outcome, meaning) = match signal {
        "SIGXCPU" => (Outcome::To, "it used up its CPU time"),
        "SIGKILL" => {
            (Outcome::Sg, "killed by the system: out of memory, or past the hard limit of CPU time")
        }
        "SIGSEGV" | "SIGBUS" => (Outcome::Sg, "native code touched memory that is not its own"),
        "SIGABRT" => (Outcome::Sg, "native code gave up"),
        "SIGXFSZ" => (Outcome::Sg, "it wrote a file larger than it may"),
        "SIGFPE" => (Outcome::Sg, "native code divided by zero"),
        _ => (Outcome::Sg, "it was ended by a signal"),
    };
    Failure::new(outcome, format!("{meaning} ({message})"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Usage;
    use crate::sandbox::Excess;

    fn judged(status: Status, excess: Option<Excess>) -> (Outcome, String) {
        let (usage, startup) = (Usage::default(), Usage::default());
        let ended = Ended { status, usage, startup, log: String::new(), excess };
        let failure = judge(&ended, Duration::from_secs(60)).unwrap_err();
        (failure.outcome, failure.message)
    }

    #[test]
    fn every_end_has_its_outcome() {
        let message = |text: &str| text.to_owned();
        let cases = [
            (Status::Failed { message: message("RE: ZeroDivisionError") }, Outcome::Re),
            (Status::Failed { message: message("ML: MemoryError") }, Outcome::Ml),
            (Status::Failed { message: message("BAD: shape") }, Outcome::Bad),
            (Status::Failed { message: message("no such preset") }, Outcome::Re),
            (Status::Timeout { message: message("too long") }, Outcome::To),
            (Status::ProtocolError { message: message("doen") }, Outcome::Bad),
            (Status::Absent { message: message("no scipy") }, Outcome::Xx),
            (Status::Crashed { message: message("it exited with status 3") }, Outcome::Re),
            (
                Status::Crashed { message: message("it was ended by the signal SIGSEGV") },
                Outcome::Sg,
            ),
            (
                Status::Crashed { message: message("it was ended by the signal SIGXCPU; bye") },
                Outcome::To,
            ),
            (
                Status::NotReady {
                    message: format!(
                        "before it was ready, it exited with status 125 without an answer; its \
                         last words: {}",
                        sandbox::failure(sandbox::token(), "x")
                    ),
                },
                Outcome::Xx,
            ),
            (Status::NotAsked { message: message("im0.png: no space is left") }, Outcome::Xx),
            (
                Status::NotReady { message: message("/bin/x could not be started: no such file") },
                Outcome::Xx,
            ),
        ];
        for (status, outcome) in cases {
            assert_eq!(judged(status.clone(), None).0, outcome, "{status}");
        }
    }

    #[test]
    fn last_words_excuse_nobody() {
        for (status, words) in [
            (1, "sandbox failed: x"),
            (125, "sandbox failed: x"),
            (125, "sandbox failed 0000000000000000: x"),
            (125, "no sandbox failed: x"),
            (125, "x could not be started: y"),
            (0, "it had used 60.1 s of wall time when it was killed; the limit is 60 s"),
        ] {
            let exit = exited_with(status);
            let message = format!("before it was ready, {exit}; its last words: {words}");
            let (outcome, text) = judged(Status::NotReady { message }, None);
            assert_eq!(outcome, Outcome::Re, "{text}");
            assert!(text.starts_with("while it was imported, it exited with status"), "{text}");
        }
    }

    #[test]
    fn the_code_does_not_stay_in_the_message() {
        let status = Status::Failed { message: "BAD: wrong shape".into() };
        assert_eq!(judged(status, None).1, "wrong shape");
    }

    #[test]
    fn a_slow_import_is_a_time_out() {
        let message = "before it was ready, it had used 60.1 s of wall time when it was killed; \
                       the limit is 60 s";
        let (outcome, text) = judged(Status::NotReady { message: message.into() }, None);
        assert_eq!(outcome, Outcome::To);
        assert!(text.starts_with("importing it took longer than 60 s"), "{text}");
    }

    #[test]
    fn an_excess_explains_the_kill() {
        let status = Status::Crashed { message: "it was ended by the signal SIGKILL".into() };
        let (outcome, text) = judged(status, Some(Excess::Threads(200)));
        assert_eq!(
            (outcome, text.as_str()),
            (Outcome::Re, "it was killed: it had 200 threads; 64 are allowed")
        );
    }
}
