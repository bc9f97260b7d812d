//! How the command speaks: data on stdout, everything else on stderr.
//!
//! Colour follows `NO_COLOR`, `CLICOLOR` and `CLICOLOR_FORCE` and is left out when the stream is
//! not a terminal. A reader that goes away (`hazcam score ... | head -1`) is no error: the rest is written nowhere, and
//! the command goes on, since files, boards and its status may be asked of it too.

use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// What the user asked of the messages.
#[derive(Debug, Clone, Copy)]
pub struct Ui {
    quiet: bool,
}

impl Ui {
    /// `quiet` silences notes and progress; warnings and errors stay.
    pub fn new(quiet: bool) -> Self {
        Self { quiet }
    }

    /// Writes data to stdout, as it is.
    pub fn print(&self, text: &str) -> anyhow::Result<()> {
        self.write(text.as_bytes())
    }

    /// Writes data to stdout, as it is.
    pub fn write(&self, bytes: &[u8]) -> anyhow::Result<()> {
        let mut out = io::stdout().lock();
        match out.write_all(bytes).and_then(|()| out.flush()) {
            // Whoever read it has had enough.
            Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
            Err(e) => Err(anyhow::Error::new(e).context("cannot write to stdout")),
            Ok(()) => Ok(()),
        }
    }

    /// Says on stderr what was assumed or done. Silenced by `--quiet`.
    pub fn note(&self, text: impl fmt::Display) {
        if !self.quiet {
            say("\x1b[1;36mnote:\x1b[0m", text);
        }
    }

    /// Says on stderr what may surprise.
    pub fn warn(&self, text: impl fmt::Display) {
        say("\x1b[1;33mwarning:\x1b[0m", text);
    }

    /// Says on stderr which check did not pass.
    pub fn fail(&self, text: impl fmt::Display) {
        say("\x1b[1;31mfailed:\x1b[0m", text);
    }

    /// Says on stderr why the program ends, causes included.
    pub fn error(&self, error: &anyhow::Error) {
        say("\x1b[1;31merror:\x1b[0m", with_causes(error));
    }

    /// Shows what is being done and for how long, where the end cannot be foreseen.
    pub fn spinner(&self, what: impl Into<String>) -> ProgressBar {
        if self.silent() {
            return ProgressBar::hidden();
        }
        let style = ProgressStyle::with_template("{spinner} {msg}  {elapsed}")
            .expect("the template is well-formed");
        let spinner = ProgressBar::new_spinner().with_style(style).with_message(what.into());
        spinner.enable_steady_tick(Duration::from_millis(100));
        spinner
    }

    /// A bar over `steps` steps with an estimate of the time left, on stderr; invisible when that
    /// is no terminal or under `--quiet`. Advance it with `inc(1)`, name the step with
    /// `set_message`, and end it with `finish_and_clear`.
    pub fn progress(&self, steps: u64) -> ProgressBar {
        if self.silent() {
            return ProgressBar::hidden();
        }
        let style = ProgressStyle::with_template("{bar:24} {pos}/{len}  {eta} left  {wide_msg}")
            .expect("the template is well-formed");
        ProgressBar::new(steps).with_style(style)
    }

    fn silent(&self) -> bool {
        self.quiet || !io::stderr().is_terminal()
    }
}

/// The error and its causes, each once: some errors already end with the words of their cause.
fn with_causes(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |text, cause| match cause.to_string() {
        cause if text.is_empty() => cause,
        cause if text.ends_with(&cause) => text,
        cause => format!("{text}: {cause}"),
    })
}

/// A line on stderr. That nobody can read it is no reason to fail.
fn say(label: &str, text: impl fmt::Display) {
    let _ = writeln!(anstream::stderr().lock(), "{label} {text}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_that_was_told_is_not_repeated() {
        let file = || io::Error::new(io::ErrorKind::NotFound, "no such file");
        let outer = anyhow::Error::new(file()).context("cannot open a.png: no such file");
        assert_eq!(with_causes(&outer), "cannot open a.png: no such file");
        let outer = anyhow::Error::new(file()).context("cannot open a.png");
        assert_eq!(with_causes(&outer), "cannot open a.png: no such file");
    }
}
