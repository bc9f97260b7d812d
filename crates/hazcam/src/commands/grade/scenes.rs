//! Scenes of a scheme that are rendered from a seed.

use arena::dataset::CaseData;
use scenes::{Kind, Settings};

use crate::commands::bench::rendered;

/// Renders the scene of this kind, seed and size, with exact truth of every pixel.
pub fn render(
    kind: &str,
    seed: u64,
    columns: Option<usize>,
    rows: Option<usize>,
) -> Result<CaseData, String> {
    let kind: Kind = kind.parse().map_err(|error| format!("{error}"))?;
    let mut settings = Settings::new(kind, seed);
    settings.columns = columns.unwrap_or(settings.columns);
    settings.rows = rows.unwrap_or(settings.rows);
    rendered::render(&settings)
}
