//! One row for each scene, engine and region.

use super::in_order;
use super::table::{Cell, Column, Table};
use crate::dataset::{BEYOND_THE_RANGE, RANGE_BY_TRUTH, RANGE_BY_WIDTH};
use crate::engine::Status;
use crate::record::Record;

/// The measures of the table: name, heading, factor to the heading's unit, digits.
const MEASURES: [(&str, &str, f64, usize); 9] = [
    ("E_RMS", "E_RMS", 1.0, 2),
    ("p_bad", "p_bad", 1.0, 4),
    ("bad0.5", "bad0.5 %", 100.0, 2),
    ("bad1", "bad1 %", 100.0, 2),
    ("bad2", "bad2 %", 100.0, 2),
    ("bad4", "bad4 %", 100.0, 2),
    ("avgerr", "avgerr", 1.0, 2),
    ("D1", "D1 %", 100.0, 2),
    ("density", "density %", 100.0, 1),
];

/// The regions of the table, with their short names.
const REGIONS: [(&str, &str); 2] = [("all", "all"), ("non-occluded", "noc")];

/// Scores over all pixels and over the non-occluded ones, with times and memory in the first row of
/// each pair. There is a column for the status when some engine has no answer.
///
/// E_RMS and average error are in pixels; p_bad is a share from 0 to 1, as the course gives it.
pub fn scores_table(records: &[Record]) -> Table {
    let first = [Column::grouped("scene"), Column::grouped("matcher"), Column::new("pixels")];
    let measures = MEASURES.map(|(_, heading, ..)| Column::new(heading));
    let last = USED.map(Column::new);
    let mut columns: Vec<_> = first.into_iter().chain(measures).chain(last).collect();
    let with_status = needs_status(records.iter());
    if with_status {
        columns.push(Column::new("status"));
    }
    let mut table = Table { columns, rows: Vec::new() };
    for record in records {
        for (region, short) in REGIONS {
            // The first row stands even without scores: it says how the engine fared.
            if region == "all" || record.scores_of(region).is_some() {
                let mut row = row(record, region, short);
                if with_status {
                    row.push(Cell::text(if region == "all" { record.status.name() } else { "" }));
                }
                table.push(row);
            }
        }
    }
    table
}

fn row(record: &Record, region: &str, short: &str) -> Vec<Cell> {
    let mut row = vec![
        Cell::text(&record.case),
        Cell::text(&record.engine),
        match record.scores_of(region) {
            Some(_) => Cell::text(short),
            None => Cell::Empty,
        },
    ];
    row.extend(MEASURES.map(|(name, _, factor, digits)| {
        Cell::number(record.value(region, name).map(|value| value * factor), digits)
    }));
    if region == "all" {
        row.extend(used(record));
    } else {
        row.extend(USED.map(|_| Cell::text("")));
    }
    row
}

/// The headings of [`used`].
pub(super) const USED: [&str; 3] = ["CPU ms", "wall ms", "MB"];

/// Times and memory.
pub(super) fn used(record: &Record) -> [Cell; 3] {
    let usage = &record.usage;
    [
        Cell::number(usage.cpu_seconds.map(|seconds| seconds * 1e3), 1),
        Cell::Number(usage.wall_seconds * 1e3, 1),
        Cell::number(usage.peak_memory_bytes.map(|bytes| bytes as f64 / 1e6), 0),
    ]
}

/// Whether there is a column that tells how engines fared: where all is well it would only say so.
pub(super) fn needs_status<'a>(mut records: impl Iterator<Item = &'a Record>) -> bool {
    records.any(|record| record.status != Status::Done)
}

/// What the table's numbers mean, a line for each, to be printed beside it.
pub const LEGEND: [&str; 6] = [
    "all: pixels of the box (without one, of the whole image) with known truth; noc: those of them \
     that both cameras see",
    "E_RMS, p_bad (course): in px, and the share of errors > 2 px; a hole counts as disparity 0, \
     and as bad; where the truth is 0 (as in a sky at infinity) nothing is counted",
    "bad T (Middlebury): errors > T px and holes; avgerr: mean error in px of the estimates, both \
     clipped to the range",
    "D1 (KITTI): errors > 3 px and > 5 %, holes filled from the background first",
    "density: pixels with an estimate",
    USED_LEGEND,
];

/// What [`used`] means.
pub(super) const USED_LEGEND: &str = "CPU, wall, MB: the engine's process as seen from outside, from sending the pair \
                                      to its answer; MB is its peak";

/// Says on how many scenes matchers were told a range that nothing states, and where it comes from: a line for each way.
pub fn assumed_ranges(records: &[Record]) -> Vec<String> {
    let ways = [RANGE_BY_TRUTH, RANGE_BY_WIDTH].into_iter().filter_map(|way| {
        let told = |record: &&Record| record.protocol.iter().any(|line| line == way);
        let scenes = in_order(records.iter().filter(told).map(|record| record.case.as_str()));
        let count = scenes.len();
        (count > 0).then(|| format!("{way} on {count} scenes, of which nothing else states one"))
    });
    ways.collect()
}

/// Names the scenes much of whose truth lies outside the range that matchers were told.
pub fn truths_beyond(records: &[Record]) -> Vec<String> {
    let told = |record: &Record| {
        let line = record.protocol.iter().find(|line| line.contains(BEYOND_THE_RANGE))?;
        Some(format!(
            "{}: {line}: name min_disparity and max_disparity in scenes.json",
            record.case
        ))
    };
    let lines: Vec<String> = records.iter().filter_map(told).collect();
    in_order(lines.iter().map(String::as_str)).into_iter().map(str::to_owned).collect()
}

/// What came of an engine that gave no answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// The scene.
    pub case: String,
    /// The engine.
    pub engine: String,
    /// Its status with its message.
    pub status: String,
}

/// Every record without an answer.
pub fn failures(records: &[Record]) -> Vec<Failure> {
    records
        .iter()
        .filter(|record| record.status.message().is_some())
        .map(|record| Failure {
            case: record.case.clone(),
            engine: record.engine.clone(),
            status: record.status.to_string(),
        })
        .collect()
}
