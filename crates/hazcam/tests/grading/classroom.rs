//! A folder with a small scheme, submissions written by tests, and the command to grade them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use serde_json::Value;
use tempfile::TempDir;

use crate::skip::skip;

/// One test per part on a small rendered scene, so that grading takes a moment.
const SCHEME: &str = r#"
name = "Small"

[[test]]
name = "Part 1, wall"
part = "fast"
scene = "wall"
max_disparity = 12
max_e_rms = 3
max_p_bad = 0.3
points = 2
cpu_seconds = 1

[[test]]
name = "Part 2, wall"
part = "best"
scene = "wall"
max_disparity = 12
max_e_rms = 3
max_p_bad = 0.3
points = 3
cpu_seconds = 1

[scene.wall]
kind = "plane:5.5"
seed = 1
columns = 160
rows = 120
"#;

/// A function that matches well enough for all points.
pub const HONEST: &str = "
import numpy as np

def NAME(Il, Ir, bbox, maxd):
    best, Id = np.full(Il.shape, np.inf), np.zeros(Il.shape)
    for d in range(maxd + 1):
        cost = np.abs(Il - np.roll(Ir, d, axis=1))
        cost = sum(np.roll(cost, (k, l), (0, 1)) for k in range(-2, 3) for l in range(-2, 3))
        Id[cost < best] = d
        best = np.minimum(best, cost)
    return Id
";

/// Part 1 alone, with little memory and disk.
const LIMITED: [&str; 6] =
    ["--scheme", "part1.toml", "--memory-limit", "512", "--disk-limit", "32"];

/// The folder. `TMPDIR` points into it, so that what grading leaves behind can be seen.
pub struct Classroom {
    folder: TempDir,
    pub python: Option<PathBuf>,
}

impl Classroom {
    /// With any Python 3 and, where it can be had, the sandbox.
    pub fn with_plain_python() -> Option<Self> {
        let python = python_with("json")?;
        Some(Self { python: Some(python), ..Self::without_python()? })
    }

    /// With Python and numpy and, where it can be had, the sandbox; `None`, after one line on
    /// stderr, where something is missing.
    pub fn with_python() -> Option<Self> {
        let python = python_with("numpy")?;
        Some(Self { python: Some(python), ..Self::without_python()? })
    }

    /// As [`Classroom::with_python`], with scipy as well.
    pub fn with_scipy() -> Option<Self> {
        let python = python_with("scipy")?;
        Some(Self { python: Some(python), ..Self::without_python()? })
    }

    /// For engines that need no Python.
    pub fn without_python() -> Option<Self> {
        let missing = arena::sandbox::missing_parts();
        if !missing.is_empty() {
            skip(&format!("this system lacks {}", missing.join(" and ")));
            return None;
        }
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("tmp")).unwrap();
        fs::write(folder.path().join("small.toml"), SCHEME).unwrap();
        let scene = SCHEME.split_inclusive("\n\n").filter(|part| !part.contains("Part 2"));
        fs::write(folder.path().join("part1.toml"), scene.collect::<String>()).unwrap();
        Some(Self { folder, python: None })
    }

    /// Where a file of this name lies.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a submission whose part 1 is `source`, in which `NAME` stands for the function's
    /// name; part 2 is honest.
    pub fn submission(&self, name: &str, source: &str) -> PathBuf {
        let folder = self.path(name);
        fs::create_dir_all(&folder).unwrap();
        let write = |file: &str, text: String| fs::write(folder.join(file), text).unwrap();
        write("secret_id.py", format!("def secret_id():\n    return 'Secret {name}'\n"));
        write("stereo_disparity_fast.py", source.replace("NAME", "stereo_disparity_fast"));
        write("stereo_disparity_best.py", HONEST.replace("NAME", "stereo_disparity_best"));
        folder
    }

    /// The command of this name with these arguments.
    pub fn command(&self, name: &str, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hazcam"));
        command.current_dir(self.folder.path()).arg(name).args(arguments);
        command.env("TMPDIR", self.path("tmp"));
        for variable in ["HAZCAM_DATA", "HAZCAM_ENGINES", "HAZCAM_PYTHON", "HAZCAM_BOARD"] {
            command.env_remove(variable);
        }
        if let Some(python) = &self.python {
            command.env("HAZCAM_PYTHON", python);
        }
        command
    }

    /// Grades; the exit status, stdout and stderr. Nothing may be left behind.
    pub fn run(&self, arguments: &[&str]) -> (i32, String, String) {
        let Output { status, stdout, stderr } = self.command("grade", arguments).output().unwrap();
        let left: Vec<_> = fs::read_dir(self.path("tmp")).unwrap().flatten().collect();
        assert!(left.is_empty(), "left behind: {left:?}");
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (status.code().expect("hazcam was ended by a signal"), text(stdout), text(stderr))
    }

    /// Grades a submission by the small scheme, which must succeed.
    pub fn grade(&self, submission: &Path, arguments: &[&str]) -> Report {
        let mut all = vec![submission.to_str().unwrap(), "--format", "json"];
        if !arguments.contains(&"--scheme") {
            all.extend(["--scheme", "small.toml"]);
        }
        all.extend(arguments);
        let (status, stdout, stderr) = self.run(&all);
        assert_eq!(status, 0, "{stdout}{stderr}");
        Report(serde_json::from_str(&stdout).unwrap())
    }

    /// Grades part 1 alone, with this source, under the small scheme's limits and half a gigabyte of memory.
    pub fn grade_source(&self, source: &str) -> Report {
        let submission = self.submission("submission", source);
        self.grade(&submission, &LIMITED)
    }

    /// Grades part 1 alone, answered by this program in plain Python, under the same limits.
    pub fn grade_program(&self, source: &str) -> Report {
        let folder = self.path("engines");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("program.py"), source).unwrap();
        let definition = "name = 'mine'\ncommand = ['{python}', '-B', '{folder}/program.py']\n";
        fs::write(folder.join("mine.toml"), definition).unwrap();
        let engine = ["--matcher", "mine:fast", "--engines", "engines", "--format", "json"];
        let (status, stdout, stderr) = self.run(&[&engine[..], &LIMITED].concat());
        assert_eq!(status, 0, "{stdout}{stderr}");
        Report(serde_json::from_str(&stdout).unwrap())
    }

    /// An honest submission, graded after whatever came before, gets all its points.
    #[track_caller]
    pub fn expect_the_next_to_pass(&self) {
        let report = self.grade(&self.submission("next", HONEST), &[]);
        assert_eq!(report.0["points"], 5.0, "{}{}", report.message(0), report.message(1));
    }
}

/// A report in JSON.
pub struct Report(pub Value);

impl Report {
    /// How a test ended.
    pub fn outcome(&self, test: usize) -> &str {
        self.0["tests"][test]["outcome"].as_str().unwrap()
    }

    /// Why it has no answer; empty when it has one.
    pub fn message(&self, test: usize) -> &str {
        self.0["tests"][test]["message"].as_str().unwrap_or_default()
    }

    /// Its points.
    pub fn points(&self, test: usize) -> f64 {
        self.0["tests"][test]["points"].as_f64().unwrap()
    }

    /// All findings, one a line.
    pub fn findings(&self) -> String {
        let findings = self.0["findings"].as_array().unwrap().iter();
        findings.map(|f| format!("{} {}: {}\n", f["file"], f["line"], f["text"])).collect()
    }

    /// Part 1 ended so, with these words in its message.
    #[track_caller]
    pub fn expect(&self, outcome: &str, words: &[&str]) {
        let message = self.message(0);
        assert_eq!(self.outcome(0), outcome, "{message}");
        for word in words {
            assert!(message.contains(word), "`{word}` is not in: {message}");
        }
    }

    /// Part 2, which is honest and comes after part 1, was not harmed.
    #[track_caller]
    pub fn expect_part_2_to_pass(&self) {
        assert_eq!((self.outcome(1), self.points(1)), ("OK", 3.0), "{}", self.message(1));
    }
}

/// The Python that can import this module, looked for once. All have `json`.
fn python_with(module: &'static str) -> Option<PathBuf> {
    static NUMPY: OnceLock<Option<PathBuf>> = OnceLock::new();
    static SCIPY: OnceLock<Option<PathBuf>> = OnceLock::new();
    static PLAIN: OnceLock<Option<PathBuf>> = OnceLock::new();
    let place = match module {
        "scipy" => &SCIPY,
        "numpy" => &NUMPY,
        _ => &PLAIN,
    };
    let found = place.get_or_init(|| {
        let named = std::env::var_os("HAZCAM_PYTHON").filter(|name| !name.is_empty());
        let asked = Command::new(named.unwrap_or_else(|| "python3".into()))
            .args(["-c", &format!("import sys, {module}; print(sys.executable)")])
            .output()
            .ok()
            .filter(|output| output.status.success())?;
        Some(PathBuf::from(String::from_utf8(asked.stdout).ok()?.trim()))
    });
    if found.is_none() {
        skip(&format!("there is no python3 with {module}"));
    }
    found.clone()
}
