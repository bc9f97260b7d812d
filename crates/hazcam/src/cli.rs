//! What can be typed, and what the exit status says.
//!
//! To add a command: write `commands/NAME.rs` with
//! `#[derive(clap::Args)] pub struct Args` and `pub fn run(args: Args, ui: &Ui) ->
//! anyhow::Result<ExitCode>`, declare it in `commands/mod.rs`, and add one line to the table in
//! [`commands!`] below.

use std::ffi::OsString;
use std::process::ExitCode;

use anyhow::Context;
use arena::interrupt;
use clap::error::{ContextKind, ContextValue};
use clap::{Arg, CommandFactory, Parser, Subcommand};

use crate::commands;
use crate::ui::Ui;

/// A threshold that was asked for failed: the status is this.
pub const THRESHOLD_FAILED: u8 = 1;
/// Nothing was done, or not all of it: the status is this.
pub const ERROR: u8 = 2;

const EXAMPLES: &str = "\
Examples:
  hazcam match left.png right.png -o disparity.pfm --max-disparity 63
  hazcam score disparity.pfm truth.pfm --fail-over p_bad=0.05
  hazcam demo

Exit status: 0 done, 1 a threshold failed, 2 error.
Data goes to stdout, messages to stderr. NO_COLOR is respected.";

/// Dense stereo matching on a CPU: match, score, benchmark, grade
#[derive(Parser)]
#[command(name = "hazcam", version, after_help = EXAMPLES, max_term_width = 100)]
#[command(arg_required_else_help = true, subcommand_required = true)]
pub struct Cli {
    /// Print no notes and no progress; warnings and errors stay
    #[arg(short, long, global = true)]
    quiet: bool,

    #[command(subcommand)]
    command: Command,
}

/// Declares the commands once: group in `--help`, variant, module. A command's name is the
/// variant's in kebab-case, and its one-line description the doc comment of the module's `Args`.
macro_rules! commands {
    ($($group:literal { $($(#[$attribute:meta])* $variant:ident => $module:ident,)+ })+) => {
        #[derive(Subcommand)]
        enum Command {
            $($($(#[$attribute])* $variant(commands::$module::Args),)+)+
        }

        impl Command {
            /// The headings of `hazcam --help` with the variants that stand under each.
            const GROUPS: &[(&str, &[&str])] =
                &[$(($group, &[$(stringify!($variant),)+])),+];

            fn run(self, ui: &Ui) -> anyhow::Result<ExitCode> {
                match self {
                    $($(Self::$variant(args) => commands::$module::run(args, ui),)+)+
                }
            }
        }
    };
}

commands! {
    "Matching" {
        Match => match_pair,
        Score => score,
        Depth => depth,
        View => view,
        Info => info,
        Explain => explain,
    }
    "Measuring" {
        Demo => demo,
        Bench => bench,
        Engine => engine,
    }
    "Grading" {
        Grade => grade,
        Board => board,
        #[command(hide = true)] SandboxExec => sandbox_exec,
    }
    "This installation" {
        Doctor => doctor,
        Completions => completions,
        Man => man,
    }
}

/// The whole command line, with the commands grouped in its help.
pub fn command() -> clap::Command {
    let command = Cli::command().mut_subcommands(|command| command.mut_args(unset_where_empty));
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{}\x1b[1;4mOptions:\x1b[0m\n\
         {{options}}{{after-help}}",
        grouped(&command)
    );
    command.help_template(template)
}

/// An empty variable says nothing; to clap it would be an option that was given nothing.
fn unset_where_empty(argument: Arg) -> Arg {
    let value = argument.get_env().and_then(std::env::var_os);
    if value.is_some_and(|value| value.is_empty()) { argument.env(None::<&str>) } else { argument }
}

/// The variable that a value which is not allowed comes from: whose option nobody may have typed.
fn variable_of(usage: &clap::Error, command: &clap::Command) -> Option<String> {
    let told = |kind| match usage.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    let (option, value) = (told(ContextKind::InvalidArg)?, told(ContextKind::InvalidValue)?);
    let name = option.split([' ', '=']).next()?;
    let is_typed =
        |word: OsString| word.to_str().is_some_and(|word| word.split('=').next() == Some(name));
    if std::env::args_os().any(is_typed) {
        return None;
    }
    let all = command.get_subcommands().flat_map(clap::Command::get_arguments);
    let is_it =
        |argument: &&Arg| argument.get_long().is_some_and(|long| name == format!("--{long}"));
    let mut variables = all.filter(is_it).filter_map(Arg::get_env);
    let variable =
        variables.find(|name| std::env::var_os(name).is_some_and(|found| found == value))?;
    Some(variable.to_string_lossy().into_owned())
}

/// The commands with their descriptions under the headings of [`Command::GROUPS`].
fn grouped(command: &clap::Command) -> String {
    let mut list = String::new();
    // Variants and subcommands stand in the same order.
    let mut subcommands = command.get_subcommands();
    for (group, variants) in Command::GROUPS {
        list.push_str(&format!("\x1b[1;4m{group}:\x1b[0m\n"));
        for subcommand in subcommands.by_ref().take(variants.len()) {
            if !subcommand.is_hide_set() {
                let about = subcommand.get_about().map(ToString::to_string).unwrap_or_default();
                list.push_str(&format!("  \x1b[1m{:<12}\x1b[0m {about}\n", subcommand.get_name()));
            }
        }
        list.push('\n');
    }
    list
}

/// Reads the command line, runs the command, says what went wrong.
pub fn main() -> ExitCode {
    #[cfg(unix)]
    outlive_full_files();
    let cli = match command().try_get_matches().and_then(|m| from_matches(&m)) {
        Ok(cli) => cli,
        Err(usage) => {
            // Help and version are no errors. If nobody reads them, so be it.
            let _ = usage.print();
            if let Some(variable) = variable_of(&usage, &command()) {
                Ui::new(false).note(format_args!(
                    "the value comes from the variable {variable} of the environment"
                ));
            }
            return if usage.use_stderr() { ERROR.into() } else { ExitCode::SUCCESS };
        }
    };
    let ui = Ui::new(cli.quiet);
    // What becomes another program stays as it was started, and who started an engine clears up behind it, which may not
    // even be allowed to wait for signals.
    let signals = match cli.command {
        Command::SandboxExec(_) | Command::Engine(_) => Ok(()),
        _ => interrupt::clean_up_on_signals().context("cannot wait for signals"),
    };
    match signals.and_then(|()| cli.command.run(&ui)) {
        Ok(status) => status,
        Err(error) => {
            ui.error(&error);
            ERROR.into()
        }
    }
}

/// A file that may grow no more (`ulimit -f`) is an error of whoever writes it, who then takes away what there is of
/// it. Unheard, the signal would end the process before. Programs that are started from here do not inherit that.
#[cfg(unix)]
fn outlive_full_files() {
    // Where it cannot be heard, all is as if nobody had tried.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
}

fn from_matches(matches: &clap::ArgMatches) -> Result<Cli, clap::Error> {
    <Cli as clap::FromArgMatches>::from_arg_matches(matches)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        command().debug_assert();
    }

    #[test]
    fn every_command_and_option_has_help() {
        for sub in command().get_subcommands() {
            assert!(sub.get_about().is_some(), "`{}` has no description", sub.get_name());
            for argument in sub.get_arguments() {
                assert!(
                    argument.get_help().is_some(),
                    "`{} {}` has no help",
                    sub.get_name(),
                    argument.get_id()
                );
            }
        }
    }
}
