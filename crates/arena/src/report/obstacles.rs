//! How much of small obstacles engines miss, by how wide they are and how far they stand out.

use super::in_order;
use super::table::{Cell, Column, Table};
use crate::record::{Missed, Record, STEPS, WIDTHS};

/// Of each engine, for obstacles of several widths and steps: which share of their pixels is missed, and which is missed
/// surely, in per cent, over all pixels of all scenes.
pub fn obstacles_table(records: &[Record]) -> Table {
    let names = [Column::grouped("matcher"), Column::new("smaller side px")];
    let steps = STEPS.windows(2).map(|step| span(step[0], step[1], |end| end.is_finite()));
    let columns =
        steps.flat_map(|step| ["missed", "surely"].map(|what| format!("step {step} px: {what} %")));
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
                Cell::text(match width[0] {
                    0 => format!("up to {}", width[1] - 1),
                    from => span(from, width[1] - 1, |&end| end < usize::MAX - 1),
                }),
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

/// `a to b`, or `a and more` where there is no end.
fn span<T: std::fmt::Display>(start: T, end: T, ends: impl Fn(&T) -> bool) -> String {
    if ends(&end) { format!("{start} to {end}") } else { format!("{start} and more") }
}

/// What the table means, to be printed beside it.
pub const OBSTACLES_LEGEND: [&str; 3] = [
    "obstacles: pieces of each scene, ellipses and boxes 6 to 32 pixels wide, that lie somewhere else in it, nearer than \
     what is there and seen by both cameras; until they cover a tenth of it or no more fit. All images are grey, 8 bits",
    "missed: pixels whose disparity is nearer to that of what is behind, or is missing, in per cent of all obstacle pixels \
     of that size and step, over the scenes that the matcher answered; surely: missed pixels with a confidence of at least \
     0.5, in per cent of the same. What is much too near counts as seen: look at bad 2.0, too",
    "smaller side: of an obstacle's width and height; step: how many px of disparity it stands before what is behind",
];
