//! A kernel that lacks a part of the sandbox: played by a filter that answers as such a kernel does.
//! It is applied to a thread of the test, from which the command inherits it.
#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::process::Output;

use seccompiler::{BpfProgram, SeccompAction, SeccompFilter};

use crate::classroom::Classroom;

/// Runs `grade` under a kernel for which this system call does not exist.
fn without(call: libc::c_long, arguments: &[&str]) -> Option<(i32, String, String)> {
    let classroom = Classroom::without_python()?;
    let filter = SeccompFilter::new(
        BTreeMap::from([(call, Vec::new())]),
        SeccompAction::Allow,
        SeccompAction::Errno(libc::ENOSYS as u32),
        std::env::consts::ARCH.try_into().unwrap(),
    );
    let program: BpfProgram = filter.unwrap().try_into().unwrap();
    let mut command = classroom.command("grade", arguments);
    let output = std::thread::spawn(move || {
        seccompiler::apply_filter(&program).unwrap();
        command.output().unwrap()
    });
    let Output { status, stdout, stderr } = output.join().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Some((status.code().unwrap(), text(stdout), text(stderr)))
}

const GRADE: [&str; 4] = ["--matcher", "fast", "--scheme", "small.toml"];

#[test]
fn without_landlock_nothing_is_run() {
    let call = libc::SYS_landlock_create_ruleset;
    let Some((status, stdout, stderr)) = without(call, &GRADE) else { return };
    assert_eq!((status, stdout.as_str()), (2, ""));
    assert!(stderr.contains("this system lacks Landlock of Linux 6.2 or newer"), "{stderr}");
    assert!(stderr.contains("--no-sandbox"), "{stderr}");
}

#[test]
fn without_seccomp_nothing_is_run() {
    let call = libc::SYS_seccomp;
    let Some((status, stdout, stderr)) = without(call, &GRADE) else { return };
    assert_eq!((status, stdout.as_str()), (2, ""));
    assert!(stderr.contains("this system lacks seccomp filters"), "{stderr}");
}

#[test]
fn who_says_so_does_without_and_is_warned() {
    let arguments: Vec<&str> = GRADE.into_iter().chain(["--no-sandbox"]).collect();
    let call = libc::SYS_landlock_create_ruleset;
    let Some((status, stdout, stderr)) = without(call, &arguments) else { return };
    assert_eq!(status, 0, "{stderr}");
    assert!(stdout.contains("WITHOUT A SANDBOX"), "{stdout}");
    assert!(stdout.contains("5 of 5 points"), "{stdout}");
    assert!(stderr.contains("can read, change and send away all your files"), "{stderr}");
}
