//! The records and their summaries as one JSON object.

use serde::Serialize;

use crate::record::Record;

#[derive(Serialize)]
struct Report<'a, S> {
    records: &'a [Record],
    summaries: &'a [S],
}

/// The records with all their figures, and what they come to, as JSON text.
pub fn to_json<S: Serialize>(records: &[Record], summaries: &[S]) -> String {
    let mut text = serde_json::to_string_pretty(&Report { records, summaries })
        .expect("records hold only what JSON can hold");
    text.push('\n');
    text
}
