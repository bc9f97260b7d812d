//! Who stands where, and what it is worth.

use std::cmp::Ordering;

use serde::Serialize;

use super::entry::Entry;
use crate::grade::{Test, TestResult};

/// Points for the first three.
pub const BONUS: [f64; 3] = [5.0, 3.0, 2.0];

/// An entry with its place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Standing {
    /// 1 is first; `None` for a baseline, and without an answer on the hold-out.
    pub place: Option<usize>,
    /// The holdout score, lower is better; `None` without an answer.
    pub score: Option<f64>,
    /// Points for the place.
    pub bonus: f64,
    /// Points of the tests and the bonus.
    pub total: f64,
    /// What whoever grades should look at, in words: answers that equal the truth, or those of somebody else, and what the
    /// files bring besides their source. It may be honest: a fixed window has not many ways to be written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<String>,
    /// Who stands here.
    pub entry: Entry,
}

/// `(E_RMS / max_e_rms + p_bad / max_p_bad) / 2`, the thresholds being those of `test`; `None`
/// without an answer.
pub fn holdout_score(result: &TestResult, test: &Test) -> Option<f64> {
    let scores = result.scores.as_ref()?;
    Some((scores.e_rms / test.max_e_rms + scores.p_bad / test.max_p_bad) / 2.0)
}

/// Everybody, best first, judged by the thresholds of the hold-out's `test`. Entries come earliest first: of those added
/// within one second that decides.
pub fn standings(entries: Vec<Entry>, test: &Test) -> Vec<Standing> {
    let mut standings: Vec<Standing> = entries
        .into_iter()
        .map(|entry| {
            let score = holdout_score(&entry.holdout, test);
            let (total, doubts) = (entry.report.points, of_entry(&entry));
            Standing { place: None, score, bonus: 0.0, total, doubts, entry }
        })
        .collect();
    standings.sort_by(order);
    let competing = standings.iter_mut().filter(|s| s.score.is_some() && !s.entry.baseline);
    for (before, standing) in competing.enumerate() {
        standing.place = Some(before + 1);
        standing.bonus = BONUS.get(before).copied().unwrap_or(0.0);
        standing.total += standing.bonus;
    }
    // Baselines are there to be compared with.
    let competing = |at: &usize| standings[*at].place.is_some();
    let competing: Vec<usize> = (0..standings.len()).filter(competing).collect();
    for &at in &competing {
        let of = |at: usize| &standings[at].entry;
        let others = competing.iter().filter(|&&other| other != at);
        let alike = others.filter(|&&other| answer_alike(&of(at).holdout, &of(other).holdout));
        let names: Vec<String> = alike.map(|&other| format!("`{}`", of(other).secret_id)).collect();
        if !names.is_empty() {
            standings[at].doubts.push(format!(
                "the same scores on the hold-out as {}, to the last digit",
                names.join(", ")
            ));
        }
    }
    standings
}

/// What is doubtful about an entry by itself: answers that equal the truth, findings for whoever grades.
fn of_entry(entry: &Entry) -> Vec<String> {
    let looks_copied =
        |test: &&TestResult| test.scores.as_ref().is_some_and(|scores| scores.looks_copied());
    let tests = entry.report.tests.iter().chain([&entry.holdout]).filter(looks_copied);
    let names: Vec<&str> = tests.map(|test| &*test.name).collect();
    let copied =
        (!names.is_empty()).then(|| format!("nearly all of the truth in {}", names.join("; ")));
    let findings = entry.report.findings.iter().filter(|finding| finding.doubtful);
    copied.into_iter().chain(findings.map(|finding| finding.to_string())).collect()
}

/// Whether two answers are the same, as far as both numbers tell.
fn answer_alike(one: &TestResult, other: &TestResult) -> bool {
    match (&one.scores, &other.scores) {
        (Some(one), Some(other)) => (one.e_rms, one.p_bad) == (other.e_rms, other.p_bad),
        _ => false,
    }
}

/// Better before worse, earlier before later: whoever hands the same in again cannot pass the first. Times do not
/// decide: on a machine that others use too they differ by chance. Without an answer on the hold-out the points of the
/// tests decide.
fn order(a: &Standing, b: &Standing) -> Ordering {
    let last = |value: Option<f64>| value.unwrap_or(f64::INFINITY);
    last(a.score)
        .total_cmp(&last(b.score))
        .then_with(|| match a.score {
            Some(_) => Ordering::Equal,
            None => b.entry.report.points.total_cmp(&a.entry.report.points),
        })
        .then_with(|| a.entry.added.cmp(&b.entry.added))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::board::Holdout;
    use crate::grade::Outcome;
    use crate::grade::output::tests::report;
    use crate::submission::Finding;

    /// An entry with these numbers on the hold-out; none without an answer.
    pub(crate) fn entry(id: &str, e_rms: Option<f64>, p_bad: f64, cpu: f64) -> Entry {
        let report = report();
        let mut holdout = report.tests[0].clone();
        holdout.usage.cpu_seconds = Some(cpu);
        match (e_rms, &mut holdout.scores) {
            (Some(e_rms), Some(scores)) => (scores.e_rms, scores.p_bad) = (e_rms, p_bad),
            _ => (holdout.scores, holdout.outcome) = (None, Outcome::To),
        }
        Entry {
            secret_id: id.into(),
            renamed: false,
            baseline: false,
            added: "2026-01-31T12:00:00Z".into(),
            tests: String::new(),
            handin: None,
            report,
            holdout,
            machine: "a machine".into(),
        }
    }

    fn ranked(entries: Vec<Entry>) -> Vec<(String, Option<usize>, f64)> {
        let test = Holdout::secret(600.0).unwrap().test;
        let standings = standings(entries, &test);
        standings.into_iter().map(|s| (s.entry.secret_id, s.place, s.bonus)).collect()
    }

    #[test]
    fn both_numbers_weigh_equally() {
        let test = Holdout::secret(600.0).unwrap().test;
        // At both thresholds, 5 px and 0.11, the score is 1.
        let score =
            |e_rms, p_bad| holdout_score(&entry("x", Some(e_rms), p_bad, 1.0).holdout, &test);
        assert_eq!(score(5.0, 0.11), Some(1.0));
        assert_eq!(score(2.5, 0.055), Some(0.5));
        assert_eq!(score(10.0, 0.0), Some(1.0));
        assert_eq!(holdout_score(&entry("x", None, 0.0, 1.0).holdout, &test), None);
    }

    #[test]
    fn the_first_three_get_a_bonus_and_baselines_do_not() {
        let mut baseline = entry("baseline", Some(0.5), 0.01, 0.1);
        baseline.baseline = true;
        let entries = vec![
            entry("fourth", Some(4.0), 0.08, 1.0),
            entry("none", None, 0.0, 1.0),
            entry("second", Some(2.0), 0.04, 1.0),
            baseline,
            entry("first", Some(1.0), 0.02, 9.0),
            entry("third", Some(3.0), 0.06, 1.0),
        ];
        let expected = [
            ("baseline", None, 0.0),
            ("first", Some(1), 5.0),
            ("second", Some(2), 3.0),
            ("third", Some(3), 2.0),
            ("fourth", Some(4), 0.0),
            ("none", None, 0.0),
        ];
        assert_eq!(ranked(entries), expected.map(|(id, p, b)| (id.to_owned(), p, b)));
    }

    #[test]
    fn answers_of_somebody_else_and_the_truth_are_told() {
        let alike = |id| entry(id, Some(1.25), 0.02, 1.0);
        let mut baseline = alike("baseline");
        baseline.baseline = true;
        let mut copied = entry("copied", Some(0.0), 0.0, 1.0);
        copied.holdout.scores.as_mut().unwrap().identical = 1.0;
        let finding = Finding::about("a.npy", "whoever grades may ask");
        copied.report.findings = vec![Finding { doubtful: true, ..finding }];
        let entries = vec![
            alike("one"),
            alike("other"),
            baseline,
            alike("third"),
            entry("by chance", Some(1.25), 0.021, 1.0),
            entry("none", None, 0.0, 1.0),
            entry("neither", None, 0.0, 1.0),
            copied,
        ];
        let standings = standings(entries, &Holdout::secret(600.0).unwrap().test);
        let doubts: Vec<(&str, &[String])> =
            standings.iter().map(|s| (&*s.entry.secret_id, &*s.doubts)).collect();
        let as_ =
            |ids| vec![format!("the same scores on the hold-out as {ids}, to the last digit")];
        let of_copied = ["nearly all of the truth in One", "a.npy: whoever grades may ask"];
        assert_eq!(doubts[0], ("copied", &of_copied.map(str::to_owned)[..]));
        assert_eq!(doubts[1], ("one", &as_("`other`, `third`")[..]));
        assert_eq!(doubts[2], ("other", &as_("`one`, `third`")[..]));
        assert_eq!(doubts[4], ("third", &as_("`one`, `other`")[..]));
        assert!(doubts[5..].iter().all(|(_, doubts)| doubts.is_empty()), "{doubts:?}");
    }

    #[test]
    fn ties_go_to_the_earlier_entry_however_quick() {
        let mut later = entry("later", Some(1.0), 0.02, 1.0);
        later.added = "2026-02-01T12:00:00Z".into();
        let entries = vec![later, entry("slow", Some(1.0), 0.02, 2.0)];
        let order: Vec<String> = ranked(entries).into_iter().map(|each| each.0).collect();
        assert_eq!(order, ["slow", "later"]);
        // Of one second they stand as they were added, whatever they are called.
        let entries = ["zoe", "adam"].map(|id| entry(id, Some(1.0), 0.02, 1.0));
        let order: Vec<String> = ranked(entries.to_vec()).into_iter().map(|each| each.0).collect();
        assert_eq!(order, ["zoe", "adam"]);
    }
}
