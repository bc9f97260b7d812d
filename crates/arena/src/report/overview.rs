//! Many records at one look: engines against scenes.

use score::mean;

use super::in_order;
use super::table::{Cell, Column, Table};
use crate::record::Record;

fn find<'a>(records: &'a [Record], case: &str, engine: &str) -> Option<&'a Record> {
    records.iter().find(|record| record.case == case && record.engine == engine)
}

/// One row for each engine: E_RMS in pixels and p_bad over all pixels on every scene, then the mean
/// CPU time over the scenes that it answered.
pub fn overview_table(records: &[Record]) -> Table {
    let cases = in_order(records.iter().map(|record| record.case.as_str()));
    let engines = in_order(records.iter().map(|record| record.engine.as_str()));
    let mut columns = vec![Column::new("matcher")];
    columns.extend(cases.iter().map(|case| Column::new(case.to_string())));
    columns.push(Column::new("CPU ms"));
    let mut table = Table { columns, rows: Vec::new() };
    for engine in engines {
        let own: Vec<_> = cases.iter().map(|case| find(records, case, engine)).collect();
        let mut row = vec![Cell::text(engine)];
        row.extend(own.iter().map(|record| match record {
            None => Cell::Empty,
            Some(record) => match record.value("all", "E_RMS").zip(record.value("all", "p_bad")) {
                Some((e_rms, p_bad)) => Cell::text(format!("{e_rms:.2} / {p_bad:.4}")),
                None => Cell::text(record.status.name()),
            },
        }));
        let times = own.iter().flatten().filter_map(|record| record.answer_cpu_seconds());
        row.push(Cell::number(mean(times).map(|seconds| seconds * 1e3), 0));
        table.push(row);
    }
    table
}

/// One row for each scene, and for each engine the share of errors above 2 px and holes
/// (Middlebury's bad 2, in per cent) over all pixels and over the non-occluded ones: how an engine
/// suffers from scene to scene. Where it gave no answer stands its status.
pub fn bad2_table(records: &[Record]) -> Table {
    let cases = in_order(records.iter().map(|record| record.case.as_str()));
    let engines = in_order(records.iter().map(|record| record.engine.as_str()));
    let mut columns = vec![Column::new("scene")];
    for engine in &engines {
        columns.push(Column::new(engine.to_string()));
        columns.push(Column::new("noc"));
    }
    let mut table = Table { columns, rows: Vec::new() };
    for case in cases {
        let mut row = vec![Cell::text(case)];
        for engine in &engines {
            let record = find(records, case, engine);
            row.extend(["all", "non-occluded"].map(|region| match record {
                Some(record) if record.status.message().is_some() && region == "all" => {
                    Cell::text(record.status.name())
                }
                Some(record) => {
                    Cell::number(record.value(region, "bad2").map(|share| 100.0 * share), 2)
                }
                None => Cell::Empty,
            }));
        }
        table.push(row);
    }
    table
}
