//! A folder of its own for a test, with files made to measure, in which the command runs.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use raster::{Image, Plane};

/// Removed when dropped.
pub struct Folder(tempfile::TempDir);

/// How a run of the command ended.
pub struct Outcome {
    /// The exit status.
    pub status: i32,
    /// What it printed as data.
    pub stdout: String,
    /// What it said.
    pub stderr: String,
}

impl Folder {
    /// An empty one.
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// With `left.png` and `right.png` of this size, a wall at 3 pixels of disparity.
    pub fn with_pair(columns: usize, rows: usize) -> Self {
        let folder = Self::new();
        folder.image("left.png", columns, rows, 0);
        folder.image("right.png", columns, rows, 3);
        folder
    }

    /// Where a file of this name lies.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a picture of a textured wall, seen `shift` pixels further left.
    pub fn image(&self, name: &str, columns: usize, rows: usize, shift: usize) {
        let texture = |x: usize, y: usize| {
            let mixed = (x as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15)
                ^ (y as u64 + 1).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
            (mixed.wrapping_mul(mixed >> 29 | 1) >> 56) as u8
        };
        let plane = Plane::from_fn(columns, rows, |x, y| texture(x + shift, y));
        formats::write_image(self.path(name), &Image::Grey8(plane)).unwrap();
    }

    /// Writes a row of disparities.
    pub fn disparities(&self, name: &str, values: &[f32]) {
        let plane = Plane::new(values.len(), 1, values.to_vec()).unwrap();
        formats::write_disparity(self.path(name), &plane).unwrap();
    }

    /// Writes the record beside a map, as far as it is read, with the shares of reasons.
    pub fn record(&self, name: &str, reasons: &str) {
        use sha2::Digest as _;
        let digest = sha2::Sha256::digest(std::fs::read(self.path(name)).unwrap());
        let digest: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        let pair = r#""left": {"path": "l.png", "sha256": "l"}, "right": {"path": "r.png", "sha256": "r"}"#;
        let record = format!(r#"{{{pair}, "output_sha256": "{digest}", "reasons": {reasons}}}"#);
        std::fs::write(self.path(&format!("{name}.json")), record).unwrap();
    }

    /// The names of all files, sorted.
    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.0.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// The command, to be run in this folder, free of what the caller's environment says.
    pub fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hazcam"));
        command.current_dir(self.0.path()).stdin(Stdio::null());
        for (name, _) in std::env::vars_os() {
            let ours = name.to_str().is_some_and(|name| name.starts_with("HAZCAM_"));
            if ours || name == "COLUMNS" || name == "CLICOLOR_FORCE" {
                command.env_remove(name);
            }
        }
        command
    }

    /// Runs the command with these arguments, separated by spaces.
    pub fn run(&self, arguments: &str) -> Outcome {
        Self::outcome(self.command().args(arguments.split_whitespace()))
    }

    /// The same from a shell, in which `before` is said first and `behind` behind the arguments.
    #[cfg(unix)]
    pub fn run_in_shell(&self, before: &str, arguments: &str, behind: &str) -> Outcome {
        let hazcam = self.command();
        let mut shell = Command::new("sh");
        shell.current_dir(self.0.path()).stdin(Stdio::null()).arg("-c");
        for (name, value) in hazcam.get_envs() {
            assert!(value.is_none(), "variables are only taken away");
            shell.env_remove(name);
        }
        shell.arg(format!("{before}\nexec \"$0\" {arguments} {behind}"));
        Self::outcome(shell.arg(hazcam.get_program()))
    }

    fn outcome(command: &mut Command) -> Outcome {
        let output = command.output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Outcome {
            status: output.status.code().expect("the command was not killed"),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    /// Runs the command, which must end with status 2, say all of `expected` on stderr, print
    /// nothing and leave no file behind.
    #[track_caller]
    pub fn refuses(&self, arguments: &str, expected: &[&str]) {
        let before = self.names();
        let outcome = self.run(arguments);
        assert_eq!(outcome.status, 2, "{arguments}: {}", outcome.stderr);
        assert_eq!(outcome.stdout, "", "{arguments}");
        for part in expected {
            assert!(outcome.stderr.contains(part), "`{part}` is not in: {}", outcome.stderr);
        }
        assert!(!outcome.stderr.contains("panicked"), "{}", outcome.stderr);
        assert_eq!(self.names(), before, "{arguments} left something behind");
    }
}

impl Outcome {
    /// This outcome, if the command succeeded.
    #[track_caller]
    pub fn done(self) -> Self {
        assert_eq!(self.status, 0, "{}", self.stderr);
        self
    }
}

/// A disparity map as a file holds it.
pub fn disparities(path: impl AsRef<Path>) -> Plane<f32> {
    formats::read_disparity(path, formats::Encoding::Auto).unwrap().values
}
