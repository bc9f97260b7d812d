//! Where the errors are: one number for each kind of place.

use super::in_order;
use super::table::{Cell, Column, Table};
use crate::record::Record;

/// The share of errors above 2 px and holes (Middlebury's bad 2, in per cent) in every region that
/// a scene knows, one row for each scene and engine. A region that a scene does not have is empty.
pub fn regions_table(records: &[Record]) -> Table {
    let scores = records.iter().flat_map(|record| &record.scores);
    let regions = in_order(scores.map(|scores| scores.region.as_str()));
    let mut columns = vec![Column::grouped("scene"), Column::new("matcher")];
    columns.extend(regions.iter().map(|region| Column::new(region.to_string())));
    let mut table = Table { columns, rows: Vec::new() };
    for record in records {
        let mut row = vec![Cell::text(&record.case), Cell::text(&record.engine)];
        let bad = |region: &&str| record.value(region, "bad2").map(|share| 100.0 * share);
        row.extend(regions.iter().map(|region| Cell::number(bad(region), 2)));
        table.push(row);
    }
    table
}

/// What the regions of rendered scenes are, to be printed beside their table.
pub const REGIONS_LEGEND: &str = "bad2 % by region. occluded: seen by the left camera only; \
    discontinuity: within 4 px of a step of more than 2 px; thin: things at most 6 px wide or high; \
    textureless: hardly any horizontal gradient; repeated: stripes, checks, dots, windows";
