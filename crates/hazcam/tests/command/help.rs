//! What a newcomer reads first: help, usage errors, completions, manual pages.

use std::process::Stdio;

use crate::folder::Folder;

#[test]
fn help_is_what_it_was() {
    let folder = Folder::new();
    for (name, arguments) in [
        ("help", "--help"),
        ("help_match", "match --help"),
        ("help_score", "score --help"),
        ("help_depth", "depth --help"),
        ("help_view", "view --help"),
        ("help_info", "info --help"),
        ("help_explain", "explain --help"),
        ("help_demo", "demo --help"),
        ("help_bench", "bench --help"),
        ("help_engine", "engine --help"),
        ("help_doctor", "doctor --help"),
        ("help_completions", "completions --help"),
        ("help_man", "man --help"),
    ] {
        insta::assert_snapshot!(name, folder.run(arguments).done().stdout);
    }
}

#[test]
fn usage_errors_are_what_they_were() {
    let folder = Folder::new();
    let mut text = String::new();
    for arguments in [
        "mach",
        "match left.png",
        "match left.png right.png -o d.pfm --matcher slow",
        "match left.png right.png -o d.pfm --box 1,2",
        "match left.png right.png -o d.pfm --max-dispari 4",
        "score d.pfm truth.pfm --format yaml",
        "score d.pfm truth.pfm --fail-over p_bad",
        "completions cmd",
    ] {
        let outcome = folder.run(arguments);
        assert_eq!(outcome.status, 2, "{arguments}");
        text.push_str(&format!("$ hazcam {arguments}\n{}\n", outcome.stderr));
    }
    insta::assert_snapshot!(text);
}

#[test]
fn without_arguments_there_is_help() {
    let folder = Folder::new();
    let outcome = folder.run("");
    assert_eq!(outcome.status, 2);
    assert_eq!(outcome.stderr, folder.run("--help").stdout);
}

#[test]
fn every_shell_gets_its_completions() {
    let folder = Folder::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let outcome = folder.run(&format!("completions {shell}")).done();
        assert!(outcome.stdout.contains("max-disparity"), "{shell}");
        assert!(outcome.stdout.contains("version"), "{shell}");
        assert!(!outcome.stdout.contains("sandbox-exec"), "{shell}");
    }
}

#[test]
fn manual_pages_are_printed_or_written() {
    let folder = Folder::new();
    let page = folder.run("man").done().stdout;
    assert!(page.contains(".TH hazcam 1"), "{page}");
    folder.run("man --folder pages").done();
    for name in ["pages/hazcam.1", "pages/hazcam-match.1", "pages/hazcam-score.1"] {
        assert!(folder.path(name).is_file(), "{name}");
    }
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let folder = Folder::new();
    for arguments in [&["completions", "bash"][..], &["--help"], &["explain", "fast"]] {
        let mut child = folder
            .command()
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {output:?}");
        assert!(output.stderr.is_empty(), "{arguments:?}: {output:?}");
    }
}

#[test]
fn messages_are_plain_when_nobody_sees_colours() {
    let outcome = Folder::new().run("explain slow");
    assert!(!outcome.stderr.contains('\u{1b}'), "{:?}", outcome.stderr);
}
