//! What many scenes come to: per family and over all.
//!
//! Means are taken over scenes, each of which weighs the same. Against a reference engine, the
//! ratio of p_bad is averaged geometrically, `exp(mean(ln(p / p_ref)))`, so that halving on one
//! scene and doubling on another cancel. A caution: a geometric mean hides a single bad scene, so
//! the worst ratio stands beside it.

use score::mean;
use serde::Serialize;

use super::in_order;
use super::table::{Cell, Column, Table};
use crate::record::Record;

/// The name of the family that is all scenes.
const OVERALL: &str = "overall";

/// One engine over the scenes of one family.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// The family, or "overall".
    pub family: String,
    /// The engine.
    pub engine: String,
    /// Scenes with scores.
    pub scenes: usize,
    /// Scenes on which the engine gave no answer. They are in none of the means.
    pub failed: usize,
    /// Mean E_RMS in pixels.
    pub mean_e_rms: Option<f64>,
    /// Mean p_bad over all pixels with truth.
    pub mean_p_bad: Option<f64>,
    /// Mean p_bad over the non-occluded pixels, of the scenes where they are known.
    pub mean_p_bad_noc: Option<f64>,
    /// How many scenes that is taken over.
    pub noc_scenes: usize,
    /// Largest p_bad, and its scene.
    pub worst_p_bad: Option<(f64, String)>,
    /// Geometric mean of p_bad over that of the reference engine, of the scenes that both answered
    /// and where neither is 0.
    pub ratio: Option<f64>,
    /// How many scenes the ratio is taken over.
    pub ratio_scenes: usize,
    /// Largest ratio, and its scene.
    pub worst_ratio: Option<(f64, String)>,
    /// Mean CPU time of its answers in seconds.
    pub mean_cpu_seconds: Option<f64>,
}

/// Sums up records of scenes with truth, engine by engine, family by family in the order of the
/// records, and over all when there are several families.
pub fn summaries(records: &[Record], reference: Option<&str>) -> Vec<Summary> {
    let families = in_order(records.iter().map(|record| record.family.as_str()));
    let engines = in_order(records.iter().map(|record| record.engine.as_str()));
    let mut all = Vec::new();
    for family in &families {
        for engine in &engines {
            all.push(summary(records, family, engine, reference, |r| r.family == *family));
        }
    }
    if families.len() > 1 {
        for engine in &engines {
            all.push(summary(records, OVERALL, engine, reference, |_| true));
        }
    }
    all.retain(|summary| summary.scenes + summary.failed > 0);
    all
}

fn summary(
    records: &[Record],
    family: &str,
    engine: &str,
    reference: Option<&str>,
    belongs: impl Fn(&Record) -> bool,
) -> Summary {
    let own: Vec<&Record> = records.iter().filter(|r| r.engine == engine && belongs(r)).collect();
    let p_bad = |record: &Record| record.value("all", "p_bad");
    let mean_of =
        |find: &dyn Fn(&Record) -> Option<f64>| mean(own.iter().filter_map(|record| find(record)));
    let of_scenes = |find: &dyn Fn(&Record) -> Option<f64>| -> Vec<(f64, String)> {
        own.iter().filter_map(|record| Some((find(record)?, record.case.clone()))).collect()
    };
    let noc = |record: &Record| record.value("non-occluded", "p_bad");
    let ratios = of_scenes(&|record| {
        let other = records
            .iter()
            .find(|other| Some(other.engine.as_str()) == reference && other.case == record.case)?;
        let (own, other) = (p_bad(record)?, p_bad(other)?);
        (own > 0.0 && other > 0.0).then(|| own / other)
    });
    Summary {
        family: family.into(),
        engine: engine.into(),
        scenes: own.iter().filter(|record| !record.scores.is_empty()).count(),
        failed: own.iter().filter(|record| record.status.message().is_some()).count(),
        mean_e_rms: mean_of(&|record| record.value("all", "E_RMS")),
        mean_p_bad: mean_of(&p_bad),
        mean_p_bad_noc: mean_of(&noc),
        noc_scenes: of_scenes(&noc).len(),
        worst_p_bad: largest(of_scenes(&p_bad)),
        ratio: mean(ratios.iter().map(|(ratio, _)| ratio.ln())).map(f64::exp),
        ratio_scenes: ratios.len(),
        worst_ratio: largest(ratios),
        mean_cpu_seconds: mean_of(&Record::answer_cpu_seconds),
    }
}

fn largest(values: Vec<(f64, String)>) -> Option<(f64, String)> {
    values.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))
}

/// The summaries as a table; the columns of the ratio are there only with a reference.
pub fn summary_table(summaries: &[Summary], reference: Option<&str>) -> Table {
    let mut names = vec!["scenes", "E_RMS", "p_bad", "p_bad noc", "worst p_bad", "on"];
    if reference.is_some() {
        names.extend(["ratio", "worst ratio", "on"]);
    }
    names.push("CPU ms");
    let mut columns = vec![Column::grouped("family"), Column::new("matcher")];
    columns.extend(names.into_iter().map(Column::new));
    let mut table = Table { columns, rows: Vec::new() };
    for summary in summaries {
        let mut row = vec![
            Cell::text(&summary.family),
            Cell::text(&summary.engine),
            match summary.failed {
                0 => Cell::text(summary.scenes.to_string()),
                failed => Cell::text(format!("{} ({failed} failed)", summary.scenes)),
            },
            Cell::number(summary.mean_e_rms, 2),
            Cell::number(summary.mean_p_bad, 4),
            match summary.mean_p_bad_noc {
                // Beside a mean over more scenes it would say the wrong thing.
                Some(mean) if summary.noc_scenes < summary.scenes => {
                    Cell::text(format!("{mean:.4} ({} of {})", summary.noc_scenes, summary.scenes))
                }
                mean => Cell::number(mean, 4),
            },
        ];
        row.extend(with_scene(&summary.worst_p_bad, 4));
        if reference.is_some() {
            row.push(Cell::number(summary.ratio, 3));
            row.extend(with_scene(&summary.worst_ratio, 3));
        }
        row.push(Cell::number(summary.mean_cpu_seconds.map(|seconds| seconds * 1e3), 1));
        table.push(row);
    }
    table
}

fn with_scene(value: &Option<(f64, String)>, digits: usize) -> [Cell; 2] {
    match value {
        Some((value, case)) => {
            let scene = case.rsplit('/').next().unwrap_or(case);
            [Cell::Number(*value, digits), Cell::text(scene)]
        }
        None => [Cell::Empty, Cell::Empty],
    }
}
