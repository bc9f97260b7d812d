//! `hazcam doctor`.

use crate::folder::Folder;

#[test]
fn the_self_match_is_right_and_the_rest_is_told() {
    let folder = Folder::new();
    let outcome = folder.run("doctor").done();
    for topic in ["vector instructions", "cores", "sandbox", "data sets", "python"] {
        assert!(outcome.stdout.contains(topic), "{topic} is not in {}", outcome.stdout);
    }
    for matcher in ["fast", "balanced", "best"] {
        assert!(outcome.stdout.contains(&format!("ok      self-match {matcher}")));
    }
    let findings: serde_json::Value =
        serde_json::from_str(&folder.run("doctor --json").done().stdout).unwrap();
    assert_eq!(findings[0]["topic"], "version");
}

#[test]
fn a_level_that_the_processor_lacks_is_wrong() {
    let folder = Folder::new();
    let empty = folder.command().arg("doctor").env("HAZCAM_CPU", "").output().unwrap();
    assert_eq!(empty.status.code(), Some(0), "an empty variable names nothing");
    let output = folder.command().arg("doctor").env("HAZCAM_CPU", "abacus").output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("WRONG   vector instructions"), "{text}");
    assert!(text.contains("`abacus`"), "{text}");
}

#[test]
fn threads_that_were_asked_for_are_told() {
    let folder = Folder::new();
    let doctor = |threads: &str| {
        let mut command = folder.command();
        let output = command.arg("doctor").env("HAZCAM_THREADS", threads).output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    let (status, text) = doctor("3");
    assert!(
        status == Some(0) && text.contains("`match` uses 3 threads (HAZCAM_THREADS)"),
        "{text}"
    );
    let (status, text) = doctor("many");
    assert!(status == Some(2) && text.contains("HAZCAM_THREADS is `many`: "), "{text}");
}

#[test]
fn without_python_it_says_what_for() {
    let folder = Folder::new();
    let output =
        folder.command().arg("doctor").env("HAZCAM_PYTHON", "no-such-python").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("`no-such-python` does not run; grading Python submissions"), "{text}");
    assert!(output.status.success(), "Python is optional");
}

/// Systems without a `python3` have a `python`, which runs engines too.
#[cfg(unix)]
#[test]
fn the_python_is_looked_at_that_engines_would_be_run_with() {
    let folder = Folder::new();
    let doctor = || {
        let mut command = folder.command();
        let output = command.arg("doctor").env("PATH", folder.path("bin")).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    let text = doctor();
    assert!(text.contains("neither python3 nor python is on PATH"), "{text}");
    // Written by another process: one that this process starts meanwhile would keep it open.
    let script = "mkdir bin; printf '#!/bin/sh\\necho 3.9.7; echo 2.5; echo -\\n' > bin/python";
    let made = std::process::Command::new("sh")
        .args(["-c", &format!("{script}; chmod +x bin/python")])
        .current_dir(folder.path(""))
        .status();
    assert!(made.unwrap().success());
    let text = doctor();
    assert!(text.contains("ok      python               3.9.7"), "{text}");
    assert!(text.contains("ok      numpy                2.5"), "{text}");
}

#[test]
fn scenes_are_found_where_the_environment_says() {
    let folder = Folder::with_pair(24, 16);
    let doctor = |data: &str| {
        let output = folder.command().arg("doctor").env("HAZCAM_DATA", data).output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stdout).unwrap()
    };
    let found = doctor(".");
    assert!(found.contains("ok      data sets"), "{found}");
    assert!(found.contains(": 1 scenes"), "{found}");
    let missing = doctor("nowhere");
    assert!(missing.contains("absent  data sets"), "{missing}");
    assert!(missing.contains("nowhere"), "{missing}");
}
