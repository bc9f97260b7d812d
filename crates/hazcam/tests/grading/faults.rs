//! What the grader itself fails to read or write is told as its fault, with status 2, and costs nobody
//! points.
#![cfg(target_os = "linux")]

use std::fs;
use std::process::{Command, Output};

use tar::Builder;

use crate::classroom::{Classroom, HONEST, Report};

#[track_caller]
fn expect_graders_fault(output: Output, words: &str) {
    let stdout = String::from_utf8(output.stdout).unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{stdout}{stderr}");
    let report = Report(serde_json::from_str(&stdout).unwrap());
    for test in [0, 1] {
        assert_eq!(report.outcome(test), "XX", "{}", report.message(test));
        assert!(report.message(test).contains(words), "{}", report.message(test));
    }
}

const JSON: [&str; 4] = ["--scheme", "small.toml", "--format", "json"];

#[test]
fn what_cannot_be_read() {
    let Some(classroom) = Classroom::without_python() else { return };
    // Where nothing is mapped, reading fails as on a broken disk.
    let mut command = classroom.command("grade", &["/proc/self/mem"]);
    expect_graders_fault(command.args(JSON).output().unwrap(), "cannot read /proc/self/mem");
}

#[test]
fn what_cannot_be_written() {
    let Some(classroom) = Classroom::without_python() else { return };
    let folder = classroom.submission("handin", HONEST);
    fs::write(folder.join("tables.py"), vec![b'#'; 300_000]).unwrap();
    let mut builder = Builder::new(fs::File::create(classroom.path("handin.tar")).unwrap());
    builder.append_dir_all("handin", &folder).unwrap();
    builder.finish().unwrap();
    for submission in ["handin", "handin.tar"] {
        let output = with_little_disk(64, classroom.command("grade", &[submission]));
        expect_graders_fault(output, "tables.py: File too large");
    }
}

#[test]
fn what_an_engine_cannot_be_given() {
    let Some(classroom) = Classroom::without_python() else { return };
    let engine = "name = \"rv\"\nkind = \"robust-vision\"\ncommand = [\"/bin/true\"]\n";
    fs::create_dir(classroom.path("engines")).unwrap();
    fs::write(classroom.path("engines/rv.toml"), engine).unwrap();
    // A scene with more to write than what the grader itself does.
    let scheme = classroom.path("small.toml");
    let large = fs::read_to_string(&scheme).unwrap().replace("plane:5.5", "cards");
    fs::write(scheme, large).unwrap();
    for matcher in ["rv", "fast"] {
        let inner = classroom.command("grade", &["--engines", "engines", "--matcher", matcher]);
        expect_graders_fault(with_little_disk(64, inner), "File too large");
    }
}

/// Runs a command with [`JSON`] and a limit of file size, which stands for a full disk.
fn with_little_disk(blocks: u32, inner: Command) -> Output {
    let mut command = Command::new("/bin/sh");
    command.arg("-c").arg(format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\""));
    command.arg(inner.get_program()).args(inner.get_args()).args(JSON);
    command.current_dir(inner.get_current_dir().unwrap());
    for (name, value) in inner.get_envs() {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
    command.output().unwrap()
}
