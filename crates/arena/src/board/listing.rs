//! A board as a table.

use std::collections::BTreeMap;

use super::standing::Standing;
use crate::report::{Cell, Column, Table};

/// One row for everybody, best first; with whose entries they are, by secret ID, and what to look at, for those who write
/// down marks.
pub fn table(standings: &[Standing], owners: Option<&BTreeMap<String, String>>) -> Table {
    let columns = [
        "place",
        "secret ID",
        "score",
        "E_RMS",
        "p_bad",
        "CPU s",
        "points",
        "bonus",
        "total",
        "added",
    ];
    let columns = columns.into_iter().chain(owners.into_iter().flat_map(|_| ["owner", "doubts"]));
    let mut table = Table { columns: columns.map(Column::new).collect(), rows: Vec::new() };
    // Quarters and the like need a second digit.
    let is_whole = |points: f64| (10.0 * points).fract().abs() < 1e-6;
    let digits = if standings.iter().all(|of| is_whole(of.entry.report.points)) { 1 } else { 2 };
    for standing in standings {
        let entry = &standing.entry;
        let scores = entry.holdout.scores.as_ref();
        let mut cells = vec![
            Cell::text(match standing.place {
                Some(place) => place.to_string(),
                None if entry.baseline => "baseline".into(),
                None => format!("({})", entry.holdout.outcome),
            }),
            Cell::text(&entry.secret_id),
            Cell::number(standing.score, 4),
            Cell::number(scores.map(|scores| scores.e_rms), 2),
            Cell::number(scores.map(|scores| scores.p_bad), 4),
            Cell::number(entry.holdout.usage.cpu_seconds, 2),
            Cell::number(Some(entry.report.points), digits),
            Cell::number(Some(standing.bonus), 0),
            Cell::number(Some(standing.total), digits),
            Cell::text(&entry.added),
        ];
        // One that was renamed in the meantime has none here.
        if let Some(owners) = owners {
            cells.push(Cell::text(owners.get(&entry.secret_id).map_or("", String::as_str)));
            cells.push(Cell::text(standing.doubts.join("; ")));
        }
        table.push(cells);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::super::standing::tests::entry;
    use super::super::{Holdout, standings};
    use super::*;

    #[test]
    fn places_and_reasons_for_none_are_shown() {
        let entries =
            vec![entry("nobody", None, 0.0, 1.0), entry("she & he", Some(1.0), 0.022, 0.5)];
        let standings = standings(entries, &Holdout::secret(600.0).unwrap().test);
        let lines: Vec<String> =
            table(&standings, None).to_text().lines().map(str::to_owned).collect();
        assert!(lines[0].starts_with("place  secret ID   score  E_RMS   p_bad  CPU s  points"));
        assert!(lines[1].starts_with("1      she & he   0.2000   1.00  0.0220   0.50     7.0"));
        assert!(lines[2].starts_with("(TO)   nobody          -      -       -"), "{}", lines[2]);
    }
}
