//! A report in the forms that people and autograders read, one form a file.

pub mod autolab;
pub mod gradescope;
pub mod junit;
pub mod text;

use super::TestResult;

/// What a test says about itself, in lines: numbers or the reason for none, then the remarks.
fn details(test: &TestResult) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(scores) = &test.scores {
        let below =
            |limit: f64| if test.counts() { format!(" (below {limit})") } else { String::new() };
        lines.push(format!(
            "E_RMS {:.2} px{}, p_bad {:.4}{}, over {} pixels",
            scores.e_rms,
            below(test.max_e_rms),
            scores.p_bad,
            below(test.max_p_bad),
            scores.pixels
        ));
    }
    if let Some(message) = &test.message {
        lines.extend(message.lines().map(str::to_owned));
    } else if let Some(shortfall) = test.shortfall().filter(|_| test.counts()) {
        lines.push(format!("no points: {shortfall}"));
    }
    if test.usage.wall_seconds > 0.0 {
        lines.push(text::usage(test));
    }
    lines.extend(test.remarks.iter().map(|remark| format!("note: {remark}")));
    lines
}

/// Points without needless decimals: 6, 47.5.
pub(crate) fn points(points: f64) -> String {
    let rounded = (points * 100.0).round() / 100.0;
    format!("{rounded}")
}

/// Seconds without more digits than clocks are good for.
fn to_milliseconds(seconds: f64) -> f64 {
    (seconds * 1000.0).round() / 1000.0
}

#[cfg(test)]
pub(crate) mod tests {
    use super::super::{MachineSpeed, Outcome, Report, Scores, TestResult};
    use crate::engine::Usage;
    use crate::submission::{Finding, Part};

    /// A report with a pass, a miss and a failure.
    pub(crate) fn report() -> Report {
        let test = |name: &str, part, outcome, message: Option<&str>, e_rms, points| TestResult {
            name: name.into(),
            part,
            scene: "wall".into(),
            outcome,
            message: message.map(str::to_owned),
            scores: message.is_none().then(|| Scores {
                e_rms,
                p_bad: 0.0833,
                pixels: 5000,
                clipped: 3,
                identical: 0.1,
                nearly: 0.2,
                protocol: "course".into(),
            }),
            max_e_rms: 8.0,
            max_p_bad: 0.17,
            cpu_limit_seconds: 600.0,
            points,
            max_points: 7.0,
            usage: Usage {
                cpu_seconds: Some(1.25),
                wall_seconds: 1.5,
                peak_memory_bytes: Some(120 << 20),
            },
            startup: Usage { cpu_seconds: Some(0.2), wall_seconds: 0.3, ..Usage::default() },
            remarks: Vec::new(),
            output: String::new(),
            disparity: None,
        };
        let error = "stereo_disparity_best.py, line 3, in stereo_disparity_best\n    1 / 0\n\
                     ZeroDivisionError: division by zero";
        let mut clipped = test("One", Part::Fast, Outcome::Ok, None, 3.271, 7.0);
        clipped.remarks.push("3 of the 9 pixels were clipped".into());
        Report {
            hazcam: "0.1.0".into(),
            scheme: "Three <tests>".into(),
            entrant: "her & his".into(),
            secret_id: Some("Jaff Bozos".into()),
            findings: vec![Finding {
                file: "stereo_disparity_fast.py".into(),
                line: Some(7),
                text: "np.int is gone".into(),
                fatal: false,
                doubtful: false,
            }],
            tests: vec![
                clipped,
                test("Two", Part::Fast, Outcome::Ok, None, 9.5, 0.0),
                test("Three", Part::Best, Outcome::Re, Some(error), 0.0, 0.0),
            ],
            points: 7.0,
            max_points: 21.0,
            protocol: "As always.".into(),
            confinement: "sandbox".into(),
            python: Some("3.11.7".into()),
            machine_speed: MachineSpeed { before_seconds: 0.001, after_seconds: 0.001 },
        }
    }
}
