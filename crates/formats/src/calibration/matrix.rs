//! Matrices as OpenCV and ROS store them, or as lists.

use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::Entries;
use crate::FormatError;

/// A matrix, row by row: as OpenCV and ROS store it, or as somebody wrote its rows or its numbers, as lists.
pub(super) struct Matrix {
    /// How many rows and columns it says that it has; none for a list of numbers.
    pub size: Option<[usize; 2]>,
    pub data: Vec<f64>,
}

impl<'de> Deserialize<'de> for Matrix {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(MatrixVisitor)
    }
}

struct MatrixVisitor;

/// A matrix as it is stored.
#[derive(Deserialize)]
struct Stored {
    rows: usize,
    cols: usize,
    data: Vec<f64>,
}

/// What a list holds.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a matrix is a list of numbers, or of rows of numbers")]
enum Item {
    Number(f64),
    Row(Vec<f64>),
}

impl<'de> Visitor<'de> for MatrixVisitor {
    type Value = Matrix;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a matrix: rows, cols and data, or a list of its rows or numbers")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Matrix, A::Error> {
        let Stored { rows, cols, data } = Stored::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Matrix { size: Some([rows, cols]), data })
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Matrix, A::Error> {
        let (mut rows, mut data) = (Vec::new(), Vec::new());
        while let Some(item) = list.next_element()? {
            match item {
                Item::Number(number) => data.push(number),
                Item::Row(row) => {
                    rows.push(row.len());
                    data.extend(row);
                }
            }
        }
        // Of rows that differ, or stand among numbers, no matrix of the right size is made.
        let columns = rows.first().copied().unwrap_or(0);
        let is_even = rows.iter().all(|&row| row == columns) && data.len() == columns * rows.len();
        let size = match rows[..] {
            [] => None,
            _ => Some(if is_even { [rows.len(), columns] } else { [rows.len(), 0] }),
        };
        Ok(Matrix { size, data })
    }
}

impl Matrix {
    /// The 3 x 4 numbers of a projection of one of two cameras that stand side by side.
    pub fn projection(self, entries: &Entries<'_>, name: &str) -> Result<[f64; 12], FormatError> {
        let numbers: [f64; 12] = self.numbers(entries, name, [3, 4])?;
        if numbers[7] != 0.0 {
            let problem = format!(
                "{name} has its camera below the other one, but pairs stand side by side here"
            );
            return Err(entries.fail(None, problem));
        }
        Ok(numbers)
    }

    /// The numbers of a matrix that must have so many rows and columns.
    pub fn numbers<const N: usize>(
        self,
        entries: &Entries<'_>,
        name: &str,
        needed: [usize; 2],
    ) -> Result<[f64; N], FormatError> {
        let Self { size, data } = self;
        let count = data.len();
        let numbers = data.try_into().ok().filter(|_| size.is_none_or(|size| size == needed));
        numbers.ok_or_else(|| {
            let found = match size {
                Some([rows, 0]) => format!("{rows} rows of different length with {count} numbers"),
                Some([rows, columns]) => format!("{rows} x {columns} with {count} numbers"),
                None => format!("a list of {count} numbers"),
            };
            let [lines, columns] = needed;
            let problem = format!("{name} is {found}, but must be {lines} x {columns} with {N}");
            entries.fail(None, problem)
        })
    }
}
