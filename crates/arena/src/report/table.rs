//! Columns and cells, and nothing of how they are shown.

use std::borrow::Cow;

use super::printable;

/// One column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its heading.
    pub name: Cow<'static, str>,
    /// Whether a value that repeats the one above is left out in tables for people.
    pub grouped: bool,
}

/// One value.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A word.
    Text(String),
    /// A number, shown with so many digits behind the point.
    Number(f64, usize),
    /// Nothing to show.
    Empty,
}

/// A table: every row has as many cells as there are columns.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// The columns, from left to right.
    pub columns: Vec<Column>,
    /// The rows, from top to bottom.
    pub rows: Vec<Vec<Cell>>,
}

impl Column {
    /// An ordinary column.
    pub fn new(name: impl Into<Cow<'static, str>>) -> Self {
        Self { name: name.into(), grouped: false }
    }

    /// A column whose repeated values are left out in tables for people.
    pub fn grouped(name: impl Into<Cow<'static, str>>) -> Self {
        Self { name: name.into(), grouped: true }
    }
}

impl Cell {
    /// A number, or nothing.
    pub fn number(value: Option<f64>, digits: usize) -> Self {
        value.map_or(Self::Empty, |value| Self::Number(value, digits))
    }

    /// A word.
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    /// For people: with the digits that mean something.
    pub(super) fn shown(&self) -> String {
        match self {
            Self::Text(text) => printable(text),
            Self::Number(value, digits) => format!("{value:.digits$}"),
            Self::Empty => "-".into(),
        }
    }
}

impl Table {
    /// Adds a row. Panics when it has not one cell for each column.
    pub fn push(&mut self, row: Vec<Cell>) {
        assert_eq!(row.len(), self.columns.len(), "a row must fill the columns");
        self.rows.push(row);
    }

    /// The cells for people: repeated values of grouped columns left out, as long as everything to
    /// their left repeats too.
    pub(super) fn shown_rows(&self) -> Vec<Vec<String>> {
        let mut above: &[Cell] = &[];
        self.rows
            .iter()
            .map(|row| {
                let mut repeats = !above.is_empty();
                let shown = row
                    .iter()
                    .enumerate()
                    .map(|(i, cell)| {
                        repeats &= self.columns[i].grouped && above.get(i) == Some(cell);
                        if repeats { String::new() } else { cell.shown() }
                    })
                    .collect();
                above = row;
                shown
            })
            .collect()
    }
}
