//! Who is graded: a submission, or an engine for each part.

use std::path::{Path, PathBuf};

use anyhow::bail;
use arena::engine::Engines;
use arena::grade::Entrant;
use arena::submission::Submission;

use super::grading::Workshop;
use crate::arguments::or_variable;
use crate::outputs;

const NOBODY: &str = "name a submission, or engines with --matcher FAST:BEST";

/// Who is graded.
#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("entrant").args(["submission", "matcher"]))]
pub struct EntrantArguments {
    /// A folder or an archive (.zip, .tar, .tar.gz) with the three files of the course
    submission: Option<PathBuf>,

    /// Engines instead: one for part 1 and one for part 2, such as fast:best, or one for both
    #[arg(short, long, value_name = "FAST:BEST")]
    matcher: Option<String>,

    /// A folder with engines of your own, one TOML file each [env: HAZCAM_ENGINES]
    #[arg(long, value_name = "DIR")]
    engines: Option<PathBuf>,
}

impl EntrantArguments {
    /// Errors at once when nobody is named, before anything is loaded.
    pub fn check(&self) -> anyhow::Result<()> {
        if self.submission.is_none() && self.matcher.is_none() {
            bail!(NOBODY);
        }
        Ok(())
    }

    /// The submission's folder or archive, if it is one.
    pub fn submission(&self) -> Option<&Path> {
        self.submission.as_deref()
    }

    /// Errors where one of these files lies in the submission's folder: it would see its copy.
    pub fn keep_from(&self, files: &[PathBuf]) -> anyhow::Result<()> {
        let Some(folder) = self.submission() else { return Ok(()) };
        match files.iter().find(|file| outputs::lies_in(file, folder)) {
            Some(file) => bail!(
                "{} lies in the submission {}, which would see it: keep it elsewhere",
                file.display(),
                folder.display()
            ),
            None => Ok(()),
        }
    }

    /// The engines' names, if it is engines.
    pub fn matcher(&self) -> Option<String> {
        self.matcher.clone()
    }

    /// The files that define engines, if it is engines and there is a folder of them.
    pub fn engine_files(&self) -> Vec<PathBuf> {
        let folder = self.matcher.as_ref();
        let folder = folder.and_then(|_| or_variable(self.engines.as_deref(), "HAZCAM_ENGINES"));
        let entries = folder.and_then(|folder| folder.read_dir().ok()).into_iter().flatten();
        let files = entries.flatten().map(|entry| entry.path());
        files.filter(|file| file.extension().is_some_and(|end| end == "toml")).collect()
    }

    /// The submission's name without folder and endings, or the engines' names.
    pub fn owner(&self) -> String {
        let named = |path: &Path| path.file_name().map(ToOwned::to_owned);
        // `.` and `..` are called what their folder is.
        let submission = self
            .submission
            .as_deref()
            .and_then(|path| named(path).or_else(|| named(&path.canonicalize().ok()?)));
        match (submission, &self.matcher) {
            (Some(name), _) => {
                let name = name.to_string_lossy();
                let plain = name.to_ascii_lowercase();
                let mut endings = [".tar.gz", ".tgz", ".tar", ".zip"].iter();
                let ending = endings.find(|end| plain.ends_with(*end)).map_or(0, |end| end.len());
                name[..name.len() - ending].to_owned()
            }
            (None, Some(matcher)) => matcher.clone(),
            (None, None) => String::new(),
        }
    }

    /// The entrant with its name for the report. A submission that cannot be taken is an entrant
    /// without a point, not an error: its results must come out, and say whose fault it is.
    pub fn open(&self, workshop: &Workshop) -> anyhow::Result<(String, Entrant)> {
        match (&self.submission, &self.matcher) {
            (Some(path), _) => {
                let name = path.display().to_string();
                if !path.exists() {
                    bail!("there is no {name}: give a folder or an archive");
                }
                let entrant = match Submission::open(path, &workshop.staging()) {
                    Ok(submission) => Entrant::Submission(submission),
                    Err(error) if error.is_entrants_fault() => Entrant::Refused(error.to_string()),
                    Err(error) => Entrant::NotTaken(error.to_string()),
                };
                Ok((name, entrant))
            }
            (None, Some(matcher)) => {
                let mut known = Engines::built_in();
                let folder = or_variable(self.engines.as_deref(), "HAZCAM_ENGINES");
                if let Some(folder) = folder {
                    known.add_folder(&folder)?;
                }
                let (fast, best) = matcher.split_once(':').unwrap_or((matcher, matcher));
                let engines =
                    Entrant::engines(known.named(fast)?.clone(), known.named(best)?.clone());
                Ok((matcher.clone(), engines))
            }
            (None, None) => bail!(NOBODY),
        }
    }
}
