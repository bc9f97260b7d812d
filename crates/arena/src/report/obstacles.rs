//! How much of small obstacles engines miss, by how wide they are and how far they stand out, and how much they take for
//! some.

use super::in_order;
use super::table::{Cell, Column, Table};
use crate::record::{FalseAlarms, Missed, Record, STEPS, WIDTHS};

/// For obstacles of each width and step, of each engine: which share of their pixels is missed, and which is missed surely,
/// and which share of them is overlooked, in per cent, over all scenes.
pub fn obstacles_table(records: &[Record]) -> Table {
    let grouped = ["smaller side px", "step px"].map(Column::grouped);
    let columns = ["matcher", "missed %", "surely %", "overlooked %"].map(Column::new);
    let columns = grouped.into_iter().chain(columns).collect();
    let mut table = Table { columns, rows: Vec::new() };
    let engines = engines(records, |record| &record.missed);
    for width in WIDTHS.windows(2) {
        let side = match width[0] {
            0 => format!("up to {}", width[1] - 1),
            from => span(from, width[1] - 1, |&end| end < usize::MAX - 1),
        };
        for step in STEPS.windows(2) {
            let is_here = |m: &Missed| m.from_width == width[0] && m.from_step == step[0];
            for (engine, all) in &engines {
                let group = || all.iter().filter(|m| is_here(m));
                let pixels: usize = group().map(|m| m.pixels).sum();
                let obstacles: usize = group().map(|m| m.obstacles).sum();
                let surely: Option<usize> = group().map(|m| m.surely).sum();
                table.push(vec![
                    Cell::text(side.clone()),
                    Cell::text(steps(step)),
                    Cell::text(*engine),
                    share(Some(group().map(|m| m.missed).sum()), pixels),
                    share(surely, pixels),
                    share(Some(group().map(|m| m.overlooked).sum()), obstacles),
                ]);
            }
        }
    }
    table
}

/// Of what is around obstacles, of each engine: which share looks nearer than it is, and which does surely, in per cent,
/// over all scenes.
pub fn false_alarms_table(records: &[Record]) -> Table {
    let columns = ["matcher", "false alarms %", "surely %"].map(Column::new);
    let columns = [Column::grouped("nearer by px")].into_iter().chain(columns).collect();
    let mut table = Table { columns, rows: Vec::new() };
    let engines = engines(records, |record| &record.false_alarms);
    for step in STEPS.windows(2) {
        for (engine, all) in &engines {
            let group = || all.iter().filter(|f: &&&FalseAlarms| f.from_step == step[0]);
            let pixels = group().map(|f| f.pixels).sum();
            table.push(vec![
                Cell::text(steps(step)),
                Cell::text(*engine),
                share(Some(group().map(|f| f.nearer).sum()), pixels),
                share(group().map(|f| f.surely).sum(), pixels),
            ]);
        }
    }
    table
}

/// The engines that were asked about obstacles, with all that was found of these.
fn engines<T>(records: &[Record], found: impl Fn(&Record) -> &[T]) -> Vec<(&str, Vec<&T>)> {
    let names = in_order(records.iter().map(|record| record.engine.as_str())).into_iter();
    let all = names.map(|name| {
        let own = records.iter().filter(|record| record.engine == name);
        (name, own.flat_map(&found).collect::<Vec<_>>())
    });
    all.filter(|(_, found)| !found.is_empty()).collect()
}

/// Some of so many, in per cent.
fn share(count: Option<usize>, of: usize) -> Cell {
    let share = |count: usize| 100.0 * count as f64 / of as f64;
    Cell::number(count.filter(|_| of > 0).map(share), 1)
}

fn steps(ends: &[f32]) -> String {
    span(ends[0], ends[1], |end| end.is_finite())
}

/// `a to b`, or `a and more` where there is no end.
fn span<T: std::fmt::Display>(start: T, end: T, ends: impl Fn(&T) -> bool) -> String {
    if ends(&end) { format!("{start} to {end}") } else { format!("{start} and more") }
}

/// What the tables mean, to be printed beside them.
pub const OBSTACLES_LEGEND: [&str; 4] = [
    "obstacles: pieces of each scene, ellipses and boxes 6 to 32 pixels wide, that lie somewhere else in it, nearer than \
     what is there and seen by both cameras; until they cover a tenth of it or no more fit. All images are grey, 8 bits. \
     Smaller side: of their width and height; step: how many px of disparity they stand before what is behind",
    "missed: pixels whose disparity is nearer to that of what is behind, or is missing, in per cent of all obstacle pixels \
     of that size and step, over the scenes that the matcher answered; surely: missed pixels with a confidence of at least \
     0.5, in per cent of the same",
    "overlooked: obstacles of which more than half is missed, in per cent of all of that size and, in the mean, that step",
    "false alarms: pixels beside obstacles that look nearer than they are by so much, in per cent of all; those with a \
     confidence of at least 0.5 surely. An obstacle that grows beyond its edge is one, too",
];
