//! Results inside a page of documentation, so that no figure there is written by hand.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, bail};
use arena::record::Record;
use arena::report;
use formats::write_atomically;

use super::tables::conditions;

const BEGIN: &str = "<!-- results -->";
const END: &str = "<!-- /results -->";

/// A Markdown page with the two markers between which results stand.
pub struct Page {
    path: PathBuf,
}

impl Page {
    /// Errors when the page cannot be read or lacks a marker: before any work is done.
    pub fn open(path: PathBuf) -> anyhow::Result<Self> {
        let page = Self { path };
        page.replaced("")?;
        Ok(page)
    }

    /// Puts the overview of the records between the markers; the rest of the page stays.
    pub fn update(&self, records: &[Record]) -> anyhow::Result<()> {
        let mut text = report::overview_table(records).to_markdown();
        text.push_str(
            "\nE_RMS in px / p_bad, the share of errors > 2 px, over all pixels with truth in the \
             scene's box; CPU: mean over these scenes, of the engine's process, seen from outside",
        );
        for line in records.first().map(conditions).iter().chain([&made_by()]) {
            text.push_str("; ");
            text.push_str(line);
        }
        text.push_str(".\n");
        let page = self.replaced(&text)?;
        write_atomically(&self.path, |writer| writer.write_all(page.as_bytes()))?;
        Ok(())
    }

    /// The page with this text between its markers.
    fn replaced(&self, text: &str) -> anyhow::Result<String> {
        let page = fs::read_to_string(&self.path)
            .with_context(|| format!("cannot read {}", self.path.display()))?;
        match between(&page, text) {
            Some(page) => Ok(page),
            None => bail!(
                "{} has no place for results: put the lines {BEGIN} and {END} into it, in this \
                 order",
                self.path.display()
            ),
        }
    }
}

/// `page` with `text` between the markers, if it has them in order.
fn between(page: &str, text: &str) -> Option<String> {
    let (before, rest) = page.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n{text}{END}{after}"))
}

/// The command line that is running, as a shell would take it.
fn made_by() -> String {
    let words: Vec<String> =
        std::env::args_os().skip(1).map(|w| quoted(&w.to_string_lossy())).collect();
    format!("made by `hazcam {}`", words.join(" "))
}

/// In quotes where a shell would read more than a word.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_takes_the_command_as_it_was() {
        assert_eq!(
            ["bench", "course/*", "it's", ""].map(quoted),
            ["bench", "'course/*'", "'it'\\''s'", "''"]
        );
    }

    #[test]
    fn only_what_stands_between_the_markers_is_replaced() {
        let page = format!("head\n{BEGIN}\nold\n{END}\ntail\n");
        let new = format!("head\n{BEGIN}\nnew\n{END}\ntail\n");
        assert_eq!(between(&page, "new\n").as_deref(), Some(new.as_str()));
        assert_eq!(between(&new, "new\n").as_deref(), Some(new.as_str()));
        for page in ["", BEGIN, END, &format!("{END}{BEGIN}")] {
            assert_eq!(between(page, "new"), None, "{page}");
        }
    }
}
