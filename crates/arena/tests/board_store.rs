//! The board's file: what is added stays, whoever else adds at the same time, and what is no board
//! is told so.

use std::path::Path;

use arena::board::{Added, Board, BoardError, Entry, Holdout, Owner, Picture};

/// An entry of this name, made from what JSON needs to say.
fn entry(secret_id: &str) -> Entry {
    let result = serde_json::json!({
        "name": "Hold-out", "part": "best", "scene": "hold-out", "outcome": "TO",
        "message": "too slow", "scores": null, "max_e_rms": 5.0, "max_p_bad": 0.11,
        "cpu_limit_seconds": 600.0, "points": 0.0, "max_points": 0.0,
        "usage": { "cpu_seconds": 1.5, "wall_seconds": 2.0, "peak_memory_bytes": 1000 },
        "startup": { "cpu_seconds": 0.1, "wall_seconds": 0.2, "peak_memory_bytes": null },
        "remarks": [], "output": "",
    });
    serde_json::from_value(serde_json::json!({
        "secret_id": secret_id,
        "baseline": false,
        "report": {
            "hazcam": "0.1.0", "scheme": "Small", "entrant": "handin", "secret_id": secret_id,
            "findings": [], "tests": [], "points": 7.0, "max_points": 50.0, "protocol": "",
            "confinement": "sandbox", "python": null,
            "calibration": { "before_seconds": 0.001, "after_seconds": 0.001 },
        },
        "holdout": result,
        "machine": "a machine",
    }))
    .unwrap()
}

fn begin(path: &Path) -> Board {
    Board::open_or_begin(path, &Holdout::secret(600.0).unwrap(), "print").unwrap()
}

fn names(board: &Board) -> Vec<String> {
    board.entries().unwrap().into_iter().map(|entry| entry.secret_id).collect()
}

#[test]
fn an_entry_comes_back_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("board.sqlite");
    let mut board = begin(&path);
    let picture = Picture { test: "Hold-out".into(), disparity: vec![1, 2, 3], error: vec![4, 5] };
    board.add("her", &entry("Jaff Bozos"), std::slice::from_ref(&picture), &[]).unwrap();
    drop(board);
    let board = Board::open(&path).unwrap();
    let mut found = board.entries().unwrap().remove(0);
    assert!(found.added.ends_with('Z') && found.added.len() == 20, "{}", found.added);
    found.added = String::new();
    assert_eq!(found, entry("Jaff Bozos"));
    assert_eq!(board.pictures("jaff bozos").unwrap(), [picture]);
    assert_eq!(board.holdout().unwrap().1, "print");
}

#[test]
fn an_owner_has_one_entry_and_a_name_one_owner() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = begin(&folder.path().join("board.sqlite"));
    let mut add = |owner: &str, id: &str| board.add(owner, &entry(id), &[], &[]);
    assert_eq!(add("her", "first").unwrap(), Added::New);
    assert_eq!(add("her", "first").unwrap(), Added::Replaced("first".into()));
    assert_eq!(add("her", "second").unwrap(), Added::Replaced("first".into()));
    assert_eq!(add("him", "first").unwrap(), Added::New);
    assert!(matches!(add("him", "SECOND"), Err(BoardError::Taken(id)) if id == "SECOND"));
    assert!(matches!(add("her", "abc"), Err(BoardError::Name(_))));
    assert_eq!(names(&board), ["second", "first"]);
}

#[test]
fn the_same_hand_in_keeps_its_time_and_place_and_another_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("board.sqlite");
    let mut board = begin(&path);
    let of = |id: &str, handin: Option<&str>, tests: &str| Entry {
        handin: handin.map(str::to_owned),
        tests: tests.to_owned(),
        ..entry(id)
    };
    let first = of("first", Some("a"), "t");
    board.add("her", &first, &[], &[]).unwrap();
    board.add("him", &of("second", Some("b"), "t"), &[], &[]).unwrap();
    // So that a second more or less does not decide.
    let long_ago = "2020-01-01T00:00:00Z";
    let database = rusqlite::Connection::open(&path).unwrap();
    database
        .execute(
            "UPDATE entry SET added = ?1, content = json_set(content, '$.added', ?1)",
            [long_ago],
        )
        .unwrap();
    assert_eq!(names(&board), ["first", "second"]);
    board.add("her", &first, &[], &[]).unwrap();
    assert_eq!(names(&board), ["first", "second"]);
    let kept = board.entry_of("her").unwrap().unwrap();
    assert_eq!((&kept.added[..], kept.is_of(Some("a"), "t")), (long_ago, true));
    assert_eq!(board.entry_of("nobody").unwrap(), None);
    // Other files, and engines, of which nobody knows whether they are the same.
    for other in [of("first", Some("c"), "t"), of("first", None, "t"), of("first", None, "t")] {
        board.add("her", &other, &[], &[]).unwrap();
        assert_eq!(names(&board), ["second", "first"]);
        assert_ne!(board.entry_of("her").unwrap().unwrap().added, long_ago);
    }
}

#[test]
fn a_guessed_owner_replaces_only_an_entry_of_the_same_name() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = begin(&folder.path().join("board.sqlite"));
    let guessed = Owner::Guessed("handin");
    assert_eq!(board.add(guessed, &entry("first"), &[], &[]).unwrap(), Added::New);
    let again = Added::Replaced("first".into());
    assert_eq!(board.add(guessed, &entry("First"), &[], &[]).unwrap(), again);
    assert!(matches!(board.admit(guessed, "second"), Err(BoardError::Guessed { .. })));
    let refused = board.add(guessed, &entry("second"), &[], &[]).unwrap_err();
    assert!(matches!(refused, BoardError::Guessed { .. }), "{refused}");
    assert_eq!(names(&board), ["First"]);
    board.admit("handin", "second").unwrap();
    assert!(board.add("handin", &entry("second"), &[], &[]).is_ok());
    assert_eq!(names(&board), ["second"]);
}

#[test]
fn names_are_changed_and_taken_off() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = begin(&folder.path().join("board.sqlite"));
    let picture = Picture { test: "t".into(), disparity: vec![1], error: vec![2] };
    board.add("her", &entry("rude word"), &[picture], &[]).unwrap();
    board.add("him", &entry("polite"), &[], &[]).unwrap();
    board.rename("Rude Word", "removed by teacher").unwrap();
    let kept = serde_json::to_string(&board.entries().unwrap()).unwrap();
    assert!(!kept.contains("Rude Word"), "{kept}");
    assert_eq!(names(&board), ["removed by teacher", "polite"]);
    assert_eq!(board.pictures("removed by teacher").unwrap().len(), 1);
    assert!(matches!(board.rename("polite", "Removed by teacher"), Err(BoardError::Taken(_))));
    assert!(matches!(board.rename("polite", "x"), Err(BoardError::Name(_))));
    // Another letter of the same picture: a Cyrillic o.
    assert!(matches!(
        board.rename("polite", "rem\u{43e}ved by teacher"),
        Err(BoardError::Alike { .. })
    ));
    board.remove("removed by teacher").unwrap();
    assert_eq!(names(&board), ["polite"]);
    let error = board.remove("removed by teacher").unwrap_err().to_string();
    assert_eq!(error, "nobody on the board is called `removed by teacher`; there are polite");
    assert!(board.pictures("removed by teacher").unwrap().is_empty());
}

#[test]
fn many_at_once_lose_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("board.sqlite");
    std::thread::scope(|scope| {
        for writer in 0..8 {
            let path = &path;
            scope.spawn(move || {
                for n in 0..10 {
                    let id = format!("{writer} has {n}");
                    begin(path).add(id.as_str(), &entry(&id), &[], &[]).unwrap();
                }
            });
        }
    });
    let board = Board::open(&path).unwrap();
    let mut found = names(&board);
    found.sort();
    let mut expected: Vec<String> =
        (0..8).flat_map(|w| (0..10).map(move |n| format!("{w} has {n}"))).collect();
    expected.sort();
    assert_eq!(found, expected);
}

#[test]
fn of_several_that_begin_a_board_one_draws_the_holdout() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("board.sqlite");
    let prints: Vec<(Holdout, String)> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..6)
            .map(|n| {
                let path = &path;
                scope.spawn(move || {
                    let holdout = Holdout::secret(600.0).unwrap();
                    let board = Board::open_or_begin(path, &holdout, &n.to_string()).unwrap();
                    board.holdout().unwrap()
                })
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(prints.iter().all(|print| *print == prints[0]));
}

#[test]
fn what_is_no_board_is_told_so_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("board.sqlite");
    let error = Board::open(&path).unwrap_err().to_string();
    assert!(error.contains("there is no board") && error.contains("board add"), "{error}");
    std::fs::write(&path, "These are my notes and no database at all.\n".repeat(40)).unwrap();
    let before = std::fs::read(&path).unwrap();
    let error = Board::open(&path).unwrap_err().to_string();
    assert!(error.contains("is no leaderboard: it is no SQLite database"), "{error}");
    let holdout = Holdout::secret(600.0).unwrap();
    assert!(matches!(
        Board::open_or_begin(&path, &holdout, "print"),
        Err(BoardError::Foreign { .. })
    ));
    assert_eq!(std::fs::read(&path).unwrap(), before);
    std::fs::write(&path, "").unwrap();
    assert!(Board::open(&path).unwrap_err().to_string().contains("it is empty"));
    let nowhere = folder.path().join("no/such/folder/board.sqlite");
    assert!(matches!(
        Board::open_or_begin(&nowhere, &holdout, "print"),
        Err(BoardError::Create { .. })
    ));
}

#[cfg(unix)]
#[test]
fn nobody_else_can_read_the_secret() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("board.sqlite");
    begin(&path);
    assert_eq!(path.metadata().unwrap().permissions().mode() & 0o777, 0o600);
}

#[test]
fn points_by_other_tests_are_refused_where_somebody_else_has_some() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("board.sqlite");
    let mut board = begin(&path);
    let by = |tests: &str, name: &str| Entry { tests: tests.into(), ..entry(name) };
    board.add("her", &by("print", "Jaff Bozos"), &[], &[]).unwrap();
    // In the transaction itself too: another one may have come while this one was graded.
    let error = board.add("him", &by("other", "Elen Mosk"), &[], &[]).unwrap_err();
    let is_told = matches!(&error, BoardError::OtherTests { id, .. } if id == "Jaff Bozos");
    assert!(is_told, "{error}");
    assert!(board.admit_tests("him", ("Small", "other")).is_err());
    board.admit_tests("him", ("Small", "print")).unwrap();
    // Her own entry goes when the new one comes.
    board.add("her", &by("other", "Jaff Bozos"), &[], &[]).unwrap();
    // Entries of older boards do not say.
    let mut board = begin(&folder.path().join("older.sqlite"));
    board.add("him", &by("", "Elen Mosk"), &[], &[]).unwrap();
    board.add("her", &by("print", "Jaff Bozos"), &[], &[]).unwrap();
    assert_eq!(names(&board).len(), 2);
}
