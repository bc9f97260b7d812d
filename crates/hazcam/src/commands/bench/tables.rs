//! Which tables tell what came of a run, and the words beside them.

use arena::engine::measures_cpu_time;
use arena::record::Record;
use arena::report::{self, Format, Table};

use super::ablation;
use super::into::command_line;
use crate::wrap::wrapped;

/// Which tables are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum View {
    /// Every score on every scene, then what it comes to over many scenes, also by the reasons that
    /// matchers give.
    #[default]
    Scores,
    /// Every score on every scene, then where in the scenes the errors are.
    Regions,
    /// Only how the share of bad pixels changes from scene to scene.
    Strains,
    /// What each ingredient of a preset gives.
    Ablation,
    /// How reliable disparities are by how sure matchers are of them.
    Reliability,
    /// How much of small obstacles matchers miss.
    Obstacles,
}

impl View {
    /// What files that hold such tables are called: those of one kind are never in the place of another's.
    pub fn file_stem(self) -> &'static str {
        match self {
            Self::Scores | Self::Regions | Self::Strains => "scores",
            Self::Ablation => "ablation",
            Self::Reliability => "reliability",
            Self::Obstacles => "obstacles",
        }
    }
}

/// A run to be shown.
pub struct Tables<'a> {
    /// What was measured.
    pub records: &'a [Record],
    /// The engine that others are compared with.
    pub reference: Option<&'a str>,
    /// Which tables are shown.
    pub view: View,
}

impl Tables<'_> {
    /// The tables with their legend; as CSV the scores or the ablation alone, as JSON the records with
    /// what they come to.
    pub fn render(&self, format: Format) -> String {
        match format {
            Format::Text => self.document(Table::to_text, |line| wrapped(&line).join("\n  ")),
            Format::Markdown => self.document(Table::to_markdown, |line| format!("* {line}")),
            Format::Csv => match self.view {
                View::Ablation => ablation::table(&ablation::rows(self.records)).to_csv(),
                View::Reliability => report::reliability_table(self.records).to_csv(),
                View::Obstacles => report::obstacles_table(self.records).to_csv(),
                _ if self.records.iter().any(|record| record.has_truth) => {
                    report::scores_table(self.records).to_csv()
                }
                _ => report::coverage_table(self.records).to_csv(),
            },
            Format::Json => match self.view {
                View::Ablation => report::to_json(self.records, &ablation::rows(self.records)),
                _ => {
                    report::to_json(self.records, &report::summaries(self.records, self.reference))
                }
            },
        }
    }

    /// Tables shown by `show`, each note by `note`.
    fn document(&self, show: impl Fn(&Table) -> String, note: impl Fn(String) -> String) -> String {
        let notes = |lines: Vec<String>| -> String {
            lines.into_iter().map(|line| note(line) + "\n").collect()
        };
        let Self { records, reference, view } = *self;
        match view {
            View::Scores => {
                let words = |lines: &[&str]| lines.iter().copied().map(str::to_owned).collect();
                let with_truth = records.iter().filter(|record| record.has_truth).cloned();
                let scores = report::scores_table(&with_truth.collect::<Vec<_>>());
                let coverage = report::coverage_table(records);
                let legend = words(&report::COVERAGE_LEGEND);
                // How it was measured is told once.
                let of_coverage =
                    if scores.rows.is_empty() { self.notes(legend) } else { legend };
                let summaries = report::summaries(records, reference);
                let parts = [
                    (scores, self.notes(words(&report::LEGEND))),
                    (coverage, of_coverage),
                    (report::summary_table(&summaries, reference), vec![summary_note(reference)]),
                    (report::reasons_table(records), vec![report::REASONS_LEGEND.into()]),
                ];
                let parts = parts.into_iter().filter(|(table, _)| !table.rows.is_empty());
                let parts = parts.map(|(table, lines)| format!("{}\n{}", show(&table), notes(lines)));
                parts.collect::<Vec<_>>().join("\n")
            }
            View::Regions => format!(
                "{}\n{}\n{}\n{}",
                show(&report::scores_table(records)),
                notes(self.notes(report::LEGEND.map(str::to_owned).to_vec())),
                show(&report::regions_table(records)),
                notes(vec![report::REGIONS_LEGEND.into()])
            ),
            View::Strains => format!(
                "{}\n{}",
                show(&report::bad2_table(records)),
                notes(self.notes(vec![
                    "per cent of errors > 2 px and holes (Middlebury's bad 2), over all pixels of \
                     the image, and noc: over those that both cameras see"
                        .into(),
                    "every scene is `plain` (cards with fine texture, 450 x 375, disparities 0 to \
                     64, noise 1) save for what its name says, a floor or a wall one plane with that \
                     texture in its own range; lengths in px, noise in grey levels, \
                     everything else as a factor or exponent"
                        .into(),
                ]))
            ),
            View::Ablation => {
                let rows = ablation::rows(records);
                let notes = notes(self.notes(ablation::legend(&rows)));
                format!("{}\n{notes}", show(&ablation::table(&rows)))
            }
            View::Reliability => format!(
                "{}\n{}",
                show(&report::reliability_table(records)),
                notes(self.notes(report::RELIABILITY_LEGEND.map(str::to_owned).to_vec()))
            ),
            View::Obstacles => format!(
                "{}\n{}\n{}",
                show(&report::obstacles_table(records)),
                show(&report::false_alarms_table(records)),
                notes(self.notes(report::OBSTACLES_LEGEND.map(str::to_owned).to_vec()))
            ),
        }
    }

    /// For a page: the table of an ablation, of reliability or of obstacles, else every engine on every scene, and
    /// how it was measured.
    pub fn for_page(&self) -> String {
        let made_by = format!("made by `{}`", command_line());
        if matches!(self.view, View::Ablation | View::Reliability | View::Obstacles) {
            return format!("{}* {made_by}\n", self.render(Format::Markdown));
        }
        let mut text = report::overview_table(self.records).to_markdown();
        text.push_str(
            "\nE_RMS in px / p_bad, the share of errors > 2 px, over all pixels with truth in the \
             scene's box; CPU: mean over these scenes, of the engine's process, seen from outside",
        );
        for line in self.records.first().map(conditions).iter().chain([&made_by]) {
            text.push_str("; ");
            text.push_str(line);
        }
        text.push_str(".\n");
        text
    }

    /// Failures, the legend, and how it was measured.
    fn notes(&self, legend: Vec<String>) -> Vec<String> {
        let mut lines: Vec<String> = report::failures(self.records)
            .into_iter()
            .map(|failure| format!("{}, {}: {}", failure.case, failure.engine, failure.status))
            .map(|line| report::printable(&line))
            .collect();
        let differ = self.records.iter().filter(|record| record.repeatable == Some(false));
        lines.extend(differ.map(|record| {
            format!("{}, {}: repeated runs gave different disparities", record.case, record.engine)
        }));
        lines.extend(legend);
        lines.extend(report::assumed_ranges(self.records));
        lines.extend(report::truths_beyond(self.records));
        if !measures_cpu_time() {
            lines.push("this system tells neither CPU time nor memory of another process".into());
        }
        lines.extend(self.records.first().map(conditions));
        lines
    }
}

/// On which machine a record was made, and with what.
fn conditions(record: &Record) -> String {
    let threads = match record.threads {
        1 => "1 thread".to_owned(),
        n => format!("{n} threads"),
    };
    let at_once = match record.jobs {
        1 => String::new(),
        n => format!(", {n} engines at once: times are longer than alone"),
    };
    format!("{threads} per engine{at_once}; {}; hazcam {}", record.machine, record.hazcam)
}

fn summary_note(reference: Option<&str>) -> String {
    let means = "means over scenes, each of which weighs the same";
    match reference {
        Some(name) => format!(
            "{means}; ratio: geometric mean of p_bad over that of {name}, which hides a single bad \
             scene, so look at the worst one too"
        ),
        None => means.into(),
    }
}
