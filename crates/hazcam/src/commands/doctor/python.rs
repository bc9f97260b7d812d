//! Which Python there is, and whether it has numpy, scipy and OpenCV.

use std::process::{Command, Stdio};

use arena::engine::Programs;

use super::Finding;

/// Prints the versions of Python, numpy, scipy and OpenCV, one a line; a dash for what is missing.
const PROGRAM: &str = "
import platform
print(platform.python_version())
for name in ('numpy', 'scipy', 'cv2'):
    try:
        print(__import__(name).__version__)
    except Exception:
        print('-')
";

/// Asks the Python that would run engines and submissions.
pub fn look() -> Vec<Finding> {
    let Some(python) = Programs::find_python() else {
        let detail = format!("{}; grading Python submissions needs it", Programs::NO_PYTHON);
        return vec![Finding::absent("python", detail)];
    };
    let answer = Command::new(&python)
        .args(["-c", PROGRAM])
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output()
        .ok()
        .filter(|output| output.status.success())
        .map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
    let Some(answer) = answer else {
        let name = python.display();
        let detail = format!("`{name}` does not run; grading Python submissions needs it");
        return vec![Finding::absent("python", detail)];
    };
    let mut versions = answer.lines();
    let mut finding = |topic, purpose: &str| match versions.next() {
        Some(version) if version != "-" => Finding::ok(topic, version),
        _ => Finding::absent(topic, format!("`import {topic}` fails; {purpose}")),
    };
    vec![
        finding("python", "grading Python submissions needs it"),
        finding("numpy", "grading Python submissions needs it"),
        finding("scipy", "Python submissions that use it cannot be graded"),
        finding("cv2", "comparing with OpenCV needs it"),
    ]
}
