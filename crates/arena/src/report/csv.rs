//! Comma-separated values (RFC 4180) with every digit, for programs.

use super::table::{Cell, Table};

impl Table {
    /// The table as CSV. Empty cells are empty, no value is left out because it repeats.
    pub fn to_csv(&self) -> String {
        let mut text = line(self.columns.iter().map(|column| column.name.clone().into_owned()));
        for row in &self.rows {
            text.push_str(&line(row.iter().map(|cell| match cell {
                Cell::Text(text) => text.clone(),
                Cell::Number(value, _) => value.to_string(),
                Cell::Empty => String::new(),
            })));
        }
        text
    }
}

fn line(cells: impl Iterator<Item = String>) -> String {
    let cells: Vec<_> = cells.map(|cell| quoted(&cell)).collect();
    format!("{}\r\n", cells.join(","))
}

/// A field of a CSV file (RFC 4180): in quotes where it needs them.
fn quoted(field: &str) -> String {
    match field.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", field.replace('"', "\"\"")),
        false => field.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::Column;
    use super::*;

    #[test]
    fn csv_fields_are_quoted_where_needed() {
        assert_eq!(quoted("plain"), "plain");
        assert_eq!(quoted("a,\"b\""), "\"a,\"\"b\"\"\"");
    }

    #[test]
    fn all_digits_and_quotes_where_needed() {
        let table = Table {
            columns: vec![Column::grouped("a"), Column::new("b, c")],
            rows: vec![
                vec![Cell::text("x \"y\""), Cell::Number(0.123456789, 2)],
                vec![Cell::text("x \"y\""), Cell::Empty],
            ],
        };
        assert_eq!(
            table.to_csv(),
            "a,\"b, c\"\r\n\"x \"\"y\"\"\",0.123456789\r\n\"x \"\"y\"\"\",\r\n"
        );
    }
}
