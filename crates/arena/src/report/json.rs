//! The records and their summaries as one JSON object.

use serde::Serialize;

use super::summary::Summary;
use crate::record::Record;

#[derive(Serialize)]
struct Report<'a> {
    records: &'a [Record],
    summaries: &'a [Summary],
}

/// The records with all their figures, and the summaries, as JSON text.
pub fn to_json(records: &[Record], summaries: &[Summary]) -> String {
    let mut text = serde_json::to_string_pretty(&Report { records, summaries })
        .expect("records hold only what JSON can hold");
    text.push('\n');
    text
}
