//! A Markdown table, readable as it stands.

use super::table::{Cell, Table};

impl Table {
    /// The table in Markdown, each line ended by a line feed. Cells stay the text that they are: a
    /// name may not be HTML on the page that shows the table.
    pub fn to_markdown(&self) -> String {
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

/// A cell in which nothing ends the cell or is HTML.
fn escaped(cell: &str) -> String {
    let html = cell.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    html.replace('|', "\\|")
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

    #[test]
    fn a_name_is_no_html() {
        let table =
            Table { columns: vec![Column::new("a")], rows: vec![vec![Cell::text("<b>R&D</b>")]] };
        let last = "| &lt;b&gt;R&amp;D&lt;/b&gt; |\n";
        assert!(table.to_markdown().ends_with(last), "{}", table.to_markdown());
    }
}
