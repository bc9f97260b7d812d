//! What OpenCV's and ROS's YAML have in common: how it is read, and matrices.

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_saphyr::UserMessageFormatter;

use super::Entries;
use crate::FormatError;

/// A matrix, row by row.
#[derive(Deserialize)]
pub(super) struct Matrix {
    rows: usize,
    cols: usize,
    data: Vec<f64>,
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
        let Self { rows, cols, data } = self;
        let count = data.len();
        let numbers = data.try_into().ok().filter(|_| [rows, cols] == needed);
        numbers.ok_or_else(|| {
            let [lines, columns] = needed;
            let problem = format!(
                "{name} is {rows} x {cols} with {count} numbers, but must be {lines} x {columns} with {N}"
            );
            entries.fail(None, problem)
        })
    }
}

/// Reads what is needed of a text; what else is in it does not matter.
pub(super) fn read<T: DeserializeOwned>(
    entries: &Entries<'_>,
    text: &str,
) -> Result<T, FormatError> {
    // What is not finite may stand elsewhere; no camera is made of it.
    let options = serde_saphyr::options! {
        non_finite_float_policy: serde_saphyr::NonFiniteFloatPolicy::PassThrough,
    };
    serde_saphyr::from_str_with_options(text, options).map_err(|error| {
        let what = error.without_snippet().render_with_formatter(&UserMessageFormatter);
        let what = what.lines().next().unwrap_or_default();
        entries.fail(None, format!("the YAML cannot be read: {what}"))
    })
}
