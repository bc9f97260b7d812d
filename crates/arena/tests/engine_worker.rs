//! An engine defined by TOML answers pairs, and what it does wrong stays with the pair.
#![cfg(unix)]

use std::path::Path;
use std::time::Duration;

use arena::engine::{Attempt, Definition, Engines, Limits, Pair, Programs, Status, Worker};
use formats::npy;
use raster::{BoundingBox, DisparityRange, Image, Plane};

const SIZE: (usize, usize) = (64, 32);
const LOOP: &str = r#"echo '{"hazcam":"ready","protocol":1,"version":"2.5"}'; i=0
    while read line; do i=$((i+1))"#;
const DONE: &str = r#"echo "{\"hazcam\":\"done\",\"job\":$i}"; done"#;

/// A definition in `folder` whose program is this shell script.
fn scripted(folder: &Path, kind: &str, script: &str) -> Definition {
    std::fs::write(folder.join("engine.sh"), script).unwrap();
    let file = folder.join("fake.toml");
    let command = "['/bin/sh', '{folder}/engine.sh']";
    std::fs::write(&file, format!("name = 'fake'\nkind = '{kind}'\ncommand = {command}")).unwrap();
    Definition::read(&file).unwrap()
}

fn worker(definition: Definition) -> Worker {
    let limits = Limits { wall: Duration::from_secs(60), ..Limits::default() };
    Worker::new(definition, Programs::find("hazcam".into()), limits, 1).unwrap()
}

/// A pair in which everything is 5 pixels further left in the right image.
fn shifted(colour: bool) -> (Image, Image) {
    let value = |x: usize, y: usize| ((x * x * 7 + x * 13 + y * 29 + x * y * 3) % 251) as u8;
    let image = |shift: usize| match colour {
        false => Image::Grey8(Plane::from_fn(SIZE.0, SIZE.1, |x, y| value(x + shift, y))),
        true => Image::Rgb8(Plane::from_fn(SIZE.0, SIZE.1, |x, y| [value(x + shift, y); 3])),
    };
    (image(0), image(5))
}

fn ask(worker: &mut Worker, min: i32) -> Attempt {
    let (left, right) = shifted(false);
    worker.run(&Pair {
        left: &left,
        right: &right,
        bounds: BoundingBox::whole(SIZE.0, SIZE.1),
        range: DisparityRange::new(min, 15).unwrap(),
    })
}

#[test]
fn a_crash_costs_one_pair() {
    let folder = tempfile::tempdir().unwrap();
    npy::write(folder.path().join("answer.npy"), &Plane::filled(SIZE.0, SIZE.1, 5f32)).unwrap();
    let at = folder.path().display();
    let script = format!(
        "{LOOP}; if [ ! -e {at}/crashed ]; then touch {at}/crashed; kill -ABRT $$; fi
         cp {at}/answer.npy disparity.npy; {DONE}"
    );
    let mut worker = worker(scripted(folder.path(), "protocol", &script));
    let crashed = ask(&mut worker, 0);
    assert!(crashed.status.to_string().contains("SIGABRT"), "{}", crashed.status);
    assert_eq!(crashed.answer, None);
    for _ in 0..2 {
        let attempt = ask(&mut worker, 0);
        assert_eq!(attempt.status, Status::Done);
        assert_eq!(attempt.answer.unwrap().disparity, Plane::filled(SIZE.0, SIZE.1, 5.0));
    }
    assert_eq!(worker.version(), Some("2.5"));
    worker.end();
}

#[test]
fn a_wrong_answer_is_a_bad_result() {
    let folder = tempfile::tempdir().unwrap();
    npy::write(folder.path().join("answer.npy"), &Plane::filled(9, 9, 5f32)).unwrap();
    let script = format!("{LOOP}; cp {}/answer.npy disparity.npy; {DONE}", folder.path().display());
    let attempt = ask(&mut worker(scripted(folder.path(), "protocol", &script)), 0);
    assert!(attempt.status.to_string().starts_with("bad-result: disparity.npy has the shape"));
    let attempt =
        ask(&mut worker(scripted(folder.path(), "protocol", &format!("{LOOP}; {DONE}"))), 0);
    assert!(attempt.status.to_string().contains("no disparity file"), "{}", attempt.status);
}

#[test]
fn a_folder_in_a_files_place_costs_one_pair() {
    let folder = tempfile::tempdir().unwrap();
    npy::write(folder.path().join("answer.npy"), &Plane::filled(SIZE.0, SIZE.1, 5f32)).unwrap();
    let at = folder.path().display();
    for name in ["disparity", "reasons", "left"] {
        let script = format!(
            "{LOOP}; if [ ! -e {at}/{name} ]; then
             touch {at}/{name}; rm -f {name}.npy; mkdir -p {name}.npy/below; touch {name}.npy/x
             fi; [ -d disparity.npy ] || cp {at}/answer.npy disparity.npy; {DONE}"
        );
        let mut worker = worker(scripted(folder.path(), "protocol", &script));
        let first = ask(&mut worker, 0).status;
        assert_eq!(first == Status::Done, name == "left", "{first}");
        for _ in 0..2 {
            assert_eq!(ask(&mut worker, 0).status, Status::Done, "{name}");
        }
        worker.end();
    }
}

#[test]
fn what_an_engine_says_of_its_time_is_kept_unless_it_is_nonsense() {
    let folder = tempfile::tempdir().unwrap();
    npy::write(folder.path().join("answer.npy"), &Plane::filled(SIZE.0, SIZE.1, 5f32)).unwrap();
    let says = |seconds: &str| {
        let answer = folder.path().join("answer.npy");
        let script = format!(
            "{LOOP}; cp {} disparity.npy
             echo \"{{\\\"hazcam\\\":\\\"done\\\",\\\"job\\\":$i{seconds}}}\"; done",
            answer.display()
        );
        ask(&mut worker(scripted(folder.path(), "protocol", &script)), 0)
    };
    assert_eq!(says(r#",\"seconds\":0.0005"#).claimed_seconds, Some(0.0005));
    // Milliseconds, say.
    let long = says(r#",\"seconds\":5000"#).status.to_string();
    assert!(long.contains("matching took 5000 s, but its answer was there after"), "{long}");
    let silent = says("");
    assert_eq!((silent.status, silent.claimed_seconds), (Status::Done, None));
    let nonsense = says(r#",\"seconds\":-1"#).status.to_string();
    assert!(nonsense.contains("matching took -1 s, which must not be negative"), "{nonsense}");
}

#[test]
fn an_engine_that_cannot_start_is_tried_once() {
    let folder = tempfile::tempdir().unwrap();
    let script = format!("echo x >> {}/starts; exit 1", folder.path().display());
    let mut worker = worker(scripted(folder.path(), "protocol", &script));
    for _ in 0..3 {
        assert!(matches!(ask(&mut worker, 0).status, Status::NotReady { .. }));
    }
    assert_eq!(std::fs::read_to_string(folder.path().join("starts")).unwrap(), "x\n");
}

#[test]
fn programs_of_the_robust_vision_form_run_once_per_pair() {
    let folder = tempfile::tempdir().unwrap();
    formats::write_disparity(folder.path().join("a.pfm"), &Plane::filled(SIZE.0, SIZE.1, 5f32))
        .unwrap();
    let script = format!(
        "test -s $1 && test -s $2 && test $3 = 16 && cp {}/a.pfm $4/disp0FAKE.pfm || exit 9
         echo 0.0005 > $4/timeFAKE.txt; echo done",
        folder.path().display()
    );
    let mut fake = worker(scripted(folder.path(), "robust-vision", &script));
    for _ in 0..2 {
        let attempt = ask(&mut fake, 0);
        assert_eq!(attempt.status, Status::Done, "{}", attempt.log);
        assert_eq!(attempt.claimed_seconds, Some(0.0005));
        assert_eq!(attempt.answer.unwrap().disparity, Plane::filled(SIZE.0, SIZE.1, 5.0));
    }
    // By -1 programs say that they do not know.
    let long = ask(
        &mut worker(scripted(
            folder.path(),
            "robust-vision",
            &script.replace("echo 0.0005", "echo 500"),
        )),
        0,
    );
    assert!(long.status.to_string().contains("matching took 500 s"), "{}", long.status);
    let unknown = script.replace("echo 0.0005", "echo -1");
    let unknown = ask(&mut worker(scripted(folder.path(), "robust-vision", &unknown)), 0);
    assert_eq!((unknown.status, unknown.claimed_seconds), (Status::Done, None));
    let negative = ask(&mut fake, -1).status;
    assert!(negative.to_string().contains("search from 0"), "{negative}");
    let mut idle = worker(scripted(folder.path(), "robust-vision", "true"));
    assert!(ask(&mut idle, 0).status.to_string().contains("0 files disp0*.pfm"));
    let mut broken = worker(scripted(folder.path(), "robust-vision", "echo ouch >&2; exit 4"));
    assert!(
        ask(&mut broken, 0)
            .status
            .to_string()
            .ends_with("status 4 without an answer; its last words: ouch")
    );
}

#[test]
fn a_robust_vision_program_that_hangs_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let definition = scripted(folder.path(), "robust-vision", "sleep 600");
    let limits = Limits { wall: Duration::from_millis(200), ..Limits::default() };
    let programs = Programs::find("hazcam".into());
    let mut worker = Worker::new(definition, programs, limits, 1).unwrap();
    assert!(matches!(ask(&mut worker, 0).status, Status::Timeout { .. }));
}

#[test]
fn opencv_finds_a_known_shift() {
    for definition in Engines::built_in().iter().filter(|e| e.name.starts_with("opencv")) {
        let mut worker = worker(definition.clone());
        if let Err(Status::Absent { message }) = worker.start() {
            println!("not tested, {}: {message}", definition.name);
            continue;
        }
        for (colour, min) in [(false, 0), (true, -3)] {
            let (left, right) = shifted(colour);
            let attempt = worker.run(&Pair {
                left: &left,
                right: &right,
                bounds: BoundingBox::whole(SIZE.0, SIZE.1),
                range: DisparityRange::new(min, 15).unwrap(),
            });
            assert_eq!(attempt.status, Status::Done, "{}: {}", definition.name, attempt.log);
            let found = attempt.answer.unwrap().disparity;
            assert!(found.samples().iter().all(|value| value.is_finite()));
            let near = (8..24).flat_map(|y| (20..50).map(move |x| (x, y)));
            let wrong = near.filter(|&(x, y)| (found.row(y)[x] - 5.0).abs() > 0.5).count();
            assert!(wrong < 48, "{}: {wrong} of 480 are wrong", definition.name);
        }
        worker.end();
    }
}
