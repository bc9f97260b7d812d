//! For people: a line when a test begins, its result when it has ended, a summary.

use super::super::{Event, Grader, Report, Test, TestResult};
use super::points;
use crate::report::printable;
use crate::submission::Finding;

/// Before everything: what is graded, by what, how it is confined.
pub fn header(grader: &Grader<'_>, entrant: &str) -> String {
    let confined = match grader.confinement.helper {
        Some(_) => "in a sandbox",
        None => "WITHOUT A SANDBOX, with all rights of whoever grades",
    };
    let (name, points) = (&grader.scheme.name, points(grader.scheme.points()));
    format!("{} ({points} points): {}, {confined}\n\n", printable(name), printable(entrant))
}

/// What was noticed before anything was run.
pub fn findings(findings: &[Finding]) -> String {
    let text: String = findings.iter().map(|finding| format!("{finding}\n")).collect();
    let lines: String = text.lines().map(|line| format!("{}\n", printable(line))).collect();
    if lines.is_empty() { lines } else { lines + "\n" }
}

/// What happened in a grading.
pub fn event(event: &Event<'_>) -> String {
    match event {
        Event::Begins(test) => begins(test),
        Event::Ended(result) => ended(result),
    }
}

/// Before a test: its name and its limit of CPU time.
pub fn begins(test: &Test) -> String {
    format!("{:<24} limit {} CPU s\n", test.name, test.cpu_seconds)
}

/// After a test: how it ended, both numbers with their thresholds, points, time and memory; then
/// what the author can act on.
pub fn ended(test: &TestResult) -> String {
    let counts = test.counts();
    let points = if counts { format!("{} points", share(test)) } else { "no points".into() };
    let mut text = format!("  {:<4} {points:>14}", test.outcome);
    if let Some(scores) = &test.scores {
        let limit = |value: f64| if counts { format!(" (below {value})") } else { String::new() };
        text.push_str(&format!(
            "   E_RMS {:>6.2} px{}   p_bad {:.4}{}",
            scores.e_rms,
            limit(test.max_e_rms),
            scores.p_bad,
            limit(test.max_p_bad)
        ));
    }
    text.push('\n');
    if test.usage.wall_seconds > 0.0 {
        text.push_str(&indented(&usage(test)));
    }
    if let Some(message) = &test.message {
        text.push_str(&indented(message));
    } else if let Some(shortfall) = test.shortfall().filter(|_| counts) {
        text.push_str(&indented(&format!("no points: {shortfall}")));
    }
    for remark in &test.remarks {
        text.push_str(&indented(&format!("note: {remark}")));
    }
    if test.message.is_some() && !test.output.trim().is_empty() {
        text.push_str(&indented("what it printed, at the end:"));
        let lines: Vec<&str> = test.output.trim_end().lines().collect();
        for line in &lines[lines.len().saturating_sub(5)..] {
            text.push_str(&indented(&format!("| {}", shortened(line, PRINTED))));
        }
    }
    text
}

/// After everything: what was noticed in the files, and the points.
pub fn summary(report: &Report) -> String {
    let mut text = String::from("\n");
    let ran = report.tests.iter().any(|test| test.usage.cpu_seconds.is_some());
    if ran && report.machine_speed.is_noisy() {
        text.push_str(&format!(
            "The machine was busy: a fixed piece of work took {:.2} ms before and {:.2} ms after \
             the tests. Take the times with caution.\n",
            report.machine_speed.before_seconds * 1e3,
            report.machine_speed.after_seconds * 1e3
        ));
    }
    if report.grader_failed() {
        text.push_str(
            "XX: the grader failed, and not the entrant; mend what it says and grade again.\n",
        );
    }
    if let Some(id) = &report.secret_id {
        text.push_str(&format!("Secret ID: {id}\n"));
    }
    text.push_str(&format!("{} of {} points\n", points(report.points), points(report.max_points)));
    text
}

/// CPU time, wall time, peak memory.
pub(super) fn usage(test: &TestResult) -> String {
    let cpu = match test.usage.cpu_seconds {
        Some(seconds) => format!("CPU {} of {} s", time(seconds), test.cpu_limit_seconds),
        None => "CPU time unknown".into(),
    };
    let memory = match test.usage.peak_memory_bytes {
        Some(bytes) => format!(", peak memory {:.0} MB", bytes as f64 / 1e6),
        None => String::new(),
    };
    let startup = match test.startup.cpu_seconds {
        Some(seconds) if seconds > 0.0 => format!(", import {} s", time(seconds)),
        _ => String::new(),
    };
    format!("{cpu}, wall {} s{memory}{startup}", time(test.usage.wall_seconds))
}

fn time(seconds: f64) -> String {
    if seconds < 10.0 { format!("{seconds:.2}") } else { format!("{seconds:.1}") }
}

fn share(test: &TestResult) -> String {
    format!("{} of {}", points(test.points), points(test.max_points))
}

fn indented(text: &str) -> String {
    text.lines().map(|line| format!("       {}\n", printable(&shortened(line, WORDS)))).collect()
}

/// What is shown of a line: of the words of graders and of what a program printed, which may be one line of a megabyte.
const WORDS: usize = 800;
const PRINTED: usize = 160;

/// A line of so many characters at the most.
fn shortened(line: &str, most: usize) -> String {
    let beginning: String = line.chars().take(most).collect();
    if line.chars().nth(most).is_some() { format!("{beginning} ...") } else { beginning }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_reads_well() {
        let report = super::super::tests::report();
        let text: String = report.tests.iter().map(ended).collect();
        assert_eq!(
            text,
            "  OK    7 of 7 points   E_RMS   3.27 px (below 8)   p_bad 0.0833 (below 0.17)\n       \
             CPU 1.25 of 600 s, wall 1.50 s, peak memory 126 MB, import 0.20 s\n       \
             note: 3 of the 9 pixels were clipped\n  \
             OK    0 of 7 points   E_RMS   9.50 px (below 8)   p_bad 0.0833 (below 0.17)\n       \
             CPU 1.25 of 600 s, wall 1.50 s, peak memory 126 MB, import 0.20 s\n       \
             no points: E_RMS 9.50 px is not below 8\n  \
             RE    0 of 7 points\n       \
             CPU 1.25 of 600 s, wall 1.50 s, peak memory 126 MB, import 0.20 s\n       \
             stereo_disparity_best.py, line 3, in stereo_disparity_best\n           1 / 0\n       \
             ZeroDivisionError: division by zero\n"
        );
        assert_eq!(summary(&report), "\nSecret ID: Jaff Bozos\n7 of 21 points\n");
    }

    #[test]
    fn a_test_without_points_has_no_thresholds() {
        let mut test = super::super::tests::report().tests.remove(1);
        test.max_points = 0.0;
        let text = ended(&test);
        assert!(
            text.starts_with("  OK        no points   E_RMS   9.50 px   p_bad 0.0833\n"),
            "{text}"
        );
        assert!(!text.contains("below"), "{text}");
    }

    #[test]
    fn what_was_printed_cannot_take_over_the_screen() {
        let mut test = super::super::tests::report().tests.remove(2);
        test.output = format!("\x1b[2J{}\n", "x".repeat(100_000));
        test.message = Some(format!("ValueError: \x1b]0;mine\x07\u{202e}{}", "y".repeat(100_000)));
        let text = ended(&test);
        assert!(text.len() < 2000 && !text.contains(['\x1b', '\u{202e}']), "{text}");
        let finding = Finding {
            file: "a.py".into(),
            line: None,
            text: "two\nlines\x1b[2J".into(),
            fatal: false,
            doubtful: false,
        };
        assert_eq!(findings(&[finding]), "a.py: two\nlines [2J\n\n");
        assert_eq!(findings(&[]), "");
    }
}
