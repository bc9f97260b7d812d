//! Where the errors are by what an engine itself says of its pixels.

use raster::Reason;

use super::in_order;
use super::table::{Cell, Column, Table};
use crate::record::Record;

/// Means over the scenes of each engine that gives reasons: the share of the pixels that have the
/// reason, and how many of *all* pixels have it and are off by more than 2 and 4 px or holes, in per
/// cent. What stands below each other adds up to the whole.
pub fn reasons_table(records: &[Record]) -> Table {
    let columns = ["pixels %", "bad2 %", "bad4 %"].map(Column::new);
    let names = [Column::grouped("matcher"), Column::new("reason")];
    let mut table = Table { columns: names.into_iter().chain(columns).collect(), rows: Vec::new() };
    for engine in in_order(records.iter().map(|record| record.engine.as_str())) {
        let own = records.iter().filter(|record| record.engine == engine);
        let own: Vec<_> = own.filter(|record| !record.by_reason.is_empty()).collect();
        for reason in Reason::ALL.map(Reason::name) {
            let shares = own.iter().filter_map(|record| {
                let scores = record.by_reason.iter().find(|scores| scores.region == reason)?;
                let all: usize = record.by_reason.iter().map(|scores| scores.pixels).sum();
                let share = scores.pixels as f64 / all as f64;
                let [_, _, bad2, bad4] = &scores.middlebury.bad;
                Some([1.0, bad2.totbad, bad4.totbad].map(|of_these| share * of_these))
            });
            let Some(sums) = shares.reduce(|a, b| [0, 1, 2].map(|i| a[i] + b[i])) else { continue };
            let means = sums.map(|sum| Cell::number(Some(100.0 * sum / own.len() as f64), 2));
            let names = [engine, reason].map(Cell::text);
            table.push(names.into_iter().chain(means).collect());
        }
    }
    table
}

/// What the table means, to be printed beside it.
pub const REASONS_LEGEND: &str = "by the reason that the matcher gives a pixel, in per cent of all \
    pixels, means over scenes: how many there are, and how many of them are holes or off by more \
    than 2 and 4 px";
