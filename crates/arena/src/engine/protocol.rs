//! The messages of the engine protocol, version 1, one JSON object a line (`PROTOCOL.md` has the
//! whole story).
//!
//! Both directions are tagged by the key `hazcam`, so that a line of an engine's own chatter is
//! never taken for a message: [`parse_line`] tells the two apart.

use std::path::PathBuf;

use raster::{BoundingBox, DisparityRange};
use serde::{Deserialize, Serialize};

/// The version of the protocol that this arena speaks.
pub const VERSION: u32 = 1;

/// A message, including its line end, has at most this many bytes.
pub const LINE_LIMIT: usize = 65_536;

/// What the arena says to an engine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "hazcam", rename_all = "lowercase")]
pub enum ToEngine {
    /// Match this pair.
    Job(Job),
}

/// What an engine says to the arena.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "hazcam", rename_all = "lowercase")]
pub enum FromEngine {
    /// It takes jobs from now on.
    Ready(Ready),
    /// It cannot work on this machine: something is not installed.
    Absent {
        /// What is missing, and how to get it.
        message: String,
    },
    /// The answer is written.
    Done {
        /// The job's number.
        job: u64,
        /// How long the matching alone took, in seconds, by the engine's own clock.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        seconds: Option<f64>,
    },
    /// There will be no answer to this job; the next one is welcome.
    Failed {
        /// The job's number.
        job: u64,
        /// Why.
        message: String,
    },
}

/// How an engine introduces itself.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Ready {
    /// The version of the protocol that it speaks.
    pub protocol: u32,
    /// What answers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Its version.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
}

/// One pair to match. Paths are absolute.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Job {
    /// Repeated in the answer.
    pub job: u64,
    /// `.npy`, `uint8` or `uint16`, `rows x columns` or `rows x columns x 3`.
    pub left: PathBuf,
    /// As `left`, of the same shape.
    pub right: PathBuf,
    /// Width of both images in pixels.
    pub columns: usize,
    /// Height of both images in pixels.
    pub rows: usize,
    /// `[x0, y0, x1, y1]`, inclusive: the pixels to answer.
    #[serde(rename = "box")]
    pub bounds: [usize; 4],
    /// The smallest disparity to search, in pixels.
    pub min_disparity: i32,
    /// The largest disparity to search, in pixels, inclusive.
    pub max_disparity: i32,
    /// How many threads the engine may use.
    pub threads: usize,
    /// Where the disparity goes: `.npy`, `float32`, `rows x columns`, NaN = no value.
    pub disparity: PathBuf,
    /// Where the reasons may go: `.npy`, `uint8`, `rows x columns`.
    pub reasons: PathBuf,
    /// Where the confidence may go: `.npy`, `float32`, `rows x columns`.
    pub confidence: PathBuf,
}

impl Job {
    /// The pixels to answer. Errors when the box is inverted or leaves the images.
    pub fn bounding_box(&self) -> Result<BoundingBox, raster::BoundsError> {
        let [x0, y0, x1, y1] = self.bounds;
        let bounds = BoundingBox { x0, y0, x1, y1 };
        bounds.check_within(self.columns, self.rows).map(|()| bounds)
    }

    /// The disparities to search. Errors when the range is empty.
    pub fn range(&self) -> Result<DisparityRange, raster::BoundsError> {
        DisparityRange::new(self.min_disparity, self.max_disparity)
    }
}

/// What a line of an engine's standard output is.
#[derive(Debug, Clone, PartialEq)]
pub enum Line {
    /// A message.
    Message(FromEngine),
    /// What looks like a JSON object with the key `hazcam` and is no message of this protocol; the text says why.
    Broken(String),
    /// Anything else: the engine's own talk.
    Chatter,
}

/// Tells messages from an engine's own talk.
pub fn parse_line(line: &str) -> Line {
    let text = line.trim();
    if !text.starts_with('{') {
        return Line::Chatter;
    }
    match serde_json::from_str::<serde_json::Value>(text) {
        Ok(value) if value.get("hazcam").is_some() => match serde_json::from_value(value) {
            Ok(message) => Line::Message(message),
            Err(error) => Line::Broken(error.to_string()),
        },
        // Python's json writes NaN and Infinity, which JSON does not know.
        Err(error) if text.contains("\"hazcam\"") => {
            Line::Broken(format!("it is no JSON: {error}"))
        }
        _ => Line::Chatter,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_told_from_chatter() {
        assert_eq!(
            parse_line("{\"hazcam\":\"done\",\"job\":7,\"note\":\"unknown keys are ignored\"}\n"),
            Line::Message(FromEngine::Done { job: 7, seconds: None })
        );
        assert_eq!(
            parse_line(r#"{"hazcam":"done","job":7,"seconds":0.25}"#),
            Line::Message(FromEngine::Done { job: 7, seconds: Some(0.25) })
        );
        assert_eq!(
            parse_line(r#"{"hazcam":"ready","protocol":1,"name":"mine"}"#),
            Line::Message(FromEngine::Ready(Ready {
                protocol: 1,
                name: Some("mine".into()),
                version: None
            }))
        );
        for chatter in ["", "done", "{", "{\"job\":7}", "[1, 2]", "100 %|####|"] {
            assert_eq!(parse_line(chatter), Line::Chatter, "{chatter}");
        }
    }

    #[test]
    fn a_malformed_message_is_broken_and_not_chatter() {
        for broken in [
            r#"{"hazcam":"doen","job":7}"#,
            r#"{"hazcam":"done"}"#,
            r#"{"hazcam":"done","job":-1}"#,
            r#"{"hazcam":"done","job":1,"seconds":NaN}"#,
            r#"{"hazcam":"done","job":1"#,
        ] {
            assert!(matches!(parse_line(broken), Line::Broken(_)), "{broken}");
        }
    }

    #[test]
    fn a_job_is_one_line_with_the_documented_keys() {
        let job = Job {
            job: 1,
            left: "/s/left.npy".into(),
            right: "/s/right.npy".into(),
            columns: 450,
            rows: 375,
            bounds: [54, 0, 449, 374],
            min_disparity: 0,
            max_disparity: 55,
            threads: 1,
            disparity: "/s/disparity.npy".into(),
            reasons: "/s/reasons.npy".into(),
            confidence: "/s/confidence.npy".into(),
        };
        assert_eq!(job.bounding_box().unwrap().columns(), 396);
        assert_eq!(job.range().unwrap().count(), 56);
        let text = serde_json::to_string(&ToEngine::Job(job)).unwrap();
        assert_eq!(
            text,
            r#"{"hazcam":"job","job":1,"left":"/s/left.npy","right":"/s/right.npy","columns":450,"rows":375,"box":[54,0,449,374],"min_disparity":0,"max_disparity":55,"threads":1,"disparity":"/s/disparity.npy","reasons":"/s/reasons.npy","confidence":"/s/confidence.npy"}"#
        );
        assert!(include_str!("../../PROTOCOL.md").contains(&text.replace("/s/", "/scratch/")));
    }
}
