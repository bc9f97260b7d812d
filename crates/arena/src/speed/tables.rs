//! Runs as tables: everything that was measured, engines against their peers, and how time grows. Where runs
//! are of several machines, the first says in each row of which; in the others rows are of the one that measured
//! last.

use super::peers::PEERS;
use super::record::Run;
use crate::engine::Status;
use crate::record::Machine;
use crate::report::{Cell, Column, Table, in_order};

/// One row for each engine of each run: shortest and median time of matching, the rate that follows
/// from the median, CPU time and memory. There is a column for the status when something failed.
pub fn measurements_table(runs: &[Run]) -> Table {
    let several = runs.windows(2).any(|pair| pair[0].machine != pair[1].machine);
    let mut columns: Vec<Column> =
        several.then(|| Column::grouped("machine")).into_iter().collect();
    columns.extend(["scene", "size", "threads"].map(Column::grouped));
    columns.push(Column::new("matcher"));
    columns.extend(["runs", "min ms", "median ms", "MDE/s", "CPU ms", "MB"].map(Column::new));
    let all = || runs.iter().flat_map(|run| &run.measurements);
    let with_status = all().any(|measurement| measurement.status != Status::Done);
    if with_status {
        columns.push(Column::new("status"));
    }
    let mut table = Table { columns, rows: Vec::new() };
    for run in runs {
        for measurement in &run.measurements {
            let median = measurement.median();
            let mut row = Vec::from_iter(several.then(|| Cell::text(run.machine.to_string())));
            row.extend(place(run));
            row.push(Cell::text(&measurement.engine));
            row.push(Cell::Number(measurement.seconds.len() as f64, 0));
            row.push(milliseconds(measurement.minimum()));
            row.push(milliseconds(median));
            row.push(Cell::number(median.map(|seconds| run.rate(seconds) / 1e6), 0));
            row.push(milliseconds(measurement.cpu_seconds));
            row.push(megabytes(measurement.peak_memory_bytes));
            if with_status {
                row.push(Cell::text(measurement.status.name()));
            }
            table.push(row);
        }
    }
    table
}

/// One row for each pair of [`PEERS`] that met on the machine that measured last: both medians, how many times
/// as long the peer takes, hazcam's rate and both peaks of memory. How many times as long it takes on each other
/// machine stands in a column of that machine.
pub fn peers_table(runs: &[Run]) -> Table {
    let (latest, others) = latest_and_others(runs);
    let mut columns = ["scene", "size", "threads"].map(Column::grouped).to_vec();
    columns.extend(
        ["matcher", "peer", "ms", "peer ms", "ratio", "MDE/s", "MB", "peer MB"].map(Column::new),
    );
    columns.extend(others.iter().map(|machine| Column::new(format!("ratio on {machine}"))));
    let mut table = Table { columns, rows: Vec::new() };
    let met = |run: &Run, (engine, peer)| run.of(engine).is_some() && run.of(peer).is_some();
    for run in runs.iter().filter(|run| Some(&run.machine) == latest) {
        for (engine, peer) in PEERS.into_iter().filter(|pair| met(run, *pair)) {
            let measured = [engine, peer].map(|name| run.of(name));
            let [own, other] = measured.map(|found| found.and_then(|found| found.median()));
            let memory = measured.map(|found| found.and_then(|found| found.peak_memory_bytes));
            let mut row = place(run).to_vec();
            row.extend([Cell::text(engine), Cell::text(peer)]);
            row.extend([own, other].map(milliseconds));
            row.push(Cell::number(run.ratio(engine, peer), 2));
            row.push(Cell::number(own.map(|seconds| run.rate(seconds) / 1e6), 0));
            row.extend(memory.map(megabytes));
            row.extend(others.iter().map(|&machine| {
                let same =
                    runs.iter().find(|other| other.machine == *machine && run.asks_as(other));
                Cell::number(same.and_then(|other| other.ratio(engine, peer)), 2)
            }));
            table.push(row);
        }
    }
    table
}

/// One row for each run of the machine that measured last, a column for each engine: nanoseconds per pixel and
/// disparity, which stay the same from size to size where time grows with the work alone.
pub fn sweep_table(runs: &[Run]) -> Table {
    let (latest, _) = latest_and_others(runs);
    let runs = || runs.iter().filter(|run| Some(&run.machine) == latest);
    let engines = in_order(runs().flat_map(|run| &run.measurements).map(|found| &*found.engine));
    let mut columns = ["size", "Mpixel", "threads"].map(Column::new).to_vec();
    columns.extend(engines.iter().map(|engine| Column::new(format!("{engine} ns"))));
    let mut table = Table { columns, rows: Vec::new() };
    for run in runs() {
        let [_, size, threads] = place(run);
        let megapixels = (run.columns * run.rows) as f64 / 1e6;
        let mut row = vec![size, Cell::Number(megapixels, 1), threads];
        row.extend(engines.iter().map(|engine| {
            let median = run.of(engine).and_then(|measurement| measurement.median());
            Cell::number(median.map(|seconds| 1e9 / run.rate(seconds)), 2)
        }));
        table.push(row);
    }
    table
}

/// The machine that measured last, and each of the others once.
fn latest_and_others(runs: &[Run]) -> (Option<&Machine>, Vec<&Machine>) {
    // Of several that measured on that day, the last in the record.
    let latest = runs.iter().max_by_key(|run| &run.date).map(|run| &run.machine);
    let mut others: Vec<&Machine> = Vec::new();
    for machine in runs.iter().map(|run| &run.machine) {
        if Some(machine) != latest && !others.contains(&machine) {
            others.push(machine);
        }
    }
    (latest, others)
}

fn place(run: &Run) -> [Cell; 3] {
    let size = format!("{} x {} x {}", run.columns, run.rows, run.disparities);
    [Cell::text(&run.scene), Cell::text(size), Cell::Number(run.threads as f64, 0)]
}

fn milliseconds(seconds: Option<f64>) -> Cell {
    Cell::number(seconds.map(|seconds| seconds * 1e3), 1)
}

fn megabytes(bytes: Option<u64>) -> Cell {
    Cell::number(bytes.map(|bytes| bytes as f64 / 1e6), 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Definition, Engines};
    use crate::record::Machine;
    use crate::speed::{Measurement, Record};

    fn measured(engine: &str, seconds: &[f64]) -> Measurement {
        let known = Engines::built_in();
        let definition: &Definition = known.named(engine).unwrap();
        Measurement {
            seconds: seconds.to_vec(),
            cpu_seconds: Some(0.03),
            peak_memory_bytes: Some(21_400_000),
            ..Measurement::new(definition, Some("1"))
        }
    }

    /// A thousand pixels by a hundred by ten disparities: a million evaluations.
    fn a_run() -> Run {
        Run {
            scene: "strip".into(),
            columns: 1000,
            rows: 100,
            disparities: 10,
            threads: 2,
            sweep: false,
            hazcam: "0.1.0".into(),
            command: "hazcam bench --speed".into(),
            date: "2026-01-31".into(),
            machine: Machine::this(None),
            measurements: vec![
                measured("fast", &[0.012, 0.010, 0.008]),
                measured("opencv-bm-9x9", &[0.030, 0.020, 0.025]),
                Measurement {
                    status: Status::Failed { message: "no memory".into() },
                    ..measured("opencv-hh", &[])
                },
            ],
        }
    }

    fn another() -> Machine {
        Machine { cpu: Some("Another".into()), cores: 4, ..Machine::this(None) }
    }

    #[test]
    fn of_several_machines_the_one_that_measured_last_is_shown_and_what_ratios_the_others_have() {
        let earlier = Run {
            measurements: vec![measured("fast", &[0.010]), measured("opencv-bm-9x9", &[0.020])],
            date: "2026-01-30".into(),
            machine: another(),
            ..a_run()
        };
        for runs in [[a_run(), earlier.clone()], [earlier.clone(), a_run()]] {
            let csv = peers_table(&runs).to_csv();
            let rows: Vec<&str> = csv.lines().collect();
            assert!(
                rows[0].ends_with(",\"ratio on Another, 4 cores, vector level unknown\""),
                "{csv}"
            );
            assert!(rows[1].contains(",10,25,2.5,") && rows[1].ends_with(",2"), "{csv}");
            assert_eq!(rows.len(), 2, "{csv}");
            assert_eq!(sweep_table(&runs), sweep_table(&[a_run()]));
            let all = measurements_table(&runs).to_csv();
            assert_eq!(all.lines().count(), 1 + 3 + 2, "{all}");
            assert!(all.starts_with("machine,scene,"), "{all}");
            assert!(all.contains("\"Another, 4 cores, vector level unknown\",strip,"), "{all}");
        }
        // What the other machine did not measure.
        let elsewhere = Run { threads: 1, ..earlier };
        let csv = peers_table(&[a_run(), elsewhere]).to_csv();
        assert!(csv.lines().count() == 2 && csv.lines().last().unwrap().ends_with(','), "{csv}");
    }

    #[test]
    fn minimum_median_and_rate_of_every_engine() {
        assert_eq!(
            measurements_table(&[a_run()]).to_text(),
            "scene  size             threads  matcher        runs  min ms  median ms  MDE/s  CPU ms  \
             MB  status\n\
             strip  1000 x 100 x 10        2  fast              3     8.0       10.0    100    30.0  \
             21  done\n\
             \x20                                opencv-bm-9x9     3    20.0       25.0     40    30.0  \
             21  done\n\
             \x20                                opencv-hh         0       -          -      -    30.0  \
             21  failed\n"
        );
    }

    #[test]
    fn the_ratio_is_that_of_the_medians_of_those_that_met() {
        let run = a_run();
        assert_eq!(run.ratio("fast", "opencv-bm-9x9"), Some(2.5));
        assert_eq!(run.ratio("fast", "opencv-hh"), None);
        let table = peers_table(&[run]);
        assert_eq!(
            table.to_csv(),
            "scene,size,threads,matcher,peer,ms,peer ms,ratio,MDE/s,MB,peer MB\r\n\
             strip,1000 x 100 x 10,2,fast,opencv-bm-9x9,10,25,2.5,100,21.4,21.4\r\n"
        );
    }

    #[test]
    fn a_sweep_shows_time_per_pixel_and_disparity() {
        assert_eq!(
            sweep_table(&[a_run()]).to_csv(),
            "size,Mpixel,threads,fast ns,opencv-bm-9x9 ns,opencv-hh ns\r\n\
             1000 x 100 x 10,0.1,2,10,25,\r\n"
        );
    }

    #[test]
    fn a_record_keeps_one_run_for_each_machine_scene_and_number_of_threads() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("speed.json");
        let mut record = Record::default();
        let alone = Run { threads: 1, ..a_run() };
        let later = Run { date: "2026-02-01".into(), ..a_run() };
        let other = Run { scene: "other".into(), ..a_run() };
        let elsewhere = Run { machine: another(), ..a_run() };
        let news = [a_run(), elsewhere.clone(), other.clone(), alone.clone(), later.clone()];
        for run in news {
            record.put(run);
        }
        assert_eq!(record.runs, [later, alone, other, elsewhere]);
        record.write(&path).unwrap();
        assert_eq!(Record::read(&path).unwrap(), record);
        std::fs::write(&path, "{}").unwrap();
        let error = Record::read(&path).unwrap_err().to_string();
        assert!(error.contains("speed.json holds no record") && error.contains("missing field"));
    }
}
