//! Measuring as a person meets it: `engine`, `demo` and `bench` are run, and what they print, leave
//! behind and end with is looked at.

mod ablation;
mod bench;
mod demo;
mod engine;
#[cfg(target_os = "linux")]
mod interrupted;
mod obstacles;
mod speed;

use std::path::Path;
use std::process::{Command, Output};

/// The command, in a folder, without anything that the environment would tell it.
fn hazcam(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hazcam"));
    command.current_dir(folder).args(arguments);
    for variable in ["HAZCAM_DATA", "HAZCAM_ENGINES", "HAZCAM_THREADS"] {
        command.env_remove(variable);
    }
    command
}

/// What a run printed, after checking its status.
fn run(folder: &Path, arguments: &[&str], status: i32) -> (String, String) {
    let Output { status: found, stdout, stderr } = hazcam(folder, arguments).output().unwrap();
    let (stdout, stderr) = (String::from_utf8(stdout).unwrap(), String::from_utf8(stderr).unwrap());
    assert_eq!(found.code(), Some(status), "{arguments:?}\n{stdout}\n{stderr}");
    (stdout, stderr)
}
