//! The table, best first until a reader sorts it otherwise.

use super::{anchor, number};
use crate::board::Standing;
use crate::grade::output::points;
use formats::markup::escaped;

/// Heading, explanation, whether numbers stand in it, whether a narrow screen leaves it out.
const COLUMNS: [(&str, &str, bool, bool); 10] = [
    ("#", "place", true, false),
    ("Secret ID", "a link to its results", false, false),
    ("Score", "on the hold-out, lower is better", true, false),
    ("E<sub>RMS</sub>", "root mean square error on the hold-out in pixels", true, true),
    ("p<sub>bad</sub>", "share of the hold-out's pixels off by more than 2 px", true, true),
    ("CPU s", "CPU time on the hold-out", true, false),
    ("Tests", "points of the tests", true, true),
    ("Bonus", "points for the place", true, true),
    ("Total", "points in all", true, false),
    ("Added", "day of the entry, UTC", false, true),
];

pub(super) fn table(standings: &[Standing]) -> String {
    if standings.is_empty() {
        return "<p>There are no entries yet.</p>\n".into();
    }
    let heads: String = COLUMNS
        .iter()
        .enumerate()
        .map(|(at, (name, explanation, is_number, wide_only))| {
            let sorted = if at == 0 { " aria-sort=\"ascending\"" } else { "" };
            format!(
                "<th scope=\"col\" class=\"{}\"{sorted}><button type=\"button\" \
                 title=\"{explanation}\">{name}</button></th>",
                class(*is_number, *wide_only)
            )
        })
        .collect();
    let rows: String = standings.iter().enumerate().map(|(at, each)| row(at, each)).collect();
    format!(
        "<div class=\"scroll\"><table class=\"sortable\">\n<thead><tr>{heads}</tr></thead>\n\
         <tbody>\n{rows}</tbody>\n</table></div>\n\
         <p class=\"hint\"><span class=\"scripted\">Press a heading to sort.</span> Press a name to see \
         its disparities and errors.</p>\n"
    )
}

fn row(at: usize, standing: &Standing) -> String {
    let entry = &standing.entry;
    let scores = entry.holdout.scores.as_ref();
    let cpu = entry.holdout.usage.cpu_seconds;
    let place = match standing.place {
        Some(place) => place.to_string(),
        None if entry.baseline => "<abbr title=\"baseline, out of competition\">b</abbr>".into(),
        None => format!(
            "<abbr title=\"no answer on the hold-out: {}\">{}</abbr>",
            entry.holdout.outcome.meaning(),
            entry.holdout.outcome
        ),
    };
    let day = entry.added.get(..10).unwrap_or(&entry.added);
    let cells = [
        // Sorted by rank: who has no place stands where the board puts it.
        (format!("{}", at + 1), place),
        (
            escaped(&entry.secret_id.to_lowercase()),
            format!("<a href=\"#{}\">{}</a>", anchor(at), escaped(&entry.secret_id)),
        ),
        value(standing.score, 3),
        value(scores.map(|scores| scores.e_rms), 2),
        value(scores.map(|scores| scores.p_bad), 4),
        value(cpu, 2),
        (entry.report.points.to_string(), points(entry.report.points)),
        (standing.bonus.to_string(), points(standing.bonus)),
        (standing.total.to_string(), points(standing.total)),
        (escaped(&entry.added), escaped(day)),
    ];
    let cells: String = cells
        .iter()
        .zip(COLUMNS)
        .map(|((key, shown), (_, _, is_number, wide_only))| {
            format!("<td class=\"{}\" data-key=\"{key}\">{shown}</td>", class(is_number, wide_only))
        })
        .collect();
    let kind = if entry.baseline { " class=\"baseline\"" } else { "" };
    format!("<tr{kind}>{cells}</tr>\n")
}

/// The key to sort by, empty when there is none, and what is shown.
fn value(value: Option<f64>, digits: usize) -> (String, String) {
    (value.map_or_else(String::new, |value| value.to_string()), number(value, digits))
}

fn class(is_number: bool, wide_only: bool) -> &'static str {
    match (is_number, wide_only) {
        (true, true) => "number wide",
        (true, false) => "number",
        (false, true) => "wide",
        (false, false) => "",
    }
}
