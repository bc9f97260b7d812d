//! Gradescope's `results.json`: a test per test, and a row for its leaderboard.

use serde_json::{Value, json};

use super::super::Report;
use super::{details, to_milliseconds};

/// The whole file.
pub fn write(report: &Report) -> String {
    let tests: Vec<Value> = report
        .tests
        .iter()
        .map(|test| {
            json!({
                "name": test.name,
                "score": test.points,
                "max_score": test.max_points,
                "status": if test.is_met() { "passed" } else { "failed" },
                "output": format!(
                    "{} ({})\n{}", test.outcome, test.outcome.meaning(), details(test).join("\n")
                ),
                "output_format": "text",
            })
        })
        .collect();
    let findings: Vec<String> = report.findings.iter().map(ToString::to_string).collect();
    let overview = format!("{}\n\n{}", findings.join("\n"), report.protocol);
    let wall: f64 = report.tests.iter().map(|test| test.usage.wall_seconds).sum();
    let mut leaderboard =
        vec![json!({ "name": "Points", "value": report.points, "order": "desc" })];
    if let Some(cpu) = report.cpu_seconds() {
        leaderboard
            .push(json!({ "name": "CPU seconds", "value": to_milliseconds(cpu), "order": "asc" }));
    }
    let results = json!({
        "score": report.points,
        "execution_time": wall.round() as u64,
        "output": overview.trim(),
        "output_format": "text",
        "tests": tests,
        "leaderboard": leaderboard,
    });
    format!("{results:#}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_has_every_test_with_its_message() {
        let mut report = super::super::tests::report();
        let results: Value = serde_json::from_str(&write(&report)).unwrap();
        // Without points it is enough to be answered.
        report.tests.iter_mut().for_each(|test| test.max_points = 0.0);
        let without: Value = serde_json::from_str(&write(&report)).unwrap();
        let status = [0, 1, 2].map(|i| without["tests"][i]["status"].as_str().unwrap());
        assert_eq!(status, ["passed", "passed", "failed"]);
        assert_eq!(results["score"], 7.0);
        assert_eq!(results["tests"].as_array().unwrap().len(), 3);
        assert_eq!(results["tests"][0]["status"], "passed");
        assert_eq!(results["tests"][1]["status"], "failed");
        let output = results["tests"][2]["output"].as_str().unwrap();
        assert!(output.starts_with("RE (run-time error)\nstereo_disparity_best.py, line 3"));
        assert!(results["output"].as_str().unwrap().contains("line 7: np.int is gone"));
    }
}
