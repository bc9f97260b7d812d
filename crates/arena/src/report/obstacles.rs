//! How much of small obstacles engines miss, by how wide they are and how far they stand out.

use super::in_order;
use super::table::{Cell, Column, Table};
use crate::record::{Missed, Record, STEPS, WIDTHS};

/// Of each engine, for obstacles of several widths and steps: which share of their pixels is missed, and which is missed
/// surely, in per cent, over all pixels of all scenes.
pub fn obstacles_table(records: &[Record]) -> Table {
    let names = [Column::grouped("matcher"), Column::new("width px")];
    let steps = STEPS.windows(2).map(|step| span(step[0], step[1], |end| end.is_finite()));
    let columns =
        steps.flat_map(|step| ["missed", "surely"].map(|what| format!("{step} px: {what} %")));
    let columns = names.into_iter().chain(columns.map(Column::new)).collect();
    let mut table = Table { columns, rows: Vec::new() };
    for engine in in_order(records.iter().map(|record| record.engine.as_str())) {
        let own = records.iter().filter(|record| record.engine == engine);
        let own: Vec<&Missed> = own.flat_map(|record| &record.missed).collect();
        if own.is_empty() {
            continue;
        }
        for width in WIDTHS.windows(2) {
            let mut row = vec![
                Cell::text(engine),
                Cell::text(span(width[0].max(1), width[1] - 1, |&end| end < usize::MAX - 1)),
            ];
            for &from_step in &STEPS[..STEPS.len() - 1] {
                let here = |m: &&&Missed| m.from_width == width[0] && m.from_step == from_step;
                let group = || own.iter().filter(here);
                let pixels: usize = group().map(|m| m.pixels).sum();
                let share = |count: usize| 100.0 * count as f64 / pixels as f64;
                let missed = (pixels > 0).then(|| share(group().map(|m| m.missed).sum()));
                let surely: Option<usize> = group().map(|m| m.surely).sum();
                let surely = surely.filter(|_| pixels > 0).map(share);
                row.extend([Cell::number(missed, 1), Cell::number(surely, 1)]);
            }
            table.rows.push(row);
        }
    }
    table
}

/// `a to b`, or `a on` where there is no end.
fn span<T: std::fmt::Display>(start: T, end: T, ends: impl Fn(&T) -> bool) -> String {
    if ends(&end) { format!("{start} to {end}") } else { format!("{start} on") }
}

/// What the table means, to be printed beside it.
pub const OBSTACLES_LEGEND: [&str; 3] = [
    "obstacles: pieces of each scene, ellipses and boxes 6 to 32 pixels wide, that lie somewhere else before what is there, \
     seen by both cameras; they cover up to a tenth of it",
    "missed: pixels of obstacles whose disparity is nearer to that of what is behind, or is missing, in per cent of all \
     that are so wide and stand so many px of disparity before it, in scenes that the matcher answered; surely: those with \
     a confidence of 0.5 and more",
    "width: the smaller one of an obstacle's width and height",
];
