//! The table of `hazcam match --profile`.

use std::fmt::Write;
use std::time::Duration;

use matching::{Limits, Matcher, Stage};
use raster::BoundingBox;

/// What there is to say of a stage, or of all together.
struct Line<'a> {
    name: &'a str,
    time: Duration,
    bytes: u64,
    operations: u64,
    products: u64,
    limit: Duration,
    /// What the limit is due to.
    due: &'static str,
}

impl<'a> Line<'a> {
    fn new(stage: &'a Stage, limits: &Limits) -> Self {
        let &Stage { name, time, bytes, operations, products, .. } = stage;
        let (mut limit, mut due) = (limits.memory(stage), "memory");
        for (least, name) in
            [(limits.operations(stage), "operations"), (limits.products(stage), "products")]
        {
            if least > limit {
                (limit, due) = (least, name);
            }
        }
        Self { name, time, bytes, operations, products, limit, due }
    }

    /// All stages, one after the other.
    fn all(stages: &[Self]) -> Line<'static> {
        Line {
            name: "all",
            time: stages.iter().map(|stage| stage.time).sum(),
            bytes: stages.iter().map(|stage| stage.bytes).sum(),
            operations: stages.iter().map(|stage| stage.operations).sum(),
            products: stages.iter().map(|stage| stage.products).sum(),
            limit: stages.iter().map(|stage| stage.limit).sum(),
            due: "",
        }
    }

    fn row(&self, width: usize, all: Duration) -> String {
        let &Self { name, time, bytes, operations, products, limit, due } = self;
        let millions = |number: u64| number as f64 / 1e6;
        let [operations, products] = [operations, products].map(|number| match number {
            0 => "-".to_owned(),
            number => format!("{:.1}", millions(number)),
        });
        let times = match limit.is_zero() {
            true => "-".to_owned(),
            false => format!("{:.1}", time.as_secs_f64() / limit.as_secs_f64()),
        };
        format!(
            "{name:width$}  {:9.3}  {:3.0} %  {:8.1}  {operations:>8}  {products:>8}  {:8.3}  {due:10}  {times:>6}",
            1e3 * time.as_secs_f64(),
            100.0 * time.as_secs_f64() / all.as_secs_f64(),
            millions(bytes),
            1e3 * limit.as_secs_f64(),
        )
    }
}

/// The stages of the matcher's last frame with their times and shares, what was done in them, how fast
/// that could be at the best, and how many times as long it took; then what these numbers are.
pub fn table(matcher: &Matcher, bounds: BoundingBox) -> String {
    let (options, limits) = (matcher.options(), matcher.limits());
    let stages: Vec<_> = matcher.profile().iter().map(|s| Line::new(s, &limits)).collect();
    let all = Line::all(&stages);
    let width = stages.iter().map(|stage| stage.name.len()).max().unwrap_or(0).max(5);
    let mut text = format!(
        "{:width$}  {:>9}  share  {:>8}  {:>8}  {:>8}  {:>8}  {:10}  {:>6}\n",
        "stage", "ms", "MB", "Mop", "Mmac", "limit ms", "due to", "times"
    );
    for line in stages.iter().chain([&all]) {
        _ = writeln!(text, "{}", line.row(width, all.time));
    }
    let disparities = bounds.columns() * bounds.rows() * options.range.count();
    let rate = disparities as f64 / all.time.as_secs_f64() / 1e6;
    let threads = options.threads;
    _ = writeln!(text, "{rate:.0} MDE/s; threads: {threads}, {}", matcher.level().name());
    text + &explanation(matcher.profile(), &limits)
}

/// What the numbers mean, and what was measured.
fn explanation(stages: &[Stage], limits: &Limits) -> String {
    let pieces = stages.iter().map(Stage::bytes_per_run);
    let [most, least] = [pieces.clone().max(), pieces.min()].map(Option::unwrap_or_default);
    let copies = [most, least].map(|piece| {
        let rate = limits.bytes_per_second(piece) / 1e9;
        format!("{rate:.1} GB/s with {:.3} MB at once", piece as f64 / 1e6)
    });
    format!(
        "MB: planes that are read or written; Mop: million operations on bytes; Mmac: million products of 16 bits \
         added to sums; - where there are none or they are not counted\n\
         limit: copying as many bytes, doing as many operations or products in registers, whichever takes \
         longest; times: the ms over the limit\n\
         measured here and now: copies of {}, {}; {:.1} Gop/s, {:.1} Gmac/s\n",
        copies[0],
        copies[1],
        limits.operations_per_second() / 1e9,
        limits.products_per_second() / 1e9
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(name: &str, ms: u64, operations: u64, limit_us: u64) -> Line<'_> {
        let (time, limit) = (Duration::from_millis(ms), Duration::from_micros(limit_us));
        let products = operations / 4;
        Line { name, time, bytes: 1_250_000, operations, products, limit, due: "memory" }
    }

    #[test]
    fn rows_say_how_many_times_the_limit_a_stage_took() {
        let stages = [line("paths", 30, 64_000_000, 2500), line("fill", 10, 0, 0)];
        let all = Line::all(&stages);
        let rows = stages.iter().chain([&all]).map(|stage| stage.row(5, all.time));
        assert_eq!(
            rows.collect::<Vec<_>>(),
            [
                "paths     30.000   75 %       1.2      64.0      16.0     2.500  memory        12.0",
                "fill      10.000   25 %       1.2         -         -     0.000  memory           -",
                "all       40.000  100 %       2.5      64.0      16.0     2.500                16.0",
            ]
        );
    }
}
