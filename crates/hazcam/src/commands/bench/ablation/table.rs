//! One row for each variant: its errors, and against the whole preset.

use std::collections::BTreeSet;

use arena::record::Record;
use arena::report::{Cell, Column, Table};
use matching::{Ingredient, Preset};
use score::mean;
use serde::Serialize;

use super::Variant;

/// Every pixel with truth, those that both cameras see, those that only the left one does.
const REGIONS: [&str; 3] = ["all", "non-occluded", "occluded"];

/// What a variant came to on one scene.
#[derive(Debug, Clone, PartialEq, Default)]
struct Figures {
    scene: String,
    e_rms: [Option<f64>; 3],
    p_bad: [Option<f64>; 3],
    sub_pixel: Option<f64>,
    ause: Option<f64>,
    cpu_seconds: Option<f64>,
}

impl Figures {
    fn of(record: &Record) -> Self {
        Self {
            scene: record.case.clone(),
            e_rms: REGIONS.map(|region| record.value(region, "E_RMS")),
            p_bad: REGIONS.map(|region| record.value(region, "p_bad")),
            sub_pixel: record.value(REGIONS[0], "subpixel-rms"),
            ause: record.confidence.as_ref().map(|confidence| confidence.ause),
            cpu_seconds: record.usage.cpu_seconds,
        }
    }
}

/// What a variant came to over all scenes: means, of the scenes that have the figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The preset.
    matcher: &'static str,
    /// What is left out of it.
    without: Option<&'static str>,
    /// Scenes that every variant of the preset has scores on.
    scenes: usize,
    /// E_RMS in pixels over all, non-occluded and occluded pixels.
    e_rms: [Option<f64>; 3],
    /// p_bad over the same.
    p_bad: [Option<f64>; 3],
    /// Geometric mean of p_bad over all pixels against the whole preset's.
    ratio: Option<f64>,
    /// Scenes on which it has a smaller p_bad than the whole preset.
    better: Option<usize>,
    /// RMS in pixels of the errors of at most one pixel.
    sub_pixel: Option<f64>,
    /// Area under the sparsification error of the confidence.
    ause: Option<f64>,
    /// CPU time.
    cpu_seconds: Option<f64>,
}

impl Row {
    fn new(variant: Variant, whole: &[Figures], own: &[Figures]) -> Self {
        let region = |find: fn(&Figures) -> [Option<f64>; 3]| {
            std::array::from_fn(|i| mean(own.iter().filter_map(|figures| find(figures)[i])))
        };
        // p_bad of the whole preset and of this variant, scene by scene.
        let pairs: Vec<(f64, f64)> = own
            .iter()
            .filter_map(|own| {
                let whole = whole.iter().find(|whole| whole.scene == own.scene)?;
                whole.p_bad[0].zip(own.p_bad[0])
            })
            .collect();
        let logarithms =
            pairs.iter().filter(|(a, b)| *a > 0.0 && *b > 0.0).map(|(a, b)| (b / a).ln());
        Self {
            matcher: variant.preset.name(),
            without: variant.without.map(Ingredient::name),
            scenes: own.len(),
            e_rms: region(|figures| figures.e_rms),
            p_bad: region(|figures| figures.p_bad),
            ratio: variant.without.and(mean(logarithms)).map(f64::exp),
            better: variant.without.map(|_| pairs.iter().filter(|(a, b)| b < a).count()),
            sub_pixel: mean(own.iter().filter_map(|figures| figures.sub_pixel)),
            ause: mean(own.iter().filter_map(|figures| figures.ause)),
            cpu_seconds: mean(own.iter().filter_map(|figures| figures.cpu_seconds)),
        }
    }
}

/// The rows of every preset that has run.
pub fn rows(records: &[Record]) -> Vec<Row> {
    let figures = |variant: Variant| -> Vec<Figures> {
        let engine = variant.name();
        records.iter().filter(|record| record.engine == engine).map(Figures::of).collect()
    };
    let mut rows = Vec::new();
    for preset in Preset::ALL {
        let (variants, mut found): (Vec<_>, Vec<_>) =
            Variant::of(preset).map(|variant| (variant, figures(variant))).unzip();
        keep_shared_scenes(&mut found);
        if !found[0].is_empty() {
            rows.extend(variants.iter().zip(&found).map(|(v, own)| Row::new(*v, &found[0], own)));
        }
    }
    rows
}

/// Leaves only scenes that every variant has scores on: means over others cannot be compared.
fn keep_shared_scenes(found: &mut [Vec<Figures>]) {
    let scored = |figures: &[Figures]| -> BTreeSet<String> {
        let scored = figures.iter().filter(|figures| figures.p_bad[0].is_some());
        scored.map(|figures| figures.scene.clone()).collect()
    };
    let shared = found.iter().map(|figures| scored(figures)).reduce(|a, b| &a & &b);
    for figures in found {
        figures.retain(|figures| shared.iter().any(|shared| shared.contains(&figures.scene)));
    }
}

/// The rows as a table.
pub fn table(rows: &[Row]) -> Table {
    let names = [
        "without",
        "E_RMS",
        "E_RMS noc",
        "E_RMS occ",
        "p_bad",
        "p_bad noc",
        "p_bad occ",
        "ratio",
        "better on",
        "subpixel-rms",
        "AUSE",
        "CPU ms",
    ];
    let mut columns = vec![Column::grouped("matcher")];
    columns.extend(names.map(Column::new));
    let mut table = Table { columns, rows: Vec::new() };
    for row in rows {
        let mut cells = vec![Cell::text(row.matcher), Cell::text(row.without.unwrap_or("nothing"))];
        cells.extend(row.e_rms.map(|value| Cell::number(value, 2)));
        cells.extend(row.p_bad.map(|value| Cell::number(value, 4)));
        cells.push(Cell::number(row.ratio, 3));
        cells.push(Cell::number(row.better.map(|count| count as f64), 0));
        cells.push(Cell::number(row.sub_pixel, 3));
        cells.push(Cell::number(row.ause, 4));
        cells.push(Cell::number(row.cpu_seconds.map(|seconds| seconds * 1e3), 0));
        table.push(cells);
    }
    table
}

/// What the numbers mean, then what each ingredient is, a line for each.
pub fn legend(rows: &[Row]) -> Vec<String> {
    let scenes = rows.iter().map(|row| row.scenes).max().unwrap_or(0);
    let mut lines = vec![
        format!(
            "means over {scenes} scenes, each of which weighs the same; E_RMS in px; p_bad: share of \
             errors > 2 px; over all pixels with truth, noc: those that both cameras see, occ: the \
             others"
        ),
        "ratio: geometric mean of p_bad over the whole preset's; above 1 the ingredient pays".into(),
        "better on: scenes on which leaving it out lowers p_bad".into(),
        "subpixel-rms: in px, of the errors of at most 1 px".into(),
        "AUSE: how badly the confidence ranks errors > 2 px, 0 is perfect; without path-margin it is \
         that of the difference of the two views alone"
            .into(),
        "CPU: of the engine's process, seen from outside".into(),
    ];
    let mut told: Vec<&str> = Vec::new();
    for name in rows.iter().filter_map(|row| row.without) {
        if !told.contains(&name) {
            told.push(name);
        }
    }
    lines.extend(told.into_iter().filter_map(|name| name.parse::<Ingredient>().ok()).map(
        |ingredient| {
            format!("{ingredient}: {}; without: {}", ingredient.explanation(), ingredient.instead())
        },
    ));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(scene: &str, p_bad: f64, e_rms: f64) -> Figures {
        Figures {
            scene: scene.into(),
            e_rms: [Some(e_rms), None, None],
            p_bad: [Some(p_bad), Some(p_bad / 2.0), None],
            sub_pixel: Some(p_bad + 0.1),
            ause: Some(0.01),
            cpu_seconds: Some(0.25),
        }
    }

    #[test]
    fn means_ratios_and_wins_of_fixed_figures() {
        let whole = [figures("a", 0.1, 1.0), figures("b", 0.2, 3.0), figures("c", 0.0, 2.0)];
        // Worse by 4, better by 2, and where the whole preset has no error at all.
        let own = [figures("c", 0.3, 2.0), figures("b", 0.1, 1.0), figures("a", 0.4, 6.0)];
        let variant = Variant { preset: Preset::Best, without: Some(Ingredient::Median) };
        let row = Row::new(variant, &whole, &own);
        assert!((row.ratio.unwrap() - f64::sqrt(4.0 * 0.5)).abs() < 1e-12);
        assert_eq!((row.scenes, row.better), (3, Some(1)));
        assert_eq!(row.e_rms, [Some(3.0), None, None]);
        let whole = Row::new(Variant { without: None, ..variant }, &whole, &whole);
        assert_eq!((whole.ratio, whole.better), (None, None));
        let text = table(&[whole, row]).to_markdown();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines[2],
            "| best | nothing | 2.00 | - | - | 0.1000 | 0.0500 | - | - | - | 0.200 | 0.0100 | 250 |"
        );
        assert_eq!(
            lines[3],
            "|  | median | 3.00 | - | - | 0.2667 | 0.1333 | - | 1.414 | 1 | 0.367 | 0.0100 | 250 |"
        );
    }

    #[test]
    fn a_scene_that_one_variant_lacks_counts_for_none() {
        let (a, b) = (figures("a", 0.1, 1.0), figures("b", 0.2, 3.0));
        let failed = Figures { scene: "b".into(), ..Figures::default() };
        let mut found = [vec![a.clone(), b], vec![failed, a.clone()]];
        keep_shared_scenes(&mut found);
        assert_eq!(found, [vec![a.clone()], vec![a]]);
    }

    #[test]
    fn every_ingredient_in_the_table_is_explained_once() {
        let variants = [Preset::Balanced, Preset::Best].into_iter().flat_map(Variant::of);
        let rows: Vec<Row> = variants.map(|variant| Row::new(variant, &[], &[])).collect();
        let legend = legend(&rows);
        for ingredient in Ingredient::of(Preset::Best) {
            let beginning = format!("{ingredient}: ");
            assert_eq!(legend.iter().filter(|line| line.starts_with(&beginning)).count(), 1);
        }
    }
}
