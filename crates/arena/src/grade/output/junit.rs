//! JUnit's XML, for continuous integration: a test case per test; a miss is a failure, the
//! grader's own fault an error.

use super::super::{Outcome, Report};
use super::{details, points};
use formats::markup::escaped;

/// The whole file.
pub fn write(report: &Report) -> String {
    let tests = &report.tests;
    let errors = tests.iter().filter(|test| test.outcome == Outcome::Xx).count();
    let missed = tests.iter().filter(|test| !test.is_met()).count() - errors;
    let time: f64 = tests.iter().map(|test| test.usage.wall_seconds).sum();
    let mut xml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n  <testsuite name=\"{}\" \
         tests=\"{}\" failures=\"{missed}\" errors=\"{errors}\" time=\"{time:.3}\">\n",
        escaped(&report.scheme),
        tests.len()
    );
    for test in tests {
        xml.push_str(&format!(
            "    <testcase classname=\"{}\" name=\"{}\" time=\"{:.3}\">\n",
            escaped(&report.entrant),
            escaped(&test.name),
            test.usage.wall_seconds
        ));
        let text = escaped(&details(test).join("\n"));
        let (tag, meaning) = match test.outcome {
            Outcome::Xx => ("error", test.outcome.meaning()),
            Outcome::Ok => ("failure", "not below a threshold"),
            _ => ("failure", test.outcome.meaning()),
        };
        if test.is_met() {
            xml.push_str(&format!("      <system-out>{text}</system-out>\n"));
        } else {
            xml.push_str(&format!(
                "      <{tag} type=\"{}\" message=\"{meaning}: {} of {} points\">{text}</{tag}>\n",
                test.outcome,
                points(test.points),
                points(test.max_points)
            ));
        }
        xml.push_str("    </testcase>\n");
    }
    xml.push_str("  </testsuite>\n</testsuites>\n");
    xml
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misses_are_failures_and_markup_is_escaped() {
        let mut report = super::super::tests::report();
        let xml = write(&report);
        assert!(
            xml.contains("name=\"Three &lt;tests&gt;\" tests=\"3\" failures=\"2\" errors=\"0\"")
        );
        assert!(xml.contains("<testcase classname=\"her &amp; his\" name=\"One\" time=\"1.500\">"));
        assert!(
            xml.contains("<failure type=\"OK\" message=\"not below a threshold: 0 of 7 points\">")
        );
        assert!(xml.contains("<failure type=\"RE\" message=\"run-time error: 0 of 7 points\">"));
        assert!(xml.contains("E_RMS 9.50 px is not below 8"));
        // Without points it is enough to be answered.
        report.tests[1].max_points = 0.0;
        let xml = write(&report);
        assert!(xml.contains("failures=\"1\"") && !xml.contains("is not below 8"), "{xml}");
        report.tests[1].max_points = 7.0;
        report.tests[2].outcome = Outcome::Xx;
        report.tests[2].message = Some("bell \x07".into());
        let xml = write(&report);
        assert!(xml.contains("failures=\"1\" errors=\"1\"") && xml.contains("<error type=\"XX\""));
        assert!(xml.contains("bell \u{fffd}"));
    }
}
