//! A Markdown table, readable as it stands.

use super::table::{Cell, Table};

impl Table {
    /// The table in Markdown, each line ended by a line feed.
    pub fn to_markdown(&self) -> String {
        let escaped = |cell: &str| cell.replace('|', "\\|");
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let mut text = line(self.columns.iter().map(|column| escaped(&column.name)).collect());
        let rules = (0..self.columns.len()).map(|i| {
            match self.rows.iter().any(|row| matches!(row[i], Cell::Number(..))) {
                true => "---:".to_owned(),
                false => "---".to_owned(),
            }
        });
        text.push_str(&line(rules.collect()));
        for row in self.shown_rows() {
            text.push_str(&line(row.iter().map(|cell| escaped(cell)).collect()));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::Column;
    use super::*;

    #[test]
    fn numbers_stand_right_and_bars_are_escaped() {
        let table = Table {
            columns: vec![Column::new("a"), Column::new("b")],
            rows: vec![vec![Cell::text("x|y"), Cell::Number(0.5, 2)]],
        };
        assert_eq!(table.to_markdown(), "| a | b |\n| --- | ---: |\n| x\\|y | 0.50 |\n");
    }
}
