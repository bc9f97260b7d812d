//! What `hazcam score` prints, one function per format.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use arena::report::{Cell, Column, Format, Table, in_markdown};
use formats::Encoding;
use score::{Measure, Scores, Sparsification, Unit};
use serde::{Serialize, Serializer};

use crate::wrap::wrapped;

/// The scores and where they come from.
#[derive(Serialize)]
pub struct Report {
    /// The version of hazcam.
    pub hazcam: &'static str,
    /// What was scored.
    pub estimate: Map,
    /// What it was scored against.
    pub truth: Map,
    /// The numbers.
    pub scores: Scores,
    /// How well a confidence ranks errors, if one was given.
    #[serde(skip_serializing_if = "Option::is_none", rename = "confidence")]
    pub ranking: Option<Ranking>,
    /// The factor by which the estimate seems to be too large, if any.
    pub suspected_scale: Option<f64>,
}

/// A disparity map's file and how it was understood.
#[derive(Serialize)]
pub struct Map {
    #[serde(serialize_with = "formats::path_as_text")]
    path: PathBuf,
    #[serde(serialize_with = "as_text")]
    encoding: Encoding,
}

/// How well a confidence ranks errors.
#[derive(Serialize)]
pub struct Ranking {
    /// The file that it stands in.
    #[serde(serialize_with = "formats::path_as_text")]
    pub path: PathBuf,
    /// Bad pixels.
    pub bad: Sparsification,
    /// Errors in pixels.
    pub error: Sparsification,
}

/// A number by its name.
struct Row {
    name: &'static str,
    value: Option<f64>,
    unit: Unit,
}

fn as_text<S: Serializer>(encoding: &Encoding, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(encoding)
}

impl Map {
    /// The file and its encoding.
    pub fn new(path: &Path, encoding: Encoding) -> Self {
        Self { path: path.to_owned(), encoding }
    }

    fn describe(&self) -> String {
        format!("{} ({})", self.path.display(), self.encoding)
    }
}

/// The number as people of the field write it: pixels, the course's share, per cent otherwise.
fn shown(&Row { name, value, unit }: &Row) -> String {
    match (value, unit) {
        (None, _) => "none".into(),
        (Some(value), Unit::Pixels) => format!("{value:.3} px"),
        (Some(value), Unit::Share) if name == "p_bad" => format!("{value:.4}"),
        (Some(value), Unit::Share) => format!("{:.2} %", 100.0 * value),
    }
}

/// The areas under a curve, of these names.
fn areas(names: [&'static str; 3], of: &Sparsification, unit: Unit) -> Vec<Row> {
    let values = [of.auc, of.optimal_auc, of.ause];
    let rows = names.into_iter().zip(values);
    rows.map(|(name, value)| Row { name, value: Some(value), unit }).collect()
}

impl Report {
    /// The report as text that ends with a line break.
    pub fn render(&self, format: Format) -> anyhow::Result<String> {
        Ok(match format {
            Format::Text => self.text(),
            Format::Json => serde_json::to_string_pretty(self)? + "\n",
            Format::Csv => self.csv(),
            Format::Markdown => self.markdown(),
        })
    }

    /// Families of measures: those that share a protocol, in order.
    fn families(&self) -> Vec<(&str, Vec<Row>)> {
        let mut families: Vec<(&str, Vec<Row>)> = Vec::new();
        for measure in Measure::ALL {
            let protocol = measure.protocol(&self.scores).unwrap_or(
                "course: no pixel has a nonzero truth, and the course reads zero as unknown",
            );
            let value = measure.value(&self.scores);
            let row = Row { name: measure.name, value, unit: measure.unit };
            match families.last_mut() {
                Some((last, members)) if *last == protocol => members.push(row),
                _ => families.push((protocol, vec![row])),
            }
        }
        if let Some(Ranking { bad, error, .. }) = &self.ranking {
            let names = ["AUC-bad2", "AUC-bad2-optimal", "AUSE-bad2"];
            families.push((&bad.protocol, areas(names, bad, Unit::Share)));
            let names = ["AUC-EPE", "AUC-EPE-optimal", "AUSE-EPE"];
            families.push((&error.protocol, areas(names, error, Unit::Pixels)));
        }
        families
    }

    fn text(&self) -> String {
        let Scores { pixels, holes, .. } = self.scores;
        let mut text = String::new();
        let mut line = |line: String| text.extend([&line, "\n"]);
        line(format!("estimate   {}", self.estimate.describe()));
        line(format!("truth      {}", self.truth.describe()));
        let percent = 100.0 * holes as f64 / pixels as f64;
        line(format!(
            "pixels     {pixels} with known truth, {holes} of them holes ({percent:.2} %)"
        ));
        for (protocol, rows) in self.families() {
            line(String::new());
            wrapped(protocol).into_iter().for_each(&mut line);
            for row in rows {
                line(format!("  {:<16} {:>10}", row.name, shown(&row)));
            }
        }
        text
    }

    fn csv(&self) -> String {
        let columns = ["estimate", "truth", "measure", "value", "unit", "protocol"];
        let mut table = Table { columns: columns.map(Column::new).into(), rows: Vec::new() };
        let [estimate, truth] =
            [&self.estimate, &self.truth].map(|map| map.path.display().to_string());
        for (protocol, rows) in self.families() {
            for Row { name, value, unit } in rows {
                let unit = match unit {
                    Unit::Pixels => "px",
                    Unit::Share => "share",
                };
                let [estimate, truth] = [&estimate, &truth].map(Cell::text);
                let (name, value) = (Cell::text(name), Cell::number(value, 0));
                table.push(vec![
                    estimate,
                    truth,
                    name,
                    value,
                    Cell::text(unit),
                    Cell::text(protocol),
                ]);
            }
        }
        table.to_csv()
    }

    fn markdown(&self) -> String {
        let families = self.families();
        let mut table =
            Table { columns: ["measure", "value"].map(Column::new).into(), rows: Vec::new() };
        for (i, (_, rows)) in families.iter().enumerate() {
            for row in rows {
                let name = format!("{} ({})", row.name, i + 1);
                table.push(vec![Cell::text(name), Cell::text(shown(row))]);
            }
        }
        let [estimate, truth] =
            [&self.estimate, &self.truth].map(|map| in_markdown(&map.describe()));
        let Scores { pixels, holes, .. } = self.scores;
        let table = table.to_markdown();
        let mut text =
            format!("{estimate} against {truth}, {pixels} pixels, {holes} holes\n\n{table}\n");
        for (i, (protocol, _)) in families.iter().enumerate() {
            let _ = writeln!(text, "{}. {}", i + 1, in_markdown(protocol));
        }
        text
    }
}
