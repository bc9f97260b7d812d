//! The `hazcam` command. What is typed is in `cli`, what it does in `commands`.
#![forbid(unsafe_code)]
// Both panic when nobody reads on; `ui` does not.
#![warn(clippy::print_stdout, clippy::print_stderr)]

mod arguments;
mod cli;
mod clock;
mod commands;
mod map;
mod outputs;
mod rig;
mod ui;
mod wrap;

fn main() -> std::process::ExitCode {
    cli::main()
}
