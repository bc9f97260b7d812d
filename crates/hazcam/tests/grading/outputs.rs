//! The forms of a report, on one submission that passes one test and fails the other.

use serde_json::{Value, json};

use crate::classroom::{Classroom, HONEST};

const CRASH: &str = "def NAME(Il, Ir, bbox, maxd):\n    return 1 / 0\n";

#[test]
fn every_form_has_every_test() {
    let Some(classroom) = Classroom::with_python() else { return };
    classroom.submission("handin", CRASH);
    let run = |form: &str| {
        let arguments = ["handin", "--scheme", "small.toml", "--format", form];
        let (status, stdout, stderr) = classroom.run(&arguments);
        // The limits come first, whatever stdout is for.
        let limits = match form {
            "text" | "autolab" => "",
            _ => "note: Part 1, wall: limit 1 CPU s\nnote: Part 2, wall: limit 1 CPU s\n",
        };
        assert_eq!((status, stderr.as_str()), (0, limits));
        stdout
    };
    let text = run("text");
    for words in [
        "Small (5 points): handin, in a sandbox\n",
        "Part 1, wall             limit 1 CPU s\n  RE    0 of 2 points\n",
        "stereo_disparity_fast.py, line 2, in stereo_disparity_fast\n",
        "ZeroDivisionError: division by zero",
        "Part 2, wall             limit 1 CPU s\n  OK    3 of 3 points   E_RMS",
        "Secret ID: Secret handin\n3 of 5 points\n",
    ] {
        assert!(text.contains(words), "`{words}` is not in:\n{text}");
    }
    let autolab = run("autolab");
    let last: Value = serde_json::from_str(autolab.lines().last().unwrap()).unwrap();
    assert_eq!(last["scores"], json!({ "Part 1, wall": 0.0, "Part 2, wall": 3.0 }));
    assert_eq!(last["scoreboard"][0], 3.0);
    let gradescope: Value = serde_json::from_str(&run("gradescope")).unwrap();
    assert_eq!(gradescope["score"], 3.0);
    assert_eq!(gradescope["tests"][0]["status"], "failed");
    assert_eq!(gradescope["tests"][1]["status"], "passed");
    let junit = run("junit");
    assert!(junit.contains("tests=\"2\" failures=\"1\" errors=\"0\""), "{junit}");
    assert!(junit.contains("ZeroDivisionError"), "{junit}");
}

#[test]
fn a_file_gets_the_results_and_the_screen_the_text() {
    let Some(classroom) = Classroom::with_python() else { return };
    classroom.submission("handin", HONEST);
    let arguments =
        ["handin", "--scheme", "small.toml", "--format", "gradescope", "-o", "results.json"];
    let (status, stdout, _) = classroom.run(&arguments);
    assert_eq!(status, 0);
    assert!(stdout.ends_with("5 of 5 points\n"), "{stdout}");
    let results = std::fs::read(classroom.path("results.json")).unwrap();
    assert_eq!(serde_json::from_slice::<Value>(&results).unwrap()["score"], 5.0);
}

#[test]
fn the_status_says_when_points_are_missing_or_the_grader_failed() {
    let Some(classroom) = Classroom::with_python() else { return };
    classroom.submission("handin", CRASH);
    let graded = |arguments: &[&str]| {
        let mut all = vec!["handin", "--scheme", "small.toml"];
        all.extend(arguments);
        classroom.run(&all)
    };
    assert_eq!(graded(&["--fail-under", "3"]).0, 0);
    assert_eq!(graded(&["--fail-under", "4"]).0, 1);
    assert!(graded(&["--fail-under", "nan"]).2.contains("give a number of points"));
    let (status, stdout, _) = graded(&["--python", "/nonexistent/python"]);
    assert_eq!(status, 2);
    assert!(stdout.contains("XX") && stdout.contains("/nonexistent/python"), "{stdout}");
    // A relative path is one from here.
    let (_, stdout, _) = graded(&["--python", "./python"]);
    assert!(stdout.contains("./python cannot be started"), "{stdout}");
    #[cfg(unix)]
    {
        use std::path::Path;
        // The folder of the whole environment: of its program alone Python would not know the packages.
        let python = classroom.python.as_deref().unwrap();
        let environment = python.parent().and_then(Path::parent).unwrap();
        std::os::unix::fs::symlink(environment, classroom.path("environment")).unwrap();
        let python = Path::new("./environment/bin").join(python.file_name().unwrap());
        let (status, stdout, _) = graded(&["--python", python.to_str().unwrap()]);
        assert_eq!(status, 0, "{stdout}");
    }
    // Without data, the course's tests cannot be run: the grader's fault, with the remedy.
    let (status, stdout, _) = classroom.run(&["handin"]);
    assert_eq!(status, 2);
    assert!(stdout.contains("set HAZCAM_DATA, or --data, to the folder"), "{stdout}");
}

#[test]
fn no_score_is_written_when_the_grader_failed() {
    let Some(classroom) = Classroom::with_plain_python() else { return };
    classroom.submission("handin", HONEST);
    let graded = |form: &str, output: &[&str]| {
        let mut all = vec!["handin", "--scheme", "small.toml", "--format", form];
        all.extend(["--python", "/nonexistent/python"]);
        all.extend(output);
        classroom.run(&all)
    };
    for form in ["gradescope", "autolab"] {
        let (status, stdout, stderr) = graded(form, &["-o", "results.json"]);
        assert_eq!(status, 2, "{form}");
        assert!(stdout.contains("XX: the grader failed"), "{form}: {stdout}");
        assert!(
            stderr.contains("the grader failed in `Part 1, wall`, `Part 2, wall` ("),
            "{stderr}"
        );
        assert!(!classroom.path("results.json").exists(), "{form}");
        let (status, stdout, stderr) = graded(form, &[]);
        assert_eq!(status, 2, "{form}");
        assert!(stderr.contains("/nonexistent/python"), "{form}: {stderr}");
        assert!(!stdout.contains("score"), "{form}: {stdout}");
    }
    // These tell the grader's fault from the entrant's.
    for (form, word) in [("json", "\"XX\""), ("junit", "errors=\"2\"")] {
        assert_eq!(graded(form, &["-o", form]).0, 2);
        let results = std::fs::read_to_string(classroom.path(form)).unwrap();
        assert!(results.contains(word), "{results}");
    }
}

#[test]
fn the_text_goes_to_a_file_too() {
    let Some(classroom) = Classroom::without_python() else { return };
    let arguments = ["--matcher", "fast", "--scheme", "small.toml", "-o", "results.txt"];
    let (_, stdout, _) = classroom.run(&arguments);
    assert_eq!(std::fs::read_to_string(classroom.path("results.txt")).unwrap(), stdout);
    assert!(stdout.contains("Part 1, wall") && stdout.ends_with(" points\n"), "{stdout}");
}

#[test]
fn mistakes_on_the_command_line_are_named() {
    let Some(classroom) = Classroom::without_python() else { return };
    std::fs::write(classroom.path("handin.tar"), "hand-in").unwrap();
    std::fs::create_dir(classroom.path("unpacked")).unwrap();
    std::fs::write(classroom.path("bad.toml"), "name = 'x'\n[[test]]\nname = 'a'\n").unwrap();
    std::fs::create_dir(classroom.path("engines")).unwrap();
    let engine = "name = 'mine'\nkind = 'protocol'\ncommand = ['/bin/true']\n";
    for name in ["one", "other"] {
        std::fs::write(classroom.path(&format!("engines/{name}.toml")), engine).unwrap();
    }
    for (arguments, words) in [
        (
            &["--matcher", "fast", "--engines", "engines"][..],
            "engines/one.toml and engines/other.toml both define `mine`",
        ),
        (
            &["--matcher", "fast", "--engines", "engines", "-o", "engines/one.toml"],
            "engines/one.toml would replace an input",
        ),
        (&[], "name a submission, or engines with --matcher"),
        (&["a", "--matcher", "fast"], "cannot be used with"),
        (&["nothing-here"], "there is no nothing-here: give a folder or an archive"),
        (&["--matcher", "fastest"], "there is no engine `fastest`"),
        (&["--matcher", "fast", "--scheme", "bad.toml"], "bad.toml: "),
        (&["--matcher", "fast", "--scheme", "none.toml"], "cannot read none.toml"),
        (&["--matcher", "fast", "--cpu-limit", "0"], "give seconds from 0.1"),
        (&["--matcher", "fast", "--data", "nowhere"], "nowhere"),
        // What cannot be written is told before the work, and no input is replaced.
        (&["--matcher", "fast", "-o", "no/results.json"], "the folder no does not exist"),
        (
            &["handin.tar", "-o", "./handin.tar"],
            "--output ./handin.tar would replace an input: name another file",
        ),
        (&["unpacked", "-o", "unpacked/secret_id.py"], "would lie in the submission: name another"),
        (
            &["--matcher", "fast", "--scheme", "small.toml", "-o", "small.toml"],
            "--output small.toml would replace an input: name another file",
        ),
    ] {
        let (status, stdout, stderr) = classroom.run(arguments);
        assert_eq!((status, stdout.as_str()), (2, ""), "{arguments:?}");
        assert!(stderr.contains(words), "{arguments:?}: {stderr}");
    }
}

#[test]
fn the_scheme_that_is_printed_can_be_used() {
    let Some(classroom) = Classroom::without_python() else { return };
    let (status, scheme, _) = classroom.run(&["--print-scheme"]);
    assert_eq!(status, 0);
    let path = classroom.path("mine.toml");
    let parsed = arena::grade::Scheme::parse(&scheme, &path).unwrap();
    assert_eq!(parsed, arena::grade::Scheme::course());
    // Variables that are set are not options that were given.
    let mut command = classroom.command("grade", &["--print-scheme"]);
    let output = command.envs(VARIABLES.map(|name| (name, "x"))).output().unwrap();
    assert_eq!(String::from_utf8(output.stdout).unwrap(), scheme);
}

#[test]
fn an_empty_variable_names_nothing() {
    let Some(classroom) = Classroom::without_python() else { return };
    let mut command = classroom.command("grade", &["--matcher", "fast", "--scheme", "small.toml"]);
    let output = command.envs(VARIABLES.map(|name| (name, ""))).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), stderr.as_str()), (Some(0), ""));
}

/// The variables that can stand for options of `grade`.
const VARIABLES: [&str; 3] = ["HAZCAM_DATA", "HAZCAM_ENGINES", "HAZCAM_PYTHON"];
