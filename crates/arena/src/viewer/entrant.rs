//! What opens for one entrant: its results, and per scene the truth, its disparities, its errors.
//!
//! Messages of failed tests are not shown: they quote the entrant's code, which is nobody else's
//! business.

use super::{BoardPage, anchor, image, number};
use crate::board::{Picture, Standing};
use crate::grade::output::points;
use crate::grade::{Outcome, TestResult};
use formats::markup::escaped;

pub(super) fn section(
    page: &BoardPage<'_>,
    at: usize,
    standing: &Standing,
    pictures: &[Picture],
) -> String {
    let entry = &standing.entry;
    let results = || entry.report.tests.iter().chain([&entry.holdout]);
    let rows: String = results().map(row).collect();
    let is_shown = |result: &&TestResult| page.reveals_holdout || result.name != entry.holdout.name;
    let figures: String = results()
        .filter(is_shown)
        .filter_map(|result| {
            let picture = pictures.iter().find(|picture| picture.test == result.name)?;
            Some(figures(page, result, picture))
        })
        .collect();
    let place = match (standing.place, entry.baseline) {
        (Some(place), _) => format!("Place {place}"),
        (None, true) => "Baseline, out of competition".into(),
        (None, false) => "No place: no answer on the hold-out".into(),
    };
    let python =
        entry.report.python.as_ref().map_or(String::new(), |version| format!(", Python {version}"));
    format!(
        "<section class=\"entrant\" role=\"dialog\" aria-modal=\"true\" id=\"{}\" aria-label=\"{name}\" tabindex=\"-1\">\n\
         <div class=\"sheet\">\n<a class=\"close\" href=\"#board\">Close</a>\n<h2>{name}</h2>\n\
         <p>{place}, score {}, {} points with a bonus of {}.</p>\n\
         <div class=\"scroll\"><table>\n<thead><tr><th scope=\"col\">Test</th>\
         <th scope=\"col\">End</th><th scope=\"col\" class=\"number\">Points</th>\
         <th scope=\"col\" class=\"number\">E<sub>RMS</sub></th>\
         <th scope=\"col\" class=\"number\">p<sub>bad</sub></th>\
         <th scope=\"col\" class=\"number wide\">CPU s</th>\
         <th scope=\"col\" class=\"number wide\">Memory MB</th></tr></thead>\n<tbody>\n{rows}</tbody>\n\
         </table></div>\n{figures}\
         <p class=\"hint\">Added {}; hazcam {}{python}; {}.</p>\n</div>\n</section>\n",
        anchor(at),
        number(standing.score, 3),
        points(standing.total),
        standing.bonus,
        escaped(&entry.added),
        escaped(&entry.report.hazcam),
        escaped(&entry.machine),
        name = escaped(&entry.secret_id),
    )
}

fn row(result: &TestResult) -> String {
    let scores = result.scores.as_ref();
    let memory = result.usage.peak_memory_bytes.map(|bytes| bytes as f64 / 1e6);
    let points = match result.max_points {
        0.0 => "\u{2013}".to_owned(),
        max => format!("{} of {max}", result.points),
    };
    format!(
        "<tr><td>{}</td><td>{}</td><td class=\"number\">{points}</td><td class=\"number\">{}</td>\
         <td class=\"number\">{}</td><td class=\"number wide\">{}</td><td class=\"number wide\">{}</td></tr>\n",
        escaped(&result.name),
        match result.outcome {
            Outcome::Ok if result.max_points == 0.0 => "answered",
            Outcome::Ok if result.passes() => "passed",
            Outcome::Ok => "not below a threshold",
            other => other.meaning(),
        },
        number(scores.map(|scores| scores.e_rms), 2),
        number(scores.map(|scores| scores.p_bad), 4),
        number(result.usage.cpu_seconds, 2),
        number(memory, 0),
    )
}

fn figures(page: &BoardPage<'_>, result: &TestResult, picture: &Picture) -> String {
    let truth = page
        .truths
        .iter()
        .find(|truth| truth.test == result.name)
        .map_or_else(String::new, |truth| figure(&truth.truth, &result.name, "truth"));
    format!(
        "<h3>{}</h3>\n<div class=\"pictures\">\n{truth}{}{}</div>\n",
        escaped(&result.name),
        figure(&picture.disparity, &result.name, "disparity"),
        figure(&picture.error, &result.name, "error"),
    )
}

fn figure(png: &[u8], test: &str, what: &str) -> String {
    let image = image(png, &format!("{what} of {test}"));
    format!("<figure>{image}<figcaption>{what}</figcaption></figure>\n")
}
