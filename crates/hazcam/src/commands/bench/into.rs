//! Results inside a page of documentation, so that no figure there is written by hand.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, bail};
use formats::write_atomically;

use crate::outputs;

/// A Markdown page with two lines `<!-- NAME -->` and `<!-- /NAME -->`, between which results stand.
pub struct Page {
    path: PathBuf,
    name: &'static str,
}

impl Page {
    /// Errors when the page cannot be read or written, or lacks a marker: before any work is done.
    pub fn open(path: PathBuf, name: &'static str) -> anyhow::Result<Self> {
        let page = Self { path, name };
        page.replaced("")?;
        outputs::check(&[outputs::Output::text("--into", &page.path, "")], &[])?;
        Ok(page)
    }

    /// Puts this text between the markers; the rest of the page stays.
    pub fn put(&self, text: &str) -> anyhow::Result<()> {
        let page = self.replaced(text)?;
        write_atomically(&self.path, |writer| writer.write_all(page.as_bytes()))?;
        Ok(())
    }

    /// The page with this text between its markers.
    fn replaced(&self, text: &str) -> anyhow::Result<String> {
        let page = fs::read_to_string(&self.path)
            .with_context(|| format!("cannot read {}", self.path.display()))?;
        match between(&page, self.name, text) {
            Some(page) => Ok(page),
            None => bail!(
                "{} has no place for results: put the lines <!-- {name} --> and <!-- /{name} --> \
                 into it, in this order",
                self.path.display(),
                name = self.name
            ),
        }
    }
}

/// `page` with `text` between the markers of this name, if it has them in order.
fn between(page: &str, name: &str, text: &str) -> Option<String> {
    let (begin, end) = (format!("<!-- {name} -->"), format!("<!-- /{name} -->"));
    let (before, rest) = page.split_once(&begin)?;
    let (_, after) = rest.split_once(&end)?;
    // The page keeps its ends of lines.
    let (line, text) = match after.starts_with("\r\n") || rest.starts_with("\r\n") {
        true => ("\r\n", text.replace('\n', "\r\n")),
        false => ("\n", text.to_owned()),
    };
    Some(format!("{before}{begin}{line}{text}{end}{after}"))
}

/// The command line that is running, as a shell would take it, but for where its records go: no figure
/// depends on that, and others have no such folder.
pub fn command_line() -> String {
    let words = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    let words: Vec<String> = without_out(words).map(|word| quoted(&word)).collect();
    format!("hazcam {}", words.join(" "))
}

/// Words without `--out`, or `-o`, and the folder that it names.
fn without_out(words: impl Iterator<Item = String>) -> impl Iterator<Item = String> {
    let mut names_a_folder = false;
    words.filter(move |word| {
        let is_folder = std::mem::replace(&mut names_a_folder, word == "--out" || word == "-o");
        let has_folder = word.starts_with("--out=") || word.starts_with("-o");
        !is_folder && !names_a_folder && !has_folder
    })
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
    fn where_records_go_is_left_out() {
        let left = |line: &str| -> Vec<String> {
            without_out(line.split(' ').map(str::to_owned)).collect()
        };
        assert_eq!(left("bench --out here -m fast"), ["bench", "-m", "fast"]);
        assert_eq!(left("bench -m fast --out=here --into page"), left("bench -m fast --into page"));
        assert_eq!(left("bench -o here -m fast -othere"), ["bench", "-m", "fast"]);
        assert_eq!(left("bench --outer x"), ["bench", "--outer", "x"]);
    }

    #[test]
    fn only_what_stands_between_the_markers_is_replaced() {
        let other = "<!-- results -->\nkept\n<!-- /results -->\n";
        let page = format!("{other}<!-- speed -->\nold\n<!-- /speed -->\ntail\n");
        let new = format!("{other}<!-- speed -->\nnew\n<!-- /speed -->\ntail\n");
        assert_eq!(between(&page, "speed", "new\n").as_deref(), Some(new.as_str()));
        assert_eq!(between(&new, "speed", "new\n").as_deref(), Some(new.as_str()));
        let [page, new] = [page, new].map(|text| text.replace('\n', "\r\n"));
        assert_eq!(between(&page, "speed", "new\n").as_deref(), Some(new.as_str()));
        for page in
            ["", "<!-- speed -->", "<!-- /speed -->", "<!-- /speed --><!-- speed -->", other]
        {
            assert_eq!(between(page, "speed", "new"), None, "{page}");
        }
    }
}
