//! By what and how entrants are graded: tests, scenes, limits, sandbox, Python.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, bail};
use arena::dataset::{self, Case};
use arena::engine::Programs;
use arena::grade::{
    Allowance, Confinement, Grader, MOST_SECONDS, Scene, SceneSource, Scenes, Scheme, Test,
    load_scenes,
};
use arena::interrupt::Scratch;
use arena::sandbox;
use arena::submission::{Python, Runner};

use super::scenes;
use crate::arguments::or_variable;
use crate::ui::Ui;

/// By what and how entrants are graded.
#[derive(clap::Args)]
pub struct GradingArguments {
    /// Tests, thresholds, points and limits, as TOML [default: the course's six]
    #[arg(long, value_name = "FILE", help_heading = "Tests")]
    scheme: Option<PathBuf>,

    /// Folder with the data sets that hold the scenes of the tests [env: HAZCAM_DATA]
    #[arg(long, value_name = "DIR", help_heading = "Tests")]
    data: Option<PathBuf>,

    /// Run every test twice and say where the answers differ
    #[arg(long, help_heading = "Tests")]
    twice: bool,

    /// CPU seconds for each test, instead of the scheme's; a board's hold-out keeps its own
    #[arg(long, value_name = "SECONDS", value_parser = seconds, help_heading = "Limits")]
    cpu_limit: Option<f64>,

    /// Seconds until an entrant is ready: its imports
    #[arg(long, value_name = "SECONDS", value_parser = seconds, help_heading = "Limits")]
    #[arg(default_value = "60")]
    start_limit: f64,

    /// Megabytes of memory (address space). Vectorised cost volumes on KITTI take 0.5 GB a copy
    #[arg(long, value_name = "MB", default_value = "4096", help_heading = "Limits")]
    #[arg(value_parser = clap::value_parser!(u64).range(256..=1 << 20))]
    memory_limit: u64,

    /// Megabytes of files that an entrant may write
    #[arg(long, value_name = "MB", default_value = "256", help_heading = "Limits")]
    #[arg(value_parser = clap::value_parser!(u64).range(16..=1 << 20))]
    disk_limit: u64,

    /// Run entrants with all your rights: only for code that you trust with all your files
    #[arg(long, help_heading = "Limits")]
    no_sandbox: bool,

    /// The Python that runs submissions [env: HAZCAM_PYTHON] [default: python3 or python on PATH]
    #[arg(long, value_name = "PROGRAM", help_heading = "Limits")]
    python: Option<PathBuf>,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.1..=MOST_SECONDS).contains(&value) => Ok(value),
        _ => Err(format!("give seconds from 0.1 to {MOST_SECONDS}")),
    }
}

/// Everything that a [`Grader`] needs, loaded. Its folder is removed with it.
pub struct Workshop {
    scheme: Scheme,
    scenes: Scenes,
    scene_files: Vec<PathBuf>,
    confinement: Confinement,
    programs: Programs,
    python: Result<Python, String>,
    twice: bool,
    folder: Scratch,
}

impl Workshop {
    /// Reads the scheme, loads its scenes, looks for Python and for the parts of the sandbox.
    ///
    /// Errors when entrants cannot be confined and nobody said to do without.
    pub fn open(args: &GradingArguments) -> anyhow::Result<Self> {
        let this = std::env::current_exe().context("cannot find this program's own file")?;
        let missing = sandbox::missing_parts();
        if !args.no_sandbox && !missing.is_empty() {
            bail!(
                "this system lacks {}, so entrants cannot be confined; grade on one that has it, \
                 or say --no-sandbox if you trust the code with all your files",
                missing.join(" and ")
            );
        }
        let temporary = std::env::temp_dir();
        if temporary.to_str().is_none() {
            // Neither the sandbox nor an engine could be told where to work.
            bail!(
                "the folder for temporary files {} has a name that is not UTF-8: let TMPDIR name \
                 another",
                temporary.display()
            );
        }
        let scheme = args.read_scheme()?;
        let mut programs = Programs::find(this.clone());
        if let Some(python) = &args.python {
            programs.python = Some(python.clone());
        }
        let python = match &programs.python {
            Some(program) => Python::find(program).map_err(|error| error.to_string()),
            None => Err(format!(
                "{}: install Python 3.8 or newer with numpy and scipy, or name it with --python",
                Programs::NO_PYTHON
            )),
        };
        if let Ok(python) = &python {
            // Not what PATH finds: that may be a script which looks for Python where engines must
            // not look.
            programs.python = Some(python.executable.clone());
        }
        let folder = Scratch::new("hazcam-grade-").context("cannot create a working folder")?;
        std::fs::create_dir(folder.path().join("submission"))?;
        let allowance = Allowance {
            start: Duration::from_secs_f64(args.start_limit),
            memory_bytes: args.memory_limit << 20,
            disk_bytes: args.disk_limit << 20,
        };
        let (scenes, scene_files) = args.load_scenes(&scheme)?;
        Ok(Self {
            scenes,
            scene_files,
            scheme,
            confinement: Confinement { helper: (!args.no_sandbox).then_some(this), allowance },
            programs,
            python,
            twice: args.twice,
            folder,
        })
    }

    /// The empty folder for the copy of a submission.
    pub fn staging(&self) -> PathBuf {
        self.folder.path().join("submission")
    }

    /// By what is graded.
    pub fn scheme(&self) -> &Scheme {
        &self.scheme
    }

    /// The tests whose scenes could be loaded, with these.
    pub fn tests(&self) -> impl Iterator<Item = (&Test, &Scene)> {
        let tests = self.scheme.tests.iter();
        tests.filter_map(|test| Some((test, self.scenes.get(&test.scene)?.as_ref().ok()?)))
    }

    /// The files that the scenes are made from.
    pub fn scene_files(&self) -> &[PathBuf] {
        &self.scene_files
    }

    /// Errors with the reason where a scene of the tests could not be loaded.
    pub fn check_scenes(&self) -> anyhow::Result<()> {
        let of_test = |test: &Test| self.scenes.get(&test.scene)?.as_ref().err();
        match self.scheme.tests.iter().find_map(of_test) {
            Some(why) => bail!("not entered, because a scene cannot be used: {why}"),
            None => Ok(()),
        }
    }

    /// The grader.
    pub fn grader(&self) -> anyhow::Result<Grader<'_>> {
        let runner = match &self.python {
            Ok(python) => Ok(Runner::install(python.clone(), &self.folder.path().join("runner"))?),
            Err(why) => Err(why.clone()),
        };
        Ok(Grader {
            scheme: &self.scheme,
            scenes: &self.scenes,
            confinement: self.confinement.clone(),
            programs: self.programs.clone(),
            runner,
            twice: self.twice,
            secrets: Vec::new(),
        })
    }
}

impl GradingArguments {
    /// The file of the scheme, if one was named.
    pub fn scheme(&self) -> Option<&Path> {
        self.scheme.as_deref()
    }

    /// What the scheme's paths are relative to.
    fn folder(&self) -> &Path {
        self.scheme.as_deref().and_then(Path::parent).unwrap_or(Path::new(""))
    }

    /// Says what it means when entrants run without a sandbox.
    pub fn warn_if_unconfined(&self, ui: &Ui) {
        if self.no_sandbox {
            ui.warn("no sandbox: what is graded can read, change and send away all your files");
        }
    }

    fn read_scheme(&self) -> anyhow::Result<Scheme> {
        let mut scheme = match &self.scheme {
            Some(path) => {
                let text = std::fs::read_to_string(path)
                    .with_context(|| format!("cannot read {}", path.display()))?;
                Scheme::parse(&text, path)?
            }
            None => Scheme::course(),
        };
        if let Some(seconds) = self.cpu_limit {
            for test in &mut scheme.tests {
                test.cpu_seconds = seconds;
            }
        }
        Ok(scheme)
    }

    /// The scheme's scenes, and the files that they are made from; a scene that cannot be used is told by the tests
    /// that need it.
    fn load_scenes(&self, scheme: &Scheme) -> anyhow::Result<(Scenes, Vec<PathBuf>)> {
        let elsewhere = |id: &String| !scheme.scenes.contains_key(id);
        let needs_data = scheme.tests.iter().map(|test| &test.scene).any(elsewhere);
        let data = or_variable(self.data.as_deref(), "HAZCAM_DATA");
        let cases: Vec<Case> = match &data {
            Some(folder) if needs_data => dataset::open(folder).context("HAZCAM_DATA or --data")?,
            _ => Vec::new(),
        };
        let remedy = match &data {
            Some(_) => "look at what HAZCAM_DATA or --data names",
            None => "set HAZCAM_DATA, or --data, to the folder with the course's images",
        };
        let sources = scheme.scenes.values().map(|source| source.within(self.folder()));
        let of_source = |source| match source {
            SceneSource::Files { left, right, truth, bounds, .. } => {
                let bounds = bounds.filter(|bounds| bounds.ends_with(".npy")).map(PathBuf::from);
                [left, right, truth].into_iter().chain(bounds).collect()
            }
            SceneSource::Rendered { .. } => Vec::new(),
        };
        let mut files: Vec<PathBuf> = sources.flat_map(of_source).collect();
        let tested = |case: &&Case| scheme.tests.iter().any(|test| test.scene == case.id);
        let of_cases = cases.iter().filter(tested).filter_map(Case::files);
        files.extend(of_cases.flat_map(|files| files.all()).map(Path::to_owned));
        let catalogue = data.map(|folder| folder.join("scenes.json"));
        files.extend(catalogue.filter(|catalogue| catalogue.is_file()));
        let scenes = load_scenes(scheme, self.folder(), &cases, remedy, &scenes::render);
        Ok((scenes, files))
    }
}
