//! Grading as an instructor meets it: `grade` is run on submissions of every sort, honest and
//! hostile, and what it prints, leaves behind and ends with is looked at.

mod archives;
mod attacks;
mod board;
#[path = "../browser/mod.rs"]
mod browser;
mod classroom;
mod engines;
mod entrants;
mod faults;
mod help;
mod hostile;
mod messages;
mod missing_parts;
mod outputs;
mod page;
mod paths;
#[path = "../skip/mod.rs"]
mod skip;
mod zips;
