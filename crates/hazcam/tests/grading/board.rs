//! `hazcam board` from the first entry to the page.

use std::fs;
use std::process::Output;

use serde_json::Value;

use crate::classroom::{Classroom, HONEST};

/// A small hold-out that takes no time.
const HOLDOUT: &str = r#"
name = "Hold-out"

[[test]]
name = "Hold-out"
part = "best"
scene = "ground"
max_disparity = 64
max_e_rms = 5.0
max_p_bad = 0.11
points = 0
cpu_seconds = 20

[scene.ground]
kind = "mars"
seed = 99
columns = 200
rows = 150
box = "64,0,199,149"
"#;

/// A board that ranks on the small hold-out.
pub struct Course(pub Classroom);

impl Course {
    pub fn new() -> Option<Self> {
        let classroom = Classroom::without_python()?;
        fs::write(classroom.path("holdout.toml"), HOLDOUT).unwrap();
        Some(Self(classroom))
    }

    fn with_python() -> Option<Self> {
        let classroom = Classroom::with_python()?;
        fs::write(classroom.path("holdout.toml"), HOLDOUT).unwrap();
        Some(Self(classroom))
    }

    /// `board` with these arguments; exit status, stdout, stderr.
    pub fn run(&self, arguments: &[&str]) -> (i32, String, String) {
        let mut command = self.0.command("board", arguments);
        let Output { status, stdout, stderr } = command.output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (status.code().unwrap(), text(stdout), text(stderr))
    }

    /// Runs what must succeed; stdout.
    #[track_caller]
    pub fn done(&self, arguments: &[&str]) -> String {
        let (status, stdout, stderr) = self.run(arguments);
        assert_eq!(status, 0, "{arguments:?}\n{stdout}{stderr}");
        stdout
    }

    /// The ranking as JSON.
    fn ranking(&self) -> Vec<Value> {
        serde_json::from_str(&self.done(&["show", "--format", "json"])).unwrap()
    }
}

/// Adds an entrant under the small scheme.
pub const ADD: [&str; 5] = ["add", "--scheme", "small.toml", "--holdout", "holdout.toml"];

fn with<'a>(arguments: &[&'a str]) -> Vec<&'a str> {
    ADD.into_iter().chain(arguments.iter().copied()).collect()
}

#[test]
fn entrants_are_ranked_renamed_and_removed() {
    let Some(course) = Course::new() else { return };
    let text = course.done(&with(&["--matcher", "fast:fast", "--owner", "her"]));
    assert!(
        text.contains("Hold-out                 limit 20 CPU s\n  OK        no points   E_RMS")
    );
    assert!(text.ends_with("Entered `fast:fast`: place 1 of 1\n"), "{text}");
    course.done(&with(&["--matcher", "best", "--baseline"]));
    let text =
        course.done(&with(&["--matcher", "fast:best", "--secret-id", "Zwei", "--owner", "him"]));
    assert!(text.contains("Entered `Zwei`: place 1 of 2"), "{text}");
    let ranking = course.ranking();
    let row = |at: usize| {
        let each = &ranking[at];
        (
            each["entry"]["secret_id"].as_str().unwrap(),
            each["place"].as_u64(),
            each["bonus"].as_f64(),
        )
    };
    // The baseline is the same matcher: it stands beside its twin, without a place.
    let mut first = [row(0), row(1)];
    first.sort_by_key(|each| each.0);
    assert_eq!(first, [("Zwei", Some(1), Some(5.0)), ("best", None, Some(0.0))]);
    assert_eq!(row(2), ("fast:fast", Some(2), Some(3.0)));
    assert_eq!(ranking[2]["total"].as_f64(), Some(5.0 + 3.0));
    // The score is the documented one.
    let scores = &ranking[2]["entry"]["holdout"]["scores"];
    let (e_rms, p_bad) = (scores["e_rms"].as_f64().unwrap(), scores["p_bad"].as_f64().unwrap());
    let score = ranking[2]["score"].as_f64().unwrap();
    assert!((score - (e_rms / 5.0 + p_bad / 0.11) / 2.0).abs() < 1e-12);
    // The sky has no disparity, and what is left of the box is not asked for.
    assert!((1..=136 * 150).contains(&scores["pixels"].as_u64().unwrap()), "{scores}");

    let (status, stdout, stderr) = course.run(&with(&["--matcher", "fast", "--secret-id", "zwei"]));
    assert_eq!((status, stdout.as_str()), (2, ""), "refused before the work");
    assert!(stderr.contains("the secret ID `zwei` is taken"), "{stderr}");
    let alike = with(&["--matcher", "fast", "--secret-id", "Zw\u{435}i"]);
    let (status, stdout, stderr) = course.run(&alike);
    assert_eq!((status, stdout.as_str()), (2, ""), "refused before the work");
    assert!(stderr.contains("looks like `Zwei`, which somebody else has"), "{stderr}");
    let text = course.done(&with(&["--matcher", "fast", "--owner", "him", "--secret-id", "Drei"]));
    assert!(text.contains("in the place of the earlier entry `Zwei` of him"), "{text}");
    course.done(&["rename", "Drei", "Four"]);
    course.done(&["remove", "best"]);
    let table = course.done(&["show"]);
    assert!(
        table.contains("Four") && !table.contains("Drei") && !table.contains("best"),
        "{table}"
    );
    assert_eq!(course.ranking().len(), 2);
    // Whose they are is told to who asks for it alone.
    let csv = course.done(&["show", "--owners", "--format", "csv"]);
    let of_four = csv.lines().find(|line| line.contains(",Four,")).expect("it is on the board");
    let heads = csv.lines().next().unwrap();
    assert!(heads.ends_with(",owner,doubts") && of_four.contains(",him,"), "{csv}");
    let json =
        |arguments: &[&str]| course.done(&[&["show", "--format", "json"], arguments].concat());
    assert!(json(&["--owners"]).contains("\"owner\": \"him\""));
    assert!(
        !table.contains("him")
            && !json(&[]).contains("\"owner\"")
            && !json(&[]).contains("\"entrant\"")
    );
}

#[test]
fn who_answers_as_somebody_else_is_told_to_whoever_grades() {
    let Some(course) = Course::new() else { return };
    let add = |owner: &str| {
        let (status, _, stderr) = course.run(&with(&[
            "--matcher",
            "fast",
            "--owner",
            owner,
            "--secret-id",
            &format!("Anna {owner}"),
        ]));
        assert_eq!(status, 0, "{stderr}");
        stderr
    };
    assert!(!add("one").contains("same scores"));
    let told = add("two");
    assert!(
        told.contains("`Anna two` is doubtful: the same scores on the hold-out as `Anna one`"),
        "{told}"
    );
    let csv = course.done(&["show", "--owners", "--format", "csv"]);
    assert!(csv.contains(",two,\"the same scores on the hold-out as `Anna one`,"), "{csv}");
    let json = course.done(&["show", "--format", "json"]);
    assert!(!json.contains("doubts"), "{json}");
}

#[test]
fn what_nobody_may_see_is_kept_from_submissions() {
    let Some(course) = Course::new() else { return };
    let folder = course.0.submission("mine", HONEST);
    let folder = folder.to_str().unwrap();
    for board in ["board.sqlite", "below/../board.sqlite"] {
        let board = format!("{folder}/{board}");
        fs::create_dir_all(format!("{folder}/below")).unwrap();
        let (status, stdout, stderr) = course.run(&with(&[folder, "--board", &board]));
        assert_eq!((status, stdout.as_str()), (2, ""), "{stderr}");
        assert!(stderr.contains("board.sqlite lies in the submission"), "{stderr}");
        assert!(!std::path::Path::new(&board).exists());
    }
    fs::copy(course.0.path("holdout.toml"), format!("{folder}/holdout.toml")).unwrap();
    let holdout = format!("{folder}/holdout.toml");
    let (_, _, stderr) =
        course.run(&["add", "--scheme", "small.toml", "--holdout", &holdout, folder]);
    assert!(stderr.contains("holdout.toml lies in the submission"), "{stderr}");
}

#[test]
fn a_submission_is_entered_under_its_secret_id() {
    let Some(course) = Course::with_python() else { return };
    course.0.submission("alice", HONEST);
    let text = course.done(&with(&["alice"]));
    assert!(text.ends_with("Entered `Secret alice`: place 1 of 1\n"), "{text}");
    fs::remove_file(course.0.path("alice/secret_id.py")).unwrap();
    let (status, _, stderr) = course.run(&with(&["alice"]));
    assert_eq!(status, 2);
    assert!(stderr.contains("no usable secret ID"), "{stderr}");
    let (status, stdout, stderr) = course.run(&with(&["alice", "--secret-id", "Ally"]));
    assert_eq!((status, stdout.as_str()), (2, ""), "refused before the work");
    assert!(stderr.contains("give --owner 'alice'"), "{stderr}");
    let text = course.done(&with(&["alice", "--secret-id", "Ally", "--owner", "alice"]));
    assert!(text.contains("in the place of the earlier entry `Secret alice` of alice"), "{text}");
    // One that crashes on the hold-out is entered, without a place.
    let crash = "def NAME(Il, Ir, bbox, maxd):\n    assert maxd < 20\n    return Il * 0 + 5\n";
    let source = crash.replace("NAME", "stereo_disparity_best");
    course.0.submission("bob", HONEST);
    fs::write(course.0.path("bob/stereo_disparity_best.py"), source).unwrap();
    let text = course.done(&with(&["bob"]));
    assert!(text.contains("without a place, since it has no answer on the hold-out"), "{text}");
    assert!(text.contains("AssertionError"), "{text}");
}

#[test]
fn hand_ins_of_one_file_name_do_not_replace_each_other() {
    let Some(course) = Course::with_python() else { return };
    course.0.submission("alice/handin", HONEST);
    course.0.submission("bob/handin", HONEST);
    course.done(&with(&["alice/handin"]));
    let (status, _, stderr) = course.run(&with(&["bob/handin"]));
    assert_eq!(status, 2);
    for words in ["`handin`", "`Secret alice/handin` and not `Secret bob/handin`", "--owner NAME"] {
        assert!(stderr.contains(words), "`{words}` is not in: {stderr}");
    }
    course.done(&with(&["bob/handin", "--owner", "bob"]));
    assert_eq!(course.ranking().len(), 2);
    // The folder where one is has a name as well.
    let arguments = ["add", ".", "--scheme", "../../small.toml", "--again"];
    let mut command = course.0.command("board", &arguments);
    command.args(["--board", "../../board.sqlite"]).current_dir(course.0.path("alice/handin"));
    let output = command.output().unwrap();
    let stdout = String::from_utf8(output.stdout).unwrap();
    assert!(stdout.contains("earlier entry `Secret alice/handin` of handin"), "{stdout}");
}

#[test]
fn what_is_on_the_board_as_it_is_is_passed_over() {
    let Some(course) = Course::with_python() else { return };
    course.0.submission("alice", HONEST);
    let text = course.done(&with(&["alice"]));
    assert!(text.contains("Entered `Secret alice`"), "{text}");
    let text = course.done(&with(&["alice"]));
    assert!(text.contains("`Secret alice` of alice stands as it is since 2"), "{text}");
    assert!(!text.contains("limit"), "{text}");
    for (changed, words) in [
        (&["alice", "--again"][..], "Entered `Secret alice`"),
        (&["alice", "--baseline"], "Entered `Secret alice`: a baseline"),
        (&["alice"], "Entered `Secret alice`: place 1"),
        (&["alice", "--secret-id", "Other", "--owner", "alice"], "Entered `Other`"),
    ] {
        let text = course.done(&with(changed));
        assert!(text.contains(words), "{changed:?}: {text}");
    }
    fs::write(course.0.path("alice/notes.txt"), "changed").unwrap();
    let text = course.done(&with(&["alice", "--owner", "alice"]));
    assert!(text.contains("Entered `Secret alice`"), "{text}");
    // Who ran out of time is graded again where there is more of it, and only there.
    course.0.submission("slow", &HONEST.replace("    return", "    while maxd: pass\n    return"));
    for (limit, words) in [("0.2", "Entered"), ("0.2", "stands as it is"), ("0.4", "Entered")] {
        let text = course.done(&with(&["slow", "--cpu-limit", limit]));
        assert!(text.contains(words), "{limit}: {text}");
    }
}

#[test]
fn a_name_that_was_given_stays_with_its_owner() {
    let Some(course) = Course::with_python() else { return };
    course.0.submission("alice", HONEST);
    course.done(&with(&["alice", "--owner", "alice"]));
    course.done(&["rename", "Secret alice", "Polite"]);
    for _ in 0..2 {
        let text = course.done(&with(&["alice", "--owner", "alice", "--again"]));
        assert!(text.contains("Entered `Polite`") && text.contains("that it was given"), "{text}");
    }
    // Who has only a file's name is known by what is in it, and may else be somebody else.
    assert!(course.done(&with(&["alice", "--again"])).contains("Entered `Polite`"));
    fs::write(course.0.path("alice/more.py"), "").unwrap();
    let (status, _, stderr) = course.run(&with(&["alice", "--again"]));
    assert!(status == 2 && stderr.contains("--secret-id 'Polite'"), "{stderr}");
    let again = ["alice", "--owner", "alice", "--again", "--secret-id", "Other"];
    assert!(course.done(&with(&again)).contains("Entered `Other`"));
    assert_eq!(course.ranking().len(), 1);
}

#[test]
fn a_damaged_hand_in_replaces_nothing() {
    let Some(course) = Course::with_python() else { return };
    course.0.submission("alice", HONEST);
    course.done(&with(&["alice"]));
    fs::write(course.0.path("alice.zip"), "garbage").unwrap();
    let damaged = with(&["alice.zip", "--owner", "alice", "--secret-id", "Secret alice"]);
    let (status, _, stderr) = course.run(&damaged);
    assert_eq!(status, 2);
    assert!(stderr.contains("the entry `Secret alice` of alice stays as it is"), "{stderr}");
    let ranking = course.ranking();
    assert_eq!((ranking.len(), ranking[0]["place"].as_u64()), (1, Some(1)));
}

#[test]
fn grading_does_not_write_over_the_board() {
    let Some(course) = Course::new() else { return };
    course.done(&with(&["--matcher", "fast"]));
    let arguments = ["--matcher", "fast", "--scheme", "small.toml", "-o", "board.sqlite"];
    let mut command = course.0.command("grade", &arguments);
    let output = command.env("HAZCAM_BOARD", course.0.path("board.sqlite")).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert_eq!(course.ranking().len(), 1);
}

#[test]
fn all_rank_on_one_holdout() {
    let Some(course) = Course::new() else { return };
    course.done(&with(&["--matcher", "fast"]));
    // Later entries need not name it.
    course.done(
        &["add", "--scheme", "small.toml", "--matcher", "fast", "--owner", "2"]
            .into_iter()
            .chain(["--secret-id", "second"])
            .collect::<Vec<_>>(),
    );
    let other = HOLDOUT.replace("seed = 99", "seed = 100");
    fs::write(course.0.path("holdout.toml"), other).unwrap();
    let (status, _, stderr) = course.run(&with(&["--matcher", "fast"]));
    assert_eq!(status, 2);
    assert!(stderr.contains("ranks on another hold-out"), "{stderr}");
}

/// Puts a pair on disk, in which everything is 4 pixels away, and makes it the hold-out.
fn with_pair_on_disk(course: &Course) {
    picture(course, "l.png", 0);
    picture(course, "r.png", 4);
    let truth = raster::Plane::filled(90, 60, 4.0f32);
    formats::write_disparity(course.0.path("t.pfm"), &truth).unwrap();
    let at = HOLDOUT.find("[scene.ground]").unwrap();
    let files = "[scene.ground]\nleft = 'l.png'\nright = 'r.png'\ntruth = 't.pfm'\n";
    fs::write(course.0.path("holdout.toml"), format!("{}{files}", &HOLDOUT[..at])).unwrap();
}

fn picture(course: &Course, name: &str, shift: usize) {
    let texture = |x: usize, y: usize| ((x * 7919 + y * 104_729) % 251) as u8;
    let plane = raster::Plane::from_fn(90, 60, |x, y| texture(x + shift, y));
    formats::write_image(course.0.path(name), &raster::Image::Grey8(plane)).unwrap();
}

#[test]
fn a_pair_on_disk_is_a_holdout_while_its_files_stay() {
    let Some(course) = Course::new() else { return };
    with_pair_on_disk(&course);
    course.done(&with(&["--matcher", "fast"]));
    picture(&course, "l.png", 1);
    let (status, _, stderr) = course.run(&["add", "--scheme", "small.toml", "--matcher", "fast"]);
    assert_eq!(status, 2);
    assert!(stderr.contains("its files were changed since"), "{stderr}");
    fs::remove_file(course.0.path("t.pfm")).unwrap();
    let (status, _, stderr) = course.run(&["add", "--scheme", "small.toml", "--matcher", "fast"]);
    assert_eq!(status, 2);
    assert!(stderr.contains("hold-out") && stderr.contains("t.pfm"), "{stderr}");
}

#[test]
fn the_secret_is_out_of_every_entrants_reach() {
    let Some(course) = Course::new() else { return };
    let folder = course.0.path("engines");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("mine.toml"), "name = 'mine'\ncommand = ['/bin/true']\n").unwrap();
    // An engine may read the folder of its definition, and there lies the board.
    let (status, stdout, stderr) = course.run(&with(&[
        "--matcher",
        "fast:mine",
        "--engines",
        "engines",
        "--board",
        "engines/board.sqlite",
    ]));
    assert_eq!(status, 2);
    assert!(stdout.contains("engines/board.sqlite, which tells the truth"), "{stdout}");
    assert!(stderr.contains("is not entered: the grader failed"), "{stderr}");
    // Nor do the tests before the hold-out's run it.
    assert_eq!(stdout.matches("  XX ").count(), 2, "{stdout}");
}

#[test]
fn the_board_is_out_of_reach_when_the_holdout_is_files() {
    let Some(course) = Course::new() else { return };
    with_pair_on_disk(&course);
    let folder = course.0.path("engines");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("mine.toml"), "name = 'mine'\ncommand = ['/bin/true']\n").unwrap();
    let mine = ["--matcher", "fast:mine", "--engines", "engines"];
    let add = |board: &'static str| course.run(&with(&[&mine[..], &["--board", board]].concat()));
    let (status, stdout, _) = add("engines/board.sqlite");
    assert_eq!(status, 2);
    assert!(stdout.contains("engines/board.sqlite, which tells the truth"), "{stdout}");
    // Nor may the hold-out's file, which can name a seed, lie there.
    fs::create_dir(folder.join("below")).unwrap();
    fs::write(folder.join("below/holdout.toml"), HOLDOUT).unwrap();
    let given = ["add", "--scheme", "small.toml", "--holdout", "engines/below/holdout.toml"];
    let (status, stdout, _) =
        course.run(&[&given[..], &mine, &["--board", "other.sqlite"]].concat());
    assert_eq!(status, 2);
    assert!(stdout.contains("engines/below/holdout.toml, which tells the truth"), "{stdout}");
}

#[test]
fn a_name_that_a_test_has_already_is_refused_before_the_work() {
    let Some(course) = Course::new() else { return };
    let same = HOLDOUT.replacen(
        "name = \"Hold-out\"\n\n[[test]]\nname = \"Hold-out\"",
        "name = \"x\"\n\n[[test]]\nname = \"Part 1, wall\"",
        1,
    );
    fs::write(course.0.path("holdout.toml"), same).unwrap();
    let (status, stdout, stderr) = course.run(&with(&["--matcher", "fast"]));
    assert_eq!((status, stdout.as_str()), (2, ""));
    assert!(
        stderr.contains(
            "the hold-out is called `Part 1, wall`, and so is a test of the scheme `Small`: give \
             that test another name, or the hold-out"
        ),
        "{stderr}"
    );
    assert!(!course.0.path("board.sqlite").exists(), "mistakes begin no board");
    // A board that is begun keeps its name; a scheme that comes later must not take it.
    fs::write(course.0.path("holdout.toml"), HOLDOUT).unwrap();
    course.done(&with(&["--matcher", "fast"]));
    let scheme = fs::read_to_string(course.0.path("small.toml")).unwrap();
    let scheme = scheme.replace("Part 1, wall", "Hold-out");
    fs::write(course.0.path("small.toml"), scheme).unwrap();
    let (status, stdout, stderr) =
        course.run(&["add", "--scheme", "small.toml", "--matcher", "fast"]);
    assert_eq!((status, stdout.as_str()), (2, ""));
    assert!(stderr.ends_with("give that test another name\n"), "{stderr}");
}

#[test]
fn points_by_other_tests_do_not_come_beside_those_of_the_first() {
    let Some(course) = Course::new() else { return };
    let add = |matcher: &'static str, board: &'static str| {
        course.run(&with(&["--matcher", matcher, "--board", board]))
    };
    assert_eq!(add("fast", "one.sqlite").0, 0);
    let small = fs::read_to_string(course.0.path("small.toml")).unwrap();
    let write = |text: &str| fs::write(course.0.path("small.toml"), text).unwrap();
    for (from, to) in [
        ("points = 2", "points = 6"),
        ("max_e_rms = ", "max_e_rms = 1"),
        ("max_disparity = 12", "max_disparity = 11"),
        ("Part 1, wall", "Part 1, fence"),
        ("part = \"fast\"", "part = \"best\""),
        ("seed = 1", "seed = 2"),
    ] {
        let other = small.replacen(from, to, 1);
        assert_ne!(other, small, "{from}");
        write(&other);
        let (status, stdout, stderr) = add("best", "one.sqlite");
        assert_eq!((status, stdout.as_str()), (2, ""), "{to}");
        let words = "not those by which `fast` on this board got its points: give the --scheme";
        assert!(stderr.contains(words), "{stderr}");
    }
    // Another machine may be given other limits of CPU time.
    write(&small.replace("cpu_seconds = ", "cpu_seconds = 1"));
    assert_eq!(add("best", "one.sqlite").0, 0);
    // Who is alone on a board may be graded anew by other tests.
    write(&small);
    assert_eq!(add("fast", "two.sqlite").0, 0);
    write(&small.replacen("points = 2", "points = 6", 1));
    assert_eq!(add("fast", "two.sqlite").0, 0);
}

#[test]
fn many_at_once_are_all_entered() {
    let Some(course) = Course::new() else { return };
    let children: Vec<_> = (0..5)
        .map(|n| {
            let owner = format!("owner {n}");
            // Without a hold-out given, one of them draws the seed for all.
            let arguments = ["add", "--scheme", "small.toml", "--matcher", "fast", "--owner"];
            let mut command = course.0.command("board", &arguments);
            command.args([&owner, "--secret-id", &owner]);
            command.stdout(std::process::Stdio::null()).spawn().unwrap()
        })
        .collect();
    for mut child in children {
        assert!(child.wait().unwrap().success());
    }
    let ranking = course.ranking();
    assert_eq!(ranking.len(), 5);
    let score = |each: &Value| each["score"].as_f64().unwrap();
    assert!(ranking.iter().all(|each| score(each) == score(&ranking[0])), "one hold-out for all");
}

#[test]
fn mistakes_are_named() {
    let Some(course) = Course::new() else { return };
    fs::write(course.0.path("notes.txt"), "no database\n".repeat(100)).unwrap();
    for (arguments, words) in [
        (vec!["show"], "there is no board board.sqlite: `hazcam board add` begins one"),
        (vec!["show", "--board", "notes.txt"], "notes.txt is no leaderboard"),
        (vec!["add"], "name a submission"),
        (with(&["--matcher", "fast", "--secret-id", "abc"]), "`abc` cannot be a secret ID"),
        (with(&["--matcher", "fast", "--owner", ""]), "cannot name an owner"),
        (vec!["add", "--matcher", "fast", "--holdout", "none.toml"], "none.toml"),
        (with(&["nowhere"]), "there is no nowhere"),
        (
            vec!["add", "--matcher", "fast", "--data", "nowhere"],
            "HAZCAM_DATA or --data: nowhere is not a folder\n",
        ),
    ] {
        let (status, stdout, stderr) = course.run(&arguments);
        assert_eq!((status, stdout.as_str()), (2, ""), "{arguments:?}");
        assert!(stderr.contains(words), "{arguments:?}: {stderr}");
    }
    assert!(!course.0.path("board.sqlite").exists(), "mistakes begin no board");
    course.done(&with(&["--matcher", "fast"]));
    for (arguments, words) in [
        (
            ["rename", "nobody", "somebody"],
            "nobody on the board is called `nobody`; there are fast",
        ),
        (["rename", "fast", "x"], "`x` cannot be a secret ID"),
        (
            ["export", "no/such/board.html", "--quiet"],
            "no/such/board.html: the folder no/such does not exist; create it first\n",
        ),
        (["export", "board.txt", "--quiet"], "board.txt is no name of a page for a browser"),
        (
            ["export", "./board.sqlite", "--quiet"],
            "the page ./board.sqlite would replace an input: name another file\n",
        ),
    ] {
        let (status, _, stderr) = course.run(&arguments);
        assert_eq!(status, 2);
        assert!(stderr.contains(words), "{arguments:?}: {stderr}");
    }
    assert!(course.done(&["show"]).contains("fast"), "the board is as it was");
}
