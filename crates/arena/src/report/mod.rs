//! Records as tables: what was measured on each scene, and what it comes to.
//!
//! A [`Table`] knows its columns and cells and nothing of how it is shown; [`Format`] has one file
//! for each way to show it.

mod coverage;
mod csv;
mod json;
mod markdown;
mod obstacles;
mod overview;
mod reasons;
mod regions;
mod reliability;
mod scores;
mod summary;
mod table;
mod text;

use std::fmt;
use std::str::FromStr;

pub use coverage::{COVERAGE_LEGEND, coverage_table};
pub use json::to_json;
pub use markdown::in_markdown;
pub use obstacles::{OBSTACLES_LEGEND, false_alarms_table, obstacles_table};
pub use overview::{bad2_table, overview_table};
pub use reasons::{REASONS_LEGEND, reasons_table};
pub use regions::{REGIONS_LEGEND, regions_table};
pub use reliability::{RELIABILITY_LEGEND, reliability_table};
pub use scores::{Failure, LEGEND, assumed_ranges, failures, scores_table, truths_beyond};
pub use summary::{Summary, summaries, summary_table};
pub use table::{Cell, Column, Table};

/// How a table is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Format {
    /// Aligned columns for the terminal.
    #[default]
    Text,
    /// A Markdown table.
    Markdown,
    /// Comma-separated values with all their digits (RFC 4180).
    Csv,
    /// The records themselves.
    Json,
}

impl Format {
    /// Every format's name.
    pub const NAMES: [&'static str; 4] = ["text", "markdown", "csv", "json"];

    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Format {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [Self::Text, Self::Markdown, Self::Csv, Self::Json]
            .into_iter()
            .find(|format| format.name() == text)
            .ok_or_else(|| format!("`{text}` is no format; it must be {}", Self::NAMES.join(", ")))
    }
}

/// On one line, without what would move the cursor or change colours: it comes from whoever is compared or graded.
pub fn printable(text: &str) -> String {
    let turns = |c| matches!(c, '\u{61c}' | '\u{200e}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    text.chars().map(|c| if c.is_control() || turns(c) { ' ' } else { c }).collect()
}

/// A number with so many digits at the least, and as many that what is shown holds what the number does.
pub fn shown_until(number: f64, digits: usize, holds: impl Fn(f64) -> bool) -> String {
    let shown = |digits: usize| format!("{number:.digits$}");
    let is_seen = |text: &String| text.parse().is_ok_and(&holds);
    (digits..20).map(shown).find(is_seen).unwrap_or_else(|| number.to_string())
}

/// Every name that occurs, once each, in order.
pub(crate) fn in_order<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut seen = Vec::new();
    for name in names {
        if !seen.contains(&name) {
            seen.push(name);
        }
    }
    seen
}
