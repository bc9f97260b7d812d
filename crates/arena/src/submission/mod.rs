//! A course submission in Python: a folder or an archive with `secret_id.py`,
//! `stereo_disparity_fast.py` and `stereo_disparity_best.py`.
//!
//! It comes from somebody who is not trusted. [`Submission::open`] copies it into a folder of the
//! grader's and looks at names and sizes only. Its functions are run as engines, through the
//! [`Runner`] in the crate's folder `python/`, which belongs in a sandbox. Findings about the
//! content ([`Finding`]) come from the same runner, because only Python can tell what Python will
//! make of a file.

mod archive;
mod budget;
mod contents;
mod course_files;
mod error;
mod extras;
mod finding;
mod python;
mod runner;
mod secret_id;

use std::path::{Path, PathBuf};
use std::process::Command;

pub use error::SubmissionError;
pub use finding::Finding;
pub use python::Python;
pub use runner::{Inspection, Runner};
pub use secret_id::is_secret_id;
pub(crate) use secret_id::{BEGINS_A_FORMULA, folded, look_alike};

/// One of the two parts of the course's assignment.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// Part 1: a fixed window and absolute differences.
    Fast,
    /// Part 2: any other method.
    Best,
}

impl Part {
    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Best => "best",
        }
    }

    /// The module and the function of a submission.
    pub fn function(self) -> &'static str {
        match self {
            Self::Fast => "stereo_disparity_fast",
            Self::Best => "stereo_disparity_best",
        }
    }
}

/// A submission, copied to where the grader keeps it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Submission {
    /// Where the three files are.
    root: PathBuf,
    /// What was noticed about names, before any file was looked into.
    findings: Vec<Finding>,
}

impl Submission {
    /// Copies the submission at `path`, a folder or an archive (zip, or tar, plain or gzip-compressed),
    /// into the empty folder `staging`.
    ///
    /// Errors: what is neither; links, devices, absolute paths and `..`; too many or too large
    /// files; none of the course's files in it. A single missing file is a finding.
    pub fn open(path: &Path, staging: &Path) -> Result<Self, SubmissionError> {
        let metadata = path
            .metadata()
            .map_err(|source| SubmissionError::Read { path: path.to_owned(), source })?;
        match metadata.is_dir() {
            true => contents::copy_folder(path, staging)?,
            false => archive::unpack(path, staging)?,
        }
        let root = course_files::find_root(path, staging)?;
        let mut findings = course_files::missing_files(&root);
        findings.extend(course_files::left_out(staging, &root));
        findings.extend(extras::besides_its_source(&root));
        Ok(Self { root, findings })
    }

    /// What was noticed about the files' names.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    /// The SHA-256 of its files and their names: it tells whether the same was handed in before.
    pub fn digest(&self) -> Result<String, SubmissionError> {
        contents::digest(&self.root)
            .map_err(|source| SubmissionError::Read { path: self.root.clone(), source })
    }

    /// A fresh copy for one test, which may change its files.
    pub fn copy_to(&self, folder: &Path) -> Result<(), SubmissionError> {
        contents::copy_folder(&self.root, folder)
    }
}

/// The process that looks at the copy of a submission in `folder` without running its matchers.
pub(crate) fn inspector(runner: &Runner, folder: &Path) -> Command {
    runner.command(&["inspect".as_ref(), folder.as_os_str()])
}

/// The engine that runs one function of the copy of a submission in `folder`.
pub(crate) fn engine(runner: &Runner, folder: &Path, part: Part) -> Command {
    runner.command(&["run".as_ref(), folder.as_os_str(), part.function().as_ref()])
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// A folder with these files, copied; they are there as long as that.
    fn opened(files: &[&str]) -> (tempfile::TempDir, Submission) {
        let folder = tempfile::tempdir().unwrap();
        let (handin, staging) = (folder.path().join("handin"), folder.path().join("staging"));
        fs::create_dir(&staging).unwrap();
        for file in files {
            let path = handin.join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, format!("# {file}")).unwrap();
        }
        let opened = Submission::open(&handin, &staging).unwrap();
        (folder, opened)
    }

    const WHOLE: [&str; 3] =
        ["a/secret_id.py", "a/stereo_disparity_fast.py", "a/stereo_disparity_best.py"];

    #[test]
    fn what_lies_beside_the_chosen_folder_is_told() {
        assert_eq!(opened(&WHOLE).1.findings(), []);
        let below = [&WHOLE[..], &["a/old/secret_id.py", "notes/readme.txt"]].concat();
        assert_eq!(opened(&below).1.findings(), []);
        let beside = [&WHOLE[..], &["b/secret_id.py"]].concat();
        let [finding] = opened(&beside).1.findings().to_vec().try_into().unwrap();
        assert_eq!((&finding.file[..], finding.fatal), ("b", false));
        assert!(finding.text.contains("those in `a` are graded"), "{finding}");
        let helper = [&WHOLE[..], &["a/lib/x.py", "tools.py"]].concat();
        let [finding] = opened(&helper).1.findings().to_vec().try_into().unwrap();
        assert_eq!((&finding.file[..], finding.fatal), ("tools.py", false));
        assert!(finding.text.starts_with("it lies outside of `a`, whose files"), "{finding}");
        let helpers = [&WHOLE[..], &["b/y.py", "tools.py"]].concat();
        let [finding] = opened(&helpers).1.findings().to_vec().try_into().unwrap();
        assert!(finding.text.starts_with("it and 1 more of Python lie outside"), "{finding}");
    }

    #[test]
    fn an_archive_in_a_submission_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let (handin, staging) = (folder.path().join("handin"), folder.path().join("staging"));
        for made in [&handin, &staging] {
            fs::create_dir(made).unwrap();
        }
        for name in ["HANDIN.ZIP", "data.tar"] {
            fs::write(handin.join(name), "PK").unwrap();
        }
        let error = Submission::open(&handin, &staging).unwrap_err();
        assert!(error.to_string().contains("`HANDIN.ZIP`: unpack that"), "{error}");
    }

    #[test]
    fn what_the_source_does_not_tell_is_told() {
        let with = |files: &[(&str, &[u8])]| {
            let folder = tempfile::tempdir().unwrap();
            let (handin, staging) = (folder.path().join("handin"), folder.path().join("staging"));
            fs::create_dir_all(handin.join("lib")).unwrap();
            fs::create_dir(&staging).unwrap();
            for name in WHOLE {
                fs::write(handin.join(name.trim_start_matches("a/")), "# source").unwrap();
            }
            for (name, content) in files {
                fs::write(handin.join(name), content).unwrap();
            }
            Submission::open(&handin, &staging).unwrap().findings().to_vec()
        };
        let long = vec![b'#'; 150_000];
        assert_eq!(with(&[("notes.txt", b"MZ: my zebra"), ("lib/tables.py", &long)]), []);
        let table = vec![0; 25_001];
        for name in ["lib/fast.dat", "lib/fast.txt", "lib/fast.py"] {
            let [finding] =
                with(&[(name, b"\x7fELF\x02\x01\x01"), ("a.npy", &table)]).try_into().unwrap();
            assert_eq!((&finding.file[..], finding.fatal), ("a.npy", false));
            let told = format!("a.npy (26 KB), {name} (1 KB of compiled code); whoever");
            assert!(finding.text.contains(&told), "{finding}");
        }
        let many: Vec<String> = (0..7).map(|number| format!("{number}.pyc")).collect();
        let many: Vec<(&str, &[u8])> = many.iter().map(|name| (&name[..], &b"x"[..])).collect();
        assert!(with(&many)[0].text.contains("4.pyc (1 KB of compiled code) and 2 more;"));
        // In parts it is as much.
        let parts = [("a.npy", &table[..15_000]), ("b.npy", &table[..9_000])];
        assert!(with(&parts)[0].text.contains("a.npy (15 KB), b.npy (9 KB);"));
        let sources = [("a.py", &long[..]), ("b.py", &long[..60_000])];
        assert_eq!(with(&sources)[0].file, "a.py");
    }

    #[test]
    fn a_digest_tells_files_and_names_apart() {
        let digest = |files: &[&str]| opened(files).1.digest().unwrap();
        assert_eq!(digest(&WHOLE), digest(&WHOLE));
        let digests =
            [digest(&WHOLE), digest(&WHOLE[..2]), digest(&[&WHOLE[..], &["a/x"]].concat())];
        assert!(digests[0] != digests[1] && digests[0] != digests[2]);
        assert_eq!(digests[0].len(), 64);
    }
}
