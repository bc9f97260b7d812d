//! How everything was measured, in words that stand beside the numbers.

use formats::picture::log_error_legend;

use super::BoardPage;
use crate::board::BONUS;
use crate::grade::{PROTOCOL, Report};
use formats::markup::escaped;

pub(super) fn section(page: &BoardPage<'_>) -> String {
    let test = &page.holdout.test;
    let bonus = BONUS.map(|points| points.to_string()).join(", ");
    let tests = tests(&page.standings.iter().map(|each| &each.entry.report).collect::<Vec<_>>());
    let reveals = match page.reveals_holdout {
        true => "",
        false => " Its pictures are not shown while entries are still taken.",
    };
    format!(
        "<section class=\"protocol\">\n<h2>How it is measured</h2>\n\
         <h3>Rank</h3>\n<p>Everybody is ranked on a hold-out that entrants do not have: {}.{reveals} \
         E<sub>RMS</sub> and p<sub>bad</sub> weigh equally:</p>\n\
         <p class=\"formula\">score = ( E<sub>RMS</sub> / {} px + p<sub>bad</sub> / {} ) / 2</p>\n\
         <p>A score of 1 is just at both thresholds; lower is better. Ties go to the earlier \
         entry. The first three get {bonus} points on top of those of \
         the tests. Baselines, marked b, take neither place nor bonus.</p>\n\
         <h3>Points</h3>\n<p>{}</p>\n{tests}\
         <h3>Numbers</h3>\n<p>E<sub>RMS</sub> is the root mean square of the disparity error in \
         pixels, p<sub>bad</sub> the share of pixels off by more than 2 px, both over the pixels of \
         the box with known, nonzero truth. CPU times hold for the machine they were taken on, \
         which each entry names.</p>\n\
         <h3>Pictures</h3>\n<p>Disparities go from far <span class=\"turbo\"></span> to near, in \
         the range of the truth; black has no value. Errors have the colours of KITTI, in units of \
         what its D1 calls wrong, 3 px and 5 % of the truth; half as bright where the right camera \
         cannot see, black where nobody knows the truth:</p>\n<ul class=\"legend\">{}</ul>\n\
         <p class=\"hint\">Written by hazcam {}.</p>\n</section>\n",
        escaped(&page.holdout.describe()),
        test.max_e_rms,
        test.max_p_bad,
        escaped(PROTOCOL),
        legend(),
        env!("CARGO_PKG_VERSION"),
    )
}

/// The tests, which are the same for all; within which CPU time, every entrant was graded by their own scheme.
fn tests(reports: &[&Report]) -> String {
    let Some(first) = reports.first() else { return String::new() };
    let rows: String = (first.tests.iter().enumerate())
        .map(|(i, test)| {
            let limits = reports.iter().filter_map(|report| report.tests.get(i));
            format!(
                "<tr><td>{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td>\
                 <td class=\"number\">{}</td><td class=\"number\">{}</td></tr>\n",
                escaped(&test.name),
                test.max_points,
                test.max_e_rms,
                test.max_p_bad,
                least_to_most(limits.map(|test| test.cpu_limit_seconds)),
            )
        })
        .collect();
    format!(
        "<div class=\"scroll\"><table>\n<thead><tr><th scope=\"col\">Test</th>\
         <th scope=\"col\" class=\"number\">Points</th>\
         <th scope=\"col\" class=\"number\">E<sub>RMS</sub> at most, px</th>\
         <th scope=\"col\" class=\"number\">p<sub>bad</sub> at most</th>\
         <th scope=\"col\" class=\"number\">CPU limit, s</th></tr></thead>\n<tbody>\n{rows}</tbody>\n\
         </table></div>\n"
    )
}

/// One number where all are the same.
fn least_to_most(values: impl Iterator<Item = f64>) -> String {
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (least, most) = values.fold(ends, |(least, most), v| (v.min(least), v.max(most)));
    if least == most { most.to_string() } else { format!("{least} to {most}") }
}

fn legend() -> String {
    let item = |([r, g, b], text): ([u8; 3], String)| {
        format!("<li><span style=\"background: rgb({r} {g} {b})\"></span>{text}</li>")
    };
    log_error_legend().into_iter().map(item).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_that_not_all_had_is_told_from_the_least_to_the_most() {
        assert_eq!(least_to_most([60.0, 60.0].into_iter()), "60");
        assert_eq!(least_to_most([60.0, 7.5, 120.0].into_iter()), "7.5 to 120");
    }
}
