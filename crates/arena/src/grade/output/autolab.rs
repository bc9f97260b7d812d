//! Autolab: the last line of standard output is a JSON object with a score per problem, and a row
//! for the scoreboard: points, and the CPU time of all tests in seconds.
//!
//! Problems in Autolab must bear the names of the scheme's tests.

use serde_json::{Map, Value, json};

use super::super::Report;
use super::to_milliseconds;

/// The line, with its end.
pub fn line(report: &Report) -> String {
    let scores: Map<String, Value> =
        report.tests.iter().map(|test| (test.name.clone(), json!(test.points))).collect();
    let cpu = report.cpu_seconds().map_or(Value::Null, |seconds| json!(to_milliseconds(seconds)));
    let line = json!({ "scores": scores, "scoreboard": [report.points, cpu] });
    format!("{line}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_one_line_with_every_test() {
        let line = line(&super::super::tests::report());
        assert_eq!(
            line,
            "{\"scoreboard\":[7.0,3.75],\"scores\":{\"One\":7.0,\"Three\":0.0,\"Two\":0.0}}\n"
        );
    }
}
