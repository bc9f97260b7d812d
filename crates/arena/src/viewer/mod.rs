//! Pages for a browser: one file each, complete in itself, opened without a network.
//!
//! Everything that can be seen is in the HTML that [`board_page`] writes; the script only sorts the
//! table and lets the Escape key close what is open. The page forbids itself to load anything
//! (`Content-Security-Policy`), and what entrants wrote, their names, is escaped.
//!
//! | piece | what it draws |
//! | --- | --- |
//! | `ranking` | the table |
//! | `pareto` | accuracy over CPU time |
//! | `entrant` | what opens for one entrant: tests, pictures |
//! | `protocol` | how all of it was measured |
//! | `page.css`, `page.js` | how it looks, in light and dark, wide and narrow; sorting |

mod entrant;
mod pareto;
mod protocol;
mod ranking;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use crate::board::{Holdout, Picture, SceneTruth, Standing};
use formats::markup::escaped;

/// What a page about a board shows.
#[derive(Debug)]
pub struct BoardPage<'a> {
    /// Its heading.
    pub title: &'a str,
    /// Everybody, best first.
    pub standings: &'a [Standing],
    /// The pictures of everybody, in the same order.
    pub pictures: &'a [Vec<Picture>],
    /// The true disparities of the scenes.
    pub truths: &'a [SceneTruth],
    /// By what the board ranks.
    pub holdout: &'a Holdout,
    /// Whether pictures of the hold-out are shown: only when nobody enters any more.
    pub reveals_holdout: bool,
}

/// The whole page.
pub fn board_page(page: &BoardPage<'_>) -> String {
    let title = escaped(page.title);
    let entrants: String = page
        .standings
        .iter()
        .zip(page.pictures)
        .enumerate()
        .map(|(at, (standing, pictures))| entrant::section(page, at, standing, pictures))
        .collect();
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
         img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n\
         <title>{title}</title>\n<style>\n{}</style>\n</head>\n<body>\n<main id=\"board\">\n\
         <h1>{title}</h1>\n{}{}{}</main>\n{entrants}<script>\n{}</script>\n</body>\n</html>\n",
        include_str!("page.css"),
        ranking::table(page.standings),
        pareto::figure(page.standings),
        protocol::section(page),
        include_str!("page.js"),
    )
}

/// Where the link to an entrant leads.
fn anchor(at: usize) -> String {
    format!("entrant-{}", at + 1)
}

fn image(png: &[u8], description: &str) -> String {
    format!(
        "<img alt=\"{}\" loading=\"lazy\" src=\"data:image/png;base64,{}\">",
        escaped(description),
        BASE64_STANDARD.encode(png)
    )
}

/// A number with so many digits, or a dash.
fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("\u{2013}".into(), |value| format!("{value:.digits$}"))
}
