//! Aligned columns for the terminal: words to the left, numbers to the right.

use unicode_width::UnicodeWidthStr;

use super::table::{Cell, Table};

impl Table {
    /// The table as text, each line ended by a line feed.
    pub fn to_text(&self) -> String {
        let rows = self.shown_rows();
        let columns = self.columns.len();
        let is_number = |i: usize| self.rows.iter().any(|row| matches!(row[i], Cell::Number(..)));
        let width = |i: usize| {
            let cells = rows.iter().map(|row| row[i].width());
            cells.chain([self.columns[i].name.width()]).max().unwrap_or(0)
        };
        let layout: Vec<(usize, bool)> = (0..columns).map(|i| (width(i), is_number(i))).collect();
        let line = |cells: Vec<&str>| {
            let mut line = String::new();
            for (cell, &(width, right)) in cells.iter().zip(&layout) {
                // Some letters are two columns wide, and some none, which `format!` does not know.
                let space = " ".repeat(width - cell.width());
                let [before, after] = if right { [&*space, ""] } else { ["", &*space] };
                line.push_str(&format!("{before}{cell}{after}  "));
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
    fn wide_letters_and_accents_take_their_columns() {
        let row = |name| vec![Cell::text(name), Cell::Number(0.5, 1)];
        let columns = vec![Column::new("a"), Column::new("b")];
        let table =
            Table { columns, rows: vec![row("\u{6570}\u{636e}"), row("abcde"), row("e\u{301}")] };
        let expected = "a        b\n\u{6570}\u{636e}   0.5\nabcde  0.5\ne\u{301}      0.5\n";
        assert_eq!(table.to_text(), expected);
    }

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
