//! What can be said of pairs without truth: one row for each scene and engine.

use super::scores::{USED, USED_LEGEND, needs_status, used};
use super::table::{Cell, Column, Table};
use crate::record::{Coverage, Record};

/// Of every scene that has no truth and every engine, the shares of the box, in per cent, that have a disparity, that
/// were matched and that the engine is sure of, with times and memory. There is a column for the status when some
/// engine has no answer.
pub fn coverage_table(records: &[Record]) -> Table {
    let records: Vec<&Record> = records.iter().filter(|record| !record.has_truth).collect();
    let with_status = needs_status(records.iter().copied());
    let names = ["scene", "matcher"].map(Column::grouped).into_iter();
    let shares = ["density %", "matched %", "sure %"].map(Column::new);
    let status = with_status.then(|| Column::new("status"));
    let columns = names.chain(shares).chain(USED.map(Column::new)).chain(status).collect();
    let mut table = Table { columns, rows: Vec::new() };
    for record in records {
        let share = |of: fn(&Coverage) -> Option<usize>| {
            let coverage = record.coverage.as_ref();
            let share = |coverage| Some(100.0 * of(coverage)? as f64 / coverage.pixels as f64);
            Cell::number(coverage.and_then(share), 1)
        };
        let mut row = vec![
            Cell::text(&record.case),
            Cell::text(&record.engine),
            share(|coverage| Some(coverage.estimates)),
            share(|coverage| coverage.matched),
            share(|coverage| coverage.sure),
        ];
        row.extend(used(record));
        row.extend(with_status.then(|| Cell::text(record.status.name())));
        table.push(row);
    }
    table
}

/// What the table's numbers mean, a line for each, to be printed beside it.
pub const COVERAGE_LEGEND: [&str; 3] = [
    "of these scenes nobody knows the truth: nothing says how much of it is right",
    "in per cent of the pixels of the box (without one, of the whole image): density: with an estimate; matched: not \
     filled, as the matcher says; sure: with a confidence of at least 0.5",
    USED_LEGEND,
];
