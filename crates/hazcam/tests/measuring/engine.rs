//! A preset behind the engine protocol.

use std::path::{Path, PathBuf};
use std::process::Command;

use arena::engine::{Definition, Limits, Pair, Programs, Status, Worker};
use raster::{BoundingBox, DisparityRange, Image, Plane, Reason};

fn worker(matcher: &str) -> Worker {
    let command = format!("['{{hazcam}}', 'engine', '--matcher', '{matcher}']");
    let text = format!("name = '{matcher}'\ncommand = {command}");
    let definition = Definition::parse(&text, "test").unwrap();
    let programs =
        Programs { hazcam: Path::new(env!("CARGO_BIN_EXE_hazcam")).into(), python: None };
    Worker::new(definition, programs, Limits::default(), 2).unwrap()
}

fn image(shift: usize) -> Image {
    let value = |x: usize, y: usize| ((x * x * 7 + x * 13 + y * 29 + x * y * 3) % 251) as u8;
    Image::Grey8(Plane::from_fn(60, 40, |x, y| value(x + shift, y)))
}

#[test]
fn every_preset_answers_the_box_and_nothing_else() {
    for preset in matching::Preset::ALL {
        let mut worker = worker(preset.name());
        let (left, right) = (image(0), image(4));
        let bounds = BoundingBox::new(10, 5, 49, 30).unwrap();
        for (min, max) in [(0, 12), (0, 12), (-3, 9)] {
            let range = DisparityRange::new(min, max).unwrap();
            let attempt = worker.run(&Pair { left: &left, right: &right, bounds, range });
            assert_eq!(attempt.status, Status::Done, "{}", attempt.log);
            let answer = attempt.answer.unwrap();
            let reasons = answer.reasons.unwrap();
            for y in 0..40 {
                for (x, value) in answer.disparity.row(y).iter().enumerate() {
                    assert_eq!(value.is_finite(), bounds.contains(x, y), "{x}, {y}");
                    assert_eq!(reasons.row(y)[x] == Reason::OutsideBox, !bounds.contains(x, y));
                }
            }
        }
        assert_eq!(worker.version(), Some(env!("CARGO_PKG_VERSION")));
        worker.end();
    }
}

#[test]
fn the_same_answer_as_without_a_process_between() {
    let (left, right) = (image(0), image(4));
    let range = DisparityRange::new(0, 12).unwrap();
    let bounds = BoundingBox::whole(60, 40);
    let options = matching::Options::new(matching::Preset::Fast, range);
    let mut matcher = matching::Matcher::new(options).unwrap();
    let direct = matcher.compute(&left, &right, None).unwrap();
    let attempt = worker("fast").run(&Pair { left: &left, right: &right, bounds, range });
    let answer = attempt.answer.unwrap();
    assert_eq!(answer.disparity, direct.values);
    assert_eq!(answer.reasons.as_ref(), Some(&direct.reasons));
    assert_eq!(answer.confidence.as_ref(), Some(&direct.confidence));
}

#[test]
fn a_range_that_cannot_be_is_a_failed_job_and_the_next_one_is_answered() {
    let mut worker = worker("fast");
    let (left, right) = (image(0), image(4));
    let bounds = BoundingBox::whole(60, 40);
    let mut ask = |max| {
        let range = DisparityRange::new(0, max).unwrap();
        worker.run(&Pair { left: &left, right: &right, bounds, range }).status
    };
    let Status::Failed { message } = ask(1_000_000) else { panic!("it must fail") };
    assert!(message.contains("max-disparity"), "{message}");
    assert_eq!(ask(8), Status::Done);
}

#[test]
fn what_is_no_message_ends_it_with_an_error() {
    use std::io::Write;
    let folder = tempfile::tempdir().unwrap();
    let mut child = crate::hazcam(folder.path(), &["engine", "--matcher", "fast"])
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(b"please match this\n").unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stdout).contains(r#""hazcam":"ready""#));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("the engine protocol was broken"), "{stderr}");
}

/// PROTOCOL.md shows how: what stands there is run.
#[test]
fn python_drives_a_preset() {
    let has_numpy = |python: &PathBuf| {
        let asked = Command::new(python).args(["-c", "import numpy"]).output();
        asked.is_ok_and(|output| output.status.success())
    };
    let Some(python) = Programs::find_python().filter(has_numpy) else {
        eprintln!("skipped: there is no python3 with numpy");
        return;
    };
    let page = include_str!("../../../arena/PROTOCOL.md");
    let (_, section) = page.split_once("## Driving an engine from Python").unwrap();
    let class = section.split("```").nth(1).unwrap().strip_prefix("python\n").unwrap();
    let program = format!(
        r#"{class}
left = np.random.default_rng(1).integers(0, 256, (40, 90), dtype=np.uint8)
right = np.roll(left, -7, axis=1)
matcher = Matcher("fast", r"{hazcam}")
for frame in range(2):
    disparity, sure = matcher.match(left, right, 15)
    assert disparity.shape == sure.shape == left.shape and disparity.dtype == np.float32
    assert abs(np.median(disparity) - 7) < 0.1, np.median(disparity)
    assert 0 <= sure.min() and sure.max() <= 1
try:
    matcher.match(left, right[:, 1:], 15)
    raise SystemExit("images of two sizes were matched")
except RuntimeError as error:
    print(error)
assert abs(np.median(matcher.match(left, right, 15, 5, threads=2)[0]) - 7) < 0.1
"#,
        hazcam = env!("CARGO_BIN_EXE_hazcam")
    );
    let output = Command::new(&python).args(["-c", &program]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(!output.stdout.is_empty(), "the error says something");
}
