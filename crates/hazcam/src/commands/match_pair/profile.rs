//! The table of `hazcam match --profile`.

use std::fmt::Write;
use std::time::Duration;

use matching::{Options, Stage};
use raster::BoundingBox;

/// The stages with their times and shares, and the rate of all together.
pub fn table(stages: &[Stage], options: &Options, bounds: BoundingBox) -> String {
    let total: Duration = stages.iter().map(|stage| stage.time).sum();
    let width = stages.iter().map(|stage| stage.name.len()).max().unwrap_or(0).max(5);
    let ms = |time: Duration| 1e3 * time.as_secs_f64();
    let mut text = format!("{:width$}  {:>9}  share\n", "stage", "ms");
    for Stage { name, time, .. } in stages {
        let share = 100.0 * time.as_secs_f64() / total.as_secs_f64();
        _ = writeln!(text, "{name:width$}  {:9.3}  {share:3.0} %", ms(*time));
    }
    let disparities = bounds.columns() * bounds.rows() * options.range.count();
    let rate = disparities as f64 / total.as_secs_f64() / 1e6;
    _ = writeln!(
        text,
        "{:width$}  {:9.3}  {rate:.0} MDE/s, threads: {}",
        "all",
        ms(total),
        options.threads
    );
    text
}
