//! Where results go: tables to stdout, records and pictures into a folder.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use arena::dataset::{Case, CaseData};
use arena::engine::Answer;
use arena::record::Record;
use arena::report::Format;
use formats::write_atomically;

use super::into::Page;
use super::pictures;
use super::tables::{Tables, View};
use crate::outputs;

/// The files of a folder that hold the whole result, and how each does.
fn tables_in(folder: &Path, view: View) -> [(PathBuf, Format); 3] {
    [("md", Format::Markdown), ("csv", Format::Csv), ("json", Format::Json)]
        .map(|(end, format)| (folder.join(view.file_stem()).with_extension(end), format))
}

/// What is shown and kept of a run.
#[derive(Default)]
pub struct Output {
    /// Which tables are shown.
    pub view: View,
    /// How the tables are shown.
    pub format: Format,
    /// The page that gets the results between its markers.
    pub page: Option<Page>,
    /// Whether more is kept than pictures: the scene itself, instead of its left image alone, and a page of points
    /// for each answer.
    pub in_full: bool,
    folder: Option<PathBuf>,
    pictures: bool,
    /// The scene whose own pictures have been written last.
    pictured: Option<String>,
}

impl Output {
    /// Keeps everything in a folder, which is made and tried now, so that a bad name shows before the work.
    pub fn in_folder(folder: PathBuf, view: View, pictures: bool) -> anyhow::Result<Self> {
        fs::create_dir_all(&folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        for (table, _) in tables_in(&folder, view) {
            outputs::check(&[outputs::Output::text("--out", table, "")], &[])?;
        }
        Ok(Self { folder: Some(folder), view, pictures, ..Self::default() })
    }

    /// Errors where the folder is one that a scene comes from: records and pictures would lie among its files, or
    /// replace some.
    pub fn admit(&self, cases: &[Case]) -> anyhow::Result<()> {
        let Some(folder) = &self.folder else { return Ok(()) };
        for case in cases {
            let Some(files) = case.files() else { continue };
            let own = folder.join(&case.id).canonicalize().ok();
            let lies_there = |file: &Path| {
                let of_file = file.parent().and_then(|folder| folder.canonicalize().ok());
                of_file.is_some() && of_file == own
            };
            if files.all().any(lies_there) {
                bail!(
                    "--out {}: results of {} would lie among its own files; name another folder",
                    folder.display(),
                    case.id
                );
            }
        }
        Ok(())
    }

    /// Keeps what came of one engine on one scene, if there is a folder.
    pub fn keep(
        &mut self,
        case: &Case,
        data: &CaseData,
        record: &Record,
        answer: Option<&Answer>,
    ) -> anyhow::Result<()> {
        let Some(folder) = &self.folder else { return Ok(()) };
        let folder = folder.join(&case.id);
        fs::create_dir_all(&folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        if self.pictures {
            if self.pictured.as_ref() != Some(&case.id) {
                match self.in_full {
                    true => pictures::write_pair(&folder, data)?,
                    false => pictures::write_left(&folder, data)?,
                }
                pictures::write_truth(&folder, data)?;
                self.pictured = Some(case.id.clone());
            }
            if let Some(answer) = answer {
                pictures::write_answer(&folder, &record.engine, data, answer)?;
                if self.in_full {
                    let page = folder.join(format!("{}.html", record.engine));
                    let title = format!("{}: {}", case.id, record.engine);
                    pictures::write_page(&page, &title, data, answer)?;
                }
            }
        }
        record.write(&folder.join(format!("{}.json", record.engine)))?;
        Ok(())
    }

    /// The whole result in the format that was asked for.
    pub fn shown(&self, records: &[Record], reference: Option<&str>) -> String {
        Tables { records, reference, view: self.view }.render(self.format)
    }

    /// The folder gets the whole result in all formats, the page gets it as an overview. A result without anything in it
    /// takes no other one's place: nor the folder's without a record, nor the page's without an answer.
    pub fn finish(&self, records: &[Record], reference: Option<&str>) -> anyhow::Result<()> {
        let tables = Tables { records, reference, view: self.view };
        if let Some(folder) = &self.folder
            && !records.is_empty()
        {
            for (table, format) in tables_in(folder, self.view) {
                let text = tables.render(format);
                write_atomically(table, |writer| writer.write_all(text.as_bytes()))?;
            }
        }
        if let Some(page) = &self.page
            && records.iter().any(|record| record.status.message().is_none())
        {
            page.put(&tables.for_page())?;
        }
        Ok(())
    }

    /// In words where the results lie, if they are kept; of what nobody answered there are no pictures.
    pub fn place(&self, any_answered: bool) -> Option<String> {
        let folder = self.folder.as_ref()?;
        let what = match (self.in_full, self.pictures) {
            _ if !any_answered => "records are",
            (true, _) => "pictures, pages of points and records are",
            (false, true) => "pictures and records are",
            (false, false) => "records are",
        };
        Some(format!("{what} in {}", folder.display()))
    }
}
