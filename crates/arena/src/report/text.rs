//! Aligned columns for the terminal: words to the left, numbers to the right.

use super::table::{Cell, Table};

impl Table {
    /// The table as text, each line ended by a line feed.
    pub fn to_text(&self) -> String {
        let rows = self.shown_rows();
        let columns = self.columns.len();
        let is_number = |i: usize| self.rows.iter().any(|row| matches!(row[i], Cell::Number(..)));
        let width = |i: usize| {
            let cells = rows.iter().map(|row| row[i].chars().count());
            cells.chain([self.columns[i].name.chars().count()]).max().unwrap_or(0)
        };
        let layout: Vec<(usize, bool)> = (0..columns).map(|i| (width(i), is_number(i))).collect();
        let line = |cells: Vec<&str>| {
            let mut line = String::new();
            for (cell, &(width, right)) in cells.iter().zip(&layout) {
                match right {
                    true => line.push_str(&format!("{cell:>width$}  ")),
                    false => line.push_str(&format!("{cell:<width$}  ")),
                }
            }
            format!("{}\n", line.trim_end())
        };
        let mut text = line(self.columns.iter().map(|column| &*column.name).collect());
        for row in &rows {
            text.push_str(&line(row.iter().map(String::as_str).collect()));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::Column;
    use super::*;

    #[test]
    fn columns_are_aligned_and_groups_shown_once() {
        let mut table = Table {
            columns: vec![Column::grouped("scene"), Column::grouped("matcher"), Column::new("px")],
            rows: Vec::new(),
        };
        for (scene, matcher, px) in [
            ("a", "fast", Some(1.25)),
            ("a", "fast", None),
            ("a", "b", Some(10.0)),
            ("c", "b", None),
        ] {
            table.push(vec![Cell::text(scene), Cell::text(matcher), Cell::number(px, 1)]);
        }
        assert_eq!(
            table.to_text(),
            "scene  matcher    px\n\
             a      fast      1.2\n\
             \x20                  -\n\
             \x20      b        10.0\n\
             c      b           -\n"
        );
    }
}
