//! A session with an engine ends in a clear status whatever the engine does.
#![cfg(unix)]

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use arena::engine::protocol::Job;
use arena::engine::{Limits, Session, Status};

const READY: &str = r#"echo '{"hazcam":"ready","protocol":1,"name":"fake","version":"7"}';"#;

fn shell(script: &str) -> Command {
    let mut command = Command::new("/bin/sh");
    command.args(["-c", script]);
    command
}

fn limits() -> Limits {
    Limits { wall: Duration::from_secs(60), ..Limits::default() }
}

fn job(number: u64, scratch: &Path) -> Job {
    Job {
        job: number,
        left: scratch.join("left.npy"),
        right: scratch.join("right.npy"),
        columns: 2,
        rows: 1,
        bounds: [0, 0, 1, 0],
        min_disparity: 0,
        max_disparity: 3,
        threads: 1,
        disparity: scratch.join("disparity.npy"),
        reasons: scratch.join("reasons.npy"),
        confidence: scratch.join("confidence.npy"),
    }
}

/// What becomes of the first job of an engine whose script is this, after `ready`.
fn first_job(script: &str, limits: Limits) -> Status {
    let scratch = tempfile::tempdir().unwrap();
    let command = shell(&format!("{READY} {script}"));
    let mut session = Session::start(command, scratch.path(), limits).unwrap();
    let (status, usage) = session.run(&job(1, scratch.path()));
    assert!(usage.wall_seconds > 0.0);
    assert_eq!(session.is_alive(), matches!(status, Status::Done | Status::Failed { .. }));
    status
}

fn started(script: &str, limits: Limits) -> Status {
    let scratch = tempfile::tempdir().unwrap();
    Session::start(shell(script), scratch.path(), limits).unwrap_err()
}

#[test]
fn one_engine_answers_many_jobs_between_its_chatter() {
    let scratch = tempfile::tempdir().unwrap();
    let script = format!(
        r#"echo loading; {READY} i=0
        while read line; do
            i=$((i+1)); echo "working on $i"; echo "a warning" >&2
            printf '%s' "$line" > job.json
            if [ $i = 2 ]; then echo '{{"hazcam":"failed","job":2,"message":"no"}}'
            else echo "{{\"hazcam\":\"done\",\"job\":$i}}"; fi
        done; touch ended"#
    );
    let mut session = Session::start(shell(&script), scratch.path(), limits()).unwrap();
    assert_eq!(session.ready().version.as_deref(), Some("7"));
    for number in 1..=3 {
        let expected = match number {
            2 => Status::Failed { message: "no".into() },
            _ => Status::Done,
        };
        let asked = job(number, scratch.path());
        assert_eq!(session.run(&asked).0, expected);
        let seen = std::fs::read_to_string(scratch.path().join("job.json")).unwrap();
        assert_eq!(serde_json::from_str::<Job>(&seen).unwrap(), asked);
    }
    assert!(session.log().contains("working on 3"));
    session.end();
    assert!(scratch.path().join("ended").exists(), "it ended by itself");
}

#[test]
fn a_crash_is_a_status_with_the_last_words() {
    let status = first_job("read line; echo 'Segmentation thing' >&2; exit 3", limits());
    let text = status.to_string();
    assert!(text.starts_with("crashed: it exited with status 3"), "{text}");
    assert!(text.ends_with("Segmentation thing"), "{text}");
    let text = first_job("read line; kill -SEGV $$", limits()).to_string();
    assert!(text.contains("SIGSEGV"), "{text}");
}

#[test]
fn all_that_was_said_is_there_at_the_end() {
    let words = r#"read line; head -c 16000 /dev/zero | tr '\0' x >&2; echo end >&2; echo out;"#;
    let script = format!(r#"{READY} {words} echo '{{"hazcam":"done","job":1}}'; sleep 60"#);
    for _ in 0..20 {
        let scratch = tempfile::tempdir().unwrap();
        let mut session = Session::start(shell(&script), scratch.path(), limits()).unwrap();
        assert_eq!(session.run(&job(1, scratch.path())).0, Status::Done);
        let said = session.last_words();
        assert!(said.contains("end\n") && said.contains("out\n"), "{}", said.len());
        assert_eq!(said.len(), 16_000 + "end\nout\n".len());
    }
}

#[test]
fn an_engine_that_reads_nothing_is_killed_at_its_limit() {
    let limits = Limits { wall: Duration::from_secs(1), ..limits() };
    let answer = r#"sleep 0.1; echo '{"hazcam":"failed","job":1,"message":"no"}'"#;
    let scratch = tempfile::tempdir().unwrap();
    let command = shell(&format!("{READY} {answer}; sleep 600"));
    let mut session = Session::start(command, scratch.path(), limits).unwrap();
    // Two of them are more than a pipe takes.
    let long = |number| Job { left: "x".repeat(60_000).into(), ..job(number, scratch.path()) };
    assert!(matches!(session.run(&long(1)).0, Status::Failed { .. }));
    let (status, usage) = session.run(&long(2));
    assert!(matches!(status, Status::Timeout { .. }), "{status}");
    assert!(usage.wall_seconds < 60.0);
}

#[test]
fn what_is_said_before_a_job_is_a_protocol_error() {
    let answers = r#"{"hazcam":"done","job":1}\n{"hazcam":"done","job":2}\n"#;
    let script = format!("{READY} read line; printf '{answers}'; touch told; read line; sleep 600");
    let scratch = tempfile::tempdir().unwrap();
    let mut session = Session::start(shell(&script), scratch.path(), limits()).unwrap();
    assert_eq!(session.run(&job(1, scratch.path())).0, Status::Done);
    let told = (0..600).any(|_| {
        std::thread::sleep(Duration::from_millis(100));
        scratch.path().join("told").exists()
    });
    assert!(told, "the engine says both at once");
    // Whoever listens may still be at it.
    std::thread::sleep(Duration::from_secs(1));
    let text = session.run(&job(2, scratch.path())).0.to_string();
    assert!(text.contains("before it was asked"), "{text}");
}

#[test]
fn an_engine_that_closes_its_ears_has_crashed() {
    let scratch = tempfile::tempdir().unwrap();
    let command = shell(&format!("exec 0<&-; {READY} sleep 600"));
    let mut session = Session::start(command, scratch.path(), limits()).unwrap();
    let (status, _) = session.run(&job(1, scratch.path()));
    assert!(matches!(status, Status::Crashed { .. }), "{status}");
}

#[test]
fn an_engine_that_is_gone_before_the_job_has_crashed() {
    assert!(matches!(first_job("exit 0", limits()), Status::Crashed { .. }));
}

#[test]
fn a_hang_is_killed_with_all_its_children() {
    let limits = Limits { wall: Duration::from_millis(300), ..limits() };
    let script = "read line; (sleep 600 & echo $! > child; wait) & sleep 600";
    let scratch = tempfile::tempdir().unwrap();
    let command = shell(&format!("{READY} {script}"));
    let mut session = Session::start(command, scratch.path(), limits).unwrap();
    let (status, usage) = session.run(&job(1, scratch.path()));
    assert!(status.to_string().contains("wall time"), "{status}");
    assert!(usage.wall_seconds >= 0.3);
    let child: i32 = std::fs::read_to_string(scratch.path().join("child"))
        .map_or(0, |text| text.trim().parse().unwrap());
    if cfg!(target_os = "linux") && child > 0 {
        // Killed, though perhaps not yet waited for by whoever inherited it.
        let state = || std::fs::read_to_string(format!("/proc/{child}/stat"));
        while let Ok(stat) = state() {
            if stat.contains(") Z ") {
                break;
            }
            std::thread::yield_now();
        }
    }
    assert!(matches!(session.run(&job(2, scratch.path())).0, Status::Crashed { .. }));
}

#[test]
#[cfg(target_os = "linux")]
fn spinning_runs_into_the_cpu_limit_also_in_a_child() {
    let limits = Limits { cpu: Some(Duration::from_millis(200)), ..limits() };
    for script in ["read line; while :; do :; done", "read line; (while :; do :; done) & wait"] {
        let status = first_job(script, limits);
        assert!(status.to_string().contains("CPU time"), "{status}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn who_sleeps_is_stopped_and_who_computes_is_not() {
    let limits = Limits { idle: Some(Duration::from_secs(1)), ..limits() };
    let status = first_job("read line; sleep 600", limits);
    assert!(status.to_string().contains("no CPU time for 1 s"), "{status}");
    // For three seconds it computes all the time.
    let busy = "read line; end=$(($(date +%s) + 3)); while [ $(date +%s) -lt $end ]; do :; done";
    let script = format!(r#"{busy}; echo '{{"hazcam":"done","job":1}}'; read line"#);
    assert_eq!(first_job(&script, limits), Status::Done);
}

#[test]
fn breaking_the_protocol_is_named() {
    for (answer, why) in [
        (r#"{"hazcam":"done","job":9}"#, "answered job 9 when job 1"),
        (r#"{"hazcam":"ready","protocol":1}"#, "a second time"),
        (r#"{"hazcam":"finished"}"#, "cannot be understood"),
        (r#"{"hazcam":"absent","message":"x"}"#, "after it had said `ready`"),
    ] {
        let status = first_job(&format!("read line; echo '{answer}'; sleep 600"), limits());
        assert!(matches!(status, Status::ProtocolError { .. }), "{status}");
        assert!(status.to_string().contains(why), "{status}");
    }
}

#[test]
fn a_message_behind_something_else_is_named_and_one_that_is_logged_is_not() {
    let done = r#"{"hazcam":"done","job":1}"#;
    let status =
        first_job(&format!("read job; printf '100 percent'; echo '{done}'; read end"), limits());
    let message = status.message().unwrap_or_default();
    assert!(message.contains("`100 percent` stands before one"), "{status}");
    let logged = format!("read job; echo 'sending {done}'; sleep 0.1; echo '{done}'; read end");
    assert_eq!(first_job(&logged, limits()), Status::Done);
    let ready = r#"{"hazcam":"ready","protocol":1}"#;
    let status = started(&format!("printf 'loading..'; echo '{ready}'; read end"), limits());
    assert!(status.to_string().contains("`loading..` stands before one"), "{status}");
}

#[test]
fn garbage_and_floods_do_no_harm() {
    let flood = r#"read line; head -c 3000000 /dev/zero | tr '\0' 'x'; head -c 300000 /dev/urandom;
        echo; echo '{ not json'; echo '{"hazcam":"done","job":1}'; sleep 600"#;
    assert_eq!(first_job(flood, limits()), Status::Done);
}

#[test]
fn an_engine_that_never_gets_ready_is_named() {
    let quick = Limits { start: Duration::from_millis(300), ..limits() };
    let text = started("sleep 600", quick).to_string();
    assert!(text.contains("before it was ready") && text.contains("wall time"), "{text}");
    let text = started("echo 'No module named x' >&2; exit 1", limits()).to_string();
    assert!(text.ends_with("No module named x"), "{text}");
    let text = started(r#"echo '{"hazcam":"ready","protocol":2}'"#, limits()).to_string();
    assert!(text.contains("version 2"), "{text}");
    let text = started(r#"echo '{"hazcam":"absent","message":"no cv2"}'"#, limits()).to_string();
    assert_eq!(text, "absent: no cv2");
    let scratch = tempfile::tempdir().unwrap();
    let nothing = Command::new("/nonexistent/engine");
    let text = Session::start(nothing, scratch.path(), limits()).unwrap_err().to_string();
    assert!(text.contains("/nonexistent/engine could not be started"), "{text}");
}

#[test]
fn a_slow_start_is_recorded_apart_from_the_job() {
    let scratch = tempfile::tempdir().unwrap();
    let script = format!("sleep 0.4; {READY} read line; echo '{{\"hazcam\":\"done\",\"job\":1}}'");
    let mut session = Session::start(shell(&script), scratch.path(), limits()).unwrap();
    assert!(session.startup().wall_seconds >= 0.4);
    assert_eq!(session.run(&job(1, scratch.path())).0, Status::Done);
}
