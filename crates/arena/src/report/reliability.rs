//! How reliable disparities are, by how sure an engine itself says it is of them.

use score::mean;

use super::in_order;
use super::table::{Cell, Column, Table};
use crate::record::{LEAST_CONFIDENCES, Record, at_least};

/// Of each engine that says how sure it is, for several bounds: means over the scenes of the share of
/// pixels that are as sure, of their errors above 2 and 4 px in per cent, and of the errors that half, 90,
/// 95 and 99 % of them do not exceed, in px; and the scene with the most errors above 2 px.
pub fn reliability_table(records: &[Record]) -> Table {
    let names = [Column::grouped("matcher"), Column::new("sure from")];
    let columns = ["pixels %", "bad2 %", "bad4 %", "A50", "A90", "A95", "A99", "worst bad2 %"];
    let columns = columns.map(Column::new).into_iter().chain([Column::new("worst scene")]);
    let mut table = Table { columns: names.into_iter().chain(columns).collect(), rows: Vec::new() };
    for engine in in_order(records.iter().map(|record| record.engine.as_str())) {
        let own = records.iter().filter(|record| record.engine == engine);
        let own: Vec<&Record> = own.filter(|record| !record.by_confidence.is_empty()).collect();
        for least in LEAST_CONFIDENCES {
            table.rows.extend(row(engine, &own, least));
        }
    }
    table
}

fn row(engine: &str, records: &[&Record], least: f32) -> Option<Vec<Cell>> {
    let region = at_least(least);
    let mut shares = 0.0;
    let mut found: Vec<([Option<f64>; 6], &str)> = Vec::new();
    for record in records {
        let Some(of_sure) = record.by_confidence.iter().find(|scores| scores.region == region)
        else {
            continue;
        };
        let all = record.scores_of("all").map_or(of_sure.pixels, |scores| scores.pixels);
        shares += of_sure.pixels as f64 / all as f64;
        let m = &of_sure.middlebury;
        let [_, _, bad2, bad4] = m.bad.map(|bad| Some(100.0 * bad.totbad));
        found.push(([bad2, bad4, m.a50, m.a90, m.a95, m.a99], &record.case));
    }
    let worst = found.iter().max_by(|(a, _), (b, _)| a[0].partial_cmp(&b[0]).expect("a number"))?;
    let mean_of = |i: usize| mean(found.iter().filter_map(|(numbers, _)| numbers[i]));
    // A scene none of whose pixels is as sure counts with a share of 0.
    let share = Cell::number(Some(100.0 * shares / records.len() as f64), 1);
    let mut cells = vec![Cell::text(engine), Cell::text(least.to_string()), share];
    cells.extend((0..6).map(|i| Cell::number(mean_of(i), 2)));
    cells.extend([Cell::number(worst.0[0], 2), Cell::text(worst.1)]);
    Some(cells)
}

/// What the table means, to be printed beside it.
pub const RELIABILITY_LEGEND: [&str; 4] = [
    "sure from: pixels whose confidence is at least that; errors are means over the scenes that have any, each of \
     which weighs the same",
    "pixels %: of all pixels with truth in the scene's box, over all scenes; bad2, bad4: of those that are sure, in per \
     cent, errors > 2 and > 4 px and holes",
    "A50 to A99: errors in px that so many per cent of them do not exceed",
    "an error of e px in disparity is one of e Z^2 / (f B) in depth, for a focal length f in pixels and \
     cameras B apart: depth is good to a share s up to s f B / e",
];
