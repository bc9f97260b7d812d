//! A run that is ended by a signal.

use std::fs;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Says that it is ready and its process number, takes a job, starts another process and answers never.
const HANGING: &str = r#"
name = "hanging"
command = ["sh", "-c", '''
echo '{"hazcam":"ready","protocol":1}'
read job
sleep 1000 &
echo $$ $! > PLACE/numbers.part
mv PLACE/numbers.part PLACE/numbers
wait
''']
"#;

/// Runs it, sends it a signal once the engine works, and tells by which signal it ended, if it did within two
/// seconds, and which of the engine's processes and of its folders are left.
fn interrupted(before: &str, signal: &str) -> (Option<i32>, Vec<String>, usize) {
    let folder = tempfile::tempdir().unwrap();
    let [engines, temporary] = ["engines", "temporary"].map(|name| folder.path().join(name));
    for folder in [&engines, &temporary] {
        fs::create_dir(folder).unwrap();
    }
    let engine = HANGING.replace("PLACE", folder.path().to_str().unwrap());
    fs::write(engines.join("hanging.toml"), engine).unwrap();
    let bench =
        "bench --stress --scenes stress/plain -m none --engine hanging --engines engines -q";
    let mut hazcam = Command::new("sh")
        .args(["-c", &format!("{before}\nexec \"$0\" {bench}"), env!("CARGO_BIN_EXE_hazcam")])
        .current_dir(folder.path())
        .env("TMPDIR", &temporary)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .process_group(0)
        .spawn()
        .unwrap();
    let until = |what: &mut dyn FnMut() -> bool, at_most| {
        let started = Instant::now();
        while !what() && started.elapsed() < at_most {
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    let numbers = folder.path().join("numbers");
    until(&mut || numbers.exists(), Duration::from_secs(60));
    let numbers = fs::read_to_string(numbers).expect("the engine got its job");
    let kill = |signal: &str, number: &str| {
        let status = Command::new("kill").args([signal, number]).stderr(Stdio::null()).status();
        assert!(status.is_ok(), "there is no program kill");
    };
    kill(signal, &hazcam.id().to_string());
    let mut ended = None;
    until(
        &mut || {
            ended = hazcam.try_wait().unwrap();
            ended.is_some()
        },
        Duration::from_secs(2),
    );
    let runs = |number: &&str| {
        let stat = fs::read_to_string(format!("/proc/{number}/stat")).unwrap_or_default();
        // One that has ended and that nobody has waited for is not left.
        !matches!(stat.rsplit(')').next().unwrap().trim().chars().next(), None | Some('Z'))
    };
    let mut left: Vec<String> = Vec::new();
    let mut look = || {
        left = numbers.split_whitespace().filter(runs).map(str::to_owned).collect();
        left.is_empty()
    };
    until(&mut look, Duration::from_secs(1));
    let folders = entries(&temporary);
    if ended.is_none() {
        kill("-TERM", &hazcam.id().to_string());
        hazcam.wait().unwrap();
    }
    (ended.and_then(|status| status.signal()), left, folders)
}

fn entries(folder: &Path) -> usize {
    fs::read_dir(folder).unwrap().count()
}

#[test]
fn a_signal_ends_the_engines_too_and_leaves_no_folders() {
    // Not another: tests that run in the background may have been told to ignore it.
    let (ended_by, left, folders) = interrupted("", "-TERM");
    assert_eq!((ended_by, left, folders), (Some(15), Vec::new(), 0));
}

#[test]
fn a_signal_that_it_is_told_to_ignore_ends_nothing() {
    let (ended_by, left, folders) = interrupted("trap '' HUP", "-HUP");
    assert_eq!((ended_by, left.len()), (None, 2));
    assert!(folders > 0);
}
