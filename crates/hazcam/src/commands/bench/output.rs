//! Where results go: tables to stdout, records and pictures into a folder.

use std::fs;
use std::path::PathBuf;

use anyhow::Context;
use arena::dataset::{Case, CaseData};
use arena::engine::{Answer, measures_cpu_time};
use arena::record::Record;
use arena::report::{self, Format, Summary};
use formats::write_atomically;

use super::pictures;

/// What is shown and kept of a run.
#[derive(Default)]
pub struct Output {
    /// How the tables are shown.
    pub format: Format,
    folder: Option<PathBuf>,
    pictures: bool,
    /// The scene whose own pictures have been written last.
    pictured: Option<String>,
}

impl Output {
    /// Keeps everything in a folder, which is made now, so that a bad name shows before the work.
    pub fn in_folder(folder: PathBuf, pictures: bool) -> anyhow::Result<Self> {
        fs::create_dir_all(&folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        Ok(Self { folder: Some(folder), pictures, ..Self::default() })
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
                pictures::write_scene(&folder, data)?;
                self.pictured = Some(case.id.clone());
            }
            if let Some(answer) = answer {
                pictures::write_answer(&folder, &record.engine, data, answer)?;
            }
        }
        record.write(&folder.join(format!("{}.json", record.engine)))?;
        Ok(())
    }

    /// The whole result in the format that was asked for; the folder gets it in all of them.
    pub fn finish(&self, records: &[Record], reference: Option<&str>) -> anyhow::Result<String> {
        let summaries = report::summaries(records, reference);
        if let Some(folder) = &self.folder {
            for (name, format) in [
                ("scores.md", Format::Markdown),
                ("scores.csv", Format::Csv),
                ("scores.json", Format::Json),
            ] {
                let text = render(format, records, &summaries, reference);
                write_atomically(folder.join(name), |writer| writer.write_all(text.as_bytes()))?;
            }
        }
        Ok(render(self.format, records, &summaries, reference))
    }

    /// In words where the results lie, if they are kept.
    pub fn place(&self) -> Option<String> {
        let folder = self.folder.as_ref()?;
        let what = if self.pictures { "pictures and records are" } else { "records are" };
        Some(format!("{what} in {}", folder.display()))
    }
}

fn render(
    format: Format,
    records: &[Record],
    summaries: &[Summary],
    reference: Option<&str>,
) -> String {
    let scores = report::scores_table(records);
    let summary = report::summary_table(summaries, reference);
    match format {
        Format::Text => {
            let mut text = scores.to_text();
            text.push_str(&notes(records, "\n"));
            text.push_str(&format!("\n{}", summary.to_text()));
            text.push_str(&summary_note(reference));
            text
        }
        Format::Markdown => {
            let mut text = scores.to_markdown();
            text.push_str(&notes(records, "\n* "));
            text.push_str(&format!("\n{}", summary.to_markdown()));
            text.push_str(&summary_note(reference));
            text
        }
        Format::Csv => scores.to_csv(),
        Format::Json => report::to_json(records, summaries),
    }
}

/// Failures and the legend, each line introduced by `mark`.
fn notes(records: &[Record], mark: &str) -> String {
    let mut lines: Vec<String> = report::failures(records)
        .into_iter()
        .map(|failure| format!("{}, {}: {}", failure.case, failure.engine, failure.status))
        .collect();
    lines.extend(records.iter().filter(|record| record.repeatable == Some(false)).map(|record| {
        format!("{}, {}: repeated runs gave different disparities", record.case, record.engine)
    }));
    lines.extend(report::LEGEND.map(str::to_owned));
    if !measures_cpu_time() {
        lines.push("this system tells neither CPU time nor memory of another process".into());
    }
    if let Some(record) = records.first() {
        let machine = &record.machine;
        lines.push(format!(
            "{} thread(s) an engine, {}, {} core(s), {}; hazcam {}",
            record.threads,
            machine.cpu.as_deref().unwrap_or(machine.architecture),
            machine.cores,
            machine.level.as_deref().unwrap_or("vector level unknown"),
            record.hazcam
        ));
    }
    let mut text: String = lines.iter().map(|line| format!("{mark}{line}")).collect();
    text.push('\n');
    text
}

fn summary_note(reference: Option<&str>) -> String {
    let means = "\nMeans over scenes, each of which weighs the same.";
    match reference {
        Some(name) => format!(
            "{means} Ratio: geometric mean of p_bad over that of {name}; it hides a single bad \
             scene, so look at the worst one too.\n"
        ),
        None => format!("{means}\n"),
    }
}
