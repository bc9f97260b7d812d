//! Runs as text: tables, what their columns mean, and how it was measured.

use arena::report::{Format, Table, printable};
use arena::speed::{self, Record, Run};

use crate::wrap::wrapped;

/// What the times hold. They are medians unless a column says otherwise.
const LEGEND: [&str; 4] = [
    "ms: matching alone by each engine's own clock, median over the runs after one to warm up; the \
     engines take turns; ratio: the peer's time over the matcher's; MDE/s: million disparities \
     evaluated per second, at the median; ns (sweep): per pixel and disparity; of several machines, \
     whatever does not name one is of the one that measured last",
    "CPU ms, MB: of the engine's process (median, peak), seen from outside (Linux only), so that files \
     are read and written within, and OpenCV's has Python in it",
    "the images are grey, all of their pixels are answered, and all disparities from 0 on are \
     searched at each: OpenCV gets a border on the left for that, which is not timed",
    "fast, balanced and best are timed with all they do: grey images in, a map without holes, \
     reasons and confidence out; StereoBM with its prefilter, texture and uniqueness checks; \
     StereoSGBM with its uniqueness and right-view checks, 3 x 3 median and speckle filter, holes \
     left open; WLS with the right view and the filter",
];

/// The runs in the format that was asked for.
pub fn show(runs: &[Run], format: Format) -> String {
    let tables = || {
        let (sweep, fixed) = parted(runs);
        [speed::measurements_table(&fixed), speed::peers_table(&fixed), speed::sweep_table(&sweep)]
    };
    match format {
        Format::Text => {
            document(&tables(), runs, Table::to_text, |line| wrapped(line).join("\n  "))
        }
        Format::Markdown => markdown(&tables(), runs),
        Format::Csv => speed::measurements_table(runs).to_csv(),
        Format::Json => Record { runs: runs.to_vec() }.to_json(),
    }
}

/// For a page: matchers against their peers, how time grows, and how it was measured.
pub fn for_page(runs: &[Run]) -> String {
    let (sweep, fixed) = parted(runs);
    markdown(&[speed::peers_table(&fixed), speed::sweep_table(&sweep)], runs)
}

fn markdown(tables: &[Table], runs: &[Run]) -> String {
    document(tables, runs, Table::to_markdown, |line| format!("* {line}"))
}

/// The tables that have rows, shown by `show`, then each note by `note`.
fn document(
    tables: &[Table],
    runs: &[Run],
    show: impl Fn(&Table) -> String,
    note: impl Fn(&str) -> String,
) -> String {
    let mut parts: Vec<String> =
        tables.iter().filter(|table| !table.rows.is_empty()).map(show).collect();
    let notes = failures(runs).into_iter().chain(LEGEND.map(str::to_owned)).chain(conditions(runs));
    parts.push(notes.map(|line| note(&line) + "\n").collect());
    parts.join("\n")
}

/// Runs of a sweep, and the others.
fn parted(runs: &[Run]) -> (Vec<Run>, Vec<Run>) {
    runs.iter().cloned().partition(|run| run.sweep)
}

fn failures(runs: &[Run]) -> Vec<String> {
    let all = runs.iter().flat_map(|run| run.measurements.iter().map(move |found| (run, found)));
    all.filter(|(_, found)| found.status.message().is_some())
        .map(|(run, found)| format!("{}, {}: {}", run.scene, found.engine, found.status))
        .map(|line| printable(&line))
        .collect()
}

/// Machines, programs, days and commands, each said once.
fn conditions(runs: &[Run]) -> Vec<String> {
    let mut lines: Vec<(String, String)> = Vec::new();
    for run in runs {
        let machine = &run.machine;
        let opencv = run.measurements.iter().find(|found| found.engine.starts_with("opencv-"));
        let opencv = opencv.and_then(|found| found.version.as_deref());
        let opencv = opencv.map(|version| format!(", OpenCV {version}")).unwrap_or_default();
        let line = format!(
            "{machine}, {} {}; hazcam {}{opencv}; {}; made by",
            machine.architecture, machine.system, run.hazcam, run.date
        );
        let command = format!("`{}`", run.command);
        match lines.iter_mut().find(|(known, _)| *known == line) {
            Some((_, commands)) if commands.contains(&command) => {}
            Some((_, commands)) => *commands += &format!(", {command}"),
            None => lines.push((line, command)),
        }
    }
    lines.into_iter().map(|(line, commands)| format!("{line} {commands}")).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// A file of the project.
    fn project(name: &str) -> std::path::PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
    }

    #[test]
    fn the_readme_shows_the_record_and_nothing_else() {
        let record = Record::read(&project("benchmarks/speed.json")).unwrap();
        let page = std::fs::read_to_string(project("README.md")).unwrap();
        let (_, rest) = page.split_once("<!-- speed -->\n").unwrap();
        let (shown, _) = rest.split_once("<!-- /speed -->").unwrap();
        assert_eq!(
            shown,
            for_page(&record.runs),
            "make it anew: hazcam bench --speed --record benchmarks/speed.json --recorded --into \
             README.md"
        );
    }
}
