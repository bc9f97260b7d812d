//! A process that is killed in the middle of writing leaves a board that is valid and has
//! everything that it had reported as written.
#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use arena::board::{Board, Entry, Holdout, Picture};

/// Names the board to the child.
const BOARD: &str = "HAZCAM_TEST_BOARD";

fn entry(secret_id: &str) -> Entry {
    serde_json::from_value(serde_json::json!({
        "secret_id": secret_id, "baseline": false, "machine": "",
        "report": {
            "hazcam": "", "scheme": "", "entrant": "", "secret_id": null, "findings": [],
            "tests": [], "points": 0.0, "max_points": 0.0, "protocol": "", "confinement": "",
            "python": null, "calibration": { "before_seconds": 1.0, "after_seconds": 1.0 },
        },
        "holdout": {
            "name": "h", "part": "best", "scene": "h", "outcome": "OK", "message": null,
            "scores": null, "max_e_rms": 1.0, "max_p_bad": 1.0, "cpu_limit_seconds": 1.0,
            "points": 0.0, "max_points": 0.0, "remarks": [], "output": "",
            "usage": { "cpu_seconds": null, "wall_seconds": 0.0, "peak_memory_bytes": null },
            "startup": { "cpu_seconds": null, "wall_seconds": 0.0, "peak_memory_bytes": null },
        },
    }))
    .unwrap()
}

/// What the child does: adds entries without end, telling each when it is written. Alone, it has
/// nothing to do.
#[test]
fn writer() {
    let Some(path) = std::env::var_os(BOARD) else { return };
    let mut board =
        Board::open_or_begin(Path::new(&path), &Holdout::secret(600.0).unwrap(), "print").unwrap();
    let picture =
        Picture { test: "h".into(), disparity: vec![7; 200_000], error: vec![8; 200_000] };
    for n in 0.. {
        let id = format!("{}-{n}", std::process::id());
        board.add(id.as_str(), &entry(&id), std::slice::from_ref(&picture), &[]).unwrap();
        println!("\nwritten {id}");
    }
}

#[test]
fn a_killed_writer_leaves_a_valid_board() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("board.sqlite");
    let mut written = Vec::new();
    for round in 0..12 {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "writer", "--nocapture", "--test-threads=1"])
            .env(BOARD, &path)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut told = BufReader::new(child.stdout.take().unwrap()).lines();
        // It is at work from its first word on; the kill comes at another moment every round.
        let first = told.by_ref().map(Result::unwrap).find(|line| line.starts_with("written"));
        std::thread::sleep(Duration::from_millis(3 * round));
        child.kill().unwrap();
        child.wait().unwrap();
        let rest = told.map(Result::unwrap).filter(|line| line.starts_with("written "));
        written
            .extend(first.into_iter().chain(rest).map(|line| line["written ".len()..].to_owned()));

        let board = Board::open(&path).unwrap();
        let entries = board.entries().unwrap();
        for id in &written {
            assert!(entries.iter().any(|entry| entry.secret_id == *id), "{id} is lost");
        }
        // What was being written is there with its picture or not at all.
        for entry in &entries {
            assert_eq!(board.pictures(&entry.secret_id).unwrap().len(), 1, "{}", entry.secret_id);
        }
        let check: String = rusqlite::Connection::open(&path)
            .unwrap()
            .query_row("PRAGMA integrity_check", [], |row| row.get(0))
            .unwrap();
        assert_eq!(check, "ok");
    }
    assert!(written.len() >= 12);
}
