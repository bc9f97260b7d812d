//! The `hazcam` command. What is typed is in `cli`, what it does in `commands`.
#![forbid(unsafe_code)]

mod arguments;
mod cli;
mod clock;
mod commands;
mod outputs;
mod ui;
mod wrap;

fn main() -> std::process::ExitCode {
    cli::main()
}
