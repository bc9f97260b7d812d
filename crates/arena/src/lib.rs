//! Data sets, engines, runs and records: everything that compares matchers.
//!
//! | module | what it is for |
//! | --- | --- |
//! | [`dataset`] | scenes on disk: layouts, catalogues, truth, masks, boxes, ranges |
//! | [`engine`] | a matcher in a process of its own, driven by `PROTOCOL.md`, measured from outside |
//! | [`run`] | engines on scenes; [`record`]: what came of one engine on one scene; [`report`]: tables of records |
//! | [`speed`] | matching alone, in turns with OpenCV's |
//! | [`submission`] | a course's Python files, from folders and archives; [`sandbox`]: what they may touch |
//! | [`grade`] | tests, thresholds and points; [`board`]: the leaderboard; [`viewer`]: its page |
//! | [`interrupt`] | folders and processes that are cleared away when a signal ends the program |

pub mod board;
pub mod dataset;
pub mod engine;
pub mod grade;
mod hexadecimal;
pub mod interrupt;
pub mod record;
pub mod report;
pub mod run;
pub mod sandbox;
pub mod speed;
pub mod submission;
pub mod viewer;

pub use hexadecimal::hexadecimal;
