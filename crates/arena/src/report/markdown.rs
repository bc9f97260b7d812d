//! A Markdown table, readable as it stands.

use super::table::{Cell, Table};

impl Table {
    /// The table in Markdown, each line ended by a line feed. Cells stay the text that they are: a
    /// name may not be HTML on the page that shows the table.
    pub fn to_markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let mut text = line(self.columns.iter().map(|column| in_markdown(&column.name)).collect());
        let rules = (0..self.columns.len()).map(|i| {
            match self.rows.iter().any(|row| matches!(row[i], Cell::Number(..))) {
                true => "---:".to_owned(),
                false => "---".to_owned(),
            }
        });
        text.push_str(&line(rules.collect()));
        for row in self.shown_rows() {
            text.push_str(&line(row.iter().map(|cell| in_markdown(cell)).collect()));
        }
        text
    }
}

/// Text in which nothing ends a table's cell, is HTML, a link, a picture or emphasis.
pub fn in_markdown(cell: &str) -> String {
    let mut text = String::new();
    for (at, letter) in cell.char_indices() {
        match letter {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '@' => text.push_str("&#64;"),
            // What looks like an address becomes a link by itself.
            ':' if cell[at..].starts_with("://") => text.push_str("&#58;"),
            '.' if cell[..at].to_lowercase().ends_with("www") => text.push_str("&#46;"),
            '|' | '\\' | '`' | '*' | '[' | ']' | '~' => text.extend(['\\', letter]),
            '_' if !is_within_a_word(cell, at) => text.extend(['\\', letter]),
            _ => text.push(letter),
        }
    }
    text
}

/// Whether there are letters or digits at both sides: an underscore there is only itself.
fn is_within_a_word(cell: &str, at: usize) -> bool {
    let (before, after) = (cell[..at].chars().next_back(), cell[at..].chars().nth(1));
    [before, after].into_iter().all(|letter| letter.is_some_and(char::is_alphanumeric))
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

    #[test]
    fn a_name_is_no_link_no_picture_and_no_emphasis() {
        for (name, shown) in [
            ("![p](//e.x/p.png)", r"!\[p\](//e.x/p.png)"),
            ("http://e.x www.e.x a@e.x", "http&#58;//e.x www&#46;e.x a&#64;e.x"),
            ("__init__ *x* `y` ~~z~~", r"\_\_init\_\_ \*x\* \`y\` \~\~z\~\~"),
            (r"a\|b", r"a\\\|b"),
            ("playground_1l: 0.5", "playground_1l: 0.5"),
        ] {
            assert_eq!(in_markdown(name), shown);
        }
    }
}
