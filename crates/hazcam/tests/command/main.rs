//! The command as a person meets it: the binary is run, and what it prints, leaves behind and ends
//! with is looked at.

mod bad_input;
#[path = "../browser/mod.rs"]
mod browser;
mod depth;
mod doctor;
mod folder;
mod help;
mod info;
mod match_pair;
#[cfg(target_os = "linux")]
mod names;
mod score;
#[path = "../skip/mod.rs"]
mod skip;
mod view;
